//! The extremes of a run.

use super::{HandLoad, Session};
use thenar_core::world::Energy;

/// Extremes since the start of a run.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Most contact constraints in one step.
    pub contacts_max: u32,
    /// Most contacts left out in one step: see
    /// [`StepReport::contacts_dropped`](thenar_core::world::StepReport).
    pub contacts_dropped_max: u32,
    /// Largest distance between the two sides of a joint \[m\].
    pub joint_gap_max: f64,
    /// Deepest penetration \[m\].
    pub penetration_max: f64,
    /// Most elements with negative volume in one step.
    pub inverted_tets_max: u32,
    /// Most steps in a row after each of which some element had negative volume.
    pub inverted_longest: u64,
    /// Steps in a row of this kind that the last one ended; 0 if it had none.
    pub inverted_now: u64,
    /// Steps that produced a number that is not finite and were taken back.
    pub non_finite: u64,
    /// Steps that the chosen solver could not make, and that were made safely instead.
    pub fell_back: u64,
    /// Steps that were made in parts: see [`StepReport::parts`](thenar_core::world::StepReport).
    pub divided: u64,
    /// Steps whose contact missed the accuracy asked for.
    pub contact_unconverged: u64,
    /// Largest violation of the contact law \[m/s\].
    pub contact_residual_max: f64,
    /// Most conjugate-gradient iterations in one step.
    pub cg_iterations_max: u32,
    /// Most contact sweeps in one step.
    pub contact_sweeps_max: u32,
    /// Steps whose contact was cut short (`contact_work_max`).
    pub contact_cut_short: u64,
    /// Energies at the start, in the end, and the largest total \[J\].
    pub energy_initial: Energy,
    /// See `energy_initial`.
    pub energy_final: Energy,
    /// Largest total energy \[J\].
    pub energy_max: f64,
    /// Peaks of the five fingers, thumb first, over all hands.
    pub fingers: [HandLoad; 5],
    /// Peaks of the five fingers of each hand.
    pub hands: Vec<[HandLoad; 5]>,
}

impl Summary {
    /// A run that starts now.
    pub fn new(session: &Session) -> Self {
        let energy = session.world().energy(session.input());
        Self {
            energy_initial: energy,
            energy_final: energy,
            energy_max: energy.total(),
            hands: vec![<[HandLoad; 5]>::default(); session.hands().len()],
            ..Self::default()
        }
    }

    /// Takes in the step just done.
    pub fn take(&mut self, session: &Session) {
        let r = session.report();
        self.contacts_max = self.contacts_max.max(r.contacts);
        self.contacts_dropped_max = self.contacts_dropped_max.max(r.contacts_dropped);
        self.joint_gap_max = self.joint_gap_max.max(r.joint_gap_max);
        self.penetration_max = self.penetration_max.max(r.penetration_max);
        self.take_inverted(r.inverted_tets);
        self.non_finite += u64::from(r.non_finite);
        self.fell_back += u64::from(r.fell_back);
        self.divided += u64::from(r.parts > 1);
        self.contact_unconverged += u64::from(r.contact_unconverged);
        self.contact_cut_short += u64::from(r.contact_cut_short);
        self.contact_residual_max = self.contact_residual_max.max(r.contact_residual);
        self.cg_iterations_max = self.cg_iterations_max.max(r.cg_iterations);
        self.contact_sweeps_max = self.contact_sweeps_max.max(r.contact_sweeps);
        self.energy_final = session.world().energy(session.input());
        self.energy_max = self.energy_max.max(self.energy_final.total());
        for (hand, own) in self.hands.iter_mut().enumerate() {
            let [_, fingers @ ..] = session.hand_loads(hand);
            for ((peak, own), now) in self.fingers.iter_mut().zip(own).zip(fingers) {
                peak.grow(&now);
                own.grow(&now);
            }
        }
    }

    /// Takes in how many elements have negative volume after a step.
    fn take_inverted(&mut self, count: u32) {
        self.inverted_tets_max = self.inverted_tets_max.max(count);
        self.inverted_now = if count == 0 { 0 } else { self.inverted_now + 1 };
        self.inverted_longest = self.inverted_longest.max(self.inverted_now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One step, then three with a break after them, then two that go on.
    #[test]
    fn the_longest_series_of_inverted_steps_is_kept() {
        let mut summary = Summary::default();
        for count in [0, 4, 0, 1, 7, 2, 0, 3, 3] {
            summary.take_inverted(count);
        }
        assert_eq!(summary.inverted_tets_max, 7);
        assert_eq!((summary.inverted_longest, summary.inverted_now), (3, 2));
    }
}
