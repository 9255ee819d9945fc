//! Stiffness and damping of the two couplings of a proxy.

use crate::{Proxy, RigidState};
use thenar_core::kernels::drive_force;
use thenar_core::math::{Mat3, Vec3};
use thenar_core::model::{Drive, HandModel};

/// Free choices in a proxy's couplings; the rest follows from the bone's mass and inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CouplingDesign {
    /// Between tracked pose and proxy \[N/m\]: with `bone_stiffness` in series, what the wearer
    /// feels of a bone that cannot move. More is crisper; `stability` bounds it.
    pub device_stiffness: f64,
    /// Between proxy and simulated bone \[N/m\].
    pub bone_stiffness: f64,
    /// Distance from the bone's centre at which turning is as stiff as pushing \[m\]:
    /// angular stiffness = stiffness × lever². About half a phalanx.
    pub lever: f64,
    /// Damping of the proxy between both couplings over its critical damping; 1 settles fastest.
    pub damping_ratio: f64,
    /// Damping of the device coupling \[N s/m\], part of the above. It amplifies the noise of the
    /// measured velocity, so it is kept small and the bone coupling supplies the rest.
    pub device_damping: f64,
}

impl Default for CouplingDesign {
    /// 400 N/m to a bone that cannot move, critically damped.
    fn default() -> Self {
        Self {
            device_stiffness: 800.0,
            bone_stiffness: 800.0,
            lever: 0.02,
            damping_ratio: 1.0,
            device_damping: 0.2,
        }
    }
}

impl CouplingDesign {
    /// The proxies of a hand, one per bone; their bone couplings are also the drives of the bones.
    pub fn hand(&self, hand: &HandModel) -> Vec<Proxy> {
        hand.bones.iter().map(|bone| self.proxy(bone.mass, &bone.inertia)).collect()
    }

    /// The proxy of a bone of this mass \[kg\] and inertia about its centre \[kg m²\].
    ///
    /// Held by both couplings, stiffness K in all, a mass m has critical damping 2 √(m K). About
    /// the centre the axis of largest inertia gets this ratio, the others more.
    pub fn proxy(&self, mass: f64, inertia_B: &Mat3) -> Proxy {
        let stiffness = self.device_stiffness + self.bone_stiffness;
        let damping = 2.0 * self.damping_ratio * (mass * stiffness).sqrt();
        let largest = inertia_B.symmetric_eigenvalues().max();
        let square = self.lever * self.lever;
        let turning = 2.0 * self.damping_ratio * (largest * stiffness * square).sqrt();
        let share = if damping > 0.0 { (self.device_damping / damping).min(1.0) } else { 0.0 };
        let drive = |stiffness: f64, share: f64| Drive {
            stiffness,
            damping: damping * share,
            angular_stiffness: stiffness * square,
            angular_damping: turning * share,
        };
        Proxy {
            mass,
            inertia_B: *inertia_B,
            device: drive(self.device_stiffness, share),
            bone: drive(self.bone_stiffness, 1.0 - share),
        }
    }
}

impl Proxy {
    /// The proxy of a bone that has a drive of its own: held to it by this drive, and to the hand
    /// no softer than that. With it the parts of the device coupling's force and torque that the
    /// wearer is shown, so that a bone that cannot move is felt as stiff as the softer hold would
    /// have it.
    ///
    /// A softer hold on the hand than on the bone lets the simulated hand go elsewhere than the
    /// real one: a palm that is driven with 10 N m/rad but held with 0.3 pitches forward when its
    /// fingers bend.
    pub fn driven_by(&self, drive: &Drive) -> (Self, [f64; 2]) {
        let part = |own: f64, bone: f64| {
            if bone > own { series_stiffness(own, bone) / (0.5 * bone) } else { 1.0 }
        };
        let shown = [
            part(self.device.stiffness, drive.stiffness),
            part(self.device.angular_stiffness, drive.angular_stiffness),
        ];
        let device = Drive {
            stiffness: self.device.stiffness.max(drive.stiffness),
            angular_stiffness: self.device.angular_stiffness.max(drive.angular_stiffness),
            ..self.device
        };
        (Self { device, bone: *drive, ..*self }, shown)
    }

    /// A proxy of `part` of the mass, as critically damped by its bone coupling as before.
    pub fn lighter(&self, part: f64) -> Self {
        let root = part.sqrt();
        let bone = Drive {
            damping: root * self.bone.damping,
            angular_damping: root * self.bone.angular_damping,
            ..self.bone
        };
        Self { mass: part * self.mass, inertia_B: self.inertia_B * part, bone, ..*self }
    }
}

/// Force \[N\] and torque \[N m\] on the wearer, world, of a coupling between the hand and a body,
/// both after a step: what a drive did, felt from its other end.
pub fn drive_reaction(drive: &Drive, hand: &RigidState, body: &RigidState) -> [Vec3; 2] {
    let [pull, twist] = drive_force(drive, &hand.target(), &body.pose_WB);
    let slip = body.velocity_W - hand.velocity_W;
    let spin = body.angular_velocity_W - hand.angular_velocity_W;
    [slip * drive.damping - pull, spin * drive.angular_damping - twist]
}

/// Stiffness of two springs one after the other: what is felt through a proxy at rest \[N/m\].
pub fn series_stiffness(a: f64, b: f64) -> f64 {
    if a + b > 0.0 { a * b / (a + b) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::math::{Pose, Quat};

    /// The textbook ratio c / (2 √(m K)), for both kinds of motion.
    #[test]
    fn the_proxy_has_the_damping_ratio_asked_for() {
        let inertia = Mat3::from_diagonal(&Vec3::new(2e-7, 3e-8, 1e-7));
        for ratio in [0.3, 1.0, 1.7] {
            let design = CouplingDesign { damping_ratio: ratio, ..CouplingDesign::default() };
            let proxy = design.proxy(0.004, &inertia);
            let (d, b) = (&proxy.device, &proxy.bone);
            let critical = 2.0 * (0.004 * (d.stiffness + b.stiffness)).sqrt();
            assert!(((d.damping + b.damping) / critical - ratio).abs() < 1e-12);
            let k = d.angular_stiffness + b.angular_stiffness;
            let turning = d.angular_damping + b.angular_damping;
            assert!((turning / (2.0 * (2e-7 * k).sqrt()) - ratio).abs() < 1e-12);
            assert!((d.damping - 0.2).abs() < 1e-12);
        }
    }

    /// A bone that cannot move is felt through both springs as through those of the design, and the
    /// proxy is never held softer to the hand than to the bone.
    #[test]
    fn a_firmer_hold_is_not_felt_stiffer() {
        let own = CouplingDesign::default().proxy(0.004, &Mat3::from_diagonal_element(1e-7));
        for (k, turning) in [(100.0, 0.1), (800.0, 0.32), (4000.0, 10.0)] {
            let drive = Drive { stiffness: k, angular_stiffness: turning, ..own.bone };
            let (proxy, shown) = own.driven_by(&drive);
            assert!(proxy.device.stiffness >= k && proxy.device.angular_stiffness >= turning);
            assert_eq!(proxy.bone, drive);
            let felt = shown[0] * series_stiffness(proxy.device.stiffness, k);
            assert!((felt - 800.0 * k / (800.0 + k)).abs() < 1e-9, "{felt} N/m through {k} N/m");
            let felt = shown[1] * series_stiffness(proxy.device.angular_stiffness, turning);
            assert!((felt - 0.32 * turning / (0.32 + turning)).abs() < 1e-12, "{felt} N m/rad");
        }
    }

    /// A body that lags behind holds the hand back; one that turns less twists it back.
    #[test]
    fn the_wearer_feels_the_other_end_of_a_drive() {
        let drive =
            Drive { stiffness: 500.0, damping: 2.0, angular_stiffness: 0.4, angular_damping: 0.01 };
        let turn = Quat::from_scaled_axis(Vec3::z() * 0.5);
        let hand = RigidState {
            pose_WB: Pose::new(Vec3::x() * 0.01, turn),
            velocity_W: Vec3::x() * 0.1,
            angular_velocity_W: Vec3::z() * 2.0,
        };
        let body = RigidState::at_rest(Pose::identity());
        let [force, torque] = drive_reaction(&drive, &hand, &body);
        assert!((force - Vec3::x() * -(500.0 * 0.01 + 2.0 * 0.1)).norm() < 1e-12);
        assert!((torque - Vec3::z() * -(0.4 * 0.5 + 0.01 * 2.0)).norm() < 1e-12);
    }

    #[test]
    fn springs_in_series() {
        assert_eq!(series_stiffness(800.0, 800.0), 400.0);
        assert_eq!(series_stiffness(1000.0, 600.0), 375.0);
        assert_eq!(series_stiffness(0.0, 0.0), 0.0);
    }
}
