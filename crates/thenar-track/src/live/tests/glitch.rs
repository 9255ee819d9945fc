//! Goal: a glitch of one sample is not felt, at any rate and after a lost sample, and a true
//! approach is late by one sample at most. Method: a live hand as the loop has it; how far its
//! bones go, against what is felt of that.

use super::Rig;
use crate::ANGLES;
use crate::live::LivePose;
use thenar_core::random::Random;
use thenar_core::{Pose, Quat, Vec3};

/// Ticks of the loop \[s\].
const TICK: f64 = 1e-3;
const RATES: [f64; 4] = [30.0, 60.0, 90.0, 120.0];

/// Stiffness that a grip of 1 N s/m is shown behind a tracker without latency, observed within 10
/// ms \[N/m\].
fn felt(rate: f64) -> f64 {
    0.85 / (0.5e-3 + 0.5 / rate + 0.01 - 0.2 * 0.5 / rate)
}

fn rig() -> Rig {
    let mut rig = Rig::new();
    rig.live.follow_at(80.0);
    rig.live.doubt_glitches();
    rig
}

/// Times of samples at a rate for so long \[s\]; one in twenty is lost where there are losses, no
/// two in a row: three periods of 30 Hz are a tenth of a second, after which a hand counts as lost.
fn times(rate: f64, end: f64, losses: bool, random: &mut Random) -> Vec<f64> {
    let mut lost = false;
    let mut seen = |_: &u32| {
        lost = losses && !lost && random.symmetric() > 0.9;
        !lost
    };
    (0..(end * rate) as u32).filter(&mut seen).map(|k| f64::from(k) / rate).collect()
}

/// Returns the largest distance of any bone's end in the hand from where it was \[m\].
fn farthest(rig: &Rig, home: &[Vec3]) -> f64 {
    ends(rig).iter().zip(home).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn ends(rig: &Rig) -> Vec<Vec3> {
    let bones = rig.targets.iter().zip(&rig.hand.bones);
    bones.map(|(target, bone)| target.unwrap().pose_WB.point(&bone.ends_B[1])).collect()
}

/// Pressed still, with half a millimetre of noise: 5 cm of the wrist, as much at a fingertip by a
/// turn of the wrist, or by one knuckle, once, adds half a newton at most to what noise does.
#[test]
fn a_glitch_of_one_sample_is_not_felt() {
    for rate in RATES {
        for losses in [false, true] {
            for kind in 0..3 {
                let mut most = 0.0_f64;
                for seed in 1..=10 {
                    let mut random = Random::new(seed);
                    let times = times(rate, 2.0, losses, &mut random);
                    let mut clean = rig();
                    let (mut off, mut at) = (clean.clone(), 0);
                    let glitch = times.len() * 3 / 4 + seed as usize;
                    for tick in 1..2000 {
                        let t = TICK * f64::from(tick);
                        if times.get(at).is_some_and(|due| *due <= t + 1e-9) {
                            let mut noise = || 5e-4 * 3f64.sqrt() * random.symmetric();
                            let wrist = Pose::translation(noise(), noise(), noise());
                            let (mut turned, mut angles) = (wrist, [0.2; ANGLES]);
                            let pose = LivePose::Angles { wrist, angles };
                            clean.live.pose(times[at], &pose, &clean.targets).unwrap();
                            match (at == glitch, kind) {
                                (true, 0) => turned.position.z += 0.05,
                                (true, 1) => {
                                    turned.rotation =
                                        Quat::from_scaled_axis(Vec3::x() * (0.05 / 0.17))
                                }
                                (true, _) => angles[4] += 0.05 / 0.09,
                                _ => {}
                            }
                            let pose = LivePose::Angles { wrist: turned, angles };
                            off.live.pose(times[at], &pose, &off.targets).unwrap();
                            at += 1;
                        }
                        clean.live.step(TICK, &mut clean.targets);
                        off.live.step(TICK, &mut off.targets);
                        most = most.max(farthest(&off, &ends(&clean)));
                    }
                }
                let force = most * felt(rate);
                println!("{rate} Hz, losses {losses}, kind {kind}: {most} m, {force} N");
                assert!(force < 0.5, "{rate} Hz, losses {losses}, kind {kind}: {force} N");
            }
        }
    }
}

/// Returns how far a reach of least jerk has come that is 3 m/s fast at most, over a way \[m\],
/// from 1 s on.
fn reach(way: f64, t: f64) -> f64 {
    let u = ((t - 1.0) / (1.875 * way / 3.0)).clamp(0.0, 1.0);
    way * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u)
}

/// From rest to 3 m/s and to rest, on ways of 0.3 m, which starts with 49 m/s², to 0.9 m: no two
/// samples wait in a row, and while it becomes faster the hand is where one that believes every
/// sample was at the sample before, or farther.
#[test]
fn a_true_approach_is_late_by_one_sample_at_most() {
    for rate in RATES {
        for losses in [false, true] {
            let (mut waited, mut behind) = (0, 0.0_f64);
            let apart = if losses { 2.0 } else { 1.0 } / rate;
            let later = (apart / TICK).ceil() as usize;
            for seed in 1..=20 {
                let way = 0.3 + 0.2 * f64::from(seed as u32 % 4);
                let times = times(rate, 2.0, losses, &mut Random::new(seed));
                let (mut gated, mut believing) = (rig(), Rig::new());
                believing.live.follow_at(80.0);
                let (mut at, mut waits, mut places) = (0, false, Vec::new());
                for tick in 1..2000 {
                    let t = TICK * f64::from(tick);
                    if times.get(at).is_some_and(|due| *due <= t + 1e-9) {
                        let wrist = Pose::translation(reach(way, times[at]), 0.0, 0.0);
                        let pose = LivePose::Angles { wrist, angles: [0.0; ANGLES] };
                        for rig in [&mut gated, &mut believing] {
                            rig.live.pose(times[at], &pose, &rig.targets).unwrap();
                        }
                        let before = std::mem::replace(&mut waits, gated.live.waits());
                        assert!(
                            !(before && waits),
                            "{rate} Hz, losses {losses}: two wait in a row"
                        );
                        waited += usize::from(waits);
                        at += 1;
                    }
                    for rig in [&mut gated, &mut believing] {
                        rig.live.step(TICK, &mut rig.targets);
                    }
                    let place = |rig: &Rig| rig.targets[0].unwrap().pose_WB.position.x;
                    places.push(place(&believing));
                    if (0.9..1.0 + 0.5 * 1.875 * way / 3.0).contains(&t) {
                        behind = behind.max(places[places.len() - 1 - later] - place(&gated));
                    }
                }
            }
            println!("{rate} Hz, losses {losses}: {waited} waited, {behind} m behind");
            assert!(behind < 0.005, "{rate} Hz, losses {losses}: {behind} m");
        }
    }
}
