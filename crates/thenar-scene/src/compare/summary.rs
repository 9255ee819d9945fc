//! Means and extremes of a comparison.

use super::{Bodies, Deviation, Divergence, Moment, SideMoment};
use crate::session::PARTS;

/// A quantity over time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Mean over time, and over bodies where there are several.
    pub mean: f64,
    /// Largest of all.
    pub max: f64,
    /// Time of the largest \[s\].
    pub time: f64,
    /// Index of the largest in a list of bodies.
    pub at: usize,
    count: f64,
}

impl Peak {
    /// Takes in one moment.
    pub fn take(&mut self, time: f64, apart: Deviation) {
        self.count += 1.0;
        self.mean += (apart.mean - self.mean) / self.count;
        if apart.max > self.max {
            (self.max, self.time, self.at) = (apart.max, time, apart.at);
        }
    }

    fn take_one(&mut self, time: f64, value: f64) {
        self.take(time, Deviation { mean: value, max: value, at: 0 });
    }
}

/// An object.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectSummary {
    /// Distance \[m\].
    pub position: Peak,
    /// Angle \[rad\].
    pub rotation: Peak,
}

/// Palm or finger of a hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartSummary {
    /// Normal force with each solver \[N\], and the size of their difference.
    pub normal: [Peak; 2],
    /// See `normal`.
    pub difference: Peak,
}

/// One solver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SideSummary {
    /// Divergence, if the solver lost the scene.
    pub diverged: Option<Divergence>,
    /// Steps that gave a number that is not finite and were taken back.
    pub failed: u64,
    /// Steps that this solver could not make (`StepReport::fell_back`).
    pub fell_back: u64,
    /// Joint gap \[m\].
    pub joint_gap: Peak,
    /// Misalignment of joint axes \[rad\].
    pub joint_misalignment: Peak,
    /// Penetration \[m\].
    pub penetration: Peak,
    /// Most contacts that carried force.
    pub contacts: u32,
    /// Total energy at the start and at the end \[J\].
    pub energy_start: f64,
    /// See `energy_start`.
    pub energy_end: f64,
    /// Largest total energy \[J\].
    pub energy_max: f64,
}

/// Everything, up to the last step in which both sides had a state.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Bones: distance \[m\].
    pub position: Peak,
    /// Bones: angle \[rad\].
    pub rotation: Peak,
    /// Drives: difference of force \[N\].
    pub drive_force: Peak,
    /// Objects beside the hand.
    pub objects: Vec<ObjectSummary>,
    /// Palm and fingers of each hand.
    pub parts: Vec<[PartSummary; 6]>,
    /// Difference of total energy \[J\].
    pub energy: Peak,
    /// Each solver.
    pub sides: [SideSummary; 2],
}

impl Summary {
    /// A comparison that starts at this moment.
    pub fn new(start: &Moment, bodies: &Bodies) -> Self {
        let side = |s: &Option<SideMoment>| {
            let energy = s.as_ref().map_or(f64::NAN, |s| s.energy);
            SideSummary {
                energy_start: energy,
                energy_end: energy,
                energy_max: energy,
                ..SideSummary::default()
            }
        };
        Self {
            objects: vec![ObjectSummary::default(); bodies.objects.len()],
            parts: vec![[PartSummary::default(); 6]; bodies.hands.len()],
            sides: start.sides.each_ref().map(side),
            ..Self::default()
        }
    }

    /// Takes in the step just done.
    pub fn take(&mut self, moment: &Moment) {
        let time = moment.time;
        let peaks = [&mut self.position, &mut self.rotation, &mut self.drive_force];
        let aparts = [moment.position, moment.rotation, moment.drive_force];
        for (peak, apart) in peaks.into_iter().zip(aparts) {
            apart.into_iter().for_each(|apart| peak.take(time, apart));
        }
        for (object, apart) in self.objects.iter_mut().zip(&moment.objects) {
            if let Some([position, rotation]) = *apart {
                object.position.take_one(time, position);
                object.rotation.take_one(time, rotation);
            }
        }
        for (s, side) in self.sides.iter_mut().zip(&moment.sides) {
            side.iter().for_each(|now| s.take(time, now));
        }
        for (s, side) in moment.sides.iter().enumerate() {
            let Some(side) = side else { continue };
            for (hand, loads) in self.parts.iter_mut().zip(&side.loads) {
                for (part, load) in hand.iter_mut().zip(loads) {
                    part.normal[s].take_one(time, load.normal);
                }
            }
        }
        let [Some(a), Some(b)] = &moment.sides else { return };
        self.energy.take_one(time, (a.energy - b.energy).abs());
        for (h, hand) in self.parts.iter_mut().enumerate() {
            for (p, part) in hand.iter_mut().enumerate() {
                let difference = a.loads[h][p].normal - b.loads[h][p].normal;
                part.difference.take_one(time, difference.abs());
            }
        }
    }

    /// Parts that were pressed on, as hand and part (see [`PARTS`]).
    pub fn touched(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let all = (0..self.parts.len()).flat_map(|h| (0..PARTS.len()).map(move |p| (h, p)));
        all.filter(|&(h, p)| self.parts[h][p].normal.iter().any(|n| n.max > 0.0))
    }
}

impl SideSummary {
    fn take(&mut self, time: f64, now: &SideMoment) {
        self.joint_gap.take_one(time, now.joint_gap);
        self.joint_misalignment.take_one(time, now.joint_misalignment);
        self.penetration.take_one(time, now.penetration);
        self.contacts = self.contacts.max(now.contacts);
        self.energy_end = now.energy;
        self.energy_max = self.energy_max.max(now.energy);
    }
}
