//! Goal: building tells how much the joints of a hand resist, and gives springs what flesh leaves
//! of what people's joints have. Method: hands of both kinds of coupling are built with both kinds
//! of springs, and their reports compared with what was asked for and with each other.

use thenar_core::model::Side;
use thenar_rig::hand::{
    HandOptions, JointStiffness, Size, Springs, asset, build_hand, build_hand_with_report,
    joint_stiffness,
};

fn flexion<'a>(rows: &'a [JointStiffness], joint: &str) -> &'a JointStiffness {
    rows.iter().find(|row| row.joint == joint && row.axis == "flexion").expect("a row")
}

/// Springs that are fixed are those of the table, whether the flesh is measured or not; the paper's
/// hand keeps them.
#[test]
fn fixed_springs_do_not_depend_on_the_flesh() {
    let options = HandOptions { render_triangles: 200, ..HandOptions::paper() };
    let hand = build_hand(asset(Side::Right), &options).unwrap();
    let rows = joint_stiffness(&hand).unwrap();
    let scale = (hand.length / 0.19).powi(3);
    // Tendons and capsule alone: 0.012 N m/rad at a knuckle, 0.008 and 0.004 beyond it.
    for (joint, spring) in [("index-mcp", 0.012), ("ring-pip", 0.008), ("little-dip", 0.004)] {
        let row = flexion(&rows, joint);
        assert!((row.spring / (spring * scale) - 1.0).abs() < 1e-12, "{row:?}");
        assert!((row.damping / (0.05 * row.spring) - 1.0).abs() < 1e-12, "{row:?}");
    }
    // What was found when the knuckle was first measured: many times as stiff as people's.
    assert!(flexion(&rows, "index-mcp").total > 0.1, "{rows:?}");
    assert_eq!(flexion(&rows, "index-mcp").met(), Some(false));
    assert_eq!(rows.len(), 20);
}

/// All joints that flesh leaves room for are as stiff as wanted, to three digits, and those that it
/// does not have no spring; wanted stiffness goes with the cube of the length.
#[test]
fn springs_that_are_the_rest_make_joints_as_stiff_as_wanted() {
    for (side, length) in [(Side::Left, 0.17), (Side::Right, 0.2)] {
        let options = HandOptions { size: Size::Length(length), ..HandOptions::touch() };
        let (hand, report) = build_hand_with_report(asset(side), &options).unwrap();
        let scale = (hand.length / 0.19).powi(3);
        for row in &report.joints {
            let what = format!("{side:?}, {length} m: {row:?}");
            assert!(row.spring >= 0.0 && row.damping > 0.0 && row.total > 0.0, "{what}");
            let met = (row.total / row.wanted - 1.0).abs() < 0.01;
            assert!(met || (row.spring == 0.0 && row.total > row.wanted), "{what}");
        }
        for finger in ["index", "middle", "ring", "little"] {
            let knuckle = flexion(&report.joints, &format!("{finger}-mcp"));
            assert!((knuckle.total / (0.039 * scale) - 1.0).abs() < 0.01, "{knuckle:?}");
            assert_eq!(knuckle.met(), Some(true), "{knuckle:?}");
            let middle = flexion(&report.joints, &format!("{finger}-pip"));
            assert!((middle.total / (0.0286 * scale) - 1.0).abs() < 0.01, "{middle:?}");
        }
    }
}

/// A hand that is built again has the same springs to the bit, and any coupling can have the rest.
#[test]
fn the_rest_is_the_same_each_time_and_for_any_coupling() {
    let options =
        HandOptions { springs: Springs::Rest, render_triangles: 200, ..HandOptions::paper() };
    let (hand, report) = build_hand_with_report(asset(Side::Left), &options).unwrap();
    let again = build_hand(asset(Side::Left), &options).unwrap();
    for (a, b) in hand.joints.iter().zip(&again.joints) {
        assert_eq!(a.axes, b.axes, "{}", a.name);
    }
    // Flesh that is held to the skin leaves knuckles nothing; the last joint of a finger gets what
    // is left.
    assert_eq!(flexion(&report.joints, "index-mcp").spring, 0.0);
    assert!(flexion(&report.joints, "index-dip").spring > 0.0);
}
