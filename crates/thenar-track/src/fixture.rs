//! A small skeleton of a right hand for tests: 16 bones, straight fingers along -z, the back up.

use thenar_core::model::{
    AngleLimit, Axis, Bone, CouplingKind, Digit, EmbeddedSurface, Flesh, HandModel, JointDesc,
    JointKind, Side,
};
use thenar_core::{Mat3, Pose, Quat, Vec3};

/// Finger, its WebXR name, its knuckle in the wrist frame \[m\], and the lengths of its bones.
const FINGERS: [(Digit, &str, [f64; 3], [f64; 3]); 5] = [
    (Digit::Thumb, "thumb", [-0.02, -0.01, -0.03], [0.045, 0.034, 0.025]),
    (Digit::Index, "index-finger", [-0.025, 0.0, -0.09], [0.042, 0.025, 0.02]),
    (Digit::Middle, "middle-finger", [0.0, 0.0, -0.092], [0.046, 0.028, 0.02]),
    (Digit::Ring, "ring-finger", [0.02, 0.0, -0.088], [0.042, 0.026, 0.02]),
    (Digit::Little, "pinky-finger", [0.038, 0.0, -0.08], [0.034, 0.02, 0.018]),
];

/// The hand, somewhere in its model frame. Joints have x to the right, so flexion is negative;
/// `flip` turns them about z, so that it is positive.
pub fn hand(flip: bool) -> HandModel {
    let pose_MT = Pose::new(Vec3::new(0.3, -0.2, 0.1), Quat::from_scaled_axis(Vec3::y() * 0.7));
    let palm_BT = Pose::translation(0.0, 0.0, 0.045);
    let mut bones = vec![bone("palm", None, Digit::Palm, pose_MT, palm_BT, 0.09)];
    bones[0].tracked_joint = Some("wrist".into());
    let mut joints = Vec::new();
    for (digit, webxr, knuckle, lengths) in FINGERS {
        let thumb = digit == Digit::Thumb;
        // The thumb points sideways, its pad towards the palm's inner side.
        let turn = if thumb { Vec3::new(-0.2, 0.7, 0.9) } else { Vec3::zeros() };
        let mut pose_TJ = Pose::new(Vec3::from(knuckle), Quat::from_scaled_axis(turn));
        let names = if thumb {
            ["metacarpal", "phalanx-proximal", "phalanx-distal"]
        } else {
            ["phalanx-proximal", "phalanx-intermediate", "phalanx-distal"]
        };
        let mut parent = 0;
        for (place, length) in lengths.into_iter().enumerate() {
            let child = bones.len() as u32;
            let name = format!("{}-{}", digit.name(), names[place].trim_start_matches("phalanx-"));
            let pose_BT = Pose::translation(0.0, 0.0, length / 2.0);
            let mut bone = bone(&name, Some(parent), digit, pose_MT * pose_TJ, pose_BT, length);
            bone.tracked_joint = Some(format!("{webxr}-{}", names[place]));
            let pose_MP: &Pose = &bones[parent as usize].pose_MB;
            let axes =
                Quat::from_scaled_axis(Vec3::z() * if flip { std::f64::consts::PI } else { 0.0 });
            let pose_MJ = pose_MT * pose_TJ * Pose::new(Vec3::zeros(), axes);
            joints.push(joint(&name, place, parent, child, flip, pose_MP, &bone.pose_MB, &pose_MJ));
            bones.push(bone);
            pose_TJ = pose_TJ * Pose::translation(0.0, 0.0, -length);
            parent = child;
        }
    }
    HandModel {
        name: "fixture".into(),
        side: Some(Side::Right),
        bones,
        joints,
        flesh: empty_flesh(),
        bindings: Vec::new(),
        node_volumes: Vec::new(),
        render: EmbeddedSurface::default(),
        collision_digits: Vec::new(),
        length: 0.186,
        solids: Vec::new(),
        coupling: CouplingKind::Uniform,
        bone_nodes: Vec::new(),
        regions: Vec::new(),
        nail_nodes: Vec::new(),
        bending: Vec::new(),
    }
}

/// This hand, `scale` times as large.
pub fn scaled(mut hand: HandModel, scale: f64) -> HandModel {
    for bone in &mut hand.bones {
        bone.pose_MB.position *= scale;
        bone.pose_BT.position *= scale;
        bone.ends_B.iter_mut().for_each(|end| *end *= scale);
    }
    for joint in &mut hand.joints {
        joint.pose_PJ.position *= scale;
        joint.pose_CK.position *= scale;
    }
    hand
}

/// Makes the bones of a digit longer by a factor.
pub fn lengthen(hand: &mut HandModel, digit: Digit, factor: f64) {
    let own: Vec<bool> = hand.bones.iter().map(|bone| bone.digit == digit).collect();
    for bone in hand.bones.iter_mut().filter(|bone| bone.digit == digit) {
        bone.pose_BT.position *= factor;
        bone.ends_B.iter_mut().for_each(|end| *end *= factor);
    }
    for joint in hand.joints.iter_mut().filter(|joint| own[joint.child as usize]) {
        joint.pose_CK.position *= factor;
        if joint.parent.is_some_and(|parent| own[parent as usize]) {
            joint.pose_PJ.position *= factor;
        }
    }
}

fn bone(
    name: &str,
    parent: Option<u32>,
    digit: Digit,
    pose_MT: Pose,
    pose_BT: Pose,
    length: f64,
) -> Bone {
    let end = Vec3::z() * (length / 2.0);
    Bone {
        name: name.into(),
        parent,
        pose_MB: pose_MT * pose_BT.inverse(),
        mass: 0.02,
        inertia: Mat3::identity() * 1e-6,
        digit,
        ends_B: [end, -end],
        radius: 0.008,
        tracked_joint: None,
        pose_BT,
    }
}

fn joint(
    name: &str,
    place: usize,
    parent: u32,
    child: u32,
    flip: bool,
    pose_MP: &Pose,
    pose_MC: &Pose,
    pose_MJ: &Pose,
) -> JointDesc {
    let range = |low: f64, high: f64| {
        let (low, high) = if flip { (low, high) } else { (-high, -low) };
        Axis {
            limit: Some(AngleLimit { min: low.to_radians(), max: high.to_radians() }),
            ..Axis::default()
        }
    };
    let (kind, axes) = match place {
        0 => (JointKind::Universal, [range(-25.0, 25.0), range(-20.0, 90.0)]),
        _ => (JointKind::Hinge, [range(-5.0, 100.0), Axis::default()]),
    };
    JointDesc {
        name: format!("{name}-joint"),
        kind,
        parent: Some(parent),
        child,
        pose_PJ: pose_MP.inverse() * *pose_MJ,
        pose_CK: pose_MC.inverse() * *pose_MJ,
        axes,
        limit_stiffness: 1.0,
        limit_damping: 0.0,
    }
}

fn empty_flesh() -> Flesh {
    Flesh {
        nodes: Vec::new(),
        tets: Vec::new(),
        materials: Vec::new(),
        relaxation: Vec::new(),
        mass_damping: 0.0,
        stiffness_damping: 0.0,
        fixed: Vec::new(),
        collision: EmbeddedSurface::default(),
        friction: 0.5,
    }
}
