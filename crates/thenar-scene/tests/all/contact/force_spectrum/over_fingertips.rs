//! Things with round and with sharp parts, drawn over a fingertip of either hand.

use super::{BALL, Case, check_spectrum};
use thenar_testing::one_in;

/// Name, shape and start rotation (TOML), and from the centre to the point that touches first
/// \[m\].
type Thing = (&'static str, &'static str, &'static str, f64);

const UPRIGHT: &str = "{ axis = [0, 0, 1], angle = 0 }";

const ROUND: [Thing; 6] = [
    ("ball of 6 mm", r#"{ kind = "sphere", radius = 0.006 }"#, UPRIGHT, 0.006),
    ("ball of 20 mm", r#"{ kind = "sphere", radius = 0.02 }"#, UPRIGHT, 0.02),
    (
        "pebble",
        r#"{ kind = "ellipsoid", size = [0.03, 0.012, 0.02] }"#,
        "{ axis = [0, 1, 0], angle_deg = 20 }",
        0.006,
    ),
    ("egg on its tip", r#"{ kind = "ellipsoid", size = [0.012, 0.03, 0.02] }"#, UPRIGHT, 0.015),
    (
        "needle",
        r#"{ kind = "capsule", radius = 0.003, length = 0.02 }"#,
        "{ axis = [1, 0, 0], angle_deg = 90 }",
        0.003,
    ),
    (
        "leaning pill",
        r#"{ kind = "capsule", radius = 0.005, length = 0.01 }"#,
        "{ axis = [0, 0, 1], angle_deg = 40 }",
        0.005 + 0.005 * 0.766_044,
    ),
];

const SHARP: [Thing; 9] = [
    ("cone on its tip", r#"{ kind = "cone", radius = 0.01, height = 0.02 }"#, UPRIGHT, 0.015),
    (
        "cone on its rim",
        r#"{ kind = "cone", radius = 0.01, height = 0.02 }"#,
        "{ axis = [0, 0, 1], angle_deg = 135 }",
        0.010_606_6,
    ),
    (
        "plate on its corner",
        r#"{ kind = "box", size = [0.03, 0.004, 0.03] }"#,
        "{ axis = [-1, 0, 1], angle_deg = 84.612 }",
        0.021_307,
    ),
    (
        "cube on its corner",
        r#"{ kind = "box", size = [0.02, 0.02, 0.02] }"#,
        "{ axis = [-1, 0, 1], angle_deg = 54.7356 }",
        0.017_320_5,
    ),
    (
        "box on its edge, along the finger",
        r#"{ kind = "box", size = [0.02, 0.02, 0.06] }"#,
        "{ axis = [0, 0, 1], angle_deg = 45 }",
        0.014_142,
    ),
    (
        "box on its edge, across the finger",
        r#"{ kind = "box", size = [0.06, 0.02, 0.02] }"#,
        "{ axis = [1, 0, 0], angle_deg = 45 }",
        0.014_142,
    ),
    (
        "box on its edge, askew",
        r#"{ kind = "box", size = [0.015, 0.015, 0.03] }"#,
        "{ quaternion = [0.04, 0.09657, 0.3806, 0.91881] }",
        0.011_6,
    ),
    (
        "cylinder on its rim",
        r#"{ kind = "cylinder", radius = 0.01, length = 0.02 }"#,
        "{ axis = [0, 0, 1], angle_deg = 45 }",
        0.014_142_1,
    ),
    (
        "cylinder on its side",
        r#"{ kind = "cylinder", radius = 0.006, length = 0.03 }"#,
        "{ axis = [1, 0, 0], angle_deg = 90 }",
        0.006,
    ),
];

/// Every thing over both hands, along and across, with friction and without, so deep \[m\].
fn drawn(
    things: &[Thing],
    ways: [[f64; 3]; 2],
    depths: &[f64],
    speed: f64,
) -> Vec<(String, Case<'static>)> {
    let mut cases = Vec::new();
    for &(name, shape, rotation, reach) in things {
        for hand in ["touch", "paper"] {
            for way in ways {
                for friction in [0.6, 0.0] {
                    for &depth in depths {
                        let name = format!("{name}, {hand}, {way:?}, {friction}, {depth}");
                        let over = Some(hand);
                        let case = Case {
                            shape,
                            rotation,
                            reach,
                            depth,
                            way,
                            friction,
                            over,
                            speed,
                            ..BALL
                        };
                        cases.push((name, case));
                    }
                }
            }
        }
    }
    cases
}

/// A fixed share of the cases.
fn check_share(cases: Vec<(String, Case<'static>)>) {
    for (name, case) in one_in(11, cases) {
        check_spectrum(&Case { name: &name, ..case });
    }
}

/// A fixed share runs here; all of them:
/// `THENAR_CASES=all cargo test -p thenar-scene --test all round_things -- --nocapture`.
#[test]
fn round_things_are_drawn_over_a_fingertip() {
    let ways = [[0.0, 0.0, 0.006], [0.004, 0.0, 0.001]];
    check_share(drawn(&ROUND, ways, &[0.0015, 0.001], BALL.speed));
}

/// At 10 mm/s: a corner that passes from one flat triangle of the skin to the next turns its path
/// there, and what that changes falls with the speed. All of them:
/// `THENAR_CASES=all cargo test -p thenar-scene --test all sharp_things -- --nocapture`.
#[test]
fn sharp_things_are_drawn_over_a_fingertip() {
    let ways = [[0.0, 0.0, 0.004], [0.003, 0.0, 0.001]];
    check_share(drawn(&SHARP, ways, &[0.0015], 0.01));
}
