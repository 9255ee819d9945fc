//! Goal: the joints of the hand for touch resist as those of the living do, whatever the hand's
//! side and length, and scenes say otherwise where they want to. Method: a torque on one knuckle
//! after the other, drives off, and the angle at rest; a finger that is bent by a torque and let
//! go; tables of joints, read back from the world.

use std::path::Path;
use thenar_core::model::{AngleLimit, Side};
use thenar_rig::hand::{HandOptions, asset, build_hand_with_report};
use thenar_scene::session::Session;

const FINGERS: [&str; 4] = ["index", "middle", "ring", "little"];
/// Torque on a knuckle \[N m\], and how long it acts on each \[s\]. Flesh without memory is at rest
/// after a second and as stiff then as after ten.
const TORQUE: f64 = 0.01;
const HELD: f64 = 2.5;

fn open(text: &str) -> Result<Session, String> {
    Session::from_text(text, Path::new("joints.toml"), &[]).map_err(|e| e.to_string())
}

/// A hand for touch whose palm is held and whose fingers are not driven.
fn limp(hand: &str, h: f64, seconds: f64, more: &str) -> Session {
    let text = format!(
        "version = 1\ngravity = [0, 0, 0]\ntime_step = {h}\nduration = {seconds}\n\
         [[hand]]\nname = \"hand\"\npreset = \"touch\"\nself_contact = false\n{hand}\n\
         bone_drive = {{ stiffness = 0, damping = 0 }}\n\
         palm_drive = {{ stiffness = 1e6, damping = 1e3, angular_stiffness = 1e4, angular_damping = 10 }}\n\
         {more}"
    );
    open(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// Flexion of a knuckle \[rad\].
fn flexion(session: &Session, finger: &str) -> f64 {
    let name = format!("hand/{finger}-mcp");
    let joints = &session.world().desc().joints;
    let j = joints.iter().position(|joint| joint.name == name).expect("a knuckle");
    session.world().joint_angles(j as u32)[1]
}

/// Flexion of each knuckle \[rad\] by a torque on it alone.
fn knuckles(hand: &str, torque: f64) -> [f64; 4] {
    let loads: String = (FINGERS.iter().enumerate())
        .map(|(i, finger)| {
            let from = HELD * i as f64;
            format!(
                "[[load]]\nkind = \"joint-torque\"\njoints = [\"hand/{finger}-mcp\"]\ntorque = {}\n\
                 profile = {{ kind = \"ramp\", from = {from}, full = {}, until = {} }}\n",
                torque,
                from + 0.3,
                from + HELD
            )
        })
        .collect();
    let h = 0.05;
    let mut session = limp(hand, h, HELD * 4.0, &loads);
    let rest = FINGERS.map(|finger| flexion(&session, finger));
    std::array::from_fn(|i| {
        for _ in 0..(HELD / h) as usize {
            let report = session.step(&mut ());
            assert!(!report.non_finite && report.inverted_tets <= 10, "{report:?}");
        }
        flexion(&session, FINGERS[i]) - rest[i]
    })
}

/// People's knuckles: 0.02 to 0.06 N m/rad. Those of hands of 170 to 200 mm all lie there.
#[test]
fn knuckles_are_as_stiff_as_those_of_people() {
    for hand in ["model = \"right\"", "model = \"left\"", "length = 0.17", "length = 0.2"] {
        let measured = knuckles(hand, -TORQUE).map(|turned| -TORQUE / turned);
        println!("{hand}: {measured:.4?} N m/rad");
        for (finger, stiffness) in FINGERS.iter().zip(measured) {
            assert!((0.02..0.06).contains(&stiffness), "{hand}, {finger}: {stiffness} N m/rad");
        }
    }
}

/// What is reported of a built hand is what torques to both sides meet, to what flesh that is bent
/// otherwise resists otherwise.
#[test]
fn what_is_reported_is_what_a_torque_meets() {
    let (_, report) =
        build_hand_with_report(asset(Side::Right), &HandOptions::touch()).expect("a hand");
    let [bent, straightened] =
        [TORQUE, -TORQUE].map(|torque| knuckles("model = \"right\"", torque));
    for (i, finger) in FINGERS.iter().enumerate() {
        let measured = 2.0 * TORQUE / (bent[i] - straightened[i]);
        println!(
            "{finger}: {measured:.4}, bent {:.4}, straightened {:.4}",
            TORQUE / bent[i],
            -TORQUE / straightened[i]
        );
        let name = format!("{finger}-mcp");
        let row = report.joints.iter().find(|row| row.joint == name && row.axis == "flexion");
        let row = row.expect("a row for each knuckle");
        assert!((measured / row.total - 1.0).abs() < 0.1, "{measured} N m/rad, {row:?}");
        assert!((row.flesh + row.spring - row.total).abs() < 1e-12, "{row:?}");
        assert!(row.spring >= 0.0 && row.flesh > 0.0 && row.flesh <= row.flesh_held, "{row:?}");
        assert_eq!(row.met(), Some(true), "{row:?}");
    }
}

/// A finger that is bent by about 30° and let go passes its rest once at most, by a tenth of the
/// way or less.
#[test]
fn a_released_finger_hardly_swings() {
    for h in [0.005, 1.0 / 60.0] {
        let load = "[[load]]\nkind = \"joint-torque\"\njoints = [\"hand/index-mcp\"]\ntorque = 0.015\n\
                    profile = { kind = \"ramp\", full = 0.5, until = 1 }\n";
        let mut session = limp("", h, 2.0, load);
        let rest = flexion(&session, "index");
        let mut way = Vec::new();
        for _ in 0..session.steps_wanted() {
            session.step(&mut ());
            if session.world().time() >= 1.0 {
                way.push(flexion(&session, "index") - rest);
            }
        }
        let bent = way[0];
        assert!(bent.to_degrees() > 20.0 && bent.to_degrees() < 40.0, "{bent} rad");
        // Swings beyond the rest on either side, as parts of the way.
        let past = way.iter().copied().fold(f64::INFINITY, f64::min) / bent;
        let lowest = way.iter().position(|x| x / bent == past).expect("the lowest");
        let back = way[lowest..].iter().copied().fold(0.0, f64::max) / bent;
        println!("{h} s: bent by {:.1}°, past {:.3}, back {back:.3}", bent.to_degrees(), -past);
        assert!(past > -0.1 && back < 0.02, "{h} s: {past} of the way past, {back} back");
        assert!(way.last().expect("steps").abs() < 0.02 * bent, "{h} s: at rest");
    }
}

/// A skeleton whose index finger a scene changes.
fn changed(joints: &str, more: &str) -> Result<Session, String> {
    open(&format!(
        "version = 1\ngravity = [0, 0, 0]\ntime_step = 0.005\nduration = 2\n\
         [[hand]]\nname = \"hand\"\nflesh = false\n\
         bone_drive = {{ stiffness = 0, damping = 0 }}\n{joints}\n{more}"
    ))
}

#[test]
fn scenes_change_single_joints() {
    let session = changed(
        "[[hand.joint]]\nname = \"index-*\"\nflexion = { stiffness = 0.1, damping = 0.002 }\n\
         [[hand.joint]]\nname = \"index-proximal\"\n\
         flexion = { range_deg = [-10, 40], rest_deg = 20 }\nabduction = { stiffness = 0.3 }\n",
        "",
    )
    .unwrap();
    let plain = changed("", "").unwrap();
    for (joint, was) in session.world().desc().joints.iter().zip(&plain.world().desc().joints) {
        let flexion = joint.kind.angles() - 1;
        let (axis, before) = (&joint.axes[flexion], &was.axes[flexion]);
        if !joint.name.starts_with("hand/index-") {
            assert_eq!(joint.axes, was.axes, "{}", joint.name);
            continue;
        }
        assert_eq!((axis.stiffness, axis.damping), (0.1, 0.002), "{}", joint.name);
        if joint.name == "hand/index-mcp" {
            let limit = AngleLimit { min: (-10f64).to_radians(), max: 40f64.to_radians() };
            assert_eq!((axis.limit, axis.rest_angle), (Some(limit), 20f64.to_radians()));
            assert_eq!(joint.axes[0].stiffness, 0.3);
            assert_eq!(joint.axes[0].limit, was.axes[0].limit);
        } else {
            assert_eq!((axis.limit, axis.rest_angle), (before.limit, before.rest_angle));
        }
    }
}

/// A finger comes to rest where its spring is relaxed, and a torque does not take it past its
/// range.
#[test]
fn changed_joints_act() {
    let at_end = |more: &str| {
        let joint = "[[hand.joint]]\nname = \"index-mcp\"\n\
                     flexion = { range_deg = [-10, 40], stiffness = 0.04, rest_deg = 25, damping = 2e-3 }\n";
        let mut session = changed(joint, more).unwrap();
        (0..session.steps_wanted()).for_each(|_| _ = session.step(&mut ()));
        flexion(&session, "index").to_degrees()
    };
    let rest = at_end("");
    assert!((rest - 25.0).abs() < 0.1, "{rest}°");
    let load = "[[load]]\nkind = \"joint-torque\"\njoints = [\"hand/index-mcp\"]\ntorque = 0.2\n";
    let pressed = at_end(load);
    assert!((pressed - 40.0).abs() < 0.1, "{pressed}°");
}

#[test]
fn what_makes_no_sense_is_refused_by_key_and_reason() {
    let refused = |joint: &str| {
        let text = format!("[[hand.joint]]\n{joint}\n");
        changed(&text, "").err().unwrap_or_else(|| panic!("{joint} was taken"))
    };
    let unknown = refused("name = \"toe\"");
    for part in
        ["joints.toml:", "hand[0].joint[0].name", "no joint \"toe\"", "index-pip", "little-dip"]
    {
        assert!(unknown.contains(part), "{unknown}");
    }
    for (joint, key, reason) in [
        ("name = \"index-pip\"\nabduction = { stiffness = 1 }", "abduction", "no abduction"),
        ("name = \"index-mcp\"\nflexion = { range_deg = [40, 20] }", "range_deg", "[40, 20]"),
        ("name = \"index-mcp\"\nflexion = { range_deg = [50, 80] }", "range_deg", "rest pose"),
        ("name = \"index-mcp\"\nflexion = { range_deg = [-200, 80] }", "range_deg", "180"),
        ("name = \"index-mcp\"\nflexion = { stiffness = -1 }", "stiffness", "-1"),
        ("name = \"index-mcp\"\nflexion = { damping = nan }", "damping", "NaN"),
    ] {
        let error = refused(joint);
        assert!(error.contains(key) && error.contains(reason), "{joint}: {error}");
    }
}
