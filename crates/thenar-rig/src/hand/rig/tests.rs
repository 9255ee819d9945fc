//! Goal: rigs of people and of hands from common tools are recognised whole. Method: lists of all
//! names that bear on hands, of both sides, among other bones, in an order that says nothing; each
//! joint must be the one that the tool means.

use super::{RigJoints, find};
use crate::glb::RigJoint;
use crate::hand::names::NameMap;
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};

/// A name, and the distance of its joint from the wrist, in hundredths of a hand's length.
type Named = (String, u32);

/// Distances from the wrist of the joints of a digit, from the metacarpal to the tip.
const FAR: [u32; 5] = [15, 50, 70, 85, 100];

/// Names of one hand of a tool: of the wrist, of moving joint `k` (from 0) of digit `d` (the
/// thumb's is 0), and of what else belongs to digits.
struct Tool {
    wrist: String,
    moving: Box<dyn Fn(usize, usize) -> String>,
    metacarpal: Option<Box<dyn Fn(usize) -> String>>,
    tip: Option<Box<dyn Fn(usize) -> String>>,
}

impl Tool {
    fn names(&self) -> Vec<Named> {
        let mut names = vec![(self.wrist.clone(), 0)];
        for d in 0..5 {
            names.extend((0..3).map(|k| ((self.moving)(d, k), FAR[k + 1])));
            names.extend(self.tip.as_ref().map(|name| (name(d), FAR[4])));
            let base = self.metacarpal.as_ref().filter(|_| d > 0);
            names.extend(base.map(|name| (name(d), FAR[0])));
        }
        names
    }

    /// Asserts that what was found is what the tool means.
    fn check(&self, what: &str, found: &RigJoints, joints: &[RigJoint]) {
        let name = |k: usize| joints[k].name.clone();
        assert_eq!(name(found.wrist), self.wrist, "{what}");
        for (d, chain) in found.digits.iter().enumerate() {
            assert_eq!(chain.moving.map(name), [0, 1, 2].map(|k| (self.moving)(d, k)), "{what}");
            let base = self.metacarpal.as_ref().filter(|_| d > 0).map(|name| name(d));
            assert_eq!(chain.metacarpal.map(name), base, "{what}");
            assert_eq!(chain.tip.map(name), self.tip.as_ref().map(|name| name(d)), "{what}");
        }
    }
}

/// Joints of these names, the last first, which is no order of a hand.
fn joints(names: Vec<Named>) -> Vec<RigJoint> {
    let mut joints: Vec<RigJoint> = (names.into_iter())
        .map(|(name, far)| {
            let place = Vec3::z() * (-0.0019 * f64::from(far));
            RigJoint { name, pose: Pose::new(place, Quat::identity()), parent: None }
        })
        .collect();
    joints.sort_by(|a, b| b.name.cmp(&a.name));
    joints
}

/// Finds each hand of a figure that has two and other bones, and either alone.
fn check(what: &str, of_side: impl Fn(Side) -> Tool, others: &[&str]) {
    let others = || others.iter().map(|name| (name.to_string(), 0));
    let sides = [Side::Left, Side::Right];
    let figure = joints(sides.iter().flat_map(|s| of_side(*s).names()).chain(others()).collect());
    let refused = find(&figure, &NameMap::new(), None).unwrap_err().to_string();
    assert!(refused.contains("a left and a right hand"), "{what}: {refused}");
    for side in sides {
        let tool = of_side(side);
        for (joints, asked) in [(figure.clone(), Some(side)), (joints(tool.names()), None)] {
            let found = find(&joints, &NameMap::new(), asked);
            let found = found.unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(found.side, Some(side), "{what}");
            tool.check(what, &found, &joints);
        }
    }
}

fn letter(side: Side) -> &'static str {
    if side == Side::Left { "L" } else { "R" }
}

#[test]
fn makehuman_s_default_rig_is_recognised() {
    let others = [
        "root",
        "spine01",
        "neck01",
        "clavicle.R",
        "shoulder01.R",
        "upperarm02.L",
        "lowerarm01.R",
        "lowerarm02.R",
        "lowerarm02.L",
        "toe1-1.R",
        "toe2-3.R",
        "toe5-3.L",
        "tongue05.L",
        "oris06",
        "special05.R",
        "orbicularis03.R",
    ];
    let tool = |side| {
        let s = letter(side);
        Tool {
            wrist: format!("wrist.{s}"),
            moving: Box::new(move |d, k| format!("finger{}-{}.{s}", d + 1, k + 1)),
            metacarpal: Some(Box::new(move |d| format!("metacarpal{d}.{s}"))),
            tip: None,
        }
    };
    check("MakeHuman", tool, &others);
}

const DIGITS: [&str; 5] = ["thumb", "index", "middle", "ring", "pinky"];

/// MPFB2's `game_engine`, and Unreal 4's figure.
#[test]
fn game_engine_rigs_are_recognised() {
    let others = ["Root", "pelvis", "spine_01", "clavicle_r", "lowerarm_r", "upperarm_l", "ball_r"];
    let tool = |side| {
        let s = letter(side).to_lowercase();
        Tool {
            wrist: format!("hand_{s}"),
            moving: Box::new(move |d, k| format!("{}_0{}_{s}", DIGITS[d], k + 1)),
            metacarpal: None,
            tip: None,
        }
    };
    check("game engine", tool, &others);
    check("Unreal 4", tool, &[&others[..], &["ik_hand_root", "ik_hand_gun", "ik_hand_r"]].concat());
}

/// One layer of a Rigify figure: a prefix, and one hand's bones behind it.
fn rigify(prefix: &'static str, side: Side) -> Tool {
    let s = letter(side);
    let of_finger = |d: usize| if d == 0 { "" } else { "f_" };
    Tool {
        wrist: format!("{prefix}hand.{s}"),
        moving: Box::new(move |d, k| {
            format!("{prefix}{}{}.0{}.{s}", of_finger(d), DIGITS[d], k + 1)
        }),
        metacarpal: Some(Box::new(move |d| format!("{prefix}palm.0{d}.{s}"))),
        tip: None,
    }
}

#[test]
fn rigify_s_metarig_and_its_layers_are_recognised() {
    for prefix in ["", "DEF-", "ORG-"] {
        let others = ["spine.001", "shoulder.R", "upper_arm.R", "forearm.R", "heel.02.R", "toe.L"];
        let others = others.map(|name| format!("{prefix}{name}"));
        check(
            &format!("Rigify {prefix}"),
            |side| rigify(prefix, side),
            &others.each_ref().map(String::as_str),
        );
    }
}

/// A generated rig with everything in it: copies of the drawn bones are the hand, else what
/// deforms.
#[test]
fn of_a_generated_rigify_figure_one_layer_is_the_hand() {
    let mut handles: Vec<String> = Vec::new();
    for s in ["L", "R"] {
        for word in
            ["hand_ik", "hand_fk", "hand_tweak", "palm", "MCH-hand_ik_parent", "VIS_hand_ik_pole"]
        {
            handles.push(format!("{word}.{s}"));
        }
        for digit in ["thumb", "f_index", "f_middle", "f_ring", "f_pinky"] {
            handles.push(format!("{digit}.01_master.{s}"));
            handles.push(format!("{digit}.01.{s}.001"));
            handles.extend((1..4).map(|k| format!("MCH-{digit}.0{k}_drv.{s}")));
        }
    }
    for (lower, upper) in [("DEF-", "ORG-"), ("", "ORG-"), ("", "DEF-")] {
        let more = [Side::Left, Side::Right].map(|side| rigify(lower, side).names()).concat();
        let others: Vec<&str> =
            handles.iter().chain(more.iter().map(|(name, _)| name)).map(String::as_str).collect();
        for side in [Side::Left, Side::Right] {
            let tool = rigify(upper, side);
            let names = tool.names().into_iter().chain(others.iter().map(|n| (n.to_string(), 20)));
            let joints = joints(names.collect());
            let found = find(&joints, &NameMap::new(), Some(side));
            let found = found.unwrap_or_else(|e| panic!("{upper} over {lower}: {e}"));
            tool.check(upper, &found, &joints);
        }
    }
}

/// Older figures cut the first bones of fingers in two; the first part begins at the joint.
#[test]
fn bones_that_rigify_cut_in_two_begin_at_the_first_part() {
    let cut = |side: Side| {
        let tool = rigify("DEF-", side);
        let moving = tool.moving;
        let name = move |d: usize, k: usize| {
            format!("{}{}", moving(d, k), if k == 0 { ".01" } else { "" })
        };
        Tool { moving: Box::new(name), ..tool }
    };
    let seconds: Vec<String> = [Side::Left, Side::Right]
        .iter()
        .flat_map(|side| (0..5).map(|d| format!("{}.02", (rigify("DEF-", *side).moving)(d, 0))))
        .collect();
    let others: Vec<&str> = seconds.iter().map(String::as_str).collect();
    for side in [Side::Left, Side::Right] {
        let names = cut(side).names().into_iter();
        let names = names.chain(others.iter().map(|n| (n.to_string(), 60))).collect();
        let joints = joints(names);
        let found = find(&joints, &NameMap::new(), Some(side)).unwrap_or_else(|e| panic!("{e}"));
        cut(side).check("cut", &found, &joints);
    }
}

/// A prefix of fingers that the wrist does not have makes no handle of the wrist.
#[test]
fn a_wrist_beside_prefixed_fingers_is_the_wrist() {
    for prefix in ["DEF-", "ORG-"] {
        let tool = |side| Tool { wrist: rigify("", side).wrist, ..rigify(prefix, side) };
        check(prefix, tool, &["spine", "forearm.R"]);
    }
}

/// Metacarpals counted to five beside named digits: the first is the thumb's, whatever its own
/// joints are called.
#[test]
fn numbered_metacarpals_go_with_named_digits() {
    let bones = ["proximal", "intermediate", "distal"];
    let others = ["metacarpal_1_l", "metacarpal_1_r", "forearm_r"];
    let named = |side| {
        let s = letter(side).to_lowercase();
        let t = s.clone();
        Tool {
            wrist: format!("hand_{s}"),
            moving: Box::new(move |d, k| match d {
                0 => format!("thumb_0{}_{s}", k + 1),
                _ => format!("{}_{}_{s}", DIGITS[d], bones[k]),
            }),
            metacarpal: Some(Box::new(move |d| format!("metacarpal_{}_{t}", d + 1))),
            tip: None,
        }
    };
    check("numbered thumb", named, &others);
}

/// With and without the end nodes that some exports have.
#[test]
fn mixamo_s_figures_are_recognised() {
    for prefix in ["mixamorig:", "mixamorig1:", "mixamorig", "mixamorig_", ""] {
        for ends in [false, true] {
            let others =
                ["Hips", "Spine1", "LeftForeArm", "RightForeArm", "RightArm", "LeftToeBase"];
            let others = others.map(|name| format!("{prefix}{name}"));
            let tool = |side| {
                let side = if side == Side::Left { "Left" } else { "Right" };
                let name = move |d: usize, k: usize| {
                    let digit = ["Thumb", "Index", "Middle", "Ring", "Pinky"][d];
                    format!("{prefix}{side}Hand{digit}{}", k + 1)
                };
                Tool {
                    wrist: format!("{prefix}{side}Hand"),
                    moving: Box::new(name),
                    metacarpal: None,
                    tip: if ends { Some(Box::new(move |d| name(d, 3))) } else { None },
                }
            };
            let what = format!("Mixamo {prefix} {ends}");
            check(&what, tool, &others.each_ref().map(String::as_str));
        }
    }
}
