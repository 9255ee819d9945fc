//! The extremes of a run.

use super::Session;
use thenar::model::{BodyId, Digit};
use thenar::world::{ContactPoint, Energy};

/// Largest values of one finger.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FingerPeak {
    /// Sum of normal forces \[N\].
    pub normal: f64,
    /// Size of the summed tangential force \[N\].
    pub shear: f64,
    /// Area in contact \[m²\].
    pub area: f64,
}

/// Extremes since the start of a run.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Most contact constraints in one step.
    pub contacts_max: u32,
    /// Largest distance between the two sides of a joint \[m\].
    pub joint_gap_max: f64,
    /// Deepest penetration \[m\].
    pub penetration_max: f64,
    /// Most elements with negative volume in one step.
    pub inverted_tets_max: u32,
    /// Steps that produced a number that is not finite and were taken back.
    pub non_finite: u64,
    /// Most conjugate-gradient iterations in one step.
    pub cg_iterations_max: u32,
    /// Most contact sweeps in one step.
    pub contact_sweeps_max: u32,
    /// Energies at the start, in the end, and the largest total \[J\].
    pub energy_initial: Energy,
    /// See `energy_initial`.
    pub energy_final: Energy,
    /// Largest total energy \[J\].
    pub energy_max: f64,
    /// Peaks of the five fingers, thumb first, over all hands.
    pub fingers: [FingerPeak; 5],
}

impl Summary {
    /// A run that starts now.
    pub fn new(session: &Session) -> Self {
        let energy = session.world().energy(session.input());
        Self {
            energy_initial: energy,
            energy_final: energy,
            energy_max: energy.total(),
            ..Self::default()
        }
    }

    /// Takes in the step just done.
    pub fn take(&mut self, session: &Session) {
        let r = session.report();
        self.contacts_max = self.contacts_max.max(r.contacts);
        self.joint_gap_max = self.joint_gap_max.max(r.joint_gap_max);
        self.penetration_max = self.penetration_max.max(r.penetration_max);
        self.inverted_tets_max = self.inverted_tets_max.max(r.inverted_tets);
        self.non_finite += u64::from(r.non_finite);
        self.cg_iterations_max = self.cg_iterations_max.max(r.cg_iterations);
        self.contact_sweeps_max = self.contact_sweeps_max.max(r.contact_sweeps);
        self.energy_final = session.world().energy(session.input());
        self.energy_max = self.energy_max.max(self.energy_final.total());
        for hand in session.hands() {
            let Some(soft) = hand.flesh() else { continue };
            let now = fingers(session.world().contacts(), soft, &hand.model.collision_digits);
            for (peak, now) in self.fingers.iter_mut().zip(now) {
                peak.normal = peak.normal.max(now.normal);
                peak.shear = peak.shear.max(now.shear);
                peak.area = peak.area.max(now.area);
            }
        }
    }
}

/// Contact of each finger of the hand whose flesh is `soft`, thumb first. `digits` names the
/// digit of each vertex of its collision surface.
pub fn fingers(contacts: &[ContactPoint], soft: u32, digits: &[Digit]) -> [FingerPeak; 5] {
    let mut sums = [(0.0, thenar::Vec3::zeros(), 0.0); 5];
    for contact in contacts {
        for side in 0..2 {
            let vertex = contact.vertices[side].map(|v| v as usize);
            if contact.bodies[side] != BodyId::Soft(soft) {
                continue;
            }
            let digit = vertex.and_then(|v| digits.get(v));
            let finger = Digit::FINGERS.iter().position(|f| Some(f) == digit);
            let Some(finger) = finger else { continue };
            let normal = contact.force_W.dot(&contact.normal_W);
            let sign = if side == 0 { 1.0 } else { -1.0 };
            sums[finger].0 += normal;
            sums[finger].1 += (contact.force_W - contact.normal_W * normal) * sign;
            sums[finger].2 += if normal > 0.0 { contact.area } else { 0.0 };
        }
    }
    sums.map(|(normal, shear, area)| FingerPeak { normal, shear: shear.norm(), area })
}
