//! Roles of joints: which bends which finger which way.

use thenar_core::Vec3;
use thenar_core::model::{Digit, HandModel, JointKind};

/// Role of a joint in a hand.
#[derive(Clone, Debug, PartialEq)]
pub struct JointRole {
    /// Name of the bone it carries.
    pub bone: String,
    /// Name of the joint.
    pub joint: String,
    /// Digit that the joints belong to.
    pub digit: Digit,
    /// Place in the finger, from 0 at the palm.
    pub place: usize,
    /// Angle that flexes, and +1 or -1 for the sense in which it closes the hand.
    pub flexion: Option<(usize, f64)>,
    /// Angle that spreads, and +1 or -1 for the sense that moves the finger away from the middle
    /// finger (the middle finger: towards the thumb; the thumb: out of the plane of the palm).
    pub spread: Option<(usize, f64)>,
}

/// The roles of all joints of a hand, found from its geometry at rest, so that "flexion" means
/// the same whatever the axes a rig has chosen.
#[derive(Clone, Debug)]
pub struct Anatomy {
    /// One per joint.
    pub roles: Vec<JointRole>,
}

impl Anatomy {
    /// Roles of the joints of `hand`, whose joints must form a tree.
    pub fn of(hand: &HandModel) -> Self {
        let radial_M = radial_direction(hand);
        Self { roles: (0..hand.joints.len()).map(|j| role(hand, j, &radial_M)).collect() }
    }

    /// Index of the joint with this name, or of the one that carries the bone with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.roles.iter().position(|r| r.joint == name || r.bone == name)
    }

    /// Indices of the joints of a digit, from the palm outwards.
    pub fn joints_of(&self, digit: Digit) -> impl Iterator<Item = usize> {
        (0..self.roles.len()).filter(move |j| self.roles[*j].digit == digit)
    }
}

fn role(hand: &HandModel, j: usize, radial_M: &Vec3) -> JointRole {
    let (joint, bone) = (&hand.joints[j], &hand.bones[j + 1]);
    let rotation_MJ = (bone.pose_MB * joint.pose_CK).rotation;
    let lever_M = bone.pose_MB.vector(&(bone.ends_B[1] - joint.pose_CK.position));
    // Sense of the angle about `axis` that moves the bone's far end along `direction`.
    let sense = |axis: Vec3, direction: Vec3| {
        if (rotation_MJ * axis).cross(&lever_M).dot(&direction) < 0.0 { -1.0 } else { 1.0 }
    };
    let pad_M = -((bone.pose_MB * bone.pose_BT).vector(&Vec3::y()));
    let palm_M = hand
        .bones
        .first()
        .map_or(-Vec3::y(), |palm| -((palm.pose_MB * palm.pose_BT).vector(&Vec3::y())));
    let away_M = match bone.digit {
        Digit::Thumb => palm_M,
        Digit::Ring | Digit::Little => -radial_M,
        Digit::Index | Digit::Middle | Digit::Palm => *radial_M,
    };
    let (flexion, spread) = match joint.kind {
        JointKind::Hinge => (Some((0, sense(Vec3::x(), pad_M))), None),
        JointKind::Universal => {
            (Some((1, sense(Vec3::x(), pad_M))), Some((0, sense(Vec3::y(), away_M))))
        }
        _ => (None, None),
    };
    JointRole {
        bone: bone.name.clone(),
        joint: joint.name.clone(),
        digit: bone.digit,
        place: place_in_digit(hand, j + 1),
        flexion,
        spread,
    }
}

/// Number of ancestors in the same digit.
fn place_in_digit(hand: &HandModel, bone: usize) -> usize {
    let mut place = 0;
    let mut at = bone;
    while let Some(parent) = hand.bones[at].parent.map(|p| p as usize).filter(|p| *p < at) {
        place += usize::from(hand.bones[parent].digit == hand.bones[bone].digit);
        at = parent;
    }
    place
}

/// From the little finger towards the thumb, across the knuckles.
fn radial_direction(hand: &HandModel) -> Vec3 {
    let knuckle = |digit: Digit| {
        let bone = hand.bones.iter().position(|bone| bone.digit == digit).filter(|b| *b > 0)?;
        Some((hand.bones[bone].pose_MB * hand.joints.get(bone - 1)?.pose_CK).position)
    };
    match (knuckle(Digit::Index), knuckle(Digit::Little)) {
        (Some(index), Some(little)) => index - little,
        _ => Vec3::x(),
    }
}
