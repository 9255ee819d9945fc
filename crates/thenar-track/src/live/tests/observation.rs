//! Goal: the rule of stiffness knows what observation costs. Method: a wrist that sways evenly, seen at a rate and late;
//! of what is followed, the part in quadrature is what a spring to it would take off the damping.

use super::Rig;
use crate::ANGLES;
use crate::TrackerTiming;
use crate::live::{LivePose, OBSERVATION};
use std::collections::VecDeque;
use std::f64::consts::TAU;
use thenar::Pose;

/// `-Im G(ω)/ω` \[s\] at `hz`, by Fourier's sums over the last 3 s of 5.
fn taken(timing: &TrackerTiming, hz: f64) -> f64 {
    let mut rig = Rig::new();
    rig.live.follow_at(80.0);
    rig.live.doubt_glitches();
    let (rate, size) = (TAU * hz, 0.01);
    let mut way = VecDeque::new();
    let (mut seen, mut sum) = (0.0, 0.0);
    for ms in 1..=5000 {
        let t = 1e-3 * f64::from(ms);
        if t * timing.rate >= seen {
            seen += 1.0;
            let wrist = Pose::translation(size * (rate * t).sin(), 0.0, 0.0);
            let pose = LivePose::Angles { wrist, angles: [0.0; ANGLES] };
            way.push_back((t + timing.latency, t, pose));
        }
        while way.front().is_some_and(|(due, ..)| *due <= t + 1e-9) {
            let (_, time, pose) = way.pop_front().unwrap();
            rig.live.pose(time, &pose, &rig.targets).unwrap();
        }
        rig.live.step(1e-3, &mut rig.targets);
        if ms > 2000 {
            let x = rig.targets[0].unwrap().pose_WB.position.x;
            sum -= x * (rate * t).cos();
        }
    }
    2.0 * sum / (3000.0 * size) / rate
}

/// At the worst sway from 1 to 20 Hz no more than a millisecond beyond the rule, which is not far beyond it.
#[test]
fn observation_takes_what_the_rule_says() {
    let mut most_over = 0.0_f64;
    for rate in [60.0, 90.0, 120.0, 1000.0] {
        for latency in [0.0, 0.02, 0.05] {
            let timing = TrackerTiming { rate, latency, noise: 0.0 };
            let rule = timing.delay() + OBSERVATION.adds(timing.delay());
            let sways = [1.0, 2.0, 3.0, 5.0, 6.0, 8.0, 10.0, 11.0, 12.0, 15.0, 20.0];
            let worst = sways.map(|hz| taken(&timing, hz)).into_iter().fold(0.0, f64::max);
            println!("{rate} Hz, {latency} s: {worst} s, by the rule {rule} s");
            assert!(worst < rule + 1e-3, "{rate} Hz, {latency} s: {worst} of {rule} s");
            most_over = most_over.max(rule - worst);
        }
    }
    assert!(most_over < 9e-3, "the rule is {most_over} s beyond what is taken");
}
