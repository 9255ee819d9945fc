//! A rigid object of a simulation.

use crate::{Twist, Wrench};
use thenar_core::model::BodyId;
use thenar_core::{Pose, World};

/// A rigid object as it is after the last step.
#[derive(Clone, Copy, Debug)]
pub struct RigidRef<'a> {
    pub(crate) world: &'a World,
    pub(crate) body: u32,
}

impl<'a> RigidRef<'a> {
    /// Name in the scene.
    pub fn name(&self) -> &'a str {
        &self.world.desc().rigids[self.body as usize].name
    }

    /// Mass \[kg\].
    pub fn mass(&self) -> f64 {
        self.world.desc().rigids[self.body as usize].mass
    }

    /// Pose in the world of its frame, whose origin is the centre of mass.
    pub fn pose(&self) -> Pose {
        self.world.rigid_pose(self.body)
    }

    /// Velocity of the centre of mass, and angular velocity.
    pub fn velocity(&self) -> Twist {
        self.world.rigid_velocity(self.body).into()
    }

    /// Force and torque of all contacts on it in the last step, about its centre of mass at the end
    /// of that.
    pub fn contact_wrench(&self) -> Wrench {
        let (own, middle) = (BodyId::Rigid(self.body), self.pose().position);
        let mut wrench = Wrench::default();
        for contact in self.world.contacts() {
            let arm = contact.position_W - middle;
            for (body, sign) in contact.bodies.iter().zip([1.0, -1.0]) {
                if *body == own {
                    wrench.add(&(contact.force_W * sign), &arm);
                }
            }
        }
        wrench
    }
}

/// A rigid object that is put elsewhere.
#[derive(Debug)]
pub struct RigidMut<'a> {
    pub(crate) world: &'a mut World,
    pub(crate) body: u32,
}

impl RigidMut<'_> {
    /// Puts it there with this velocity. Ignored where a number is not finite.
    pub fn place(&mut self, pose: Pose, velocity: Twist) {
        self.world.set_rigid_state(self.body, pose, velocity.into());
    }
}
