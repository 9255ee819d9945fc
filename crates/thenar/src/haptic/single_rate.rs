//! Single-rate touch: the whole simulation steps within the haptic tick. Nothing is smoothed and
//! nothing is late; it must fit into a tick.
//!
//! There are no proxies: tracked poses are the targets of the bones' drives, and what the drives do
//! is felt from their other end ([`drive_reaction`]). A drive then stands for both couplings in
//! series ([`series_drive`]).

use crate::haptic::{
    FastToSlow, HandReport, Prediction, RigidState, Sample, SlowToFast, Touch, Track,
    drive_reaction, seconds_between, series_stiffness,
};
use crate::math::{Pose, Quat, Vec3, rotation_vector};
use crate::model::Drive;
use crate::world::{Input, World};
use std::ops::Range;

/// How a simulation within the tick is stepped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleRateSettings {
    /// Between samples of the tracker.
    pub tracking: Prediction,
    /// A tick longer than this is stepped as if it were this long \[s\]: the simulation falls
    /// behind rather than leap.
    pub step_max: f64,
    /// Shorter times wait for the next tick \[s\].
    pub step_min: f64,
    /// After a jump of the tracker the target glides there with this time constant \[s\]: a bone
    /// that is to be a metre away would pull at the wearer.
    pub glide: f64,
}

impl Default for SingleRateSettings {
    fn default() -> Self {
        Self { tracking: Prediction::TRACKER, step_max: 0.02, step_min: 1e-4, glide: 0.15 }
    }
}

/// A hand whose world steps within the haptic tick.
#[derive(Clone, Debug)]
pub struct SingleRate {
    settings: SingleRateSettings,
    world: World,
    input: Input,
    /// The hand's bones among the rigid bodies.
    first: usize,
    tracks: Vec<Track>,
    /// What is left of jumps (linear, angular): targets are the tracked poses plus this.
    glides: Vec<[Vec3; 2]>,
    tracked: Vec<RigidState>,
    targets: Vec<RigidState>,
    jumped: Vec<bool>,
    bones: Vec<RigidState>,
    wrenches: Vec<[Vec3; 2]>,
    last_ns: Option<u64>,
    /// Time that has passed and is not simulated yet \[s\].
    owed: f64,
    ticks: u64,
}

impl SingleRate {
    /// `bones` are the hand's among the world's rigid bodies, those with a drive are felt.
    /// Allocates all it needs.
    pub fn new(settings: SingleRateSettings, world: World, bones: Range<u32>) -> Self {
        let end = (bones.end as usize).min(world.model().rigids.len());
        let first = (bones.start as usize).min(end);
        let n = end - first;
        let at = |i: usize| RigidState::of(&world, (first + i) as u32);
        let states: Vec<RigidState> = (0..n).map(at).collect();
        Self {
            settings,
            input: world.input(),
            first,
            tracks: vec![Track::default(); n],
            glides: vec![[Vec3::zeros(); 2]; n],
            tracked: states.clone(),
            targets: states.clone(),
            jumped: vec![false; n],
            bones: states,
            wrenches: vec![[Vec3::zeros(); 2]; n],
            last_ns: None,
            owed: 0.0,
            ticks: 0,
            world,
        }
    }

    /// What else acts in the next steps: gravity, other hands, loads. The hand's own targets are
    /// written over.
    pub fn input_mut(&mut self) -> &mut Input {
        &mut self.input
    }

    /// Places tracked poses and targets `h` \[s\] after the tick before; the age of the oldest.
    fn place_hand(&mut self, now_ns: u64, h: f64) -> f64 {
        let mut oldest = 0.0_f64;
        let left = if self.settings.glide > 0.0 { (-h / self.settings.glide).exp() } else { 0.0 };
        for i in 0..self.tracks.len() {
            let Some(told) = self.tracks[i].at(now_ns, &self.settings.tracking) else {
                // Never tracked: let go, and nothing is felt.
                (self.tracked[i], self.targets[i]) = (self.bones[i], self.bones[i]);
                self.input.targets[self.first + i] = None;
                oldest = f64::INFINITY;
                continue;
            };
            let begins = self.input.targets[self.first + i].is_none();
            self.jumped[i] = told.jumped;
            self.tracked[i] = told.state;
            let glide = &mut self.glides[i];
            if told.jumped || begins {
                let (from, to) = (&self.targets[i].pose_WB, &told.state.pose_WB);
                let turn = rotation_vector(&(from.rotation * to.rotation.inverse()));
                *glide = [from.position - to.position, turn];
            } else {
                glide.iter_mut().for_each(|part| *part *= left);
            }
            self.targets[i] = shifted(&told.state, glide, self.settings.glide);
            self.input.targets[self.first + i] = Some(self.targets[i].target());
            oldest = oldest.max(told.age);
        }
        oldest
    }

    fn feel(&mut self) {
        for i in 0..self.bones.len() {
            self.bones[i] = RigidState::of(&self.world, (self.first + i) as u32);
            let drive = self.world.desc().drives[self.first + i];
            let held = drive.filter(|_| self.input.targets[self.first + i].is_some());
            self.wrenches[i] = held.map_or([Vec3::zeros(); 2], |drive| {
                drive_reaction(&drive, &self.targets[i], &self.bones[i])
            });
        }
    }
}

impl Touch for SingleRate {
    fn track(
        &mut self,
        bone: usize,
        time_ns: u64,
        pose_WB: Pose,
        velocity: Option<[Vec3; 2]>,
    ) -> Sample {
        self.tracks[bone].push(time_ns, pose_WB, velocity, &self.settings.tracking)
    }

    fn tick(&mut self, now_ns: u64, _: &SlowToFast) -> HandReport {
        let passed = seconds_between(self.last_ns.unwrap_or(now_ns), now_ns);
        self.last_ns = Some(now_ns);
        let h = passed.clamp(0.0, self.settings.step_max);
        self.owed = (self.owed + h).min(self.settings.step_max);
        let tracking_age = self.place_hand(now_ns, h);
        let mut world = None;
        if self.owed >= self.settings.step_min && self.owed > 0.0 {
            self.world.set_time_step(self.owed);
            world = Some(self.world.step(&self.input, &mut ()));
            self.owed = 0.0;
        }
        self.feel();
        self.ticks += 1;
        HandReport { step: h, tracking_age, world, ..HandReport::default() }
    }

    fn publish(&self, now_ns: u64, to: &mut FastToSlow) {
        (to.time_ns, to.tick) = (now_ns, self.ticks);
        to.proxies.copy_from_slice(&self.targets);
    }

    fn tracked(&self) -> &[RigidState] {
        &self.tracked
    }

    fn jumped(&self, bone: usize) -> bool {
        self.jumped[bone]
    }

    fn bones(&self) -> &[RigidState] {
        &self.bones
    }

    fn device_wrenches(&self) -> &[[Vec3; 2]] {
        &self.wrenches
    }

    fn world(&self) -> Option<&World> {
        Some(&self.world)
    }
}

/// The drive that feels like a proxy between two couplings, once it is at rest: springs in series,
/// dampers in series.
pub fn series_drive(device: &Drive, bone: &Drive) -> Drive {
    Drive {
        stiffness: series_stiffness(device.stiffness, bone.stiffness),
        damping: series_stiffness(device.damping, bone.damping),
        angular_stiffness: series_stiffness(device.angular_stiffness, bone.angular_stiffness),
        angular_damping: series_stiffness(device.angular_damping, bone.angular_damping),
    }
}

/// `state` away by a glide that decays with this time constant.
fn shifted(state: &RigidState, [linear, angular]: &[Vec3; 2], time: f64) -> RigidState {
    let rate = if time > 0.0 { 1.0 / time } else { 0.0 };
    let turned = Quat::from_scaled_axis(*angular) * state.pose_WB.rotation;
    RigidState {
        pose_WB: Pose::new(state.pose_WB.position + linear, turned),
        velocity_W: state.velocity_W - linear * rate,
        angular_velocity_W: state.angular_velocity_W - angular * rate,
    }
}
