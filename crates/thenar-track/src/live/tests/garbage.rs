//! Random sequences: whatever comes, targets stay finite, bounded in speed, within limits, and
//! the same calls give the same bits.

use super::*;
use crate::live::JOINT_RATE_MAX;
use thenar_core::random::Random;

/// One run of 6 s with everything a bad tracker can do; returns all targets, and whether the
/// scene started over before.
fn run(seed: u64) -> Vec<(bool, Vec<Option<Target>>)> {
    let mut random = Random::new(seed);
    let mut rig = Rig::new();
    let motion = waving(&rig.hand);
    let hand = rig.hand.clone();
    let tracker = Tracker::new(&hand, &motion);
    let mut history = Vec::new();
    let (mut clock, mut frozen) = (0.0, None);
    for _ in 0..1200 {
        let mut restarted = false;
        let u = random.symmetric().abs();
        clock += GAP;
        if u < 0.02 {
            clock += 50.0 * random.symmetric();
        }
        let mut joints = frozen.unwrap_or_else(|| tracker.joints(rig.time));
        match (random.symmetric().abs() * 40.0) as u32 {
            0 => joints
                .iter_mut()
                .for_each(|j| j.position += Vec3::new(3.0, -1.0, 2.0) * random.symmetric()),
            1 => joints
                .iter_mut()
                .for_each(|j| j.rotation = Quat::new_unchecked(-j.rotation.into_inner())),
            2 => frozen = if frozen.is_some() { None } else { Some(joints) },
            3 => joints[5].position.z = f64::NAN,
            4 => joints.iter_mut().for_each(|j| {
                j.rotation = Quat::from_scaled_axis(random.vector(3.0)) * j.rotation;
            }),
            5 => joints = [joints[0]; 25],
            6 => rig.live.lose(),
            7 => rig.live.follow_script(),
            8 => clock = rig.time,
            9 => {
                rig.script();
                rig.live.restart(&rig.targets);
                restarted = true;
            }
            _ => {}
        }
        // Some steps without a pose, some with several.
        for _ in 0..(random.symmetric().abs() * 3.0) as u32 {
            // What is refused is refused.
            let pose = match random.symmetric() > 0.9 {
                true => LivePose::Angles {
                    wrist: joints[0],
                    angles: std::array::from_fn(|_| 4.0 * random.symmetric()),
                },
                false => joints_pose(joints),
            };
            let _ = rig.live.pose(clock, &pose, &rig.targets);
        }
        rig.step();
        history.push((restarted, rig.targets.clone()));
    }
    history
}

#[test]
fn targets_stay_finite_bounded_and_repeatable() {
    let hand = fixture::hand(false);
    let articulation = Articulation::new(&hand).unwrap();
    let wrist = |targets: &[Option<Target>]| targets[0].unwrap().pose_WB * hand.bones[0].pose_BT;
    let angles = |targets: &[Option<Target>]| {
        let poses: Vec<_> = targets.iter().map(|t| t.unwrap().pose_WB).collect();
        let mut angles = vec![[0.0; 2]; poses.len() - 1];
        articulation.tree.angles(&poses, &mut angles);
        angles
    };
    for seed in 1..=40 {
        let history = run(seed);
        for pair in history.windows(2) {
            let [(_, before), (restarted, after)] = pair else { continue };
            if *restarted {
                continue;
            }
            let pair = [before, after];
            assert!(finite(pair[1]), "seed {seed}");
            let (a, b) = (wrist(pair[0]), wrist(pair[1]));
            let moved = (a.position - b.position).norm();
            // A script met again is off by 0.1 mm at most when it takes over.
            assert!(moved <= SPEED_MAX * H + 2e-4, "seed {seed}: {}", moved / H);
            let turned = a.rotation.angle_to(&b.rotation);
            assert!(turned <= SPIN_MAX * H + 2e-4, "seed {seed}: {}", turned / H);
            let limits = (0..15).map(|j| articulation.tree.limits(j));
            for ((a, b), limits) in angles(pair[0]).iter().zip(&angles(pair[1])).zip(limits) {
                for k in 0..2 {
                    assert!((a[k] - b[k]).abs() <= JOINT_RATE_MAX * H + 2e-4, "seed {seed}");
                    let inside =
                        limits[k].is_none_or(|l| l.min - 1e-6 <= b[k] && b[k] <= l.max + 1e-6);
                    assert!(inside, "seed {seed}: {}", b[k]);
                }
            }
            // The tip of a finger of 0.19 m: wrist, its turn, and three joints at most.
            let fastest = SPEED_MAX + (SPIN_MAX + 3.0 * JOINT_RATE_MAX) * 0.2;
            for target in pair[1].iter().flatten() {
                assert!(target.velocity_W.norm() < fastest, "seed {seed}");
            }
        }
        assert_eq!(history, run(seed), "seed {seed}");
    }
}
