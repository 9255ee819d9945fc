//! Trackers that go wrong as planned, for trials of everything behind them.

use crate::{Driver, FoundDevice, HandSample, LinkError, Opened, PresenceCheck, Tracker};
use std::f64::consts::PI;
use thenar_core::model::Side;
use thenar_core::random::Random;
use thenar_core::{Pose, Quat, Vec3};
use thenar_touch::TrackerTiming;
use thenar_track::live::LivePose;

/// Kinds of fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The hand is somewhere else \[m\].
    Teleport(Vec3),
    /// The hand is turned by half a turn about itself: palm for back.
    Flip,
    /// One pose is repeated, with new times.
    Freeze,
    /// A number is none.
    NotANumber,
    /// Nothing comes.
    DropOut,
    /// The device says that it does not see the hand.
    Lost,
    /// Times are off \[ns\].
    ClockJump(i64),
}

/// A fault and when, from the first sample on \[ns\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScheduledFault {
    /// Beginning of the fault \[ns\].
    pub from_ns: u64,
    /// End of the fault \[ns\].
    pub to_ns: u64,
    /// The fault itself.
    pub fault: Fault,
}

/// Faults of these kinds in turn, at random times and for random whiles: 20 ms to 600 ms each, 0.3
/// s to 1.5 s apart. The same seed gives the same plan.
pub fn plan(seed: u64, duration_ns: u64) -> Vec<ScheduledFault> {
    let mut random = Random::new(seed);
    let mut random = || random.unit();
    let (mut plan, mut at, mut turn) = (Vec::new(), 0, (random() * 7.0) as usize);
    while plan.len() < 100_000 {
        at += 300_000_000 + (random() * 1.2e9) as u64;
        let to_ns = at + 20_000_000 + (random() * 0.58e9) as u64;
        if at >= duration_ns {
            break;
        }
        let sign = if random() < 0.5 { -1.0 } else { 1.0 };
        let fault = match turn % 7 {
            0 => Fault::Teleport(Vec3::new(0.3 + random(), random(), random()) * sign),
            1 => Fault::Flip,
            2 => Fault::Freeze,
            3 => Fault::NotANumber,
            4 => Fault::DropOut,
            5 => Fault::Lost,
            _ => Fault::ClockJump((sign * (0.05 + 2.0 * random()) * 1e9) as i64),
        };
        plan.push(ScheduledFault { from_ns: at, to_ns, fault });
        (at, turn) = (to_ns, turn + 1);
    }
    plan
}

/// A tracker behind which things go wrong. What it tells then may break every promise of a
/// tracker: that is its purpose.
pub struct FaultInjector {
    inner: Box<dyn Tracker>,
    plan: Vec<ScheduledFault>,
    /// Time of the first sample \[ns\].
    first_ns: Option<u64>,
    /// Last sample reported of each hand, to freeze and to lend.
    told: [Option<HandSample>; 2],
}

impl FaultInjector {
    /// This tracker, and what shall go wrong with it, in order of time.
    pub fn new(inner: Box<dyn Tracker>, plan: Vec<ScheduledFault>) -> Self {
        Self { inner, plan, first_ns: None, told: [None, None] }
    }
}

impl Tracker for FaultInjector {
    fn timing(&self) -> Option<TrackerTiming> {
        self.inner.timing()
    }

    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let sample = self.inner.latest(side)?;
        let since = sample.time_ns.saturating_sub(*self.first_ns.get_or_insert(sample.time_ns));
        let next = self.plan.partition_point(|planned| planned.to_ns <= since);
        let fault = self.plan.get(next).filter(|planned| planned.from_ns <= since);
        let told = &mut self.told[side as usize];
        let mut changed = sample.clone();
        match fault.map(|planned| planned.fault) {
            None => {}
            Some(Fault::Teleport(by)) => each_pose(&mut changed, &mut |pose| pose.position += by),
            Some(Fault::Flip) => flip(&mut changed),
            Some(Fault::Freeze) => {
                if let Some(told) = told {
                    changed.pose.clone_from(&told.pose);
                }
            }
            Some(Fault::NotANumber) => {
                each_pose(&mut changed, &mut |pose| pose.position.y = f64::NAN);
            }
            Some(Fault::DropOut) => return None,
            Some(Fault::Lost) => changed.pose = None,
            Some(Fault::ClockJump(by)) => {
                changed.time_ns = changed.time_ns.saturating_add_signed(by)
            }
        }
        *told = Some(changed);
        told.as_ref()
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.inner.heard_ns()
    }

    fn hand_length(&self) -> Option<f64> {
        self.inner.hand_length()
    }

    fn messages(&mut self) -> Vec<String> {
        self.inner.messages()
    }

    fn presence_check(&self) -> PresenceCheck {
        self.inner.presence_check()
    }
}

fn each_pose(sample: &mut HandSample, change: &mut dyn FnMut(&mut Pose)) {
    match &mut sample.pose {
        Some(LivePose::Joints { joints, .. }) => joints.iter_mut().for_each(change),
        Some(LivePose::Angles { wrist, .. }) => change(wrist),
        None => {}
    }
}

/// Half a turn about the wrist's z.
fn flip(sample: &mut HandSample) {
    let wrist = match &sample.pose {
        Some(LivePose::Joints { joints, .. }) => joints[0],
        Some(LivePose::Angles { wrist, .. }) => *wrist,
        None => return,
    };
    let half = Pose::new(Vec3::zeros(), Quat::from_scaled_axis(Vec3::z() * PI));
    let turn = wrist * half * wrist.inverse();
    each_pose(sample, &mut |pose| *pose = turn * *pose);
}

/// Driver of addresses `fault:SEED:DEVICE`.
pub struct FaultInjectionDriver;

impl Driver for FaultInjectionDriver {
    fn name(&self) -> &'static str {
        "fault"
    }

    fn about(&self) -> &'static str {
        "any device with a tracker that goes wrong, for an hour, by a plan: fault:SEED:DEVICE"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let refuse = |cause: &str| LinkError::Setting {
            what: format!("device `fault:{address}`"),
            cause: cause.into(),
        };
        let (seed, inner) =
            address.split_once(':').ok_or_else(|| refuse("expected SEED:DEVICE"))?;
        let seed = seed.parse().map_err(|_| refuse("the seed must be a whole number"))?;
        let opened = crate::open(inner)?;
        let plan = plan(seed, 3_600_000_000_000);
        let tracker = opened.tracker.ok_or_else(|| refuse("that device tracks nothing"))?;
        Ok(Opened { tracker: Some(Box::new(FaultInjector::new(tracker, plan))), ..opened })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use std::mem::discriminant;
    use thenar_track::ANGLES;

    const MS: u64 = 1_000_000;

    /// A hand that moves 1 mm per call, a call per millisecond.
    struct Steady(HandSample);

    impl Steady {
        fn start() -> Self {
            let wrist = Pose::translation(0.1, 0.2, 0.3);
            let pose = Some(LivePose::Angles { wrist, angles: [0.1; ANGLES] });
            Self(HandSample { side: Side::Right, time_ns: 5000 * MS, pose })
        }
    }

    impl Tracker for Steady {
        fn latest(&mut self, _: Side) -> Option<&HandSample> {
            self.0.time_ns += MS;
            each_pose(&mut self.0, &mut |pose| pose.position.x += 1e-3);
            Some(&self.0)
        }

        fn heard_ns(&mut self) -> Option<u64> {
            Some(self.0.time_ns)
        }

        fn messages(&mut self) -> Vec<String> {
            Vec::new()
        }
    }

    fn wrist(sample: &HandSample) -> Pose {
        match &sample.pose {
            Some(LivePose::Angles { wrist, .. }) => *wrist,
            other => panic!("{other:?}"),
        }
    }

    /// Each fault by itself, from 10 ms to 20 ms, and nothing before and after.
    #[test]
    fn faults_begin_and_end_as_planned() {
        let faults = [
            Fault::Teleport(Vec3::y()),
            Fault::Flip,
            Fault::Freeze,
            Fault::NotANumber,
            Fault::DropOut,
            Fault::Lost,
            Fault::ClockJump(-700_000_000),
        ];
        for fault in faults {
            let plan = vec![ScheduledFault { from_ns: 10 * MS, to_ns: 20 * MS, fault }];
            let mut injector = FaultInjector::new(Box::new(Steady::start()), plan);
            let mut right = Steady::start();
            let mut frozen = None;
            for ms in 0..30 {
                let want = right.latest(Side::Right).unwrap().clone();
                let got = injector.latest(Side::Right).cloned();
                if !(10..20).contains(&ms) {
                    assert_eq!(got.as_ref(), Some(&want), "{fault:?} {ms}");
                    frozen = got;
                    continue;
                }
                match (fault, got) {
                    (Fault::Teleport(by), Some(got)) => {
                        assert_eq!(wrist(&got).position, wrist(&want).position + by);
                    }
                    (Fault::Flip, Some(got)) => {
                        let (a, b) = (wrist(&got), wrist(&want));
                        assert!((a.position - b.position).norm() < 1e-12);
                        assert!((a.vector(&Vec3::y()) + b.vector(&Vec3::y())).norm() < 1e-12);
                    }
                    (Fault::Freeze, Some(got)) => {
                        assert_eq!(got.pose, frozen.as_ref().unwrap().pose);
                        assert_eq!(got.time_ns, want.time_ns);
                    }
                    (Fault::NotANumber, Some(got)) => assert!(!wrist(&got).is_finite()),
                    (Fault::DropOut, None) => {}
                    (Fault::Lost, Some(got)) => assert_eq!(got.pose, None),
                    (Fault::ClockJump(_), Some(got)) => {
                        assert_eq!(got.time_ns + 700 * MS, want.time_ns);
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
    }

    #[test]
    fn plans_are_repeatable_ordered_and_hold_every_fault() {
        let minute = plan(3, 60_000 * MS);
        assert_eq!(minute, plan(3, 60_000 * MS));
        assert_ne!(minute, plan(4, 60_000 * MS));
        assert!(minute.windows(2).all(|two| two[0].to_ns < two[1].from_ns));
        assert!(minute.iter().all(|p| p.to_ns - p.from_ns >= 20 * MS));
        let kinds: HashSet<_> = minute.iter().map(|p| discriminant(&p.fault)).collect();
        assert_eq!(kinds.len(), 7);
    }
}
