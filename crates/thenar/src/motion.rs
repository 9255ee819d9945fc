//! Motions of rigid bodies, and forces on them.

use thenar_core::Vec3;

/// Velocity of a rigid body, in the axes of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twist {
    /// Velocity of the centre of mass \[m/s\].
    pub linear: Vec3,
    /// Angular velocity \[rad/s\].
    pub angular: Vec3,
}

/// Force and torque on a body about its centre of mass, in the axes of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Force \[N\].
    pub force: Vec3,
    /// Torque \[N m\].
    pub torque: Vec3,
}

impl Twist {
    /// Velocity without turning \[m/s\].
    pub fn linear(velocity: impl Into<Vec3>) -> Self {
        Self { linear: velocity.into(), angular: Vec3::zeros() }
    }

    /// Velocity of the point at `arm` \[m\] from the centre of mass \[m/s\].
    pub fn at(&self, arm: &Vec3) -> Vec3 {
        self.linear + self.angular.cross(arm)
    }
}

impl Wrench {
    /// Adds a force \[N\] that acts at `arm` \[m\] from the centre of mass.
    pub fn add(&mut self, force: &Vec3, arm: &Vec3) {
        self.force += force;
        self.torque += arm.cross(force);
    }
}

impl From<[Vec3; 2]> for Twist {
    fn from([linear, angular]: [Vec3; 2]) -> Self {
        Self { linear, angular }
    }
}

impl From<Twist> for [Vec3; 2] {
    fn from(twist: Twist) -> Self {
        [twist.linear, twist.angular]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_turn_about_the_centre_of_mass() {
        let mut wrench = Wrench::default();
        // A force up at the end of an arm along x turns about z, counter-clockwise; one back at its
        // other end as well.
        wrench.add(&(Vec3::y() * 2.0), &(Vec3::x() * 0.5));
        wrench.add(&(Vec3::y() * -2.0), &(Vec3::x() * -0.5));
        assert_eq!((wrench.force, wrench.torque), (Vec3::zeros(), Vec3::z() * 2.0));
        let twist = Twist { linear: Vec3::x(), angular: Vec3::z() * 3.0 };
        assert_eq!(twist.at(&Vec3::x()), Vec3::new(1.0, 3.0, 0.0));
    }
}
