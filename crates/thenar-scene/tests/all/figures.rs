//! Goal: figures of flesh on any bones stand, reach and grip as their scenes say, and keep their
//! momentum by themselves. Method: the shipped scenes, run whole; a free body thrashed by its own
//! motors; scenes in which something is wrong.

use crate::accuracy::Accuracy;
use std::path::Path;
use thenar_core::Vec3;
use thenar_scene::session::{Session, builtin};

fn shipped(name: &str, overrides: &[&str]) -> Session {
    let scene = builtin(name).unwrap_or_else(|| panic!("{name} comes along"));
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    Session::from_text(scene.text, Path::new(name), &overrides).unwrap_or_else(|e| panic!("{e}"))
}

fn rigid(session: &Session, name: &str) -> u32 {
    let rigids = &session.world().desc().rigids;
    rigids.iter().position(|rigid| rigid.name == name).unwrap_or_else(|| panic!("{name}")) as u32
}

fn joint(session: &Session, name: &str) -> u32 {
    let joints = &session.world().desc().joints;
    joints.iter().position(|joint| joint.name == name).unwrap_or_else(|| panic!("{name}")) as u32
}

fn run_to(session: &mut Session, time: f64) {
    let mut accuracy = Accuracy::default();
    while session.world().time() < time - 1e-9 {
        let report = session.step(&mut ());
        assert!(!report.non_finite && !report.fell_back, "{:?}", report);
        accuracy.note(&report);
    }
    accuracy.is_met();
}

/// Ten seconds on its own feet: once it has sunk into its soles, no bone moves by a millimetre.
#[test]
fn a_whole_body_stands() {
    let mut body = shipped("body", &[]);
    let bones = body.world().desc().rigids.len() as u32;
    let places = |body: &Session| -> Vec<Vec3> {
        (0..bones).map(|b| body.world().rigid_pose(b).position).collect()
    };
    let start = places(&body);
    run_to(&mut body, 2.0);
    let settled = places(&body);
    run_to(&mut body, 10.0);
    let end = places(&body);
    let most =
        |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let (sunk, drift) = (most(&start, &settled), most(&settled, &end));
    assert!(drift < 1e-3, "drifts by {drift} m, after it sank by {sunk} m");
    // Soles give way; nothing falls over.
    assert!(sunk < 0.06, "{sunk} m");
    // The floor bears its weight.
    let weight: f64 = body.world().contacts().iter().map(|contact| contact.force_W.y.abs()).sum();
    let mass: f64 = body.world().desc().rigids.iter().skip(1).map(|r| r.mass).sum::<f64>()
        + body.world().node_masses(0).iter().sum::<f64>();
    assert!((weight / (9.81 * mass) - 1.0).abs() < 0.01, "{weight} N under {mass} kg");
}

/// Momentum and spin, and the fastest bone's speed, of a body that thrashes without weight for 0.6
/// s.
fn thrashed(time_step: f64) -> ([Vec3; 2], f64) {
    let text = format!(
        r#"
version = 1
gravity = [0, 0, 0]
time_step = {time_step}
[[figure]]
name = "body"
model = "body"
tets = 800
joint = [{{ name = "*", stiffness = [60], damping = [3] }}]
key = [
  {{ time = 0.0, joints = {{ "*" = [0, 0, 0] }} }},
  {{ time = 0.3, joints = {{ "thigh_left" = [40, 0, 0], "upper_arm_right" = [0, 30, 50], "thorax" = [0, 25, 0] }} }},
  {{ time = 0.6, joints = {{ "thigh_left" = [-30, 10, 0], "upper_arm_right" = [20, 0, 0], "shank_right" = [-50, 0, 0] }} }},
]
"#
    );
    let mut body = Session::from_text(&text, Path::new("body.toml"), &[]).unwrap();
    run_to(&mut body, 0.6);
    let world = body.world();
    let speeds = (0..world.desc().rigids.len() as u32).map(|b| world.rigid_velocity(b)[0].norm());
    (world.momentum(), speeds.fold(0.0, f64::max))
}

/// As A8 of a hand: what motors do is internal. Momentum is kept; spin as far as the step is short:
/// implicit dampers of flesh and springs take it at the end of the step, so that what is off falls
/// with the step, and is a hundredth of what a limb of 7 kg has at that speed and half a metre.
#[test]
fn a_body_that_moves_its_limbs_keeps_its_momentum() {
    let [coarse, fine] = [0.005, 0.0025].map(thrashed);
    for ([linear, angular], fastest) in [coarse, fine] {
        assert!(fastest > 0.5, "nothing moves: {fastest} m/s");
        // 64 kg, to the tolerance of the solver.
        assert!(linear.norm() < 1e-5 * 64.0, "{linear:?} at {fastest} m/s");
        assert!(angular.norm() < 1e-2 * 7.0 * 0.5 * fastest, "{angular:?} at {fastest} m/s");
    }
    let [coarse, fine] = [coarse.0[1].norm(), fine.0[1].norm()];
    assert!(fine < 0.7 * coarse, "{fine} and {coarse} kg m²/s");
}

/// The ball is gripped, lifted 10 cm without slipping out, and put down again.
#[test]
fn a_soft_gripper_lifts_a_ball() {
    let mut session = shipped("gripper", &[]);
    let ball = rigid(&session, "ball");
    run_to(&mut session, 0.8);
    let high = |session: &Session| session.world().rigid_pose(ball).position.y;
    assert!((high(&session) - 0.02).abs() < 1e-3, "{}", high(&session));
    run_to(&mut session, 2.3);
    let lifted = high(&session);
    assert!((lifted - 0.12).abs() < 0.01, "lifted to {lifted} m");
    run_to(&mut session, 3.0);
    assert!((high(&session) - lifted).abs() < 1e-3, "creeps to {} m", high(&session));
    run_to(&mut session, 5.0);
    assert!((high(&session) - 0.02).abs() < 2e-3, "let go at {} m", high(&session));
}

/// Its palm meets the table, and its fingers close afterwards.
#[test]
fn a_forearm_presses_a_table_and_makes_a_fist() {
    let mut arm = shipped("forearm", &[]);
    run_to(&mut arm, 1.7);
    let pressed: f64 = arm.world().contacts().iter().map(|contact| contact.force_W.y.abs()).sum();
    assert!(pressed > 1.0, "{pressed} N");
    run_to(&mut arm, 3.8);
    let bent = |name: &str| {
        let [a, b] = arm.world().joint_angles(joint(&arm, name));
        a.to_degrees() + b.to_degrees()
    };
    for finger in ["index", "middle", "ring", "little"] {
        let whole = bent(&format!("arm/{finger}_mcp"))
            + bent(&format!("arm/{finger}_pip"))
            + bent(&format!("arm/{finger}_dip"));
        // 200° are wanted; bent flesh takes its part.
        assert!(whole > 140.0, "{finger}: {whole}");
    }
}

/// Joints go where keys say, in between by minimum jerk, and no motor gives more than it can.
#[test]
fn motors_follow_keys_and_know_their_limit() {
    let scene = |more: &str, after: &str| {
        let text = format!(
            "version = 1\ngravity = [0, 0, 0]\ntime_step = 0.002\n[[figure]]\nname = \"gripper\"\n\
             model = \"gripper\"\nflesh = 0.005\ntets = 300\nroot = \"fixed\"\n\
             joint = [{{ name = \"finger_*\", stiffness = [2], damping = [0.02] {more} }}]\n\
             key = [{{ time = 0.1, joints = {{ \"finger_1_knuckle\" = 0 }} }},\n\
             {{ time = 0.7, joints = {{ \"finger_1_knuckle\" = 40 }} }}]\n{after}"
        );
        Session::from_text(&text, Path::new("motor.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
    };
    let mut free = scene("", "");
    let knuckle = joint(&free, "gripper/finger_1_knuckle");
    run_to(&mut free, 0.4);
    let angle = |s: &Session| s.world().joint_angles(knuckle)[0].to_degrees();
    let half = angle(&free);
    run_to(&mut free, 1.2);
    let whole = angle(&free);
    // Halfway in time is halfway, and bent flesh takes off less than a fifth: it has 0.4 N m/rad at
    // most beside 2.
    assert!((half / whole - 0.5).abs() < 0.1, "{half} of {whole}");
    assert!((32.0..40.0).contains(&whole), "{whole}");
    // A load against the motor holds it where its torque and the load's balance, whatever its
    // stiffness; one that is larger than the largest torque drives it back to the end of its range.
    let loaded = |torque_max: f64, load: f64| {
        let more = format!(", torque_max = {torque_max}");
        let text = format!(
            "[[load]]\nkind = \"joint-torque\"\njoints = [\"gripper/finger_1_knuckle\"]\ntorque = {}\n",
            -load
        );
        let mut session = scene(&more, &text);
        run_to(&mut session, 1.6);
        angle(&session)
    };
    let strong = loaded(1.0, 0.1);
    // Beside the spring of 2 N m/rad the bent flesh holds too.
    let least = whole - (0.1_f64 / 2.0).to_degrees();
    assert!(strong > least && strong < whole - 0.3, "{strong} of {whole}");
    let weak = loaded(0.05, 0.1);
    assert!(weak < -15.0, "driven back to {weak}");
}

/// A motor at its limit gives that torque, no less where it moves with it and no more where it is
/// driven back: a free rod of known inertia speeds up by τ/I.
#[test]
fn a_motor_at_its_limit_gives_its_torque() {
    let text = r#"
version = 1
gravity = [0, 0, 0]
time_step = 0.002
[[figure]]
name = "gripper"
model = "gripper"
flesh = 0.005
tets = 300
root = "fixed"
joint = [{ name = "finger_*", stiffness = [200], damping = [0.5], torque_max = 0.02 }]
key = [{ time = 0, joints = { "finger_1_knuckle" = 0 } }, { time = 0.01, joints = { "finger_1_knuckle" = 60 } }]
"#;
    let mut session = Session::from_text(text, Path::new("limit.toml"), &[]).unwrap();
    let knuckle = joint(&session, "gripper/finger_1_knuckle");
    run_to(&mut session, 0.012);
    let mut torques = Vec::new();
    while session.world().joint_angles(knuckle)[0] < 0.5 && session.world().time() < 0.5 {
        let report = session.step(&mut ());
        assert!(!report.non_finite);
        let input = session.input();
        let target = input.joint_targets[knuckle as usize].unwrap();
        torques.push((target.gains[0], input.joint_torques[knuckle as usize][0]));
    }
    assert!(torques.len() > 3, "{torques:?}");
    assert!(torques.iter().all(|t| *t == (0.0, 0.02)), "{torques:?}");
}

/// A figure starts as its keys and its script say at time 0.
#[test]
fn a_figure_starts_where_its_keys_begin() {
    let text = r#"
version = 1
gravity = [0, 0, 0]
[[figure]]
name = "arm"
model = "forearm"
flesh = 0.004
root = "scripted"
joint = [{ name = "palm", stiffness = [5, 5], damping = [0.1, 0.1] }]
key = [{ time = 0, position = [0.1, 0.5, 0], rotation = { axis = [0, 1, 0], angle_deg = 90 }, joints = { "palm" = [30, 0], "index_distal" = 40 } }]
"#;
    let mut arm = Session::from_text(text, Path::new("arm.toml"), &[]).unwrap();
    let (wrist, tip) = (joint(&arm, "arm/wrist_deviation"), joint(&arm, "arm/index_dip"));
    let angle = |arm: &Session, j: u32| arm.world().joint_angles(j)[0].to_degrees();
    assert!((angle(&arm, wrist) - 30.0).abs() < 1e-6 && (angle(&arm, tip) - 40.0).abs() < 1e-6);
    // Fingers that pointed along x point along -z now.
    let at = |name: &str| arm.world().rigid_pose(rigid(&arm, name)).position;
    let reach = at("arm/middle_distal") - at("arm/forearm");
    assert!(reach.z < -0.2 && reach.x.abs() < 0.05, "{reach:?}");
    // Flesh is where bones are: a step later nothing has leapt.
    let before = arm.world().nodes(0).to_vec();
    run_to(&mut arm, 0.01);
    let leaps = arm.world().nodes(0).iter().zip(&before).map(|(a, b)| (a - b).norm());
    let mean = leaps.sum::<f64>() / before.len() as f64;
    // In creases free flesh moves by as much as an element, 10 mm; all of it is where it should be.
    assert!(mean < 5e-4, "{mean} m");
    assert_eq!(arm.report().inverted_tets, 0);
}

#[test]
fn what_is_wrong_with_a_figure_is_said() {
    let figure = |lines: &str| {
        let text = format!(
            "version = 1\n[[figure]]\nname = \"gripper\"\nmodel = \"gripper\"\ntets = 300\n{lines}\n"
        );
        match Session::from_text(&text, Path::new("wrong.toml"), &[]) {
            Ok(_) => panic!("accepted: {lines}"),
            Err(error) => error.to_string(),
        }
    };
    for (lines, parts) in [
        ("", &["how thick"][..]),
        ("flesh = -1", &["flesh"]),
        ("flesh = 0.005\njoint = [{ name = \"elbow\" }]", &["elbow", "finger_1_knuckle"]),
        ("flesh = 0.005\nkey = [{ time = 0, joints = { elbow = 3 } }]", &["elbow", "finger_1"]),
        ("flesh = 0.005\nkey = [{ time = 0, joints = { finger_1_knuckle = 3 } }]", &["no spring"]),
        (
            "flesh = 0.005\nkey = [{ time = 0, joints = { finger_1_knuckle = [1, 2] } }]",
            &["Hinge", "1 angles"],
        ),
        ("flesh = 0.005\nkey = [{ time = 0, position = [0, 1, 0] }]", &["scripted"]),
        ("flesh = 0.005\nkey = [{ time = 1 }, { time = 1 }]", &["later"]),
        ("flesh = 0.005\nroot = \"loose\"", &["loose", "free"]),
        (
            "flesh = 0.005\njoint = [{ name = \"finger_*\", stiffness = [1] }]\n\
             key = [{ time = 0, joints = { finger_1_knuckle = 500 } }]",
            &["500", "-20", "70"],
        ),
        (
            "flesh = 0.005\njoint = [{ name = \"finger_*\", stiffness = [1, 2] }]",
            &["figure[0].joint[0]"],
        ),
        ("flesh = 0.005\njoint = [{ name = \"finger_*\", axes = [[1, 0, 0]] }]", &["kind"]),
    ] {
        let error = figure(lines);
        assert!(parts.iter().all(|part| error.contains(part)), "{lines}: {error}");
    }
}
