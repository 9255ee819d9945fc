//! State that a grip keeps from step to step: with it, another session of the same scene continues
//! with the same bits.

use super::opposition::PADS_MAX;
use super::order::Order;
use super::surface::Anchor;
use super::trouble::Trouble;
use serde::{Deserialize, Serialize};
use thenar_core::{Vec3, World};
use thenar_track::reach::{Angles, FREEDOMS_MAX};

/// Phase of a grip.
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

/// State of one pad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PadMemory {
    /// Place that the pad makes for; none for a pad that does not take part.
    pub anchor: Option<Anchor>,
    /// True once the pad has met the object.
    pub touched: bool,
    /// Centre of the pad by its targets when it met the object, in the palm's frame \[m\].
    pub point_P: Vec3,
    /// Direction out of its skin there, in the palm's frame.
    pub normal_P: Vec3,
    /// Lead of the targets over the pad that brings the pad itself where it should be, in the
    /// palm's frame \[m\].
    pub lead_P: Vec3,
    /// Angles that its targets make for \[rad\].
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

/// No palm is so far aside \[m\], nor so fast on its way there \[m/s\].
const ASIDE_MAX: f64 = 1.0;

/// Response of a grip to load. Came later to the form of a keyframe than the rest, and stands
/// behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reflex {
    /// [`Order::adapts`] of the present and of the waiting order.
    pub adapts: [bool; 2],
    /// Force that is wanted now \[N\].
    pub wanted: f64,
    /// Part of what friction can give that the side with less in hand uses up.
    pub used: f64,
    /// Depth by which each pad is pushed in beyond the others, so that it bears its share \[m\].
    pub further: [f64; PADS_MAX],
    /// Goal of the palm's shift from where its script or its pose has it, in its own frame \[m\].
    pub aside_P: Vec3,
    /// Present shift of the palm, and its rate \[m, m/s\].
    pub shift_P: [Vec3; 2],
    /// True once the object was pressed with half of what is wanted.
    pub held: bool,
    /// Time for which it has been gone after that \[s\].
    pub gone: f64,
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
    /// Time spent in that phase \[s\].
    pub since: f64,
    /// Pads: the base's first.
    pub pads: [PadMemory; PADS_MAX],
    /// From the base to the fingers, in the palm's frame.
    pub axis_P: Vec3,
    /// Depth to which pads are pushed in \[m\].
    pub depth: f64,
    /// Sum of the normal forces of each digit (palm, thumb, index, middle, ring, little) on the
    /// object in the last step \[N\].
    pub felt: [f64; 6],
    /// Force of the two sides against each other, smoothed \[N\].
    pub force: f64,
    /// Trouble of the grip, if any.
    pub trouble: Option<Trouble>,
    /// Angles of the script in the step before \[rad\]; empty before the first.
    pub script: Vec<[f64; 2]>,
    /// Response to load.
    #[serde(skip)]
    pub reflex: Reflex,
}

impl GripMemory {
    /// Returns the response to load, complete.
    pub fn reflex(&self) -> Reflex {
        let adapts = [self.order, self.waiting].map(|order| order.is_some_and(|o| o.adapts));
        Reflex { adapts, ..self.reflex }
    }

    /// Continues with this response to load.
    pub fn set_reflex(&mut self, reflex: Reflex) {
        let orders = [&mut self.order, &mut self.waiting];
        for (order, adapts) in orders.into_iter().zip(reflex.adapts) {
            *order = order.map(|order| order.adapting(adapts));
        }
        self.reflex = reflex;
    }

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
        let Reflex { wanted, used, further, gone, aside_P, shift_P, .. } = &self.reflex;
        let shifts = shift_P.iter().chain([aside_P]).flat_map(|v| v.iter());
        let reflex = further.iter().chain([wanted, used, gone]).chain(shifts).copied();
        let mut numbers = lists.chain(own).chain(reflex);
        let mut more = [self.since, self.depth, self.force].into_iter();
        numbers.all(f64::is_finite)
            && [aside_P, &shift_P[0], &shift_P[1]].iter().all(|v| v.norm() < ASIDE_MAX)
            && more.all(f64::is_finite)
            && self.script.iter().flatten().all(|x| x.is_finite())
            && anchors.into_iter().all(|anchor| anchor.fits(world))
            && orders.into_iter().all(|order| order.fits(world))
    }
}
