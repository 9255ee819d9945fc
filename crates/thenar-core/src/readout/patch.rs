//! The contact of one patch: a finger, a body, a pair of bodies.

use crate::math::Vec3;
use crate::readout::SlipState;
use crate::world::ContactPoint;

/// Sums over the contact points of a patch. "On it" is on the body or part that was asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PatchContact {
    /// Points that bear load.
    pub points: u32,
    /// Force on it, world \[N\].
    pub force_W: Vec3,
    /// Sum of the points' normal forces \[N\]; of a curved patch more than the size of their
    /// resultant.
    pub normal: f64,
    /// The part of it that deformable surfaces bear \[N\]: all but what rigid bodies put on each
    /// other, as a bone and a plate where the flesh between them is crushed.
    pub skin_normal: f64,
    /// Mean direction in which they push it, by load, world; zero when nothing presses.
    pub normal_W: Vec3,
    /// Friction on it, world \[N\].
    pub shear_W: Vec3,
    /// Sum of the sizes of the points' friction \[N\]: no less than the size of `shear_W`, and more
    /// where it points to several sides.
    pub shear_sum: f64,
    /// Centre of pressure: mean place by load, world \[m\]; zero when nothing presses.
    pub centre_W: Vec3,
    /// Torque on it about the centre of pressure, world \[N m\].
    pub torque_W: Vec3,
    /// Area of the surface nearer than 20 µm, between soft surfaces no less than load over peak
    /// pressure \[m²\]; zero between rigid bodies.
    pub area: f64,
    /// Largest depth of a point, bearing load or not, at the start of the step \[m\].
    pub penetration: f64,
    /// Largest pressure at a vertex of a deformable surface \[Pa\].
    pub pressure_max: f64,
    /// Mean tangential velocity against the other body, by load, world \[m/s\].
    pub slip_W: Vec3,
    /// Part of the normal force that sliding points bear, from 0 (all hold) to 1 (all slide): slip
    /// begins at a patch's edge, long before all of it slides.
    pub slipping: f64,
    /// State of friction under most of the load.
    pub state: SlipState,
}

impl PatchContact {
    /// Mean pressure \[Pa\]: what deformable surfaces bear over their area in contact; zero without
    /// area. What rigid bodies put on each other has no area, so it is no part of it.
    pub fn pressure_mean(&self) -> f64 {
        if self.area > 0.0 { self.skin_normal / self.area } else { 0.0 }
    }

    /// Resultant of the normal forces on it, world \[N\].
    pub fn push_W(&self) -> Vec3 {
        self.force_W - self.shear_W
    }

    /// Torque on it about another point, world \[N m\].
    pub fn torque_about(&self, point_W: &Vec3) -> Vec3 {
        self.torque_W + (self.centre_W - point_W).cross(&self.force_W)
    }
}

/// A patch being summed up.
#[derive(Clone, Copy, Debug, Default)]
pub struct PatchSum {
    patch: PatchContact,
    /// Torque about the world's origin.
    torque_W: Vec3,
}

impl PatchSum {
    /// Adds a point, of which this is side 0 (A) or 1 (B).
    pub fn add(&mut self, point: &ContactPoint, side: usize) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let normal = point.force_W.dot(&point.normal_W);
        // What touches belongs to the patch, though its neighbours may bear all of the load.
        self.patch.area += point.area;
        self.patch.penetration = self.patch.penetration.max(-point.gap);
        if normal <= 0.0 {
            return;
        }
        let force_W = point.force_W * sign;
        let push_W = point.normal_W * (normal * sign);
        let p = &mut self.patch;
        p.points += 1;
        p.force_W += force_W;
        p.normal += normal;
        p.skin_normal += if point.touches_skin() { normal } else { 0.0 };
        p.normal_W += push_W;
        p.shear_W += force_W - push_W;
        p.shear_sum += (force_W - push_W).norm();
        p.centre_W += point.position_W * normal;
        p.slip_W += point.slip_W * (normal * sign);
        p.slipping += if point.slips { normal } else { 0.0 };
        self.torque_W += point.position_W.cross(&force_W);
    }

    /// The patch, with the largest pressure on it \[Pa\].
    pub fn finish(self, pressure_max: f64) -> PatchContact {
        let mut p = self.patch;
        p.state = SlipState::of(p.normal, p.slipping);
        if p.normal > 0.0 {
            p.normal_W = p.normal_W.try_normalize(1e-12 * p.normal).unwrap_or_else(Vec3::zeros);
            p.centre_W /= p.normal;
            p.slip_W /= p.normal;
            p.slipping /= p.normal;
        }
        p.torque_W = self.torque_W - p.centre_W.cross(&p.force_W);
        PatchContact { pressure_max, ..p }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::BodyId;

    /// A thing held from two sides: 3 N each, 2 N of friction that turn it. Of the forces nothing
    /// is left, of their sizes all; pressure goes by the sizes.
    #[test]
    fn a_grip_has_no_resultant_but_a_pressure() {
        let side = |sign: f64, area: f64| ContactPoint {
            bodies: [BodyId::Soft(0), BodyId::Rigid(0)],
            vertices: [Some(0), None],
            position_W: Vec3::x() * (-0.01 * sign),
            normal_W: Vec3::x() * sign,
            gap: -1e-5,
            force_W: Vec3::new(3.0, 2.0, 0.0) * sign,
            slip_W: Vec3::zeros(),
            area,
            friction: 1.0,
            slips: false,
        };
        for body in 0..2 {
            let mut sum = PatchSum::default();
            [side(1.0, 1e-5), side(-1.0, 2e-5)].iter().for_each(|point| sum.add(point, body));
            let patch = sum.finish(0.0);
            assert_eq!((patch.normal, patch.skin_normal, patch.shear_sum), (6.0, 6.0, 4.0));
            assert_eq!((patch.push_W(), patch.penetration), (Vec3::zeros(), 1e-5));
            assert_eq!((patch.force_W, patch.shear_W), (Vec3::zeros(), Vec3::zeros()));
            assert!((patch.pressure_mean() - 6.0 / 3e-5).abs() < 1e-6);
        }
        assert_eq!(PatchSum::default().finish(0.0).pressure_mean(), 0.0);
    }

    /// A bone that bears 20 N beside skin that bears 3 N adds to the forces, and nothing to the
    /// pressure.
    #[test]
    fn pressure_is_that_on_the_skin() {
        let point = |first: BodyId, force: f64, area: f64| ContactPoint {
            bodies: [first, BodyId::Rigid(0)],
            vertices: [None; 2],
            position_W: Vec3::zeros(),
            normal_W: Vec3::y(),
            gap: 0.0,
            force_W: Vec3::y() * force,
            slip_W: Vec3::zeros(),
            area,
            friction: 1.0,
            slips: false,
        };
        let mut sum = PatchSum::default();
        sum.add(&point(BodyId::Soft(0), 3.0, 1e-5), 0);
        // Skin beside the load touches as well.
        sum.add(&point(BodyId::Soft(0), 0.0, 2e-5), 0);
        sum.add(&point(BodyId::Rigid(1), 20.0, 0.0), 0);
        let patch = sum.finish(0.0);
        assert_eq!((patch.points, patch.normal, patch.skin_normal), (2, 23.0, 3.0));
        assert_eq!((patch.push_W(), patch.area), (Vec3::y() * 23.0, 1e-5 + 2e-5));
        assert!((patch.pressure_mean() - 1e5).abs() < 1e-6);
    }
}
