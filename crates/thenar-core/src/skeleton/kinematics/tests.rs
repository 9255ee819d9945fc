//! Goal: the tree's poses, velocities and projection against finite differences and geometry.

use super::*;
use crate::math::Quat;
use crate::model::Axis;
use crate::random::Random;
use std::f64::consts::FRAC_PI_2;

fn joint(kind: JointKind, parent: u32, child: u32, pose_PJ: Pose, pose_CK: Pose) -> JointDesc {
    JointDesc {
        name: format!("joint{child}"),
        kind,
        parent: Some(parent),
        child,
        pose_PJ,
        pose_CK,
        axes: [Axis::default(); 2],
        limit_stiffness: 0.0,
        limit_damping: 0.0,
    }
}

/// A branched tree with every kind of joint, in frames at random.
fn tangle() -> Vec<JointDesc> {
    use JointKind::*;
    let mut noise = Random::new(7);
    let shape = [(Universal, 0), (Hinge, 1), (Ball, 0), (Universal, 3), (Fixed, 2), (Free, 4)];
    let mut joints: Vec<_> = (1..)
        .zip(shape)
        .map(|(child, (kind, parent))| joint(kind, parent, child, noise.pose(0.1), noise.pose(0.1)))
        .collect();
    joints[0].axes[1].limit = Some(AngleLimit { min: -0.2, max: 1.5 });
    joints
}

fn random_angles(tree: &Tree, noise: &mut Random, size: f64) -> Vec<[f64; 2]> {
    (0..tree.joints())
        .map(|j| {
            let mut q = [0.0; 2];
            q.iter_mut().take(tree.kind(j).angles()).for_each(|q| *q = size * noise.symmetric());
            q
        })
        .collect()
}

#[test]
fn a_bent_finger_is_where_trigonometry_puts_it() {
    // Two links of 40 and 30 mm along -z, origins at their middles, both bent by 90° about x:
    // the first goes up (+y), the second back (+z).
    let first = joint(
        JointKind::Hinge,
        0,
        1,
        Pose::translation(0.0, 0.0, -0.05),
        Pose::translation(0.0, 0.0, 0.02),
    );
    let second = joint(
        JointKind::Hinge,
        1,
        2,
        Pose::translation(0.0, 0.0, -0.02),
        Pose::translation(0.0, 0.0, 0.015),
    );
    let tree = Tree::new(3, &[first, second]).unwrap();
    let root = Pose::translation(1.0, 2.0, 3.0);
    let mut poses = [Pose::identity(); 3];
    tree.forward(&root, &[[FRAC_PI_2, 0.0]; 2], &mut poses);
    assert!((poses[1].position - Vec3::new(1.0, 2.02, 2.95)).norm() < 1e-14);
    assert!((poses[2].position - Vec3::new(1.0, 2.04, 2.965)).norm() < 1e-14);
}

#[test]
fn velocities_are_the_derivative_of_poses() {
    let tree = Tree::new(7, &tangle()).unwrap();
    let mut noise = Random::new(11);
    let h = 1e-5;
    for _ in 0..50 {
        let root = noise.pose(1.0);
        let [velocity, angular] = [noise.vector(1.0), noise.vector(5.0)];
        let angles = random_angles(&tree, &mut noise, 1.5);
        let rates = random_angles(&tree, &mut noise, 8.0);
        let at = |t: f64| {
            let turned = Quat::from_scaled_axis(angular * t) * root.rotation;
            let root = Pose::new(root.position + velocity * t, turned);
            let angles: Vec<_> = angles
                .iter()
                .zip(&rates)
                .map(|(q, r)| [q[0] + t * r[0], q[1] + t * r[1]])
                .collect();
            let mut poses = vec![Pose::identity(); tree.bones()];
            tree.forward(&root, &angles, &mut poses);
            poses
        };
        let mut found = vec![[Vec3::zeros(); 2]; tree.bones()];
        tree.velocities(&at(0.0), [velocity, angular], &angles, &rates, &mut found);
        for ((before, after), found) in at(-h).iter().zip(&at(h)).zip(&found) {
            let [linear, angular] = velocity_between(before, after, 2.0 * h);
            assert!((linear - found[0]).norm() < 1e-7, "{linear} {}", found[0]);
            assert!((angular - found[1]).norm() < 1e-7, "{angular} {}", found[1]);
        }
    }
}

#[test]
fn angles_of_forward_poses_are_the_angles() {
    let tree = Tree::new(7, &tangle()).unwrap();
    let mut noise = Random::new(13);
    for _ in 0..200 {
        let angles = random_angles(&tree, &mut noise, 1.5);
        let mut poses = vec![Pose::identity(); tree.bones()];
        tree.forward(&noise.pose(1.0), &angles, &mut poses);
        let mut back = vec![[0.0; 2]; tree.joints()];
        tree.angles(&poses, &mut back);
        for (a, b) in angles.iter().flatten().zip(back.iter().flatten()) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}

#[test]
fn projection_keeps_what_is_admissible_and_joins_what_is_not() {
    let tree = Tree::new(7, &tangle()).unwrap();
    let mut noise = Random::new(17);
    let (mut angles, mut out) = (vec![[0.0; 2]; 6], vec![Pose::identity(); 7]);
    for _ in 0..200 {
        // Admissible poses, with the ball and the free joint moved as well, come back unchanged.
        let mut q = random_angles(&tree, &mut noise, 1.4);
        q[0] = tree.clamp(0, q[0]);
        let mut poses_JK: Vec<Pose> =
            (0..6).map(|j| turn(joint_rotation(tree.kind(j), q[j]))).collect();
        poses_JK[2].rotation = Quat::from_scaled_axis(noise.vector(1.0));
        poses_JK[5] = noise.pose(0.1);
        let mut wanted = vec![Pose::identity(); 7];
        tree.forward_joint_poses(&noise.pose(1.0), &poses_JK, &mut wanted);
        tree.project(&wanted, &mut angles, &mut out);
        for (want, got) in wanted.iter().zip(&out) {
            assert!((want.position - got.position).norm() < 1e-12);
            assert!(want.rotation.angle_to(&got.rotation) < 1e-7);
        }

        // Poses torn apart end within the limits and with closed joints.
        let torn: Vec<Pose> = (0..7).map(|_| noise.pose(1.0)).collect();
        tree.project(&torn, &mut angles, &mut out);
        assert!((-0.2..=1.5).contains(&angles[0][1]));
        for j in (0..6).filter(|&j| tree.kind(j) != JointKind::Free) {
            let pose_JK = tree.joint_pose(j, &out);
            assert!(pose_JK.position.norm() < 1e-12);
            let reached = joint_rotation(tree.kind(j), angles[j]);
            let ball = tree.kind(j) == JointKind::Ball;
            assert!(ball || pose_JK.rotation.angle_to(&reached) < 1e-7);
        }
    }
}

#[test]
fn joints_that_are_no_tree_are_refused() {
    let mut joints = tangle();
    assert!(matches!(Tree::new(6, &joints), Err(TreeError::Count { bones: 6, joints: 6 })));
    joints[3].parent = Some(4);
    assert!(matches!(Tree::new(7, &joints), Err(TreeError::Parent { child: 4, .. })));
    joints[3].parent = Some(3);
    joints[1].child = 5;
    assert!(matches!(Tree::new(7, &joints), Err(TreeError::Child { expected: 2, child: 5, .. })));
    joints[1].child = 2;
    joints[4].pose_PJ.position.x = f64::NAN;
    assert!(matches!(Tree::new(7, &joints), Err(TreeError::NonFinite { .. })));
    joints[4].pose_PJ.position.x = 0.0;
    joints[0].axes[0].limit = Some(AngleLimit { min: f64::NAN, max: 1.0 });
    assert!(matches!(Tree::new(7, &joints), Err(TreeError::Limit { .. })));
}
