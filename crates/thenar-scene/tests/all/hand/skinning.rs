//! Goal: targets by the pose of two bones (`skinning = "joint"`) keep radius and depth, in scenes as in formulas, with
//! both solvers, and leave momentum alone. Method: a bar between two bones that are turned by 90° has its targets
//! where trigonometry puts them; a hand thrown in free air without dampers keeps its momentum.

use std::path::Path;
use thenar_scene::SceneError;
use thenar_scene::session::Session;

fn open(text: &str, overrides: &[&str]) -> Result<Session, SceneError> {
    let overrides: Vec<String> = overrides.iter().map(|&s| s.into()).collect();
    Session::from_text(text, Path::new("test.toml"), &overrides)
}

/// A bar along x from bone a to bone b, whose middle layer is bound to both; b turns by 90° about `axis`.
fn bar(axis: &str, joint: &str) -> String {
    format!(
        r#"version = 1
gravity = [0, 0, 0]
time_step = 0.005
duration = 1
[[rigid]]
name = "a"
motion = "fixed"
position = [-0.01, 0, 0]
[[rigid]]
name = "b"
motion = "scripted"
position = [0.01, 0, 0]
keyframes = [{{ time = 0 }}, {{ time = 0.5, rotation = {{ axis = {axis}, angle_deg = 90 }}, position = PLACE }}]
{joint}
[[soft]]
name = "bar"
shape = {{ kind = "lattice", size = [0.04, 0.02, 0.02], cells = [4, 2, 2], split = "five" }}
material = {{ young = 50e3, poisson = 0.4, density = 1000 }}
contact = false
[[soft.bind]]
nodes = {{ box_max = [-0.001, 1, 1] }}
bones = ["a"]
[[soft.bind]]
nodes = {{ box_min = [0.001, -1, -1] }}
bones = ["b"]
[[soft.bind]]
nodes = {{ box_min = [-0.001, -1, -1], box_max = [0.001, 1, 1] }}
bones = ["a", "b"]
"#
    )
}

const BETWEEN: &str = r#"[[joint]]
name = "between"
kind = "free"
parent = "a"
child = "b"
anchor = [0, 0, 0]
"#;

/// Distances from the origin of the targets of the middle layer, over those at rest.
fn kept(axis: &str, position: &str, skinning: &str, solver: &str) -> Vec<f64> {
    let text = bar(axis, BETWEEN).replace("PLACE", position);
    let skinning = format!("soft.bar.skinning={skinning}");
    let solver = format!("solver.kind={solver}");
    let mut session = open(&text, &[&skinning, &solver]).unwrap_or_else(|e| panic!("{e}"));
    let middle: Vec<usize> = (0..session.world().nodes(0).len())
        .filter(|&n| session.world().nodes(0)[n].x.abs() < 1e-9)
        .collect();
    let rest = session.world().nodes(0).to_vec();
    while session.world().time() < 0.6 {
        session.step(&mut ());
    }
    let mut targets = session.world().nodes(0).to_vec();
    session.world().skin_targets(0, &mut targets);
    let ratio = |&n: &usize| targets[n].norm() / rest[n].norm();
    middle.iter().filter(|&&n| rest[n].norm() > 1e-6).map(ratio).collect()
}

/// Twist: b turns about the bar. Bend: b swings about z, round the joint.
const TWIST: [&str; 2] = ["[1, 0, 0]", "[0.01, 0, 0]"];
const BEND: [&str; 2] = ["[0, 0, 1]", "[0, 0.01, 0]"];

#[test]
fn targets_keep_their_distance_from_the_joint() {
    for [axis, position] in [TWIST, BEND] {
        for solver in ["exact", "two-step"] {
            let kept = kept(axis, position, "joint", solver);
            assert_eq!(kept.len(), 8);
            assert!(kept.iter().all(|r| (r - 1.0).abs() < 1e-12), "{solver}: {kept:?}");
        }
    }
}

/// By linear blending of a twist all keep cos 45°; of a bend those off the axis, and those on it all.
#[test]
fn linear_blending_narrows_a_twist_and_thins_a_bend() {
    let [axis, position] = TWIST;
    let twisted = kept(axis, position, "lbs", "exact");
    assert!(twisted.iter().all(|r| (r - 0.5_f64.sqrt()).abs() < 1e-12), "{twisted:?}");
    let [axis, position] = BEND;
    let bent = kept(axis, position, "lbs", "exact");
    let least = bent.iter().fold(1.0_f64, |a, &b| a.min(b));
    assert!((least - 0.5_f64.sqrt()).abs() < 1e-12, "{bent:?}");
}

#[test]
fn bones_without_a_joint_have_nothing_to_turn_about() {
    let text = bar("[1, 0, 0]", "").replace("PLACE", "[0.01, 0, 0]");
    assert!(open(&text, &[]).is_ok(), "linear blending of scripted bones needs none");
    let error = open(&text, &["soft.bar.skinning=joint"]).unwrap_err().to_string();
    assert!(error.contains("bar") && error.contains("no joint connects"), "{error}");
}

#[test]
fn another_word_is_refused_with_those_that_there_are() {
    let text = bar("[1, 0, 0]", BETWEEN).replace("PLACE", "[0.01, 0, 0]");
    let error = open(&text, &["soft.bar.skinning=dqs"]).unwrap_err().to_string();
    assert!(error.contains("dqs") && error.contains("lbs") && error.contains("joint"), "{error}");
}

/// A hand in flight whose joints were pushed: nothing from outside acts, and nothing damps.
const FLIGHT: &str = r#"version = 1
gravity = [0, 0, 0]
time_step = 0.001
duration = 1
[[hand]]
name = "hand"
preset = "paper"
driven = false
coupling_damping_time = 0
self_contact = false
bones = "none"
material = { mass_damping = 0, stiffness_damping = 0 }
[[load]]
kind = "force"
body = "hand/palm"
force = [0.2, -0.3, 0.1]
point = [0.02, 0.01, 0.03]
profile = { kind = "constant", until = 0.05 }
[[load]]
kind = "joint-torque"
joints = ["hand/*"]
torque = 0.01
profile = { kind = "random", seed = 8, interval = 0.02, until = 0.1 }
"#;

#[test]
fn a_hand_in_flight_keeps_its_momentum_and_gains_no_energy() {
    let fly = |skinning: &str| {
        let skinning = format!("hand.hand.skinning={skinning}");
        let mut session = open(FLIGHT, &[&skinning]).unwrap_or_else(|e| panic!("{e}"));
        let mut at = |time: f64| {
            while session.world().time() < time {
                session.step(&mut ());
            }
            let world = session.world();
            let [p, l] = world.momentum();
            (p, l, world.energy(&world.input()).total())
        };
        let (before, after) = (at(0.15), at(0.4));
        assert!(after.2 < before.2, "{skinning}: {} J became {} J", before.2, after.2);
        let drift = (after.0 - before.0).norm() / before.0.norm();
        (drift, (after.1 - before.1).norm() / before.1.norm())
    };
    let (joint, linear) = (fly("joint"), fly("lbs"));
    // The paper's springs are linearised once a step; what they lose is the same by either blending.
    assert!(joint.0 < 1e-4 && joint.0 < 2.0 * linear.0 + 1e-6, "{joint:?} against {linear:?}");
    assert!(joint.1 < 1e-2 && joint.1 < 2.0 * linear.1 + 1e-4, "{joint:?} against {linear:?}");
}
