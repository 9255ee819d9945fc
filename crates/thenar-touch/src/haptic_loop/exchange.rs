//! Data that cross between the simulation's thread and the loop: newest values, in slots in which
//! neither side waits for the other.

use crate::{BoneFrame, DIGITS, ProxyTargets, RigidState};
use serde::{Deserialize, Serialize};
use thenar_core::world::{self, State, Target};
use triple_buffer::{Input, Output, triple_buffer};

/// Contact of a finger in a simulation frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FingerContact {
    /// Contact area \[m²\].
    pub area: f64,
    /// Mean pressure over it \[Pa\].
    pub pressure_mean: f64,
    /// Largest pressure \[Pa\].
    pub pressure_max: f64,
    /// Speed at which the skin slips over what it touches \[m/s\].
    pub slip_speed: f64,
}

/// A simulation frame of one hand.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Frame {
    /// Bones, and how they answer.
    pub bones: BoneFrame,
    /// Time at which the frame was made \[ns\]; 0 for the one before the first.
    pub made_ns: u64,
    /// Targets of the bones by script or poses, while nobody leads them.
    pub targets: Vec<Option<Target>>,
    /// Thumb first.
    pub contacts: [FingerContact; DIGITS],
    /// Counts how often the bones were put elsewhere: the scene began anew.
    pub beginnings: u64,
}

/// Lead that the loop gives the bones of one hand.
#[derive(Clone, Debug)]
pub struct Lead {
    /// False until a tracker has moved the hand: the scene's script does.
    pub leads: bool,
    /// The targets of the bones.
    pub proxies: ProxyTargets,
}

/// The simulation's ends of one hand's slots.
pub struct SimulationEndpoints {
    /// Frames go out.
    pub frame: Input<Frame>,
    /// Targets come in.
    pub lead: Output<Lead>,
    /// The state of a simulation that runs within the loop.
    pub state: Option<Output<State>>,
    /// Other inputs of that simulation.
    pub input: Option<Input<world::Input>>,
}

/// The loop's ends.
pub struct LoopEndpoints {
    /// Frames come in.
    pub frame: Output<Frame>,
    /// Targets go out.
    pub lead: Input<Lead>,
    /// The state of a simulation that runs within the loop.
    pub state: Option<Input<State>>,
    /// Other inputs of that simulation.
    pub input: Option<Output<world::Input>>,
}

/// Slots that hold this frame; for a simulation within the loop also its state, and what acts in
/// it, all of this size.
pub fn slots(
    frame: &Frame,
    within: Option<(&State, &world::Input)>,
) -> (SimulationEndpoints, LoopEndpoints) {
    let bones: &[RigidState] = &frame.bones.bones;
    let (frame_in, frame_out) = triple_buffer(frame);
    let lead = Lead { leads: false, proxies: ProxyTargets::new(bones) };
    let (lead_in, lead_out) = triple_buffer(&lead);
    let (state_in, state_out) = within.map(|(state, _)| triple_buffer(state)).unzip();
    let (input_in, input_out) = within.map(|(_, input)| triple_buffer(input)).unzip();
    (
        SimulationEndpoints { frame: frame_in, lead: lead_out, state: state_out, input: input_in },
        LoopEndpoints { frame: frame_out, lead: lead_in, state: state_in, input: input_out },
    )
}
