//! One hand that poses may move.

use super::check::checked;
use super::clock::Timing;
use super::follower::{Law, follow, follow_rotation};
use super::kinematic_state::KinematicState;
use super::memory::{CALIBRATION, Memory, PoseSource};
use super::noise::{FeltSpring, LeverArms};
use super::observer::MEMORY;
use super::outlier_gate::{GateDecision, OutlierGate, PendingWrist};
use super::{JOINT_RATE_MAX, LiveError, LivePose, Mover, OPENING, SPEED_MAX, SPIN_MAX, STALE};
use crate::calibration::RATIOS;
use crate::{ANGLES, AngleRange, Articulation, BoneLengths, Knuckles, Retarget, hand_angles};
use std::f64::consts::TAU;
use thenar_core::model::HandModel;
use thenar_core::world::Target;
use thenar_core::{Pose, Quat};

/// A pose is carried forward by so much at most \[s\].
const AHEAD_MAX: f64 = 0.025;
/// Natural frequency of the follower \[rad/s\]: on the way to another place, and once there.
const OMEGA: [f64; 2] = [TAU * 4.0, TAU * 25.0];
/// Followed tightly, a hand whose samples are noise is followed this part as tightly at least: 16
/// Hz of 80, where 1 mm of white noise at 90 Hz leaves a third of what 80 Hz lets through above 40
/// Hz.
const NOISY: f64 = 0.2;
/// Noise that is felt: place \[m\], turn of the wrist and angle of a joint \[rad\], each some 20 µm
/// at a fingertip. Sways that less noise hides are below what a hand at rest may sway by.
const FELT: [f64; 3] = [2e-5, 1e-4, 2e-4];
/// A script is reached when nothing is further off than this \[m, rad\].
const ARRIVED: f64 = 1e-4;
/// Largest change of the wrist's frame per pose while it is refined \[rad\].
const REFINEMENT: f64 = 0.0035;

/// A hand that poses may move, with all that is known of its tracker.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct LiveHand {
    pub(super) name: String,
    length: f64,
    articulation: Articulation,
    ranges: [Option<AngleRange>; ANGLES],
    /// Carries joints over; `None` for a hand that names no tracked joints.
    pub(super) retarget: Option<Retarget>,
    pub(super) knuckles: Knuckles,
    bones: BoneLengths,
    /// Natural frequency of the follower once it is there \[rad/s\].
    omega: f64,
    /// Spring that it is felt on.
    spring: FeltSpring,
    /// Samples that no motion explains wait for another that agrees; not in `memory`, which
    /// recordings keep.
    outlier_gate: Option<OutlierGate>,
    levers: LeverArms,
    /// All that changes and that the next step depends on, with what `retarget` and `knuckles` have
    /// learnt.
    pub(super) memory: Memory,
    /// Memory to work in: one entry per bone or joint.
    wanted: Vec<Pose>,
    poses: Vec<Pose>,
    angles: Vec<[f64; 2]>,
}

impl LiveHand {
    /// Prepares a hand that the script moves.
    ///
    /// # Errors
    /// Its bones are no tree.
    pub fn new(name: &str, hand: &HandModel) -> Result<Self, LiveError> {
        let unfit = |cause: String| LiveError::Unfit { hand: name.into(), cause };
        let articulation = Articulation::new(hand).map_err(|e| unfit(e.to_string()))?;
        let kinematic_state = KinematicState::at_rest(&articulation);
        let (bones, joints) = (articulation.tree.bones(), articulation.tree.joints());
        let ranges = hand_angles(hand, &articulation);
        Ok(Self {
            name: name.into(),
            length: hand.length,
            levers: LeverArms::of(hand, &ranges),
            ranges,
            retarget: Retarget::uncalibrated(hand, false).ok(),
            knuckles: Knuckles::of(hand),
            bones: BoneLengths::of(hand),
            omega: OMEGA[1],
            spring: FeltSpring::default(),
            outlier_gate: None,
            memory: Memory::new(kinematic_state, joints),
            wanted: vec![Pose::identity(); bones],
            poses: vec![Pose::identity(); bones],
            angles: vec![[0.0; 2]; joints],
            articulation,
        })
    }

    /// Follows poses at this natural frequency \[Hz\], once it is there, instead of 25 Hz: more
    /// lets more of the tracker's noise through, and is later by less. For steps that are short
    /// beside its period.
    pub fn follow_at(&mut self, frequency: f64) {
        self.omega = TAU * frequency;
    }

    /// Leads what is felt on this spring: noise is remembered for as long as it would be felt on
    /// that. A hand that is only shown need not be stiller than near.
    pub fn feel_on(&mut self, spring: FeltSpring) {
        self.spring = spring;
    }

    /// Waits with a sample that no motion explains until the next one agrees with it: a glitch of
    /// one sample does nothing, and a true start is late by one sample. For forces, which a glitch
    /// would throw at the wearer.
    pub fn doubt_glitches(&mut self) {
        self.outlier_gate = Some(OutlierGate::new(self.memory.joints.len()));
    }

    /// Lets pads that touch on the tracked hand touch on ours and no more. For forces: the wearer's
    /// own fingers press on each other already.
    pub fn press_no_pads(&mut self) {
        self.retarget.iter_mut().for_each(Retarget::without_press);
    }

    /// True if the last pose waits for another that agrees with it: nothing is known by it yet.
    pub fn waits(&self) -> bool {
        self.outlier_gate.as_ref().is_some_and(OutlierGate::waits)
    }

    /// Returns the noise of the samples: 0 as sure as motion, 1 remembered for 50 ms, and more; the
    /// worst of wrist and joints. See [`Observation`](crate::Observation).
    pub fn noisy(&self) -> f64 {
        let memory = &self.memory;
        let wrist = memory.position.noisy(FELT[0]).max(memory.rotation.noisy(FELT[1]));
        let joints = memory.joints.iter().flatten().map(|joint| joint.noisy(FELT[2]));
        joints.fold(wrist, f64::max)
    }

    /// Returns the source of the hand's motion.
    pub fn mover(&self) -> Mover {
        match self.memory.way {
            PoseSource::Script | PoseSource::Returning => Mover::Script,
            PoseSource::Live if self.is_lost() => Mover::Lost,
            PoseSource::Live => Mover::Live,
        }
    }

    /// Length of the wearer's hand, wrist to middle fingertip \[m\]: the median over the first
    /// poses with joints since they took over. `None` before the first.
    pub fn length(&self) -> Option<f64> {
        let mut ratios = [1.0; CALIBRATION];
        ratios.copy_from_slice(&self.memory.ratios);
        let known = &mut ratios[..self.memory.calibrated];
        known.sort_unstable_by(f64::total_cmp);
        known.get(known.len() / 2).map(|ratio| ratio * self.length)
    }

    /// True while poses have moved the hand for less than [`OPENING`] since it set out for another
    /// place: after they took over, came back or teleported.
    pub fn is_setting_out(&self) -> bool {
        self.memory.way == PoseSource::Live && self.memory.now - self.memory.set_out < OPENING
    }

    /// Returns the curl of finger `finger` (thumb 0), as the mean over its joints' ranges: 0 open,
    /// 1 closed; `None` for a finger without joints.
    pub fn curl(&self, finger: usize) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0.0);
        for k in [0, 2, 3] {
            let Some(Some(range)) = self.ranges.get(4 * finger + k) else { continue };
            // From straight on: what bends backwards is no part of closing.
            let open = range.min.max(0.0);
            if range.max > open {
                let angle =
                    self.memory.kinematic_state.angles[range.index][range.axis] * range.sense;
                sum += ((angle - open) / (range.max - open)).clamp(0.0, 1.0);
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum / count)
    }

    /// The pose of a hand whose bones are at these targets, as a tracker would tell of it.
    pub fn pose_of(&mut self, targets: &[Option<Target>]) -> LivePose {
        let Self { articulation, memory, ranges, poses, angles, .. } = self;
        let mut kinematic_state = memory.kinematic_state.clone();
        kinematic_state.read(articulation, targets, None, poses, angles);
        let wrist = Pose::new(kinematic_state.position[0], kinematic_state.rotation.0);
        let angle = |r: &AngleRange| r.sense * kinematic_state.angles[r.index][r.axis];
        let angles = ranges.each_ref().map(|range| range.as_ref().map_or(0.0, angle));
        LivePose::Angles { wrist, angles }
    }

    /// True when the script's targets are wanted in the next step.
    pub fn wants_script(&self) -> bool {
        self.memory.way != PoseSource::Live
    }

    /// Takes a pose that the client took at `time` \[s\] by its own clock. It acts in the next
    /// step. `targets` are the hand's present ones.
    ///
    /// # Errors
    /// The pose is none, or the hand cannot follow it. Nothing has changed then.
    pub fn pose(
        &mut self,
        time: f64,
        pose: &LivePose,
        targets: &[Option<Target>],
    ) -> Result<(), LiveError> {
        let pose = checked(time, pose)?;
        if matches!(pose, LivePose::Joints { .. }) && self.retarget.is_none() {
            let cause = "its root bone must name the tracked joint `wrist`".into();
            return Err(LiveError::Unfit { hand: self.name.clone(), cause });
        }
        let begins = self.memory.way != PoseSource::Live;
        if begins {
            self.take_over(targets);
        }
        let wrist = self.carry_over(&pose);
        let was_lost = begins || self.is_lost();
        if was_lost {
            self.memory.clock.forget();
            self.outlier_gate.iter_mut().for_each(OutlierGate::forget);
        }
        let timing = self.memory.clock.take(time, self.memory.now);
        let timing = match self.outlier_gate.is_some() && !was_lost {
            true => match self.without_doubt(&wrist, timing) {
                Some(timing) => timing,
                None => return Ok(()),
            },
            false => timing,
        };
        let longest = self.longest(timing.gap);
        self.memory.observe(&wrist, &self.angles, &timing, was_lost, longest);
        (self.memory.arrived, self.memory.late, self.memory.lost) =
            (self.memory.now, timing.late, false);
        Ok(())
    }

    /// The tracker has lost the hand: it holds still at the last pose.
    pub fn lose(&mut self) {
        self.memory.lost = true;
    }

    /// Hands the hand back to its script, which it reaches smoothly.
    pub fn follow_script(&mut self) {
        if self.memory.way == PoseSource::Live {
            (self.memory.way, self.memory.script_known, self.memory.set_out) =
                (PoseSource::Returning, false, self.memory.now);
        }
    }

    /// The scene has started over and put the bones at `targets`: a script is followed from
    /// there, a tracked hand sets out from there.
    pub fn restart(&mut self, targets: &[Option<Target>]) {
        let Self { articulation, memory, poses, angles, .. } = self;
        memory.kinematic_state.read(articulation, targets, None, poses, angles);
        self.memory.script_known = false;
        self.memory.set_out = self.memory.now;
        if self.memory.way == PoseSource::Returning {
            self.memory.way = PoseSource::Script;
        }
    }

    /// Somebody else has moved the bones to `targets`: from there the hand returns to its script,
    /// or goes on to the tracked pose.
    pub fn return_from(&mut self, targets: &[Option<Target>]) {
        self.restart(targets);
        if self.memory.way == PoseSource::Script {
            self.memory.way = PoseSource::Returning;
        }
    }

    /// Moves on by a step of `h` \[s\]. `targets` are the script's at the end of the step, when
    /// [`Self::wants_script`]; they are replaced unless the script alone moves the hand.
    pub fn step(&mut self, h: f64, targets: &mut [Option<Target>]) {
        match self.memory.way {
            PoseSource::Script => {
                let Self { articulation, memory, poses, angles, .. } = self;
                let before = memory.script_known.then_some(h);
                memory.kinematic_state.read(articulation, targets, before, poses, angles);
                self.memory.script_known = true;
                self.memory.now += h;
                return;
            }
            PoseSource::Returning => {
                let Self { articulation, memory, poses, angles, .. } = self;
                let before = memory.script_known.then_some(h);
                memory.script.read(articulation, targets, before, poses, angles);
                self.memory.script_known = true;
            }
            PoseSource::Live => self.aim(h),
        }
        self.memory.now += h;
        self.follow(h);
        if self.memory.way == PoseSource::Returning && self.has_arrived() {
            self.memory.way = PoseSource::Script;
            self.memory.kinematic_state.copy_from(&self.memory.script);
            return;
        }
        let kinematic_state = &self.memory.kinematic_state;
        let wrist = Pose::new(kinematic_state.position[0], kinematic_state.rotation.0);
        let velocity = [kinematic_state.position[1], kinematic_state.rotation.1];
        self.articulation.targets(
            &wrist,
            velocity,
            &kinematic_state.angles,
            &kinematic_state.rates,
            targets,
        );
    }

    fn is_lost(&self) -> bool {
        self.memory.lost || self.memory.now - self.memory.arrived > STALE
    }

    /// Poses move the hand from now on, from where its targets are.
    fn take_over(&mut self, targets: &[Option<Target>]) {
        if self.memory.way == PoseSource::Script {
            // The angles are those of the last step already; this keeps their rates.
            let Self { articulation, memory, poses, angles, .. } = self;
            if !memory.script_known {
                memory.kinematic_state.read(articulation, targets, None, poses, angles);
            }
        }
        self.memory.way = PoseSource::Live;
        self.memory.calibrated = 0;
        self.knuckles.forget();
    }

    /// Our wrist for a pose; its angles go to `self.angles`.
    fn carry_over(&mut self, pose: &LivePose) -> Pose {
        match pose {
            LivePose::Joints { joints, .. } => {
                self.calibrate(joints);
                let Self { articulation, retarget, angles, wanted, poses, .. } = self;
                match retarget {
                    Some(retarget) => retarget.apply(articulation, joints, angles, wanted, poses),
                    None => joints[0],
                }
            }
            LivePose::Angles { wrist, angles } => {
                self.angles.copy_from_slice(&self.articulation.rest_angles);
                for (range, angle) in self.ranges.iter().zip(angles) {
                    if let Some(r) = range {
                        self.angles[r.index][r.axis] = r.sense * angle.clamp(r.min, r.max);
                    }
                }
                *wrist
            }
        }
    }

    /// Learns of the tracker's wrist frame and of the hand's size.
    fn calibrate(&mut self, joints: &[Pose; 25]) {
        let (Some(retarget), true) = (&mut self.retarget, self.memory.calibrated < CALIBRATION)
        else {
            return;
        };
        let ratio = self.bones.ratio(joints);
        let Some(ratio) = ratio.filter(|r| RATIOS.contains(r)) else { return };
        self.memory.ratios[self.memory.calibrated] = ratio;
        self.knuckles.take(joints, false);
        let found = self.knuckles.wrist_offset();
        let present = retarget.wrist_offset();
        let change = (found * present.inverse()).scaled_axis();
        let step = if self.memory.calibrated == 0 {
            change
        } else {
            super::observer::bounded(change, REFINEMENT)
        };
        let turned = Quat::from_scaled_axis(step) * present;
        retarget.set_wrist_offset(Quat::new_normalize(turned.into_inner()));
        self.memory.calibrated += 1;
    }

    /// Returns the timing of the pose carried over, after the last one that was taken; `None` when
    /// it must wait for another that agrees with it. One that it bears out is taken before it.
    fn without_doubt(&mut self, wrist: &Pose, timing: Timing) -> Option<Timing> {
        let longest = self.longest(timing.gap);
        let Self { outlier_gate: Some(outlier_gate), memory, angles, .. } = self else {
            return Some(timing);
        };
        let since_taken = memory.now - memory.arrived + memory.late - timing.late;
        let gap = if outlier_gate.waits() { Some(since_taken.max(0.0)) } else { timing.gap };
        let surprises = [
            memory.position.surprise(wrist.position, gap),
            memory.rotation.surprise(&wrist.rotation, gap),
            (memory.joints.iter().flatten().zip(angles.as_flattened()))
                .map(|(joint, angle)| joint.surprise(*angle, gap))
                .fold(0.0, f64::max),
        ];
        match outlier_gate.look(wrist, angles, surprises, gap.unwrap_or(0.0), timing.gap) {
            GateDecision::Waits => None,
            GateDecision::Taken => Some(Timing { gap, ..timing }),
            GateDecision::BornOut(PendingWrist { wrist, gap: before }) => {
                let first = Timing { gap: Some(before), fresh: false, ..timing };
                memory.observe(&wrist, outlier_gate.angles(), &first, false, longest);
                let step = timing.gap.or_else(|| gap.map(|gap| (gap - before).max(0.0)));
                Some(Timing { gap: step, ..timing })
            }
        }
    }

    /// True for a hand that is felt.
    fn is_tight(&self) -> bool {
        self.omega > OMEGA[1]
    }

    /// Longest memory for noise of samples `gap` \[s\] apart \[s\].
    fn longest(&self, gap: Option<f64>) -> f64 {
        let longest = |gap| self.levers.longest(&self.memory, gap, &self.spring);
        gap.map_or(MEMORY[1], longest)
    }

    /// Computes the tracked hand's stance at the end of the step, into `script`.
    fn aim(&mut self, h: f64) {
        let lost = self.is_lost();
        let age = self.memory.now - self.memory.arrived + self.memory.late + h;
        let ahead = age.min(AHEAD_MAX);
        // A pose that is carried forward no further does not move.
        let moving = if lost || age > AHEAD_MAX + h { 0.0 } else { 1.0 };
        let goal = &mut self.memory.script;
        goal.position = [self.memory.position.ahead(ahead), self.memory.position.rate * moving];
        goal.rotation = (self.memory.rotation.ahead(ahead), self.memory.rotation.rate * moving);
        for (j, joint) in self.memory.joints.iter().enumerate() {
            let goal_angles = [0, 1].map(|k| joint[k].ahead(ahead));
            let admissible = self.articulation.tree.clamp(j, goal_angles);
            for k in 0..2 {
                let free = admissible[k] == goal_angles[k];
                goal.angles[j][k] = admissible[k];
                goal.rates[j][k] = if free { joint[k].rate * moving } else { 0.0 };
            }
        }
    }

    /// Returns the part of the full speed that the hand has, from 0 to 1.
    fn opening(&self) -> f64 {
        ((self.memory.now - self.memory.set_out) / OPENING).min(1.0)
    }

    /// Moves the targets towards `script`.
    fn follow(&mut self, h: f64) {
        let opening = self.opening();
        let mut omega = OMEGA[0] + (self.omega - OMEGA[0]) * opening.powi(4);
        if self.memory.way == PoseSource::Returning {
            // A script is to be met exactly: follow ever more tightly.
            let beyond = (self.memory.now - self.memory.set_out - OPENING).max(0.0);
            omega *= (beyond / 0.05).min(7.0).exp();
        }
        // Followed tightly, noise would be felt: no tighter than it is observed.
        let tight = self.is_tight() && self.memory.way == PoseSource::Live;
        let law = |speed: f64, quiet: f64| {
            // The power 5/4 of how quiet it is: least where memory is longest.
            let part = if tight { (quiet * quiet.sqrt().sqrt()).max(NOISY) } else { 1.0 };
            Law { omega: part * omega, speed: speed * opening * opening }
        };
        let quiet = [self.memory.position.quiet(), self.memory.rotation.quiet()];
        // A script may squeeze joints against their ends.
        let returns = self.memory.way == PoseSource::Returning;
        let (kinematic_state, goal) = (&mut self.memory.kinematic_state, &self.memory.script);
        kinematic_state.position =
            follow(kinematic_state.position, goal.position, law(SPEED_MAX, quiet[0]), h);
        kinematic_state.rotation =
            follow_rotation(kinematic_state.rotation, goal.rotation, law(SPIN_MAX, quiet[1]), h);
        for j in 0..kinematic_state.angles.len() {
            let limits = self.articulation.tree.limits(j);
            for k in 0..2 {
                let before = kinematic_state.angles[j][k];
                let goal = [goal.angles[j][k], goal.rates[j][k]];
                let law = law(JOINT_RATE_MAX, self.memory.joints[j][k].quiet());
                let [mut angle, mut rate] =
                    follow([before, kinematic_state.rates[j][k]], goal, law, h);
                if let Some(limit) = limits[k] {
                    // A script may have left the hand beyond a limit: then it goes no further.
                    let asked = if returns { goal[0] } else { before };
                    let low = limit.min.min(before).min(asked);
                    let inside = angle.clamp(low, limit.max.max(before).max(asked));
                    rate = if inside == angle { rate } else { 0.0 };
                    angle = inside;
                }
                (kinematic_state.angles[j][k], kinematic_state.rates[j][k]) = (angle, rate);
            }
        }
    }

    fn has_arrived(&self) -> bool {
        let (a, b) = (&self.memory.kinematic_state, &self.memory.script);
        let near = |a: &[f64; 2], b: &[f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() < ARRIVED);
        (a.position[0] - b.position[0]).norm() < ARRIVED
            && a.rotation.0.angle_to(&b.rotation.0) < ARRIVED
            && a.angles.iter().zip(&b.angles).all(|(a, b)| near(a, b))
            && self.opening() >= 1.0
    }
}
