//! Goal: any rig of a hand becomes a hand: joints named by other tools, with axes of their own,
//! some missing, in any unit, of either side, open at the wrist. Method: the shipped hands' meshes
//! and joint places are written as such rigs; what is built has the bones of the shipped hand, or
//! what the rig leaves out is where anatomy has it.

use thenar_core::model::{HandModel, Side};
use thenar_core::{Pose, Quat, Vec3};
use thenar_rig::RigError;
use thenar_rig::export::{GlbMesh, Skeleton, VertexSkin, glb};
use thenar_rig::glb::{SkinnedMesh, read_skinned_glb};
use thenar_rig::hand::{
    HandOptions, HandReport, RigListing, Size, asset, build_hand_with_report, rig_listing,
};

/// A rig as some tool would write it.
struct Foreign {
    source: SkinnedMesh,
    /// Names of the joints that it has, each with WebXR's name of what lies there.
    names: Vec<(String, String)>,
    /// Own axes of every joint, beyond those of WebXR.
    turn: Option<Quat>,
    scale: f64,
    placed: Pose,
    open: bool,
}

impl Foreign {
    fn new(side: Side, names: Vec<(String, String)>) -> Self {
        let source = read_skinned_glb(asset(side)).unwrap();
        let turn = Some(Quat::from_euler_angles(0.3, 1.2, -2.0));
        let placed = Pose::new(Vec3::new(0.3, 1.1, -0.2), Quat::from_euler_angles(0.4, -1.0, 2.2));
        Self { source, names, turn, scale: 1.0, placed, open: false }
    }

    fn bytes(&self) -> Vec<u8> {
        let mut mesh = self.source.mesh.clone();
        let rest = |webxr: &str| {
            let joint = self.source.joints.iter().find(|j| j.name == webxr);
            joint.unwrap_or_else(|| panic!("no {webxr}")).pose
        };
        if self.open {
            // The skin behind the wrist is gone.
            let wrist = rest("wrist");
            let behind = |v: &u32| wrist.inverse_point(&mesh.positions[*v as usize]).z > 0.01;
            mesh.triangles.retain(|t| !t.iter().any(behind));
        }
        let place = |p: &Vec3| self.placed.point(&(p * self.scale));
        let positions: Vec<Vec3> = mesh.positions.iter().map(place).collect();
        let pose = |webxr: &str| {
            let own = rest(webxr);
            let turned = self.turn.map_or(own.rotation, |turn| own.rotation * turn);
            Pose::new(place(&own.position), self.placed.rotation * turned)
        };
        let skeleton = Skeleton {
            names: self.names.iter().map(|(own, _)| own.as_str()).collect(),
            parents: vec![None; self.names.len()],
            poses: self.names.iter().map(|(_, webxr)| pose(webxr)).collect(),
        };
        let skin =
            vec![VertexSkin { bones: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] }; positions.len()];
        let mesh = GlbMesh {
            name: "hand",
            positions: &positions,
            triangles: &mesh.triangles,
            colour: [0.8; 3],
            skin: Some(&skin),
        };
        glb(&[mesh], Some(&skeleton)).unwrap()
    }

    fn build(&self, options: HandOptions) -> Result<(HandModel, HandReport), RigError> {
        let options = HandOptions { tets: 300, render_triangles: 2500, ..options };
        build_hand_with_report(&self.bytes(), &options)
    }
}

const FINGERS: [&str; 4] = ["index", "middle", "ring", "pinky"];
const PHALANGES: [&str; 3] = ["phalanx-proximal", "phalanx-intermediate", "phalanx-distal"];
const THUMB: [&str; 3] = ["metacarpal", "phalanx-proximal", "phalanx-distal"];

/// Sixteen joints: a wrist and three of each digit, by a tool's names of a digit's k-th joint.
fn sixteen(wrist: &str, name: impl Fn(&str, usize) -> String) -> Vec<(String, String)> {
    let mut names = vec![(wrist.to_string(), "wrist".to_string())];
    for k in 0..3 {
        names.push((name("thumb", k), format!("thumb-{}", THUMB[k])));
        for finger in FINGERS {
            names.push((name(finger, k), format!("{finger}-finger-{}", PHALANGES[k])));
        }
    }
    names
}

/// The number of a digit, the thumb's 0.
fn number(digit: &str) -> usize {
    FINGERS.iter().position(|finger| *finger == digit).map_or(0, |k| k + 1)
}

fn upper(word: &str) -> String {
    word[..1].to_uppercase() + &word[1..]
}

fn paper() -> HandOptions {
    HandOptions::paper()
}

/// The built-in hand with the same numbers.
fn shipped(side: Side) -> HandModel {
    let options = HandOptions { tets: 300, render_triangles: 2500, ..paper() };
    build_hand_with_report(asset(side), &options).unwrap().0
}

/// The largest distance of bones' ends from those of the shipped hand of the same side, and the
/// largest angle between the flexion axes of joints \[m, rad\].
fn apart(hand: &HandModel) -> (f64, f64) {
    let own = shipped(hand.side.unwrap());
    let far = hand.bones.iter().zip(&own.bones).skip(1).flat_map(|(a, b)| {
        assert_eq!(a.name, b.name);
        (0..2).map(|k| (a.pose_MB.point(&a.ends_B[k]) - b.pose_MB.point(&b.ends_B[k])).norm())
    });
    let axis = |hand: &HandModel, j: usize| {
        let joint = &hand.joints[j];
        let parent = &hand.bones[joint.parent.unwrap() as usize];
        (parent.pose_MB * joint.pose_PJ).vector(&Vec3::x())
    };
    let angle = (0..hand.joints.len()).map(|j| axis(hand, j).angle(&axis(&own, j)));
    (far.fold(0.0, f64::max), angle.fold(0.0, f64::max))
}

/// Wrist and knuckles say where the palm lies as well as a rig's own axes, to these: 9 mm at tips
/// that no joint marks, of a hand whose wrist is turned by 2°.
const FAR_MAX: f64 = 0.009;
/// Axes of digits, by places alone, against those that the rig's artist gave.
const ANGLE_MAX: f64 = 0.45;

#[test]
fn sixteen_joints_by_the_names_of_many_tools_become_the_shipped_hand() {
    type Name = fn(&str, usize) -> String;
    let tools: [(&str, &str, Name); 7] = [
        ("Mixamo", "mixamorig:RightHand", |d, k| {
            format!("mixamorig:RightHand{}{}", upper(d), k + 1)
        }),
        ("Unreal", "hand_r", |d, k| format!("{d}_0{}_r", k + 1)),
        ("Unity", "Right Hand", |d, k| {
            let digit = if d == "pinky" { "Little".into() } else { upper(d) };
            format!("Right {digit} {}", ["Proximal", "Intermediate", "Distal"][k])
        }),
        ("VRM 1.0", "rightHand", |d, k| {
            let digit = if d == "pinky" { "Little".into() } else { upper(d) };
            let of_thumb = ["Metacarpal", "Proximal", "Distal"];
            let bone = if d == "thumb" { of_thumb } else { ["Proximal", "Intermediate", "Distal"] };
            format!("right{digit}{}", bone[k])
        }),
        ("VRoid", "J_Bip_R_Hand", |d, k| {
            let digit = if d == "pinky" { "Little".into() } else { upper(d) };
            format!("J_Bip_R_{digit}{}", k + 1)
        }),
        ("3ds Max", "Bip01 R Hand", |d, k| {
            let behind = if k == 0 { String::new() } else { k.to_string() };
            format!("Bip01 R Finger{}{behind}", number(d))
        }),
        ("MakeHuman", "wrist.R", |d, k| format!("finger{}-{}.R", number(d) + 1, k + 1)),
    ];
    for (tool, wrist, name) in tools {
        let rig = Foreign::new(Side::Right, sixteen(wrist, name));
        let (hand, report) = rig.build(paper()).unwrap_or_else(|e| panic!("{tool}: {e}"));
        assert_eq!(hand.side, Some(Side::Right), "{tool}");
        assert!(!report.rig.own_axes);
        assert_eq!(report.rig.made.len(), 4 + 5, "{tool}: {:?}", report.rig.made);
        let (far, angle) = apart(&hand);
        assert!(far < FAR_MAX && angle < ANGLE_MAX, "{tool}: {far} m, {angle} rad");
    }
}

#[test]
fn oculus_hands_with_and_without_metacarpals_are_read() {
    let name = |d: &str, k: usize| format!("b_l_{d}{}", k + 1);
    let mut names = sixteen("b_l_wrist", name);
    for digit in ["thumb", "index", "middle", "ring", "pinky"] {
        let webxr =
            if digit == "thumb" { "thumb-tip".into() } else { format!("{digit}-finger-tip") };
        names.push((format!("b_l_{digit}_null"), webxr));
    }
    // Before the thumb's metacarpal lies one more joint.
    names.push(("b_l_thumb0".into(), "wrist".into()));
    names.push(("b_l_forearm_stub".into(), "wrist".into()));
    let (hand, report) = Foreign::new(Side::Left, names.clone()).build(paper()).unwrap();
    assert_eq!((hand.side, report.rig.made.len()), (Some(Side::Left), 4));
    let (far, angle) = apart(&hand);
    assert!(far < FAR_MAX && angle < ANGLE_MAX, "{far} m, {angle} rad");

    // Version 3 has them, and an end node behind each joint.
    for finger in FINGERS {
        names.push((format!("b_l_{finger}0"), format!("{finger}-finger-metacarpal")));
    }
    for k in 0..names.len() {
        let (own, webxr) = names[k].clone();
        names.push((format!("{own}_end"), webxr));
    }
    let (hand, report) = Foreign::new(Side::Left, names).build(paper()).unwrap();
    assert!(report.rig.made.is_empty(), "{:?}", report.rig.made);
    assert!(apart(&hand).0 < FAR_MAX);
}

/// A rig with WebXR's names and axes is read as it was, wherever it lies.
#[test]
fn axes_that_are_webxr_s_are_kept() {
    let source = read_skinned_glb(asset(Side::Right)).unwrap();
    let names = source.joints.iter().map(|j| (j.name.clone(), j.name.clone())).collect();
    let rig = Foreign { turn: None, ..Foreign::new(Side::Right, names) };
    let (hand, report) = rig.build(paper()).unwrap();
    assert!(report.rig.own_axes && report.rig.made.is_empty());
    let (far, angle) = apart(&hand);
    assert!(far < 1e-6 && angle < 0.05, "{far} m, {angle} rad");
}

/// Names that say no side leave it to the shape: the thumb stands before the palm.
#[test]
fn the_side_is_told_by_names_or_by_shape() {
    for side in [Side::Left, Side::Right] {
        let rig = Foreign::new(side, sixteen("wrist", |d, k| format!("{d}{}", k + 1)));
        let (hand, _) = rig.build(paper()).unwrap();
        assert_eq!(hand.side, Some(side));
        assert!(apart(&hand).0 < FAR_MAX);
        let other = if side == Side::Left { Side::Right } else { Side::Left };
        let wrong = rig.build(HandOptions { side: Some(other), ..paper() });
        let error = wrong.unwrap_err().to_string();
        assert!(error.contains(&format!("taken for a {} hand", other.name())), "{error}");

        let letter = if side == Side::Left { "l" } else { "r" };
        let names = sixteen(&format!("hand_{letter}"), |d, k| format!("{d}_0{}_{letter}", k + 1));
        let wrong = Foreign::new(side, names).build(HandOptions { side: Some(other), ..paper() });
        let error = wrong.unwrap_err().to_string();
        assert!(error.contains(&format!("are those of a {} hand", side.name())), "{error}");
    }
}

/// Names as scene exporters number them, each with its node's number.
#[test]
fn numbers_of_a_scene_s_nodes_are_passed_over() {
    let mut names = sixteen("RightHand", |d, k| format!("RightHand{}{}", upper(d), k + 1));
    for (k, (own, _)) in names.iter_mut().enumerate() {
        *own = format!("{own}_{:03}", k + 33);
    }
    let (hand, _) = Foreign::new(Side::Right, names).build(paper()).unwrap();
    assert_eq!(hand.side, Some(Side::Right));
    assert!(apart(&hand).0 < FAR_MAX);
}

/// Unreal 5 names metacarpals by word and the joints that move by number.
#[test]
fn metacarpals_by_word_stand_beside_numbers() {
    let mut names = sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1));
    for finger in FINGERS {
        names.push((format!("{finger}_metacarpal_r"), format!("{finger}-finger-metacarpal")));
    }
    let (hand, report) = Foreign::new(Side::Right, names).build(paper()).unwrap();
    assert_eq!(report.rig.made.len(), 5, "tips: {:?}", report.rig.made);
    assert!(apart(&hand).0 < FAR_MAX);
}

/// A skin whose triangles face inward is turned over, and told.
#[test]
fn a_skin_that_faces_inward_is_turned_over() {
    let names = || sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1));
    for open in [false, true] {
        let mut rig = Foreign { open, ..Foreign::new(Side::Right, names()) };
        assert!(!rig.build(paper()).unwrap().1.rig.inside_out);
        rig.source.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let (hand, report) = rig.build(paper()).unwrap();
        assert!(report.rig.inside_out);
        assert!(apart(&hand).0 < FAR_MAX);
    }
}

/// The names of one figure with two hands: one is to be chosen.
#[test]
fn of_two_hands_one_is_asked_for() {
    let mut names = sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1));
    names.extend(sixteen("hand_l", |d, k| format!("{d}_0{}_l", k + 1)));
    let rig = Foreign::new(Side::Right, names);
    let error = rig.build(paper()).unwrap_err().to_string();
    assert!(error.contains("--side") && error.contains("thumb_01_l"), "{error}");
    let asked = HandOptions { side: Some(Side::Right), ..paper() };
    assert_eq!(rig.build(asked).unwrap().0.side, Some(Side::Right));
}

#[test]
fn units_are_told_by_the_length_of_the_hand() {
    let names = || sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1));
    for (unit, scale) in [("millimetres", 1e3), ("centimetres", 100.0), ("decimetres", 10.0)] {
        let rig = Foreign { scale, ..Foreign::new(Side::Right, names()) };
        let error = rig.build(paper()).unwrap_err().to_string();
        assert!(error.contains(&format!("are these {unit}")), "{error}");
        let (hand, report) = rig.build(HandOptions { size: Size::Own, ..paper() }).unwrap();
        assert_eq!(report.rig.unit, Some(unit));
        assert!(apart(&hand).0 < FAR_MAX, "{unit}");
        let said = HandOptions { size: Size::Scale(1.0 / scale), ..paper() };
        assert!((rig.build(said).unwrap().0.length - hand.length).abs() < 1e-9);
    }
    // What can be a hand in metres is one.
    let small = Foreign { scale: 0.4, ..Foreign::new(Side::Right, names()) };
    let (hand, report) = small.build(HandOptions { size: Size::Own, ..paper() }).unwrap();
    assert_eq!(report.rig.unit, None);
    assert!(hand.length < 0.09);
}

#[test]
fn an_open_wrist_is_closed_and_told() {
    let names = || sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1));
    let rig = Foreign { open: true, ..Foreign::new(Side::Right, names()) };
    let (hand, report) = rig.build(paper()).unwrap();
    assert_eq!(report.rig.holes.len(), 1);
    // A wrist is some 60 by 40 mm.
    let hole = report.rig.holes[0];
    assert!((0.12..0.3).contains(&hole.border) && (5e-4..6e-3).contains(&hole.area), "{hole:?}");
    assert!(apart(&hand).0 < FAR_MAX);
}

#[test]
fn what_is_no_hand_is_told_with_the_joints_and_what_helps() {
    let missing = |gone: &str, wrist: &str| {
        let mut names = sixteen(wrist, |d, k| format!("{d}_0{}_r", k + 1));
        names.retain(|(own, _)| own != gone);
        Foreign::new(Side::Right, names).build(paper()).unwrap_err().to_string()
    };
    let error = missing("ring_02_r", "hand_r");
    assert!(error.contains("ring") && error.contains("\"ring_01_r\", \"ring_03_r\""), "{error}");
    assert!(error.contains("pinky_03_r") && error.contains("--joint-names"), "{error}");
    let error = missing("", "root");
    assert!(error.contains("`wrist`") && error.contains("\"root\""), "{error}");
    // All joints at one place span nothing.
    let mut rig = Foreign::new(Side::Right, sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1)));
    rig.names.iter_mut().for_each(|(_, webxr)| *webxr = "wrist".into());
    let error = rig.build(paper()).unwrap_err().to_string();
    assert!(error.contains("span no palm"), "{error}");
}

/// A mesh far from the joints is no hand: a whole figure, say.
#[test]
fn a_mesh_away_from_its_joints_is_told_by_the_bone() {
    let mut rig = Foreign::new(Side::Right, sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1)));
    let far = Pose::translation(0.0, 0.5, 0.0);
    rig.source.mesh = thenar_rig::mesh::shapes::sphere(0.1, 8).transformed(&far);
    let told = |rig: &Foreign, parts: &[&str]| {
        let error = rig.build(paper()).unwrap_err().to_string();
        for part in parts.iter().chain(&["thenar hand --list", "--mesh"]) {
            assert!(error.contains(part), "{error}: no {part}");
        }
    };
    told(&rig, &["\"middle_03_r\", the last joint of the middle, at ("]);
    for digit in ["thumb", "index", "middle", "ring", "pinky"] {
        let finger = if digit == "thumb" { "" } else { "-finger" };
        rig.names.push((format!("{digit}_tip_r"), format!("{digit}{finger}-tip")));
    }
    told(&rig, &["bone \"", "outside the hand's skin, from ("]);
}

/// The joints of a rig with their meanings; what is missing, with what may be it; and both sides.
#[test]
fn a_rig_is_listed_for_a_name_map() {
    let mut names = sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1));
    names.retain(|(own, _)| own != "ring_02_r");
    names.push(("Bone_a".into(), "wrist".into()));
    let list = |names: &[(String, String)], map: &[(&str, &str)], side| {
        let rig = Foreign::new(Side::Right, names.to_vec());
        let map = map.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
        rig_listing(&rig.bytes(), &map, &[], side).unwrap()
    };
    let listing = list(&names, &[], None);
    assert_eq!((listing.side, listing.both_sides), (Some(Side::Right), false));
    assert_eq!(listing.joints.len(), 25);
    let joint = |listing: &RigListing, name: &str| {
        listing.joints.iter().find(|joint| joint.name == name).unwrap().clone()
    };
    let own = |name: &str| joint(&listing, name).own;
    assert_eq!(own("wrist").as_deref(), Some("hand_r"));
    assert_eq!(own("thumb-metacarpal").as_deref(), Some("thumb_01_r"));
    assert_eq!(own("index-finger-phalanx-distal").as_deref(), Some("index_03_r"));
    let tip = joint(&listing, "index-finger-tip");
    assert!(tip.own.is_none() && !tip.needed);
    let lost = joint(&listing, "ring-finger-phalanx-intermediate");
    assert!(lost.own.is_none() && lost.needed);
    assert_eq!(lost.like, ["ring_01_r", "ring_03_r"]);
    assert_eq!(listing.others, ["ring_01_r", "ring_03_r", "Bone_a"]);
    // As the map says it, nothing is missing.
    let whole = list(&names, &[("ring-finger-phalanx-intermediate", "Bone_a")], None);
    assert!(whole.joints.iter().all(|joint| joint.own.is_some() || !joint.needed), "{whole:?}");
    assert!(whole.others.is_empty(), "{:?}", whole.others);
    let left = sixteen("hand_l", |d, k| format!("{d}_0{}_l", k + 1));
    let both: Vec<_> = names.iter().chain(&left).cloned().collect();
    let listing = list(&both, &[], Some(Side::Left));
    assert!(listing.both_sides && listing.side == Some(Side::Left));
    assert_eq!(joint(&listing, "wrist").own.as_deref(), Some("hand_l"));
    assert_eq!(list(&both, &[], None).side, Some(Side::Right));
}

/// A map of those joints alone whose names say nothing, beside numbers, words and WebXR's own
/// names.
#[test]
fn a_name_map_fills_in_what_names_leave_out() {
    type Name = fn(&str, usize) -> String;
    let ways: [Name; 3] = [
        |d, k| format!("{d}_0{}_r", k + 1),
        |d, k| match d {
            "thumb" => format!("r_{d}_{}", ["metacarpal", "proximal", "distal"][k]),
            _ => format!("r_{d}_{}", ["proximal", "medial", "distal"][k]),
        },
        |d, k| match d {
            "thumb" => format!("{d}-{}", THUMB[k]),
            _ => format!("{d}-finger-{}", PHALANGES[k]),
        },
    ];
    for (way, name) in ways.iter().enumerate() {
        for lost in ["thumb-metacarpal", "thumb-phalanx-distal", "ring-finger-phalanx-intermediate"]
        {
            let mut names = sixteen("wrist", name);
            let (own, _) = names.iter_mut().find(|(_, webxr)| webxr == lost).unwrap();
            *own = "Bone_a".into();
            let rig = Foreign::new(Side::Right, names);
            let error = rig.build(paper()).unwrap_err().to_string();
            assert!(error.contains("no three joints in a row"), "{error}");
            let name_map = [(lost.to_string(), "Bone_a".to_string())].into();
            let (hand, _) = rig
                .build(HandOptions { name_map, side: Some(Side::Right), ..paper() })
                .unwrap_or_else(|e| panic!("{way}, {lost}: {e}"));
            assert!(apart(&hand).0 < FAR_MAX, "{way}, {lost}");
        }
    }
}

#[test]
fn a_name_map_that_says_what_is_not_is_refused() {
    let rig = Foreign::new(Side::Right, sixteen("hand_r", |d, k| format!("{d}_0{}_r", k + 1)));
    let refused = |map: &[(&str, &str)]| {
        let name_map = map.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
        rig.build(HandOptions { name_map, ..paper() }).unwrap_err().to_string()
    };
    let error = refused(&[("index-proximal", "index_01_r")]);
    assert!(
        error.contains("\"index-proximal\"") && error.contains("index-finger-phalanx-proximal")
    );
    let error = refused(&[("wrist", "nothing")]);
    assert!(error.contains("no joint \"nothing\"") && error.contains("\"hand_r\""), "{error}");
    let error = refused(&[("wrist", "hand_r"), ("thumb-tip", "hand_r")]);
    assert!(error.contains("\"hand_r\" twice"), "{error}");
}

/// Foreign names by a map, foreign axes all the same.
#[test]
fn a_name_map_needs_no_axes() {
    let names: Vec<(String, String)> =
        sixteen("w", |d, k| format!("{}{k}", &d[..1])).into_iter().collect();
    let rig = Foreign::new(Side::Right, names.clone());
    assert!(rig.build(paper()).is_err());
    let name_map = names.into_iter().map(|(own, webxr)| (webxr, own)).collect();
    let (hand, _) = rig.build(HandOptions { name_map, ..paper() }).unwrap();
    assert!(apart(&hand).0 < FAR_MAX);
}
