//! One tick of the haptic loop for a whole hand: newest samples in, forces on the wearer out.

use crate::haptic::shared::{Resolution, SharedConstraints};
use crate::haptic::{
    FastToSlow, Prediction, Proxies, Proxy, ProxyError, ProxyReport, RigidState, Sample,
    SlowToFast, Touch, Track, Tracked, seconds_between,
};
use crate::math::{Pose, Vec3};
use crate::world::StepReport;

/// What stands in for the simulated bones between two frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The frame's bones, carried forward by their velocity (the paper).
    Multirate,
    /// The frame's condensed response, contact resolved every tick; frames without one as
    /// `Multirate`.
    SharedConstraints,
}

/// How a hand is predicted and resolved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandSettings {
    /// Between simulation frames.
    pub mode: Mode,
    /// Between samples of the tracker.
    pub tracking: Prediction,
    /// Between frames, in `Multirate`.
    pub simulation: Prediction,
    /// A tick longer than this is stepped as if it were this long \[s\].
    pub step_max: f64,
    /// Contact forces are resolved to this \[N\] ...
    pub force_tolerance: f64,
    /// ... or for so many sweeps.
    pub sweeps_max: u32,
}

impl Default for HandSettings {
    fn default() -> Self {
        Self {
            mode: Mode::Multirate,
            tracking: Prediction::TRACKER,
            simulation: Prediction::SIMULATION,
            step_max: 0.02,
            force_tolerance: 1e-3,
            sweeps_max: 20,
        }
    }
}

/// What one tick did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HandReport {
    /// Length of the step \[s\]; zero when the clock did not advance.
    pub step: f64,
    /// Age of the oldest tracked pose \[s\]; infinite when a bone was never tracked.
    pub tracking_age: f64,
    /// Age of the simulation frame \[s\].
    pub simulation_age: f64,
    /// The proxies.
    pub proxies: ProxyReport,
    /// Contact, with shared constraints.
    pub contact: Resolution,
    /// The simulation's own step, in single-rate.
    pub world: Option<StepReport>,
}

/// A hand at the device's rate.
#[derive(Clone, Debug)]
pub struct HapticHand {
    settings: HandSettings,
    tracks: Vec<Track>,
    proxies: Proxies,
    shared: SharedConstraints,
    /// Step of the frame that `shared` works on.
    shared_step: Option<u64>,
    /// Ends of the couplings in this tick.
    tracked: Vec<RigidState>,
    bones: Vec<RigidState>,
    jumped: Vec<bool>,
    last_ns: Option<u64>,
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
        let proxies = Proxies::new(proxies, start)?;
        Ok(Self {
            settings,
            tracks: vec![Track::default(); n],
            shared: SharedConstraints::new(n, contacts_max),
            shared_step: None,
            tracked: proxies.states().to_vec(),
            bones: proxies.states().to_vec(),
            jumped: vec![false; n],
            proxies,
            last_ns: None,
            ticks: 0,
        })
    }

    /// The simulated bones now.
    fn place_bones(&mut self, frame: &SlowToFast, age: f64, h: f64) -> Resolution {
        let response = &frame.response;
        if self.settings.mode == Mode::SharedConstraints && response.is_ready() {
            if self.shared_step != Some(frame.step) {
                self.shared.begin(response);
                self.shared_step = Some(frame.step);
            }
            let (tolerance, sweeps) = (self.settings.force_tolerance, self.settings.sweeps_max);
            let states = self.proxies.states();
            let resolution = self.shared.resolve(response, states, h, tolerance, sweeps);
            for (i, (bone, of_frame)) in self.bones.iter_mut().zip(&frame.bones).enumerate() {
                *bone = self.shared.bone(i, of_frame);
            }
            return resolution;
        }
        for (bone, of_frame) in self.bones.iter_mut().zip(&frame.bones) {
            *bone = self.settings.simulation.at(of_frame, age);
        }
        Resolution::default()
    }

    /// The tracked bones now, and the age of the oldest. A bone that was never tracked goes where
    /// its simulated bone is, so it feels nothing. The proxy of one that jumped goes along, so
    /// that the jump does not become a pull.
    fn place_hand(&mut self, now_ns: u64) -> f64 {
        let mut oldest = 0.0_f64;
        for (i, track) in self.tracks.iter_mut().enumerate() {
            let unknown = Tracked { state: self.bones[i], age: f64::INFINITY, jumped: false };
            let tracked = track.at(now_ns, &self.settings.tracking).unwrap_or(unknown);
            self.tracked[i] = tracked.state;
            self.jumped[i] = tracked.jumped;
            if tracked.jumped {
                self.proxies.place(i, tracked.state);
            }
            oldest = oldest.max(tracked.age);
        }
        oldest
    }

    /// The proxies and their forces.
    pub fn proxies(&self) -> &Proxies {
        &self.proxies
    }
}

impl Touch for HapticHand {
    fn track(
        &mut self,
        bone: usize,
        time_ns: u64,
        pose_WB: Pose,
        velocity: Option<[Vec3; 2]>,
    ) -> Sample {
        self.tracks[bone].push(time_ns, pose_WB, velocity, &self.settings.tracking)
    }

    fn tick(&mut self, now_ns: u64, frame: &SlowToFast) -> HandReport {
        let passed = seconds_between(self.last_ns.unwrap_or(now_ns), now_ns);
        self.last_ns = Some(now_ns);
        let h = passed.clamp(0.0, self.settings.step_max);
        let simulation_age = seconds_between(frame.time_ns, now_ns);
        let contact = self.place_bones(frame, simulation_age, h);
        let tracking_age = self.place_hand(now_ns);
        let proxies = self.proxies.step(h, &self.tracked, &self.bones);
        self.ticks += 1;
        HandReport { step: h, tracking_age, simulation_age, proxies, contact, world: None }
    }

    fn publish(&self, now_ns: u64, to: &mut FastToSlow) {
        (to.time_ns, to.tick) = (now_ns, self.ticks);
        to.proxies.copy_from_slice(self.proxies.states());
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
        self.proxies.device_wrenches()
    }
}
