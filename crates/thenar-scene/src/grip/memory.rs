//! What a grip remembers from step to step: with it, another session of the same scene goes on with the same bits.

use super::opposition::PADS_MAX;
use super::order::Order;
use super::surface::Anchor;
use super::trouble::Trouble;
use serde::{Deserialize, Serialize};
use thenar::{Vec3, World};
use thenar_track::reach::{Angles, FREEDOMS_MAX};

/// What a grip is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Nothing: the fingers follow their script or their poses.
    #[default]
    Idle,
    /// Pads go to places before the surface.
    Reaching,
    /// Pads go in until each touches.
    Closing,
    /// Pads press with the force that was asked for.
    Holding,
    /// The fingers go back to their script or their poses.
    Opening,
}

impl Phase {
    /// Name, as Python and the page have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Reaching => "reaching",
            Self::Closing => "closing",
            Self::Holding => "holding",
            Self::Opening => "opening",
        }
    }
}

/// What is remembered of one pad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PadMemory {
    /// Where it goes; none for a pad that does not take part.
    pub anchor: Option<Anchor>,
    /// Has it met the object.
    pub touched: bool,
    /// Where the targets had its centre when it met the object, in the palm's frame \[m\].
    pub point_P: Vec3,
    /// Direction out of its skin there, in the palm's frame.
    pub normal_P: Vec3,
    /// What targets are ahead of the pad, so that the pad itself is where it should be, in the palm's frame \[m\].
    pub lead_P: Vec3,
    /// What its targets make for \[rad\].
    pub goal: Angles,
    /// Targets of the joint angles \[rad\].
    pub angles: Angles,
    /// Rates of the angles \[rad/s\].
    pub rates: Angles,
}

impl Default for PadMemory {
    fn default() -> Self {
        Self {
            anchor: None,
            touched: false,
            point_P: Vec3::zeros(),
            normal_P: Vec3::y(),
            lead_P: Vec3::zeros(),
            goal: [0.0; FREEDOMS_MAX],
            angles: [0.0; FREEDOMS_MAX],
            rates: [0.0; FREEDOMS_MAX],
        }
    }
}

/// All that changes in the grips of a hand.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GripMemory {
    /// The grip that acts.
    pub order: Option<Order>,
    /// The grip that begins when the hand has opened.
    pub waiting: Option<Order>,
    /// Scripted grips that have begun.
    pub begun: u32,
    /// Present phase of the grip.
    pub phase: Phase,
    /// How long it has been doing that \[s\].
    pub since: f64,
    /// Pads: the base's first.
    pub pads: [PadMemory; PADS_MAX],
    /// From the base to the fingers, in the palm's frame.
    pub axis_P: Vec3,
    /// How far pads are pushed in \[m\].
    pub depth: f64,
    /// Sum of the normal forces of each digit (palm, thumb, index, middle, ring, little) on the object in the last step \[N\].
    pub felt: [f64; 6],
    /// Force of the two sides against each other, smoothed \[N\].
    pub force: f64,
    /// What is amiss.
    pub trouble: Option<Trouble>,
    /// Angles of the script in the step before \[rad\]; empty before the first.
    pub script: Vec<[f64; 2]>,
}

impl GripMemory {
    /// True when its numbers are finite and it names bodies of this world.
    pub fn is_of(&self, world: &World) -> bool {
        let anchors = self.pads.iter().filter_map(|pad| pad.anchor);
        let orders = self.order.iter().chain(&self.waiting);
        let lists = self.pads.iter().flat_map(|pad| {
            let vectors = [pad.point_P, pad.normal_P, pad.lead_P].map(|v| v.iter().sum::<f64>());
            let angles = [pad.goal, pad.angles, pad.rates].map(|a| a.iter().sum::<f64>());
            vectors.into_iter().chain(angles)
        });
        let own = self.felt.iter().chain(self.axis_P.iter()).copied();
        let mut numbers = lists.chain(own).chain([self.since, self.depth, self.force]);
        numbers.all(f64::is_finite)
            && self.script.iter().flatten().all(|x| x.is_finite())
            && anchors.into_iter().all(|anchor| anchor.fits(world))
            && orders.into_iter().all(|order| order.fits(world))
    }
}
