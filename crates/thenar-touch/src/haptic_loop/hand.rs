//! One hand in the loop: samples of its tracker in, forces of its couplings out.

mod held;
mod state;

pub use state::HandState;

use super::exchange::{Frame, LoopEndpoints};
use crate::turn::rotation_vector;
use crate::{
    DIGITS, FeltStiffness, HandSample, PAD_NORMAL_B, Pad, PadReading, RigidState, TickReport,
    Touch, TrackerTiming, seconds_between,
};
use held::{HeldSample, NewestTime};
use thenar_core::model::{Digit, HandModel, Side};
use thenar_core::world::Target;
use thenar_core::{Pose, Vec3};
use thenar_track::live::{LiveHand, Mover, STALE, checked};

/// After a longer gap between samples a hand begins afresh, and so it does after such a gap between
/// ticks \[s\].
const AFRESH: f64 = 0.1;
/// A tick longer than this is taken as if it were this long \[s\].
const STEP_MAX: f64 = 0.02;
/// A tracker that has been silent for so long gives way to another of the same hand \[ns\].
const TRACKER_SILENCE_NS: u64 = 100_000_000;

/// A hand in the haptic loop: observed, led and felt each tick.
pub struct LoopHand {
    side: Side,
    live: LiveHand,
    touch: Box<dyn Touch + Send>,
    ends: LoopEndpoints,
    /// Targets of the bones, by `live`.
    targets: Vec<Option<Target>>,
    pads: [Option<Pad>; DIGITS],
    readings: [Option<PadReading>; DIGITS],
    /// Stiffness with which the hand is felt, and that of a turn of the palm.
    felt: Option<FeltStiffness>,
    turn: Option<FeltStiffness>,
    report: TickReport,
    last_ns: Option<u64>,
    beginnings: u64,
    /// Step of the frame that the hand is on.
    frame_step: u64,
    /// Number of the tracker that moves the hand, and when its newest sample came \[ns\].
    tracker: Option<(usize, u64)>,
    /// The last sample that was believed.
    held: Option<HeldSample>,
    newest: NewestTime,
    /// Time of the sample that the last tick took, if it took one \[ns\].
    fresh_ns: Option<u64>,
    /// Time of the newest sample that counts as tracking \[ns\].
    tracked_ns: u64,
    palm_last: Option<Pose>,
    /// Linear \[m/s\] and angular \[rad/s\].
    palm_velocity: [[f64; 3]; 2],
}

impl LoopHand {
    /// A hand of this side, built as `model`.
    pub fn new(
        side: Side,
        model: &HandModel,
        live: LiveHand,
        touch: Box<dyn Touch + Send>,
        mut ends: LoopEndpoints,
    ) -> Self {
        let mut pads = [None; DIGITS];
        for pad in Pad::of_hand(model) {
            if let Some(finger) = Digit::FINGERS.iter().position(|digit| *digit == pad.digit) {
                pads[finger] = Some(pad);
            }
        }
        let frame = ends.frame.read();
        let (targets, beginnings) = (frame.targets.clone(), frame.beginnings);
        let frame_step = frame.bones.step;
        Self {
            side,
            live,
            touch,
            ends,
            targets,
            pads,
            readings: [None; DIGITS],
            felt: None,
            turn: None,
            report: TickReport::default(),
            last_ns: None,
            beginnings,
            frame_step,
            tracker: None,
            held: None,
            newest: NewestTime::default(),
            fresh_ns: None,
            tracked_ns: 0,
            palm_last: None,
            palm_velocity: [[0.0; 3]; 2],
        }
    }

    /// Side of the hand.
    pub fn side(&self) -> Side {
        self.side
    }

    /// Bounds how stiff it is felt, and how stiff a turn of its palm is.
    pub fn bound(&mut self, felt: FeltStiffness, turn: Option<FeltStiffness>) {
        (self.felt, self.turn) = (Some(felt), turn);
    }

    /// Takes a sample of tracker `tracker`, which states this of itself. See [`LoopHand::take`].
    pub fn take_timed(
        &mut self,
        tracker: usize,
        sample: &HandSample,
        now_ns: u64,
        stated: Option<TrackerTiming>,
    ) {
        let before = self.tracker();
        if !self.take(tracker, sample, now_ns) {
            return;
        }
        for felt in self.felt.iter_mut().chain(&mut self.turn) {
            if before != Some(tracker) {
                felt.forget();
            }
            felt.hear(sample.time_ns, now_ns, stated);
        }
    }

    /// Takes a sample of tracker `tracker`. Of two trackers of one hand the one that moves it goes
    /// on until it has been silent for a while. True if the sample moves the hand.
    pub fn take(&mut self, tracker: usize, sample: &HandSample, now_ns: u64) -> bool {
        if let Some((moving, heard_ns)) = self.tracker {
            let silent = now_ns.saturating_sub(heard_ns) > TRACKER_SILENCE_NS;
            if moving != tracker && !silent {
                return false;
            }
        }
        // One that does not see the hand is silent, and keeps no other from it.
        let Some(pose) = &sample.pose else { return false };
        let goes_on = self.tracker.is_some_and(|(moving, _)| moving == tracker);
        if !goes_on {
            self.newest = NewestTime::default();
        }
        // Nor does one that says the same again say where the hand is, whether or not it was
        // believed.
        if !self.newest.hears(sample.time_ns) {
            return false;
        }
        self.tracker = Some((tracker, now_ns));
        let takes_over = self.live.mover() == Mover::Script;
        if takes_over {
            self.targets.copy_from_slice(&self.ends.frame.output_buffer_mut().targets);
            self.live.restart(&self.targets);
        }
        let time = sample.time_ns as f64 * 1e-9;
        let is_elsewhere = || self.held.as_ref().is_some_and(|held| held.is_far(pose));
        let sets_out = !goes_on || self.is_unseen(now_ns) && is_elsewhere();
        if sets_out && checked(time, pose).is_ok() {
            self.live.lose();
        }
        self.held.iter_mut().for_each(|held| held.doubt(false));
        // A pose that is none has been told of by the device; here it only ages.
        if self.live.pose(time, pose, &self.targets).is_err() {
            return false;
        }
        if takes_over {
            // So far the hand was where its bones are, which lag behind what the script wants.
            (0..self.targets.len()).for_each(|bone| self.touch.set_out(bone));
        }
        if self.live.waits() {
            return false;
        }
        self.held = Some(HeldSample::new(pose, sample.time_ns, now_ns));
        self.fresh_ns = Some(sample.time_ns);
        if !self.live.is_setting_out() {
            self.tracked_ns = sample.time_ns;
        }
        true
    }

    /// True if no sample was believed for too long.
    fn is_unseen(&self, now_ns: u64) -> bool {
        let seen_ns = self.held.as_ref().map_or(0, HeldSample::seen_ns);
        seconds_between(seen_ns, now_ns) > STALE
    }

    /// Holds a hand still that is not seen.
    fn hold_still(&mut self, now_ns: u64) {
        // A hand that is led goes on by a few milliseconds at most when the loop stood still: its
        // time is behind then, and after so long it begins afresh.
        let stood_still = self.last_ns.is_some_and(|last| seconds_between(last, now_ns) > AFRESH);
        let Some(held) = &mut self.held else { return };
        if stood_still || held.is_over(now_ns) {
            self.live.lose();
            self.held = None;
            return;
        }
        while let Some((time, pose)) = held.again(now_ns) {
            // It was taken before, and is again.
            let _ = self.live.pose(time, pose, &self.targets);
            held.doubt(self.live.waits());
        }
    }

    /// Takes the newest simulation frame, and gives its step, if there is one. Begins a tick.
    pub fn update(&mut self, now_ns: u64) -> Option<u64> {
        self.fresh_ns = None;
        self.hold_still(now_ns);
        let fresh = self.ends.frame.update();
        let frame = self.ends.frame.output_buffer_mut();
        self.frame_step = frame.bones.step;
        if frame.beginnings != self.beginnings {
            // The bones are elsewhere: the hand sets out from there, smoothly.
            self.beginnings = frame.beginnings;
            self.targets.copy_from_slice(&frame.targets);
            self.live.restart(&self.targets);
            (0..self.targets.len()).for_each(|bone| self.touch.set_out(bone));
        }
        fresh.then_some(self.frame_step)
    }

    /// One tick. Allocates nothing.
    pub fn tick(&mut self, now_ns: u64) {
        let passed = seconds_between(self.last_ns.unwrap_or(now_ns), now_ns);
        self.last_ns = Some(now_ns);
        let h = passed.clamp(0.0, STEP_MAX);
        let frame = self.ends.frame.output_buffer_mut();
        let leads = self.live.mover() != Mover::Script;
        if leads {
            self.live.step(h, &mut self.targets);
        } else if self.ends.state.is_some() {
            // A simulation within the loop follows the script as well.
            self.targets.copy_from_slice(&frame.targets);
        }
        if leads || self.ends.state.is_some() {
            for (bone, target) in self.targets.iter().enumerate() {
                if let Some(target) = target {
                    self.touch.lead(bone, RigidState::from(*target));
                }
            }
        }
        // What acts in a simulation within the loop, but for this hand.
        if let (Some(from), Some(input)) = (&mut self.ends.input, self.touch.input_mut())
            && from.update()
        {
            input.copy_from(from.output_buffer_mut());
        }
        self.report = self.touch.tick(now_ns, &frame.bones);
        let lead = self.ends.lead.input_buffer_mut();
        lead.leads = leads;
        self.touch.write_targets(now_ns, &mut lead.proxies);
        self.ends.lead.publish();
        self.hand_over_state();
        let (touch, h) = (&*self.touch, self.report.step);
        let noisy = self.live.noisy();
        for felt in self.felt.iter_mut().chain(&mut self.turn) {
            // The turn is that of the first bone.
            felt.step(h, noisy, |bone, observed| touch.added_delay(bone, observed));
        }
        self.live.feel_on(self.felt.as_ref().map(FeltStiffness::spring).unwrap_or_default());
        for (pad, reading) in self.pads.iter_mut().zip(&mut self.readings) {
            *reading = pad.as_mut().map(|pad| pad.read(touch, h));
            if let (Some(pad), Some(reading), Some(felt)) = (pad, reading.as_mut(), &self.felt) {
                let part = felt.part(pad.bone);
                reading.force_W *= part;
                reading.pad_force *= part;
            }
        }
        self.observe_palm(h);
        if !leads {
            // A script moves the hand, from frame to frame: its speed is no wearer's.
            self.readings.iter_mut().flatten().for_each(|pad| pad.opening_velocity = 0.0);
            self.palm_velocity = [[0.0; 3]; 2];
        }
    }

    fn hand_over_state(&mut self) {
        let (Some(to), Some(world)) = (&mut self.ends.state, self.touch.world()) else { return };
        // In every tick: velocities that scripts want of bodies are worked out from it.
        to.input_buffer_mut().copy_from(world.state());
        to.publish();
    }

    fn observe_palm(&mut self, h: f64) {
        let pose = self.touch.tracked()[0].pose_WB;
        let jumped = self.touch.jumped(0);
        let before = self.palm_last.replace(pose).filter(|_| !jumped).unwrap_or(pose);
        let ways = [
            pose.position - before.position,
            rotation_vector(&(pose.rotation * before.rotation.inverse())),
        ];
        self.palm_velocity = ways.map(|way| if h > 0.0 { (way / h).into() } else { [0.0; 3] });
    }

    /// Returns the reading of each pad; `None` for a finger that the hand lacks.
    pub fn readings(&self) -> &[Option<PadReading>; DIGITS] {
        &self.readings
    }

    /// Force \[N\] and torque \[N m\] on the wearer at the palm's centre, world, each with the
    /// palm's mean velocity in the last tick \[m/s, rad/s\].
    pub fn palm(&self) -> [([f64; 3], [f64; 3]); 2] {
        let part = |felt: &Option<FeltStiffness>| felt.as_ref().map_or(1.0, |felt| felt.part(0));
        let (push, turn) = (part(&self.felt), part(&self.turn));
        let [force, torque] = self.touch.device_wrenches()[0];
        // A hand is pushed and turned by one thing: torque is cut as force is, and by its own rule.
        let (force, torque) = (force * push, torque * push.min(turn));
        let [linear, angular] = self.palm_velocity;
        [(force.into(), linear), (torque.into(), angular)]
    }

    /// Into the pad of a finger: the direction in which something presses on it, world.
    pub fn inward(&self, finger: usize) -> Vec3 {
        let Some(pad) = &self.pads[finger] else { return Vec3::zeros() };
        -self.touch.tracked()[pad.bone].pose_WB.vector(&PAD_NORMAL_B)
    }

    /// Returns the delay with which its motion is seen \[s\], as far as known.
    pub fn seen_late(&self) -> f64 {
        self.felt.as_ref().map_or(0.0, FeltStiffness::seen_late)
    }

    /// From the motion of the finger that is felt stiffest to the force that answers it \[s\], as
    /// far as that is known.
    pub fn delay(&self) -> f64 {
        let Some(felt) = &self.felt else { return 0.0 };
        self.stiffest().map_or(0.0, |bone| felt.delay(bone))
    }

    /// Stiffest that a blocked finger is felt \[N/m\].
    pub fn felt_stiffness(&self) -> f64 {
        let Some(felt) = &self.felt else { return 0.0 };
        self.stiffest().map_or(0.0, |bone| felt.stiffness(bone))
    }

    /// Part of a bone's force that is felt.
    pub fn felt_part(&self, bone: usize) -> f64 {
        self.felt.as_ref().map_or(1.0, |felt| felt.part(bone))
    }

    /// The bone of the pad that is felt stiffest when it is blocked.
    fn stiffest(&self) -> Option<usize> {
        let felt = self.felt.as_ref()?;
        let bones = self.pads.iter().flatten().map(|pad| pad.bone);
        bones.max_by(|a, b| felt.stiffness(*a).total_cmp(&felt.stiffness(*b)))
    }

    /// Returns the curl of a finger, 0 open to 1 closed.
    pub fn curl(&self, finger: usize) -> f64 {
        self.live.curl(finger).unwrap_or(0.0)
    }

    /// The newest frame.
    pub fn frame(&mut self) -> &Frame {
        self.ends.frame.output_buffer_mut()
    }

    /// Returns the time when the simulation was last heard \[ns\].
    pub fn simulated_ns(&mut self) -> u64 {
        // A simulation within the tick is as new as the tick.
        match (self.touch.world(), self.last_ns) {
            (Some(_), Some(now)) => now,
            _ => self.frame().made_ns,
        }
    }

    /// Returns the time when the hand was last tracked where it is \[ns\].
    pub fn tracked_ns(&self) -> u64 {
        self.tracked_ns
    }

    /// Since the hand was last tracked where it is \[s\]; infinite before it ever was.
    pub fn tracking_age(&self, now_ns: u64) -> f64 {
        if self.tracked_ns == 0 { f64::INFINITY } else { seconds_between(self.tracked_ns, now_ns) }
    }

    /// True while the hand is on its way to where its tracker found it.
    pub fn is_away(&self) -> bool {
        self.live.is_setting_out()
    }

    /// Time of the sample that the last tick took, if it took one \[ns\].
    pub fn fresh_ns(&self) -> Option<u64> {
        self.fresh_ns
    }

    /// Returns the source of the hand's motion.
    pub fn mover(&self) -> Mover {
        let unseen = self.last_ns.is_some_and(|now_ns| self.is_unseen(now_ns));
        match self.live.mover() {
            Mover::Live if unseen => Mover::Lost,
            mover => mover,
        }
    }

    /// The tracker that moves it.
    pub fn tracker(&self) -> Option<usize> {
        self.tracker.map(|(tracker, _)| tracker)
    }

    /// Returns the report of the last tick.
    pub fn report(&self) -> &TickReport {
        &self.report
    }

    /// Returns the touch, with the states of bones and hand.
    pub fn touch(&self) -> &dyn Touch {
        &*self.touch
    }
}
