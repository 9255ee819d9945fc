//! The simulation's side: proxies in before a step, a frame out after it.

use super::actuators::Actuators;
use super::exchange::{FingerContact, Frame, SimulationEndpoints, slots};
use super::hand::LoopHand;
use super::simulation::{SimulatedHand, Simulation};
use super::turning::felt_turn;
use super::{Core, Shared};
use crate::safety::LimitError;
use crate::{
    BoneFrame, BoneJoint, CouplingDesign, DIGITS, EmptyAirHand, FeltBounds, FeltStiffness,
    HandOutput, HandSettings, HapticHand, ProxyError, ProxyMode, RigidState, SingleRate,
    SingleRateSettings, Touch, series_drive, series_stiffness,
};
use std::ops::Range;
use std::sync::{Arc, PoisonError};
use thenar_core::model::{Digit, Drive, Side, SolverKind};
use thenar_core::readout::ContactReadout;
use thenar_core::world::{ModelError, World};
use thenar_track::live::LiveError;

/// Mode in which touch joins the tracked hand and the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LoopMode {
    /// Proxies, and the simulation's newest bones carried forward: the paper's.
    Multirate,
    /// The whole simulation steps within the tick.
    SingleRate,
    /// Proxies, and contact solved anew each tick on the condensed frame; frames without a
    /// response, of the two-step scheme, as in `Multirate`.
    #[default]
    Shared,
}

/// Why hands cannot be felt.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// The scene has none that poses could move.
    #[error("the scene has no hand that a device could move")]
    NoHand,
    /// A hand cannot be moved.
    #[error(transparent)]
    Live(#[from] LiveError),
    /// The bones of a hand cannot have proxies.
    #[error(transparent)]
    Proxies(#[from] ProxyError),
    /// A device's limits make no sense.
    #[error(transparent)]
    Limits(#[from] LimitError),
    /// The hand cannot be taken out of its world, or not be driven as it is felt.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// One simulation within the loop, one hand.
    #[error("single-rate takes one hand; the scene has {0}")]
    OneHand(usize),
}

/// A hand of the simulation with what its port keeps for it.
struct PortHand {
    /// Index in the simulation.
    index: usize,
    /// First of its bones among the rigid bodies.
    first: usize,
    drives: Vec<Option<Drive>>,
    ends: SimulationEndpoints,
    /// A flag for frames that have a response, and how often the world was retuned when that was
    /// last looked at.
    responds: bool,
    retuned: u64,
    /// The hand in empty air, where frames have no response that tells of it.
    free: Option<EmptyAirHand>,
}

/// Port for whoever steps the simulation.
pub struct SimulationPort {
    shared: Arc<Shared>,
    mode: LoopMode,
    design: CouplingDesign,
    bounds: FeltBounds,
    hands: Vec<PortHand>,
    readout: Option<ContactReadout>,
    began_ns: u64,
    beginnings: u64,
    /// Steps of the simulation after the last one; fewer when the scene has begun anew.
    steps: u64,
    /// Frames made.
    frames: u64,
}

impl SimulationPort {
    pub(super) fn new(
        shared: Arc<Shared>,
        mode: LoopMode,
        design: CouplingDesign,
        bounds: FeltBounds,
    ) -> Self {
        Self {
            shared,
            mode,
            design,
            bounds,
            hands: Vec::new(),
            readout: None,
            began_ns: 0,
            beginnings: 0,
            steps: 0,
            frames: 0,
        }
    }

    /// Puts the hands of a simulation into the loop, in place of those before. Of several hands of
    /// one side the first is felt the others keep their scripts. Allocates.
    ///
    /// # Errors
    /// Its hands cannot be felt. The loop is without hands then.
    pub fn attach(&mut self, simulation: &impl Simulation) -> Result<(), PortError> {
        let made = self.make(simulation);
        let (slow, mut hands, mut actuators) = match made {
            Ok(made) => made,
            Err(error) => {
                self.hands.clear();
                self.replace(&mut Vec::new(), &mut Vec::new());
                return Err(error);
            }
        };
        self.hands = slow;
        let world = simulation.world();
        self.readout = self
            .hands
            .iter()
            .any(|h| simulation.hand(h.index).is_some_and(|hand| hand.flesh.is_some()))
            .then(|| ContactReadout::new(world));
        self.steps = simulation.steps();
        self.keep_first_frames();
        self.shared.lock_hands();
        self.replace(&mut hands, &mut actuators);
        Ok(())
    }

    /// The frames that the hands begin on.
    fn keep_first_frames(&mut self) {
        let Some(frames) = &self.shared.frames else { return };
        frames.clear();
        for (number, hand) in self.hands.iter_mut().enumerate() {
            frames.put(number, hand.ends.frame.input_buffer_mut());
        }
    }

    fn replace(&self, hands: &mut Vec<LoopHand>, actuators: &mut Vec<Actuators>) {
        let mut outputs: Vec<_> = (0..actuators.len())
            .map(|i| HandOutput::released(hands[i % hands.len()].side(), 0))
            .collect();
        // The loop leaves out a tick while it is held; the old hands are dropped after.
        let mut core = self.shared.core.lock().unwrap_or_else(PoisonError::into_inner);
        core.replace(hands, actuators, &mut outputs);
    }

    #[allow(clippy::type_complexity)] // what `attach` puts in, and nothing else
    fn make(
        &self,
        simulation: &impl Simulation,
    ) -> Result<(Vec<PortHand>, Vec<LoopHand>, Vec<Actuators>), PortError> {
        let mut sides: Vec<(Side, usize)> = Vec::new();
        let hands = (0..).map_while(|index| Some((index, simulation.hand(index)?)));
        for (index, hand) in hands {
            let Some(side) = hand.model.side.filter(|_| hand.driven) else { continue };
            if sides.iter().all(|(known, _)| *known != side) {
                sides.push((side, index));
            }
        }
        if sides.is_empty() {
            return Err(PortError::NoHand);
        }
        if self.mode == LoopMode::SingleRate && sides.len() > 1 {
            return Err(PortError::OneHand(sides.len()));
        }
        let (mut slow, mut fast) = (Vec::new(), Vec::new());
        for (side, index) in sides {
            let Some(hand) = simulation.hand(index) else { continue };
            let (port, hand) = self.make_hand(simulation, &hand, (side, index))?;
            slow.push(port);
            fast.push(hand);
        }
        // The loop's memory is not held for this: it allocates.
        let actuators = Core::guards(&self.shared.capabilities, fast.len())?;
        Ok((slow, fast, actuators))
    }

    fn make_hand(
        &self,
        simulation: &impl Simulation,
        hand: &SimulatedHand,
        (side, index): (Side, usize),
    ) -> Result<(PortHand, LoopHand), PortError> {
        let world = simulation.world();
        let (model, bones) = (hand.model, hand.bones.clone());
        let range = bones.start as usize..bones.end as usize;
        let start: Vec<_> = bones.clone().map(|i| RigidState::of(world, i)).collect();
        let drives: Vec<_> = world.desc().drives[range.clone()].to_vec();
        let single = self.mode == LoopMode::SingleRate;
        let responds = self.responds(world);
        let free = (!single && !responds)
            .then(|| EmptyAirHand::of(world, bones.clone(), true))
            .transpose()?;
        let frame = Frame {
            bones: BoneFrame::new(&start, self.contacts_max()),
            made_ns: 0,
            targets: simulation.input().targets[range.clone()].to_vec(),
            contacts: [FingerContact::default(); DIGITS],
            beginnings: self.beginnings,
        };
        // The scene's drives are the couplings to the bones; displays bound what is shown of them.
        let held = || {
            let each = self.design.hand(model).into_iter().zip(&drives);
            each.map(|(proxy, drive)| (proxy, drive.unwrap_or(proxy.bone)))
        };
        let touch: Box<dyn Touch + Send> = if single {
            let settings = SingleRateSettings { weightless: true, ..SingleRateSettings::default() };
            // The drive of a bone is both couplings of a proxy in one.
            let mut within = world.clone();
            let mut desc = world.desc().clone();
            let mut shown = Vec::new();
            for (own, (proxy, drive)) in desc.drives[range.clone()].iter_mut().zip(held()) {
                let (proxy, parts) = proxy.driven_by(&drive);
                *own = own.map(|_| series_drive(&proxy.device, &proxy.bone));
                shown.push(parts);
            }
            within.retune(desc)?;
            let mut inner = SingleRate::new(settings, within, bones.clone())?;
            if let Some(input) = inner.input_mut() {
                input.copy_from(simulation.input());
            }
            for (bone, parts) in shown.into_iter().enumerate() {
                inner.show(bone, parts);
            }
            Box::new(inner)
        } else {
            let settings = HandSettings {
                mode: if responds { ProxyMode::SharedConstraints } else { ProxyMode::Multirate },
                ..HandSettings::default()
            };
            let (proxies, parts): (_, Vec<_>) =
                held().map(|(proxy, drive)| proxy.driven_by(&drive)).unzip();
            let mut hand = HapticHand::new(settings, proxies, &start, self.contacts_max())?;
            for (bone, parts) in parts.into_iter().enumerate() {
                hand.show(bone, parts);
            }
            hand.set_joints(bone_joints(world, &range));
            Box::new(hand)
        };
        let (slow, fast) = slots(&frame, single.then(|| (world.state(), simulation.input())));
        let mut live = simulation.live_hand(index)?;
        live.follow_at(FOLLOW_HZ);
        live.doubt_glitches();
        live.press_no_pads();
        let mut hand = LoopHand::new(side, model, live, touch, fast);
        let felt = held().map(|(proxy, drive)| {
            let (proxy, [part, _]) = proxy.driven_by(&drive);
            part * series_stiffness(proxy.device.stiffness, proxy.bone.stiffness)
        });
        let turn = held().next().map(|(proxy, drive)| {
            let (proxy, [_, part]) = proxy.driven_by(&drive);
            felt_turn(self.bounds, &proxy, part)
        });
        hand.bound(FeltStiffness::new(self.bounds, felt.collect()), turn);
        let (first, retuned) = (range.start, world.retuned());
        Ok((PortHand { index, first, drives, ends: slow, responds, retuned, free }, hand))
    }

    /// The hands in empty air take over the parameters of their world.
    fn retune(&mut self, world: &World) -> Result<(), PortError> {
        for hand in &mut self.hands {
            hand.free.as_mut().map_or(Ok(()), |free| free.retune(world))?;
            hand.retuned = world.retuned();
        }
        Ok(())
    }

    /// True if frames of this world have a response: another solver publishes none.
    fn responds(&self, world: &World) -> bool {
        self.mode == LoopMode::Shared && world.desc().solver.kind == SolverKind::Monolithic
    }

    fn contacts_max(&self) -> usize {
        if self.mode == LoopMode::Shared { CONTACTS_MAX } else { 0 }
    }

    /// Before a step, at `now_ns`: the newest proxies become the targets of the bones. Hands whose
    /// drives were changed are put into the loop anew, and other settings carried over, which
    /// allocates; otherwise nothing does.
    ///
    /// # Errors
    /// As [`SimulationPort::attach`].
    pub fn before_step(
        &mut self,
        simulation: &mut impl Simulation,
        now_ns: u64,
    ) -> Result<(), PortError> {
        let (drives, retuned) = (&simulation.world().desc().drives, simulation.world().retuned());
        let responds = self.responds(simulation.world());
        let same = |hand: &PortHand| {
            drives[hand.first..][..hand.drives.len()] == hand.drives[..]
                && hand.responds == responds
        };
        let anew = simulation.steps() < self.steps;
        let tuned = self.hands.iter().any(|hand| hand.retuned != retuned);
        // A simulation within the loop begins anew, and is tuned, only by being put in again.
        let within = self.mode == LoopMode::SingleRate && (anew || tuned);
        let again = within || !self.hands.iter().all(same);
        if again || (tuned && self.retune(simulation.world()).is_err()) {
            self.attach(simulation)?;
        }
        self.beginnings += u64::from(anew);
        self.began_ns = now_ns;
        for hand in &mut self.hands {
            if let Some(state) = &mut hand.ends.state
                && state.update()
            {
                simulation.resume(state.output_buffer_mut());
            }
            let lead = hand.ends.lead.read();
            if lead.leads {
                simulation.lead(hand.index, lead.proxies.proxies.iter().map(RigidState::target));
            } else {
                simulation.let_go(hand.index);
            }
            if let Some(free) = hand.free.as_mut().filter(|_| anew || !lead.leads) {
                free.resume(simulation.world().state());
            }
        }
        Ok(())
    }

    /// After a step, at `now_ns`: a frame for the loop. Allocates nothing.
    pub fn after_step(&mut self, simulation: &mut impl Simulation, now_ns: u64) {
        if self.mode == LoopMode::Shared {
            for hand in &mut self.hands {
                let bones = hand.first as u32..(hand.first + hand.drives.len()) as u32;
                let frame = hand.ends.frame.input_buffer_mut();
                // A frame that cannot be condensed has none, and the loop carries bones forward.
                simulation.condense(bones, &mut frame.bones);
            }
        }
        let simulation = &*simulation;
        let world = simulation.world();
        self.steps = simulation.steps();
        self.frames += 1;
        if let Some(readout) = &mut self.readout {
            readout.read(world);
        }
        for (number, hand) in self.hands.iter_mut().enumerate() {
            let frame = hand.ends.frame.input_buffer_mut();
            let n = frame.targets.len();
            frame.bones.time_ns = self.began_ns;
            frame.bones.step = self.frames;
            for (i, bone) in frame.bones.bones.iter_mut().enumerate() {
                *bone = RigidState::of(world, (hand.first + i) as u32);
            }
            if let Some(free) = &mut hand.free {
                let lead = hand.ends.lead.output_buffer_mut();
                if lead.leads {
                    let targets = lead.proxies.free.iter().map(|proxy| Some(proxy.target()));
                    free.step(world.time_step(), targets, simulation.input());
                } else {
                    free.resume(world.state());
                }
                free.write_bones(&mut frame.bones.free);
            }
            frame.targets.copy_from_slice(&simulation.input().targets[hand.first..][..n]);
            frame.beginnings = self.beginnings;
            let flesh = simulation.hand(hand.index).and_then(|hand| hand.flesh);
            if let (Some(readout), Some(soft)) = (&self.readout, flesh) {
                frame.contacts = fingers(readout, soft);
            }
            frame.made_ns = now_ns;
            if let Some(frames) = &self.shared.frames {
                frames.put(number, frame);
            }
            hand.ends.frame.publish();
            // Objects, loads and other hands go on in a simulation within the loop.
            if let Some(input) = &mut hand.ends.input
                && input.input_buffer_mut().copy_from(simulation.input())
            {
                input.publish();
            }
        }
    }
}

/// Natural frequency at which tracked poses are followed \[Hz\]: half of a step within 3.3 ms.
const FOLLOW_HZ: f64 = 80.0;

/// Contacts that a condensed frame has room for.
const CONTACTS_MAX: usize = 64;

/// The joints between these bones that keep their places together.
fn bone_joints(world: &World, bones: &Range<usize>) -> Vec<BoneJoint> {
    let within = |body: u32| bones.contains(&(body as usize)).then(|| body as usize - bones.start);
    let joints = world.desc().joints.iter().filter(|joint| joint.kind.rows() > 0);
    let bone_joints = joints.filter_map(|joint| {
        let [parent, child] = [within(joint.parent?)?, within(joint.child)?];
        let [at_parent, at_child] = [joint.pose_PJ, joint.pose_CK].map(|pose| pose.position);
        Some(BoneJoint { parent, child, at_parent, at_child })
    });
    bone_joints.collect()
}

/// Returns the contact of each finger of the hand whose flesh is `soft`.
fn fingers(readout: &ContactReadout, soft: u32) -> [FingerContact; DIGITS] {
    let parts = readout.parts(soft);
    std::array::from_fn(|finger| {
        // Parts are the palm and then the digits, in order.
        let part = Digit::FINGERS[finger] as usize;
        let Some(contact) = parts.get(part).map(|part| &part.contact) else {
            return FingerContact::default();
        };
        FingerContact {
            area: contact.area,
            pressure_mean: contact.pressure_mean(),
            pressure_max: contact.pressure_max,
            slip_speed: contact.slip_W.norm(),
        }
    })
}
