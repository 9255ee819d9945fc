//! A tracker for tests: watches a jointed hand and writes what a headset would.

use super::recording::{Recording, TRACKED_JOINTS, mirrored};
use std::fmt::Write;
use std::path::Path;
use thenar_core::kinematics::Tree;
use thenar_core::model::{HandModel, Side};
use thenar_core::{Pose, Quat, Vec3};

/// Watched hand, its motion, and the faults of its tracker.
pub struct Tracker<'a> {
    /// The watched hand.
    pub hand: &'a HandModel,
    /// Side to claim.
    pub side: Side,
    /// Root bone and joint angles at a time.
    pub motion: &'a dyn Fn(f64) -> (Pose, Vec<[f64; 2]>),
    /// Rounding of positions \[m\] and of quaternions, 0 for none.
    pub rounding: [f64; 2],
    /// Reflect everything in x = 0.
    pub mirror: bool,
    /// Constant turn of the wrist's frame.
    pub wrist_turn: Quat,
    /// Times without samples \[s\].
    pub lost: [f64; 2],
    /// Time at which everything is a metre off \[s\], for one sample.
    pub teleport: f64,
}

impl<'a> Tracker<'a> {
    /// A perfect tracker of a right hand.
    pub fn new(hand: &'a HandModel, motion: &'a dyn Fn(f64) -> (Pose, Vec<[f64; 2]>)) -> Self {
        Self {
            hand,
            side: Side::Right,
            motion,
            rounding: [0.0; 2],
            mirror: false,
            wrist_turn: Quat::identity(),
            lost: [f64::INFINITY; 2],
            teleport: f64::INFINITY,
        }
    }

    /// The 25 joint frames at `time`.
    pub fn joints(&self, time: f64) -> [Pose; 25] {
        let tree = Tree::of_hand(self.hand).unwrap();
        let (root, angles) = (self.motion)(time);
        let mut poses = vec![Pose::identity(); tree.bones()];
        tree.forward(&root, &angles, &mut poses);
        let wrist = poses[0] * self.hand.bones[0].pose_BT;
        let mut joints = [wrist; 25];
        for (bone, pose) in self.hand.bones.iter().zip(&poses) {
            let name = bone.tracked_joint.as_deref().unwrap();
            let k = TRACKED_JOINTS.iter().position(|joint| *joint == name).unwrap();
            joints[k] = *pose * bone.pose_BT;
            if TRACKED_JOINTS.get(k + 1).is_some_and(|next| next.ends_with("-tip")) {
                joints[k + 1] = Pose::new(pose.point(&bone.ends_B[1]), joints[k].rotation);
            }
        }
        joints[0].rotation *= self.wrist_turn;
        if self.mirror { joints.map(|pose| mirrored(&pose)) } else { joints }
    }

    /// The recording's text: `seconds` at 90 Hz, with the sign of every other quaternion flipped.
    pub fn text(&self, seconds: f64) -> String {
        let mut text = serde_json::json!({
            "format": "hand-joints-jsonl", "version": 1, "quat": "x,y,z,w",
            "joints": TRACKED_JOINTS,
        })
        .to_string();
        text.push('\n');
        let round = |x: f64, to: f64| if to > 0.0 { (x / to).round() * to } else { x };
        for k in 0..(seconds * 90.0) as usize {
            let time = k as f64 / 90.0;
            if self.lost[0] < time && time < self.lost[1] {
                continue;
            }
            let off = if (time - self.teleport).abs() < 0.5 / 90.0 { 1.0 } else { 0.0 };
            let joints = self.joints(time);
            let (mut pos, mut quat) = (Vec::new(), Vec::new());
            for (j, joint) in joints.iter().enumerate() {
                let p = joint.position + Vec3::new(off, 0.0, 0.0);
                let sign = if (j + k) % 2 == 0 { 1.0 } else { -1.0 };
                let q = joint.rotation.coords * sign;
                pos.push([p.x, p.y, p.z].map(|x| round(x, self.rounding[0])));
                quat.push([q.x, q.y, q.z, q.w].map(|x| round(x, self.rounding[1])));
            }
            let side = if self.side == Side::Left { "left" } else { "right" };
            let line = serde_json::json!({"t": time, "hand": side, "pos": pos, "quat": quat});
            writeln!(text, "{line}").unwrap();
        }
        text
    }

    /// The recorded motion, read back.
    pub fn recording(&self, seconds: f64) -> Recording {
        Recording::read(self.text(seconds).as_bytes(), Path::new("test.jsonl")).unwrap()
    }
}
