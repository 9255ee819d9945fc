//! Contact of one frame, resolved against the proxies of one haptic tick.

use crate::RigidState;
use crate::lanes::turn_by;
use crate::shared::values::Values;
use crate::shared::{Condensed, CondensedContact};
use crate::turn::rotation_vector;
use thenar_core::kernels::project;
use thenar_core::math::Vec3;
use thenar_core::model::Cone;

/// Contact forces, where contacts stick, and how far the bones have moved since the frame.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct SharedConstraints {
    /// In empty air: of all contacts only the hand's own, the limits of its joints, and no loads.
    empty_air: bool,
    /// Contact forces in the contact frames \[N\].
    forces: Vec<Vec3>,
    /// Contact values, and where contacts stick.
    values: Values,
    /// Wrenches `k δ` on the bones.
    load: Vec<f64>,
    /// Offset of each bone from its tangent \[m\], and the torque that turns it besides \[N m\].
    bent: Vec<[Vec3; 2]>,
    /// Turn of each proxy since the frame \[rad\], where that is known already.
    turned: Vec<Option<Vec3>>,
    /// Displacements of the bones that the forces of contacts that do not act here would take away
    /// \[m, rad\].
    missed: Vec<f64>,
    /// Displacements q of the bones, those of the tick before, and their rates.
    moved: Vec<f64>,
    moved_before: Vec<f64>,
    rates: Vec<f64>,
    /// No tick yet since the frame began: displacements cannot be compared.
    fresh: bool,
    /// Rates are those of the last tick.
    rated: bool,
}

/// Quality with which one tick was resolved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resolution {
    /// Sweeps over the contacts.
    pub sweeps: u32,
    /// Largest change of a force in the last sweep \[N\].
    pub residual: f64,
    /// Contacts that carry force.
    pub active: u32,
}

impl SharedConstraints {
    /// For frames of this size.
    pub fn new(bones: usize, contacts_max: usize) -> Self {
        Self {
            empty_air: false,
            forces: Vec::with_capacity(contacts_max),
            values: Values::new(bones, contacts_max),
            load: vec![0.0; 6 * bones],
            bent: vec![[Vec3::zeros(); 2]; bones],
            turned: vec![None; bones],
            missed: vec![0.0; 6 * bones],
            moved: vec![0.0; 6 * bones],
            moved_before: vec![0.0; 6 * bones],
            rates: vec![0.0; 6 * bones],
            fresh: true,
            rated: false,
        }
    }

    /// For the same hand in empty air: nothing touches it and nothing loads it.
    pub fn in_empty_air(bones: usize, contacts_max: usize) -> Self {
        Self { empty_air: true, ..Self::new(bones, contacts_max) }
    }

    /// True if contact `i` of a frame acts here.
    fn acts(&self, frame: &Condensed, i: usize) -> bool {
        !self.empty_air || frame.is_limit(i)
    }

    /// Starts from a new frame: its own forces, sticking where it says. Bones keep their velocity
    /// until the second tick.
    pub fn begin(&mut self, frame: &Condensed) {
        self.forces.clear();
        let (empty_air, none) = (self.empty_air, Vec3::zeros());
        self.forces.extend(frame.contacts.iter().enumerate().map(|(i, contact)| {
            if empty_air && !frame.is_limit(i) { none } else { contact.force }
        }));
        self.values.begin(frame, |i| !empty_air || frame.is_limit(i));
        self.missed.fill(0.0);
        if frame.is_ready() && self.missed.len() == 6 * frame.bones() {
            for (i, contact) in frame.contacts.iter().enumerate() {
                if !self.acts(frame, i) {
                    add_lifted(frame, i, &-contact.force, &mut self.missed);
                }
            }
        }
        self.moved.fill(0.0);
        self.fresh = true;
    }

    /// Contact forces on the hand, in the contact frames \[N\].
    pub fn forces(&self) -> &[Vec3] {
        &self.forces
    }

    /// Finds forces and displacements for these proxies by projected Gauss-Seidel, started from
    /// those of the tick before, `h` \[s\] ago, until no force changes by more than `tolerance`
    /// \[N\]. A frame that is not prepared, or not the one last begun, moves nothing.
    pub fn resolve(
        &mut self,
        frame: &Condensed,
        proxies: &[RigidState],
        h: f64,
        tolerance: f64,
        sweeps_max: u32,
    ) -> Resolution {
        self.rated = false;
        let begun = self.forces.len() == frame.contacts.len();
        let fits = self.load.len() == 6 * frame.bones() && proxies.len() == frame.bones();
        if !(frame.is_ready() && begun && fits) {
            return Resolution::default();
        }
        self.pull(frame, proxies);
        let Self { values, load, forces, empty_air, .. } = self;
        let acts = |i: usize| !*empty_air || frame.is_limit(i);
        values.measure(frame, load, forces, acts);
        let mut resolution = Resolution::default();
        while resolution.sweeps < sweeps_max {
            resolution.sweeps += 1;
            resolution.residual = self.sweep(frame);
            if resolution.residual <= tolerance {
                break;
            }
        }
        self.values.settle(&self.load);
        self.follow(frame, h);
        resolution.active = self.forces.iter().filter(|f| f.x > 0.0).count() as u32;
        resolution
    }

    /// Puts `bones` where they are now: the frame's, displaced.
    pub fn place(&self, frame: &[RigidState], bones: &mut [RigidState]) {
        let part = |q: &[f64], k: usize| Vec3::new(q[k], q[k + 1], q[k + 2]);
        for (i, (bone, of_frame)) in bones.iter_mut().zip(frame).enumerate() {
            bone.pose_WB.position = of_frame.pose_WB.position + part(&self.moved, 6 * i);
            bone.velocity_W = part(&self.rates, 6 * i);
            bone.angular_velocity_W = part(&self.rates, 6 * i + 3);
        }
        let all = bones.len().min(frame.len());
        turn_by(&mut bones[..all], |i, _| (self.turn(i), frame[i].pose_WB.rotation));
    }

    /// Turn of bone `i` since the frame, world \[rad\].
    pub fn turn(&self, i: usize) -> Vec3 {
        Vec3::from_column_slice(&self.moved[6 * i + 3..6 * i + 6])
    }

    /// Says what the linear response does not know of a bone that has turned: how far it is off its
    /// tangent \[m\], and what turns it besides \[N m\], both in the world; `turned` is how far its
    /// proxy has turned since the frame \[rad\].
    pub fn bend(&mut self, bone: usize, off: Vec3, torque: Vec3, turned: Vec3) {
        (self.bent[bone], self.turned[bone]) = ([off, torque], Some(turned));
    }

    /// Forgets how bones have turned.
    pub fn straighten(&mut self) {
        self.bent.fill([Vec3::zeros(); 2]);
        self.turned.fill(None);
    }

    /// True if contact that acts here bore load in the frame, or anything else from outside did:
    /// limits of joints do not count.
    pub fn bears(&self, frame: &Condensed) -> bool {
        let bears = |(i, contact): (usize, &CondensedContact)| {
            !frame.is_limit(i) && contact.force != Vec3::zeros()
        };
        let loaded = || frame.loads.iter().any(|load| *load != 0.0);
        !self.empty_air && (frame.contacts.iter().enumerate().any(bears) || loaded())
    }

    /// True if velocities are those of the last tick, and not older.
    pub fn is_rated(&self) -> bool {
        self.rated
    }

    #[cfg(test)]
    pub(crate) fn worked_out(&self) -> usize {
        self.values.worked_out()
    }

    #[cfg(test)]
    pub(crate) fn bent(&self, bone: usize) -> [Vec3; 2] {
        self.bent[bone]
    }

    /// `k δ`, less the loads in empty air: what the moved proxies pull at the bones. A proxy that
    /// is not finite pulls nothing.
    fn pull(&mut self, frame: &Condensed, proxies: &[RigidState]) {
        for (i, proxy) in proxies.iter().enumerate() {
            let (spring, target) = (&frame.springs[i], &frame.targets[i].pose_WB);
            let wrench = if proxy.is_finite() {
                let [off, torque] = self.bent[i];
                let away = proxy.pose_WB.position - target.position - off;
                let turn = self.turned[i].unwrap_or_else(|| {
                    rotation_vector(&(proxy.pose_WB.rotation * target.rotation.inverse()))
                });
                [away * spring.stiffness, turn * spring.angular_stiffness + torque]
            } else {
                [Vec3::zeros(); 2]
            };
            self.load[6 * i..6 * i + 3].copy_from_slice(wrench[0].as_slice());
            self.load[6 * i + 3..6 * i + 6].copy_from_slice(wrench[1].as_slice());
        }
        if self.empty_air {
            self.load.iter_mut().zip(&frame.loads).for_each(|(pull, load)| *pull -= load);
        }
    }

    /// One pass over all contacts; the largest change of a force \[N\].
    fn sweep(&mut self, frame: &Condensed) -> f64 {
        let mut largest = 0.0_f64;
        for (i, contact) in frame.contacts.iter().enumerate() {
            if !self.acts(frame, i) {
                continue;
            }
            let force = self.forces[i];
            let Some(value) = self.values.of(frame, &self.load, i, &force) else { continue };
            let own = frame.block(i);
            let new = project(Cone::Circular, contact.friction, &own, &value, &force);
            let change = new - force;
            if change == Vec3::zeros() {
                continue;
            }
            self.forces[i] = new;
            largest = largest.max(change.amax());
            self.values.add_response(frame, i, &change);
        }
        largest
    }

    /// `q = q₀ + C (k δ + Jᵀ (f - f₀))`.
    fn follow(&mut self, frame: &Condensed, h: f64) {
        std::mem::swap(&mut self.moved, &mut self.moved_before);
        frame.compliance_times(&self.load, &mut self.moved);
        self.moved.iter_mut().zip(&frame.rest).for_each(|(q, rest)| *q += rest);
        self.moved.iter_mut().zip(&self.missed).for_each(|(q, missed)| *q += missed);
        for (i, contact) in frame.contacts.iter().enumerate() {
            if self.acts(frame, i) {
                add_lifted(frame, i, &(self.forces[i] - contact.force), &mut self.moved);
            }
        }
        self.rated = !self.fresh && h > 0.0;
        if self.rated {
            let ways = self.moved.iter().zip(&self.moved_before);
            self.rates.iter_mut().zip(ways).for_each(|(rate, (q, q0))| *rate = (q - q0) / h);
        }
        self.fresh = false;
    }
}

/// Adds to the displacements `q` of the bones what a `change` of the force of contact `i` \[N\]
/// moves them by.
fn add_lifted(frame: &Condensed, i: usize, change: &Vec3, q: &mut [f64]) {
    for r in 0..3 {
        if change[r] != 0.0 {
            frame.add_lifted(3 * i + r, change[r], q);
        }
    }
}
