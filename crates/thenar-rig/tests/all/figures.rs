//! Goal: shipped descriptions of bones become figures of flesh whose mass, size and joints are
//! those of the files. Method: the files themselves, read by formula; a skinned mesh written by the
//! program and read back.

use std::path::{Path, PathBuf};
use thenar_core::Vec3;
use thenar_core::model::{AngleLimit, HandModel, JointKind};
use thenar_rig::RigError;
use thenar_rig::export::hand_glb;
use thenar_rig::figure::{
    FigureOptions, FigureReport, JointChange, build_figure, build_figure_file, read_glb_plan,
    usual_coupling_stiffness,
};

fn asset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/figures").join(name)
}

fn built(name: &str, thickness: f64) -> (HandModel, FigureReport) {
    let options = FigureOptions { thickness: Some(thickness), ..FigureOptions::default() };
    build_figure_file(&asset(name), &options).unwrap()
}

fn kinds(figure: &HandModel, kind: JointKind) -> usize {
    figure.joints.iter().filter(|joint| joint.kind == kind).count()
}

fn joint<'a>(figure: &'a HandModel, name: &str) -> &'a thenar_core::model::JointDesc {
    figure.joints.iter().find(|joint| joint.name == name).unwrap_or_else(|| panic!("{name}"))
}

/// What of a bone's solid the nodes that stand for it hold.
fn held(figure: &HandModel) -> f64 {
    figure.bone_nodes.iter().map(|node| node.volume).sum()
}

#[test]
fn a_gripper_of_urdf_is_a_figure() {
    let (gripper, report) = built("gripper.urdf", 5e-3);
    assert_eq!((gripper.bones.len(), kinds(&gripper, JointKind::Hinge)), (7, 6));
    // The file's masses: 150 g, three times 12 and 9 g.
    assert!((report.masses[0] - 0.213).abs() < 1e-9, "{:?}", report.masses);
    // 38 mm to the fingers' axes, 4 mm of bone and 5 of flesh; the palm is 39 mm wide.
    let [low, high] = report.bounds;
    assert!((high.x - 0.044).abs() < 2e-3 && (low.z + 0.044).abs() < 2e-3, "{low:?} {high:?}");
    // Fingers hang down, which is -y here.
    assert!(low.y < -0.085 && high.y < 0.02, "{low:?} {high:?}");
    let knuckle = joint(&gripper, "finger_1_knuckle");
    let range = knuckle.axes[0].limit.unwrap();
    assert!(
        (range.min.to_degrees() + 20.0).abs() < 0.1 && (range.max.to_degrees() - 70.0).abs() < 0.1
    );
    assert_eq!(knuckle.axes[0].damping, 0.002);
    assert!(gripper.side.is_none() && held(&gripper) > 0.0);
    assert!(usual_coupling_stiffness(&gripper) > 0.0);
}

/// Positive angles close the fingers: tips come nearer to the axis.
#[test]
fn the_gripper_closes_by_positive_angles() {
    use thenar_core::kinematics::Tree;
    let (gripper, _) = built("gripper.urdf", 5e-3);
    let tree = Tree::of_hand(&gripper).unwrap();
    let tips = |angle: f64| {
        let mut poses = vec![thenar_core::Pose::identity(); gripper.bones.len()];
        let angles = vec![[angle, 0.0]; gripper.joints.len()];
        tree.forward(&gripper.bones[0].pose_MB, &angles, &mut poses);
        let radius = |b: usize| {
            let tip = poses[b].point(&gripper.bones[b].ends_B[1]);
            tip.x.hypot(tip.z)
        };
        let distal =
            (0..gripper.bones.len()).filter(|&b| gripper.bones[b].name.ends_with("distal"));
        distal.map(radius).fold(0.0, f64::max)
    };
    assert!(tips(0.3) < tips(0.0) - 0.01 && tips(-0.2) > tips(0.0), "{} {}", tips(0.3), tips(0.0));
}

#[test]
fn a_forearm_with_a_hand_of_mjcf_is_a_figure() {
    let (forearm, report) = built("forearm.xml", 4e-3);
    assert_eq!(forearm.bones.len(), 17);
    assert_eq!(kinds(&forearm, JointKind::Universal), 6, "{:?}", report.joints);
    assert_eq!(kinds(&forearm, JointKind::Hinge), 10);
    // Fingers are apart: flesh around the last bone of the index finger follows that finger alone.
    let bones = (0..).zip(&forearm.bones);
    let index: Vec<u32> =
        bones.filter(|(_, b)| b.name.starts_with("index")).map(|(i, _)| i).collect();
    let tip = forearm.bones.iter().find(|b| b.name == "index_distal").unwrap().pose_MB.position;
    let nodes = forearm.flesh.nodes.iter().zip(&forearm.bindings);
    let near: Vec<_> = nodes.filter(|(x, _)| (*x - tip).norm() < 0.015).collect();
    let strangers = near.iter().filter(|(_, b)| !b.bones.iter().all(|bone| index.contains(bone)));
    assert!(near.len() > 1, "{} nodes", near.len());
    assert_eq!(strangers.count(), 0);
    let wrist =
        forearm.joints.iter().find(|j| forearm.bones[j.child as usize].name == "palm").unwrap();
    assert_eq!(wrist.kind, JointKind::Universal);
    assert_eq!(wrist.axes[0].stiffness, 1.2);
}

#[test]
fn a_whole_body_stands_as_tall_as_it_should() {
    let (body, report) = built("figure.xml", 0.03);
    assert_eq!(body.bones.len(), 21);
    let [low, high] = report.bounds;
    let height = high.y - low.y;
    assert!((height - 1.7).abs() < 0.01 && low.y.abs() < 0.01, "{low:?} {high:?}");
    let mass: f64 = report.masses.iter().sum();
    // 58.9 kg at 1000 kg/m³ by summing over a grid of 8 mm, and flesh is of 1080.
    assert!((mass / (58.9 * 1.08) - 1.0).abs() < 0.05, "{mass} kg");
    assert_eq!((kinds(&body, JointKind::Ball), kinds(&body, JointKind::Universal)), (8, 6));
}

/// A figure written as a skinned mesh and read back has the same bones at the same places, all
/// balls, and flesh that follows the same bones.
#[test]
fn a_figure_goes_through_gltf_and_back() {
    let (body, _) = built("figure.xml", 0.03);
    let bytes = hand_glb(&body).unwrap();
    let knee = |name: &str| JointChange {
        name: name.into(),
        kind: Some((JointKind::Hinge, vec![Vec3::x()])),
        ranges: vec![AngleLimit { min: 0.0, max: 2.4 }],
        stiffness: vec![100.0],
        damping: vec![1.0],
    };
    let options = FigureOptions { joints: vec![knee("shank_*")], ..FigureOptions::default() };
    let (back, report) = build_figure(read_glb_plan(&bytes).unwrap(), &options).unwrap();
    assert_eq!(back.bones.len(), body.bones.len(), "{:?}", report.notes);
    for bone in &body.bones {
        let same = back
            .bones
            .iter()
            .find(|b| b.name == bone.name)
            .unwrap_or_else(|| panic!("{}", bone.name));
        let parent = |figure: &HandModel, b: &thenar_core::model::Bone| {
            b.parent.map(|p| figure.bones[p as usize].name.clone())
        };
        assert_eq!(parent(&back, same), parent(&body, bone));
        // Joints are where they were, not in the middle of bones.
        let at = |b: &thenar_core::model::Bone| (b.pose_MB * b.pose_BT).position;
        assert!((at(same) - at(bone)).norm() < 1e-6, "{}", bone.name);
    }
    assert_eq!((kinds(&back, JointKind::Hinge), kinds(&back, JointKind::Ball)), (2, 18));
    let shank = joint(&back, "shank_left");
    assert_eq!((shank.axes[0].stiffness, shank.axes[0].limit.unwrap().max), (100.0, 2.4));
    assert!(report.lost_weight < 0.05, "{}", report.lost_weight);
    let height = report.bounds[1].y - report.bounds[0].y;
    assert!((height - 1.7).abs() < 0.02, "{height}");
}

fn refused(result: Result<(HandModel, FigureReport), RigError>, parts: &[&str]) {
    let error = result.unwrap_err().to_string();
    for part in parts {
        assert!(error.contains(part), "{error}: no {part}");
    }
}

#[test]
fn what_cannot_be_built_is_said() {
    let with = |change: fn(&mut FigureOptions)| {
        let mut options = FigureOptions { thickness: Some(5e-3), ..FigureOptions::default() };
        change(&mut options);
        build_figure_file(&asset("gripper.urdf"), &options)
    };
    refused(with(|o| o.thickness = None), &["gripper.urdf", "how thick"]);
    refused(with(|o| o.thickness = Some(-1.0)), &["thickness"]);
    refused(with(|o| o.thickness = Some(1e-3)), &["pieces", "thicker"]);
    refused(with(|o| o.thickness = Some(1e-6)), &["too thin"]);
    refused(with(|o| o.tets = 1), &["tetrahedra"]);
    refused(with(|o| o.scale = f64::NAN), &["scale"]);
    let change = |name: &str| JointChange { name: name.into(), ..JointChange::default() };
    let with_change = |change: JointChange| {
        let options = FigureOptions {
            thickness: Some(5e-3),
            joints: vec![change],
            ..FigureOptions::default()
        };
        build_figure_file(&asset("gripper.urdf"), &options)
    };
    refused(with_change(change("elbow")), &["elbow", "finger_1_knuckle"]);
    let two = JointChange { stiffness: vec![1.0, 2.0], ..change("finger_1*") };
    refused(with_change(two), &["finger_1", "Hinge", "2"]);
    let range =
        JointChange { ranges: vec![AngleLimit { min: 0.1, max: 0.2 }], ..change("finger_*") };
    refused(with_change(range), &["rest pose"]);
    let axes = JointChange {
        kind: Some((JointKind::Universal, vec![Vec3::x(), Vec3::x()])),
        ..change("finger_*")
    };
    refused(with_change(axes), &["right angles"]);
    refused(build_figure_file(&asset("nobody.urdf"), &FigureOptions::default()), &["nobody.urdf"]);
    refused(build_figure_file(&asset("README.md"), &FigureOptions::default()), &[".urdf"]);
}
