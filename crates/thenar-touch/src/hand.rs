//! One tick of the haptic loop for a whole hand: newest samples in, forces on the wearer out.

use crate::arcs::{Arcs, BoneJoint, Settled};
use crate::empty_air::Held;
use crate::late_frames::{of_multirate, of_shared_constraints};
use crate::led_hand::LedHand;
use crate::shared::{Resolution, SharedConstraints};
use crate::smooth::Smooth;
use crate::turn::rotation_vector;
use crate::{
    BLEND, BoneFrame, DelayMeter, Prediction, Proxies, Proxy, ProxyError, ProxyReport,
    ProxyTargets, RigidState, Touch, hold_then_fade, seconds_between,
};
use thenar_core::math::Vec3;
use thenar_core::world::StepReport;

/// Stand-in for the simulated bones between two frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum ProxyMode {
    /// The frame's bones, carried forward by their velocity (the paper).
    Multirate,
    /// The frame's condensed response, contact resolved every tick; frames without one as
    /// `Multirate`, for as long as what contact did when there was one can be believed.
    SharedConstraints,
}

/// Settings for the prediction and resolution of a hand.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HandSettings {
    /// Between simulation frames.
    pub mode: ProxyMode,
    /// Between frames, in `Multirate`.
    pub simulation: Prediction,
    /// A tick longer than this is stepped as if it were this long \[s\].
    pub step_max: f64,
    /// Contact forces are resolved to this \[N\] ...
    pub force_tolerance: f64,
    /// ... or for this many sweeps.
    pub sweeps_max: u32,
}

impl Default for HandSettings {
    fn default() -> Self {
        Self {
            mode: ProxyMode::Multirate,
            simulation: Prediction::SIMULATION,
            step_max: 0.02,
            force_tolerance: 1e-3,
            sweeps_max: 20,
        }
    }
}

/// Part of the masses that proxies keep with shared constraints. There bones follow their proxies
/// without any mass, so that their couplings damp nothing in free air, and a proxy of a palm's mass
/// would ring on the device coupling.
const MASS_SCALE: f64 = 0.01;
/// So far bones are always carried on \[s\]: no more than the proxies lag.
const CARRY_TIME: f64 = 0.004;
/// A frame that is older than this part of a period when it arrives is late.
const LATE_AGE: f64 = 0.75;

/// Without a response, what contact did when there last was one is felt for so long, and then fades
/// within as long again \[s\]: a step that could not be factored is made up for, and what the
/// hand's flesh bears is never felt.
const UNANSWERED: f64 = 0.05;

/// Report of one tick of a hand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TickReport {
    /// Length of the step \[s\]; zero when the clock did not advance.
    pub step: f64,
    /// Age of the simulation frame \[s\].
    pub simulation_age: f64,
    /// The proxies.
    pub proxies: ProxyReport,
    /// Contact, with shared constraints.
    pub contact: Resolution,
    /// The simulation's own step, in single-rate.
    pub world: Option<StepReport>,
}

/// The hand in empty air, whose couplings' forces are not felt.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
struct EmptyAir {
    proxies: Proxies,
    shared: SharedConstraints,
    settled: Vec<Settled>,
    bones: Vec<RigidState>,
    /// Displacement of each bone by contact, as last known.
    held: Vec<Option<Held>>,
}

/// A hand's proxies and couplings, moved at the device's rate.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct HapticHand {
    settings: HandSettings,
    hand: LedHand,
    proxies: Proxies,
    shared: SharedConstraints,
    /// Step of the frame that `shared` works on.
    shared_step: Option<u64>,
    /// Step and time of the newest frame.
    newest: Option<(u64, u64)>,
    /// Interval and age of frames, the last frame heard, and whether it has a response that is
    /// used.
    frames: DelayMeter,
    frame_heard: Option<u64>,
    responds: bool,
    /// With shared constraints, time since a frame had a response \[s\]; the part of the force that
    /// is felt.
    unanswered: f64,
    answered: f64,
    /// The newest frame's bones, at velocities that are believed.
    carried: Vec<RigidState>,
    /// Periods that bones may be carried on when frames come late.
    periods_when_late: f64,
    /// Simulated bones are carried on for as long as this, slowing down \[s\].
    reach: f64,
    /// Joints that keep bones on their arcs, and where shared constraints had bones in the last
    /// ticks.
    arcs: Arcs,
    settled: Vec<Settled>,
    /// Simulated ends of the couplings in this tick.
    bones: Vec<RigidState>,
    /// Counterpart of this hand in empty air.
    free: EmptyAir,
    /// Action of contact on the wearer, smooth from frame to frame.
    smooth: Smooth,
    /// Wrenches that the wearer feels.
    wrenches: Vec<[Vec3; 2]>,
    /// Parts of the device couplings' forces and torques that are shown.
    shown: Vec<[f64; 2]>,
    ticks: u64,
}

impl HapticHand {
    /// A hand whose proxies start at `start`, for frames with up to `contacts_max` contacts.
    pub fn new(
        settings: HandSettings,
        proxies: Vec<Proxy>,
        start: &[RigidState],
        contacts_max: usize,
    ) -> Result<Self, ProxyError> {
        let n = proxies.len();
        let least_stable = proxies.iter().map(|proxy| {
            let (device, bone) = (proxy.device.stiffness, proxy.bone.stiffness);
            if bone > 0.0 { 0.5 * device / bone } else { 1.0 }
        });
        // Half of what would just be stable.
        let periods_when_late = 0.5 * least_stable.fold(1.0, f64::min);
        let mut proxies = proxies;
        if settings.mode == ProxyMode::SharedConstraints {
            proxies.iter_mut().for_each(|proxy| *proxy = proxy.lighter(MASS_SCALE));
        }
        let proxies = Proxies::new(proxies, start)?;
        let settled: Vec<_> =
            proxies.states().iter().map(|state| Settled::at(state.pose_WB)).collect();
        let free = EmptyAir {
            proxies: proxies.clone(),
            shared: SharedConstraints::in_empty_air(n, contacts_max),
            settled: settled.clone(),
            bones: proxies.states().to_vec(),
            held: vec![None; n],
        };
        Ok(Self {
            free,
            settings,
            hand: LedHand::new(proxies.states()),
            shared: SharedConstraints::new(n, contacts_max),
            shared_step: None,
            newest: None,
            frames: DelayMeter::of_frames(),
            frame_heard: None,
            responds: false,
            unanswered: f64::INFINITY,
            answered: if settings.mode == ProxyMode::SharedConstraints { 0.0 } else { 1.0 },
            carried: proxies.states().to_vec(),
            reach: 0.0,
            periods_when_late,
            arcs: Arcs::new(n),
            settled,
            bones: proxies.states().to_vec(),
            smooth: Smooth::new(n),
            wrenches: vec![[Vec3::zeros(); 2]; n],
            shown: vec![[1.0; 2]; n],
            proxies,
            ticks: 0,
        })
    }

    /// Keeps these joints closed where bones turn between two frames, by up to half a radian, from
    /// the next frame on. A joint whose parent's number is not below its child's is passed over, as
    /// is one of a bone that the hand lacks; of several to one child the first counts.
    pub fn set_joints(&mut self, joints: impl IntoIterator<Item = BoneJoint>) {
        self.arcs.set_joints(joints);
    }

    /// Shows only these parts of a bone's force and torque to the wearer, 0 to 1.
    pub fn show(&mut self, bone: usize, parts: [f64; 2]) {
        self.shown[bone] = parts;
    }

    /// The simulated bones now.
    fn place_bones(&mut self, frame: &BoneFrame, age: f64, h: f64) -> Resolution {
        let response = &frame.response;
        let responded = self.responds;
        self.responds = self.settings.mode == ProxyMode::SharedConstraints && response.is_ready();
        if self.responds {
            if self.shared_step != Some(frame.step) {
                self.shared.begin(response);
                self.free.shared.begin(response);
                self.arcs.begin(frame);
                self.shared_step = Some(frame.step);
            }
            if !responded {
                let both =
                    [(&mut self.settled, &self.bones), (&mut self.free.settled, &self.free.bones)];
                for (settled, bones) in both {
                    let bones = bones.iter().map(|bone| Settled::at(bone.pose_WB));
                    settled.iter_mut().zip(bones).for_each(|(settled, bone)| *settled = bone);
                }
            }
            // Nobody leads a bone that was never tracked: its proxy is where the frame has it.
            for (i, of_frame) in frame.bones.iter().enumerate() {
                if !self.hand.is_known(i) {
                    self.proxies.place(i, RigidState::at_rest(of_frame.pose_WB));
                    self.free.proxies.place(i, RigidState::at_rest(of_frame.pose_WB));
                }
            }
            let (tolerance, sweeps) = (self.settings.force_tolerance, self.settings.sweeps_max);
            let Self { arcs, proxies, shared, settled, bones, free, .. } = self;
            // Resolved for where the proxies were; their step asks for its end.
            let states = proxies.states();
            arcs.bend(frame, states, settled, shared);
            let resolution = shared.resolve(response, states, h, tolerance, sweeps);
            arcs.place(frame, (states, shared), h, settled, bones);
            let EmptyAir { proxies, shared, settled, bones: free_bones, held } = free;
            let states = proxies.states();
            arcs.bend(frame, states, settled, shared);
            shared.resolve(response, states, h, tolerance, sweeps);
            arcs.place(frame, (states, shared), h, settled, free_bones);
            for (i, of_frame) in frame.bones.iter().enumerate() {
                if !self.hand.is_known(i) {
                    (bones[i], free_bones[i]) = (*of_frame, *of_frame);
                }
                held[i] = Some(Held::between(&bones[i], &free_bones[i]));
            }
            return resolution;
        }
        if self.newest.is_none_or(|(step, _)| step != frame.step) {
            self.take_frame(frame, age);
        }
        // The horizon is held for as long again, at half the speed.
        let horizon = (self.reach / 1.5).max(CARRY_TIME).min(self.settings.simulation.horizon);
        let prediction = Prediction { horizon, ..self.settings.simulation };
        let states = self.carried.iter().zip(&frame.bones);
        for (bone, (carried, of_frame)) in self.bones.iter_mut().zip(states) {
            *bone = prediction.at(&RigidState { pose_WB: of_frame.pose_WB, ..*carried }, age);
        }
        self.place_free();
        Resolution::default()
    }

    /// The bones of the hand in empty air between two frames: as far from the simulated ones as
    /// contact held them in the frame, so that what is felt comes with frames. Where that was never
    /// known, all is felt: that hand is wherever its wearer is.
    fn place_free(&mut self) {
        let EmptyAir { bones, held, .. } = &mut self.free;
        for (i, held) in held.iter().enumerate() {
            bones[i] = held.map_or(self.hand.states()[i], |held| held.let_go(&self.bones[i]));
        }
    }

    /// The couplings' forces and torques on the wearer, less what they are in empty air.
    fn feel(&mut self, h: f64, step: u64) {
        if self.settings.mode == ProxyMode::SharedConstraints {
            self.unanswered = if self.responds { 0.0 } else { self.unanswered + h };
            let part = hold_then_fade(self.unanswered, UNANSWERED, UNANSWERED);
            // Back within the time of the fade, too.
            self.answered = part.min(self.answered + h / UNANSWERED);
        }
        let free = &self.free;
        self.smooth.begin(h, step);
        for i in 0..self.wrenches.len() {
            let known = free.held[i].is_some();
            let own = if known { free.proxies.device_wrenches()[i] } else { [Vec3::zeros(); 2] };
            let told = self.proxies.device_wrenches()[i];
            // Where the hand sets out anew nothing of before goes on.
            let anew = self.hand.has_set_out(i);
            let acts = [told[0] - own[0], told[1] - own[1]].map(|wrench| wrench * self.answered);
            let felt = self.smooth.take(i, acts, anew);
            let [force, torque] = self.shown[i];
            self.wrenches[i] = [felt[0] * force, felt[1] * torque];
        }
    }

    /// Bones go on at their velocities, but not faster than they went from frame to frame (a
    /// simulation slower than real time moves less than its velocities say), and not far: what the
    /// simulation sees of its own motion comes back to it through the proxies, later, and must come
    /// back smaller. With r the part of the bone coupling in the proxies' stiffness and bones
    /// carried on by e periods, one step answers the last with r ((1 + e) b₁ - e b₀): stable up to
    /// e = 1 when frames arrive within their period. When they arrive later, and the answer is two
    /// steps old, r (1 + 2 e) < 1 is.
    fn take_frame(&mut self, frame: &BoneFrame, age: f64) {
        let period = self.newest.map_or(0.0, |(_, before)| seconds_between(before, frame.time_ns));
        let both = self.carried.iter_mut().zip(&frame.bones);
        both.for_each(|(carried, bone)| believe(carried, bone, period));
        let held = &mut self.free.held;
        if frame.free.is_empty() && self.settings.mode == ProxyMode::Multirate {
            // A frame that tells of no hand in empty air: all is felt, as before there were any.
            held.fill(None);
        }
        for (held, (bone, free)) in held.iter_mut().zip(frame.bones.iter().zip(&frame.free)) {
            *held = Some(Held::between(bone, free));
        }
        let most = if age < LATE_AGE * period { 1.0 } else { self.periods_when_late };
        self.reach = period.max(0.0) * most;
        self.newest = Some((frame.step, frame.time_ns));
    }

    /// The proxies and their forces.
    pub fn proxies(&self) -> &Proxies {
        &self.proxies
    }
}

/// Takes over a bone of the frame that came `period` \[s\] after the one before.
fn believe(carried: &mut RigidState, bone: &RigidState, period: f64) {
    let before = carried.pose_WB;
    *carried = RigidState::at_rest(bone.pose_WB);
    if period > 0.0 {
        let turn = bone.pose_WB.rotation * before.rotation.inverse();
        let went = (bone.pose_WB.position - before.position).norm() / period;
        let turned = rotation_vector(&turn).norm() / period;
        carried.velocity_W = at_most(&bone.velocity_W, went);
        carried.angular_velocity_W = at_most(&bone.angular_velocity_W, turned);
    }
}

/// A velocity of no more than this size.
fn at_most(v: &Vec3, size: f64) -> Vec3 {
    let norm = v.norm();
    // NaN stays, and is not believed by the prediction.
    if norm > size { v * (size / norm) } else { *v }
}

impl Touch for HapticHand {
    fn hand(&self) -> &LedHand {
        &self.hand
    }

    fn hand_mut(&mut self) -> &mut LedHand {
        &mut self.hand
    }

    fn tick(&mut self, now_ns: u64, frame: &BoneFrame) -> TickReport {
        let h = self.hand.passed(now_ns, self.settings.step_max);
        let simulation_age = seconds_between(frame.time_ns, now_ns);
        if self.frame_heard.replace(frame.step) != Some(frame.step) {
            self.frames.take(frame.time_ns, now_ns);
        }
        let contact = self.place_bones(frame, simulation_age, h);
        self.hand.place(&self.bones);
        for i in (0..self.bones.len()).filter(|i| self.hand.has_set_out(*i)) {
            self.proxies.place(i, RigidState::at_rest(self.bones[i].pose_WB));
            self.free.proxies.place(i, RigidState::at_rest(self.free.bones[i].pose_WB));
            self.settled[i] = Settled::at(self.bones[i].pose_WB);
            self.free.settled[i] = Settled::at(self.free.bones[i].pose_WB);
        }
        let proxies = self.proxies.step(h, self.hand.states(), &self.bones);
        self.free.proxies.step(h, self.hand.states(), &self.free.bones);
        self.feel(h, frame.step);
        self.ticks += 1;
        TickReport { step: h, simulation_age, proxies, contact, world: None }
    }

    fn write_targets(&self, now_ns: u64, to: &mut ProxyTargets) {
        (to.time_ns, to.tick) = (now_ns, self.ticks);
        to.proxies.copy_from_slice(self.proxies.states());
        to.free.copy_from_slice(self.free.proxies.states());
    }

    fn bones(&self) -> &[RigidState] {
        &self.bones
    }

    fn added_delay(&self, bone: usize, observed: f64) -> f64 {
        let Some([period, age]) = self.frames.seen() else { return BLEND.max(observed) };
        if self.responds {
            // What listed contacts answer is not late by frames, and what begins with a frame is no
            // sway.
            of_shared_constraints(period, age).max(observed)
        } else {
            of_multirate(&self.proxies.proxies()[bone], period, age) + observed
        }
    }

    fn device_wrenches(&self) -> &[[Vec3; 2]] {
        &self.wrenches
    }

    fn beside(&self) -> Option<&HapticHand> {
        Some(self)
    }
}
