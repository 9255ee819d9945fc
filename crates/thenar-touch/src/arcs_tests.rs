//! Goal: ticks come to rest where forces and torques balance on the arcs, however stiff the
//! couplings. Method: a planar finger, whose energy is written down with angles; its gradient at
//! the bones that ticks end at. Places, levers and bad input by hand.

use super::*;
use crate::shared::CondensedContact;
use nalgebra::{DMatrix, DVector};
use thenar_core::Mat3;
use thenar_core::model::Drive;
use thenar_core::random::Random;

fn drive(stiffness: f64, angular_stiffness: f64) -> Drive {
    Drive { stiffness, damping: 0.0, angular_stiffness, angular_damping: 0.0 }
}

fn turned(angle: f64) -> Quat {
    Quat::from_scaled_axis(Vec3::z() * angle)
}

/// A finger of two bones of 60 mm, the second on a joint at the end of the first.
fn two_bones() -> (BoneFrame, Arcs) {
    let at = |x: f64| RigidState::at_rest(Pose::translation(x, 0.0, 0.0));
    let mut frame = BoneFrame::new(&[at(0.0), at(0.06)], 0);
    frame.response.springs = vec![drive(100.0, 0.0); 2];
    frame.response.targets = frame.bones.clone();
    let mut arcs = Arcs::new(2);
    let [at_parent, at_child] = [Vec3::x() * 0.03, Vec3::x() * -0.03];
    arcs.set_joints([BoneJoint { parent: 0, child: 1, at_parent, at_child }]);
    (frame, arcs)
}

/// Returns the second bone's pose after a turn about the joint.
fn turned_child(angle: f64) -> Pose {
    Pose::new(Vec3::new(0.03 + 0.03 * angle.cos(), 0.03 * angle.sin(), 0.0), turned(angle))
}

/// Held at the first bone, turned at the joint by `angle`, and pulled at the second bone with 1 N
/// across the frame's finger.
fn bent_at_joint(angle: f64) -> SharedConstraints {
    let (frame, mut arcs) = two_bones();
    let poses = [Pose::identity(), turned_child(angle)];
    let mut settled = poses.map(Settled::at);
    settled[1].pull_W = Vec3::y();
    let mut shared = SharedConstraints::new(2, 0);
    arcs.begin(&frame);
    arcs.bend(&frame, &poses.map(RigidState::at_rest), &settled, &mut shared);
    shared
}

/// The second bone is off its tangent by its arc, and 1 N at its middle turns it about the joint by
/// `0.03 cos θ` N m, of which the response knows 0.03.
#[test]
fn bones_move_on_arcs_and_levers_turn_with_them() {
    for angle in [0.0_f64, 0.01, 0.3, -0.4, 0.5] {
        let shared = bent_at_joint(angle);
        let [off, torque] = shared.bent(1);
        let want = Vec3::new(0.03 * (angle.cos() - 1.0), 0.03 * (angle.sin() - angle), 0.0);
        assert!((off - want).norm() < 1e-15, "{off}");
        assert!((torque - Vec3::z() * 0.03 * (angle.cos() - 1.0)).norm() < 1e-15, "{torque}");
        assert_eq!(shared.bent(0), [Vec3::zeros(); 2]);
    }
}

#[test]
fn bones_that_turn_farther_count_as_turned_by_half_a_radian() {
    for angle in [0.6, 1.0, -3.0] {
        for (far, near) in
            bent_at_joint(angle).bent(1).iter().zip(bent_at_joint(0.5_f64.copysign(angle)).bent(1))
        {
            assert!((far - near).norm() < 1e-15, "{far} at {angle} rad");
        }
    }
}

/// Unusable input changes nothing: joints of bones that there are not, second ones, a frame or a
/// list of another size, and values that are not numbers.
#[test]
fn bad_input_bends_nothing() {
    let (frame, mut arcs) = two_bones();
    let joint = arcs.joints[0];
    arcs.set_joints([
        BoneJoint { parent: 1, child: 0, ..joint },
        BoneJoint { parent: 1, child: 2, ..joint },
        BoneJoint { parent: 1, child: 1, ..joint },
        joint,
        BoneJoint { at_parent: Vec3::zeros(), ..joint },
    ]);
    assert_eq!(arcs.joints, [joint]);
    let poses = [Pose::identity(), turned_child(0.3)];
    let (proxies, settled) = (poses.map(RigidState::at_rest), poses.map(Settled::at));
    let other = BoneFrame::new(&proxies[..1], 0);
    let bent = |arcs: &mut Arcs, frame: &BoneFrame, proxies: &[RigidState]| {
        let mut shared = bent_at_joint(0.3);
        arcs.bend(frame, proxies, &settled, &mut shared);
        shared.bent(1)
    };
    assert_eq!(bent(&mut arcs, &frame, &proxies), [Vec3::zeros(); 2], "no frame has begun");
    arcs.begin(&frame);
    assert_ne!(bent(&mut arcs, &frame, &proxies), [Vec3::zeros(); 2]);
    assert_eq!(bent(&mut arcs, &frame, &proxies[..1]), [Vec3::zeros(); 2]);
    assert_eq!(bent(&mut arcs, &other, &proxies), [Vec3::zeros(); 2]);
    arcs.begin(&other);
    assert_eq!(bent(&mut arcs, &frame, &proxies), [Vec3::zeros(); 2], "another hand's frame");
    let mut shared = bent_at_joint(0.3);
    let none = Quat::from_scaled_axis(Vec3::z() * f64::NAN);
    let lost = [poses[0], Pose::new(poses[1].position, none)];
    let mut nowhere = frame.clone();
    nowhere.bones[1].pose_WB = lost[1];
    for (frame, proxies, settled) in [
        (&frame, proxies, lost.map(Settled::at)),
        (&frame, lost.map(RigidState::at_rest), settled),
        (&nowhere, proxies, settled),
    ] {
        arcs.begin(frame);
        arcs.bend(frame, &proxies, &settled, &mut shared);
        assert!((0..2).all(|i| shared.bent(i).iter().flatten().all(|x| x.is_finite())));
    }
    let mut bone = Settled::at(lost[1]);
    bone.follow(&poses[1], &Vec3::y());
    assert_eq!(bone.pose_WB, poses[1]);
}

/// Contact bore 1 N in the frame and the coupling balanced it there: turning changes no lever of
/// that, only of what is more by now.
#[test]
fn what_contact_balanced_in_the_frame_has_no_lever() {
    let (mut frame, mut arcs) = two_bones();
    frame.response.targets[1].pose_WB.position.x += 0.01;
    let contact = CondensedContact {
        frame: Mat3::identity(),
        value: Vec3::zeros(),
        friction: 0.0,
        force: Vec3::x(),
    };
    frame.response.contacts.push(contact);
    let poses = [Pose::identity(), turned_child(0.2)];
    let mut settled = poses.map(Settled::at);
    settled[1].pull_W = Vec3::x() + Vec3::y() * 0.5;
    let proxies = poses.map(RigidState::at_rest);
    let lever = (turned(0.2) * Vec3::x() - Vec3::x()) * -0.03;
    let (mut held, mut free) =
        (SharedConstraints::new(2, 1), SharedConstraints::in_empty_air(2, 1));
    arcs.begin(&frame);
    for (shared, force) in [(&mut held, Vec3::y() * 0.5), (&mut free, Vec3::x() + Vec3::y() * 0.5)]
    {
        arcs.bend(&frame, &proxies, &settled, shared);
        let [_, torque] = shared.bent(1);
        assert!((torque + lever.cross(&force)).norm() < 1e-15, "{torque}");
    }
    // A limit of a joint is the hand's own.
    frame.response.limits = vec![true];
    arcs.bend(&frame, &proxies, &settled, &mut held);
    assert_eq!(held.bent(1), free.bent(1));
}

/// Turns about several axes: with the torque beside it, a coupling turns its bone as it does by the
/// rotation between the two.
#[test]
fn couplings_turn_bones_by_the_rotation_between_them() {
    let (mut frame, mut arcs) = two_bones();
    let stiffness = 0.3;
    frame.response.springs = vec![drive(0.0, stiffness); 2];
    let about = |x: f64, y: f64, z: f64| Quat::from_scaled_axis(Vec3::new(x, y, z));
    let [was, target] = [about(0.4, 0.1, 0.0), about(0.1, 0.5, -0.2)];
    let [now, proxy] = [about(0.25, 0.15, 0.3), about(-0.3, 0.3, 0.7)];
    frame.bones[1].pose_WB.rotation = was;
    frame.response.targets[1].pose_WB.rotation = target;
    let at = |rotation: Quat| [Pose::identity(), Pose::new(Vec3::x() * 0.06, rotation)];
    let mut shared = SharedConstraints::new(2, 0);
    let states = at(proxy).map(RigidState::at_rest);
    arcs.begin(&frame);
    arcs.bend(&frame, &states, &at(now).map(Settled::at), &mut shared);
    let vector = |to: Quat, from: Quat| rotation_vector(&(to * from.inverse()));
    // The response knows the frame's torque, the proxy's turn since and the bone's.
    let known = vector(target, was) + vector(proxy, target) - vector(now, was);
    let [_, torque] = shared.bent(1);
    let whole = known * stiffness + torque;
    assert!((whole - vector(proxy, now) * stiffness).norm() < 1e-15, "{whole}");
    assert!(torque.norm() > 1e-3, "{torque}");
}

/// Bones of a finger, the first of which moves freely \[m\].
const LENGTHS: [f64; 4] = [0.08, 0.045, 0.025, 0.02];
/// Coordinates of a finger: place of the first bone's middle, and the angle of each bone.
const N: usize = 6;
type Angles = [f64; N];

/// A planar finger on couplings, with springs at its joints that are relaxed where it is straight.
struct Finger {
    coupling: Drive,
    joints: f64,
}

impl Finger {
    fn middles(s: &Angles) -> [Vec3; 4] {
        let along = |i: usize| turned(s[2 + i]) * Vec3::x() * (0.5 * LENGTHS[i]);
        let mut at = Vec3::new(s[0], s[1], 0.0) - along(0);
        std::array::from_fn(|i| {
            let middle = at + along(i);
            at = middle + along(i);
            middle
        })
    }

    fn poses(s: &Angles) -> [Pose; 4] {
        let middles = Self::middles(s);
        std::array::from_fn(|i| Pose::new(middles[i], turned(s[2 + i])))
    }

    fn energy(&self, s: &Angles, proxies: &[Pose; 4], angles: &Angles) -> f64 {
        let middles = Self::middles(s);
        let places = proxies.iter().zip(&middles).map(|(p, x)| (p.position - x).norm_squared());
        let turns = (2..N).map(|i| (angles[i] - s[i]).powi(2));
        let joints = (3..N).map(|i| (s[i] - s[i - 1]).powi(2));
        let springs = self.coupling.stiffness * places.sum::<f64>()
            + self.coupling.angular_stiffness * turns.sum::<f64>();
        0.5 * (springs + self.joints * joints.sum::<f64>())
    }

    /// Largest slope of the energy, in units of 1 N, or of 1 N at a lever of 30 mm.
    fn slope(&self, s: &Angles, proxies: &[Pose; 4], angles: &Angles) -> f64 {
        let slopes = (0..N).map(|k| {
            let by = |step: f64| {
                let mut moved = *s;
                moved[k] += step;
                self.energy(&moved, proxies, angles)
            };
            let unit = if k < 2 { 1.0 } else { 0.03 };
            ((by(1e-6) - by(-1e-6)) / 2e-6 / unit).abs()
        });
        slopes.fold(0.0, f64::max)
    }

    /// Returns the linear effect of the coordinates on bones: 24 × 6.
    fn tangents(s: &Angles) -> DMatrix<f64> {
        let mut tangents = DMatrix::zeros(24, N);
        for k in 0..N {
            let by = |step: f64| {
                let mut moved = *s;
                moved[k] += step;
                Self::middles(&moved)
            };
            let (after, before) = (by(1e-6), by(-1e-6));
            for i in 0..4 {
                tangents.view_mut((6 * i, k), (3, 1)).copy_from(&((after[i] - before[i]) / 2e-6));
            }
            if k >= 2 {
                tangents[(6 * (k - 2) + 5, k)] = 1.0;
            }
        }
        tangents
    }

    /// Returns a frame of the finger in balance, bent as `s`, led by targets this far from its
    /// bones that hold it.
    fn frame(&self, s: &Angles, away: &[Vec3; 4]) -> BoneFrame {
        let tangents = Self::tangents(s);
        let mut stiffness = DMatrix::zeros(N, N);
        for i in 0..4 {
            for k in 0..6 {
                let row = tangents.row(6 * i + k);
                let k =
                    if k < 3 { self.coupling.stiffness } else { self.coupling.angular_stiffness };
                stiffness += row.transpose() * row * k;
            }
        }
        let mut pull = DVector::zeros(N);
        for i in 3..N {
            let mut row = DVector::zeros(N);
            (row[i], row[i - 1]) = (1.0, -1.0);
            stiffness += &row * row.transpose() * self.joints;
            pull += &row * (self.joints * (s[i] - s[i - 1]));
        }
        let bones = Self::poses(s).map(RigidState::at_rest);
        let mut frame = BoneFrame::new(&bones, 0);
        let response = &mut frame.response;
        response.springs = vec![self.coupling; 4];
        for (i, way) in away.iter().enumerate() {
            let force = way * self.coupling.stiffness;
            pull -=
                tangents.rows(6 * i, 3).transpose() * DVector::from_column_slice(force.as_slice());
        }
        assert!(pull.rows(0, 2).amax() < 1e-6 * self.coupling.stiffness, "no force is left");
        // Couplings turn each bone as its joints and levers do the other way.
        response.targets = (0..4)
            .map(|i| {
                let ahead = pull[2 + i] / self.coupling.angular_stiffness;
                assert!(ahead.abs() < 3.0, "{ahead} rad");
                let Pose { position, rotation } = bones[i].pose_WB;
                RigidState::at_rest(Pose::new(position + away[i], turned(ahead) * rotation))
            })
            .collect();
        let compliance = &tangents * stiffness.try_inverse().unwrap() * tangents.transpose();
        response.compliance = compliance.transpose().as_slice().to_vec();
        assert!(response.prepare());
        frame
    }
}

/// Turns of about half a radian from 360 bent fingers, at couplings of scenes (200 N/m) and far
/// stiffer ones, with joints that are free and stiff: after some ticks nothing moves any more, and
/// of bones that turn no farther than arcs go joints are closed and the energy has no slope.
#[test]
fn ticks_come_to_rest_where_the_energy_has_no_slope() {
    let mut random = Random::new(7);
    let (mut most, mut on_their_arcs) = (0.0_f64, 0);
    for (stiffness, lever_squared) in [(200.0, 1.5e-3), (800.0, 4e-4), (8000.0, 5e-4)] {
        for joints in [0.0, 0.05, 0.2] {
            let finger = Finger { coupling: drive(stiffness, stiffness * lever_squared), joints };
            for _ in 0..40 {
                let mut start = [0.0; N];
                let flexed =
                    [random.range(-0.2, 1.4), random.range(0.0, 1.7), random.range(0.0, 1.2)];
                (0..3).for_each(|i| start[3 + i] = start[2 + i] - flexed[i]);
                let mut led = start;
                led[0] += random.range(-0.01, 0.01);
                (2..N).for_each(|i| led[i] += random.range(-0.4, 0.4));
                let mut away =
                    [0; 4].map(|_| random.vector(0.002).component_mul(&Vec3::new(1.0, 1.0, 0.0)));
                away[0] -= away.iter().sum::<Vec3>();
                let frame = finger.frame(&start, &away);
                let proxies = Finger::poses(&led);
                let states = proxies.map(RigidState::at_rest);
                let mut arcs = Arcs::new(4);
                arcs.set_joints((0..3).map(|i| {
                    let half = |i: usize| Vec3::x() * (0.5 * LENGTHS[i]);
                    BoneJoint {
                        parent: i,
                        child: i + 1,
                        at_parent: half(i),
                        at_child: -half(i + 1),
                    }
                }));
                let mut shared = SharedConstraints::new(4, 0);
                shared.begin(&frame.response);
                let mut settled = Finger::poses(&start).map(Settled::at);
                let mut bones = frame.bones.clone();
                let mut tick = |frame: &BoneFrame,
                                states: &[RigidState],
                                shared: &mut SharedConstraints| {
                    let before = settled.map(|bone| bone.pose_WB);
                    arcs.begin(frame);
                    arcs.bend(frame, states, &settled, shared);
                    shared.resolve(&frame.response, states, 1e-3, 1e-9, 1);
                    arcs.place(frame, (states, shared), 1e-3, &mut settled, &mut bones);
                    let poses = settled.map(|bone| bone.pose_WB);
                    let ways =
                        poses.iter().zip(&before).map(|(p, b)| (p.position - b.position).norm());
                    (poses, ways.fold(0.0, f64::max), bones.clone())
                };
                (0..199).for_each(|_| drop(tick(&frame, &states, &mut shared)));
                let (poses, moved, _) = tick(&frame, &states, &mut shared);
                let context =
                    format!("{stiffness} N/m, joints of {joints} N m/rad, {flexed:?} to {led:?}");
                assert!(moved < 1e-12, "{moved} m in the last tick: {context}");
                let mut rests = [0.0; N];
                (rests[0], rests[1]) = (poses[0].position.x, poses[0].position.y);
                for (i, pose) in poses.iter().enumerate() {
                    let turn = rotation_vector(&(pose.rotation * turned(-start[2 + i]))).z;
                    rests[2 + i] = start[2 + i] + turn;
                }
                let far = (2..N).map(|i| (rests[i] - start[i]).abs()).fold(0.0, f64::max);
                if far > FARTHEST {
                    continue;
                }
                (most, on_their_arcs) = (most.max(far), on_their_arcs + 1);
                for (pose, middle) in poses.iter().zip(Finger::middles(&rests)) {
                    assert!((pose.position - middle).norm() < 1e-9, "{context}");
                }
                // A frame of the same finger bent otherwise comes to the same in its first tick.
                let other: Angles = std::array::from_fn(|k| 0.5 * (start[k] + rests[k]));
                let frame = finger.frame(&other, &[Vec3::zeros(); 4]);
                shared.begin(&frame.response);
                let (_, moved, _) = tick(&frame, &states, &mut shared);
                assert!(moved < 1e-9, "{moved} m with a new frame: {context}");
                // Led on, joints of bones stay closed, and what they go at is the same on both
                // sides.
                let mut on = led;
                for _ in 0..2 {
                    (0..N)
                        .for_each(|i| on[i] += random.range(0.0, if i < 2 { 1e-4 } else { 2e-3 }));
                    let states = Finger::poses(&on).map(RigidState::at_rest);
                    let (_, _, bones) = tick(&frame, &states, &mut shared);
                    for i in 0..3 {
                        let arms = [(i, 0.5 * LENGTHS[i]), (i + 1, -0.5 * LENGTHS[i + 1])];
                        let [one, other] = arms.map(|(i, arm)| {
                            let arm_W = bones[i].pose_WB.rotation * (Vec3::x() * arm);
                            let way = bones[i].angular_velocity_W.cross(&arm_W);
                            (bones[i].pose_WB.position + arm_W, bones[i].velocity_W + way)
                        });
                        assert!((one.0 - other.0).norm() < 1e-9, "{} {context}", one.0 - other.0);
                        assert!((one.1 - other.1).norm() < 1e-6, "{} {context}", one.1 - other.1);
                    }
                }
                // Differences of 1 µm find slopes to 1 part in 10⁹ of what a coupling bears at 100
                // mm.
                let slope = finger.slope(&rests, &proxies, &led);
                assert!(slope < 1e-9 * 0.1 * stiffness, "{slope} N: {context}");
            }
        }
    }
    assert!(on_their_arcs > 300, "{on_their_arcs}");
    assert!(most > 0.35, "turns of up to {most} rad");
}
