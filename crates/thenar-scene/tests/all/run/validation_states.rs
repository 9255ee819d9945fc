//! Goal: scenes with joints start where theory says, and move as independent codes computed.
//! Method: planar and spatial chains of links under gravity, compared with reference states that
//! two other programs (complex-step Lagrangian with an 8th-order integrator, and a rigid-body
//! engine with fourth-order Runge-Kutta at 1e-5 s) agree on to all digits.

use std::path::Path;
use thenar_scene::session::Session;

fn load(text: &str, overrides: &[String]) -> Session {
    Session::from_text(text, Path::new("test.toml"), overrides).unwrap_or_else(|e| panic!("{e}"))
}

fn value(session: &mut Session, column: &str) -> f64 {
    let at = session.columns().iter().position(|c| c.name == column);
    let at = at.unwrap_or_else(|| panic!("no column {column}"));
    session.probe()[at]
}

fn run_to(session: &mut Session, time: f64) {
    while session.world().time() < time - 0.5 * session.world().time_step() {
        let report = session.step(&mut ());
        assert!(!report.non_finite);
    }
}

const PENDULUM: &str = include_str!("../../../scenes/finger-pendulum.toml");

#[test]
fn a_horizontal_finger_starts_horizontal() {
    let mut session = load(PENDULUM, &[]);
    // 45 + 26 + 24 mm along +x.
    assert!((value(&mut session, "tip.x") - 0.095).abs() < 1e-12);
    assert!(value(&mut session, "tip.y").abs() < 1e-12);
    assert!((value(&mut session, "knuckle.angle0") - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

/// Tip of the three-link finger at t = 0.05 s: (92.0327, -12.4193) mm. Backward Euler is first
/// order, so the error must halve with the step.
#[test]
fn the_three_link_finger_swings_as_computed_elsewhere() {
    let errors: Vec<f64> = [2e-4, 1e-4]
        .into_iter()
        .map(|h| {
            let mut session = load(PENDULUM, &[format!("time_step={h}")]);
            run_to(&mut session, 0.05);
            let dx = value(&mut session, "tip.x") - 0.0920327;
            let dy = value(&mut session, "tip.y") + 0.0124193;
            dx.hypot(dy)
        })
        .collect();
    assert!(errors[1] < 1e-4, "{errors:?}");
    assert!((errors[0] / errors[1] - 2.0).abs() < 0.2, "{errors:?}");
}

/// Universal joint (about y, then the new z) and two hinges about y, from angles and a rate; link
/// lengths 45, 26, 24 mm along +x, solid cylinders.
fn universal_chain() -> String {
    let cylinder = |m: f64, r: f64, l: f64| {
        let axial = 0.5 * m * r * r;
        let across = m * (3.0 * r * r + l * l) / 12.0;
        format!("[{axial:e}, {across:e}, {across:e}]")
    };
    let mut text = String::from("version = 1\ngravity = [0, 0, -9.81]\ntime_step = 1e-4\n");
    let mut x = 0.0;
    for (name, m, r, l) in
        [("a", 0.020, 0.009, 0.045), ("b", 0.010, 0.008, 0.026), ("c", 0.006, 0.007, 0.024)]
    {
        text += &format!(
            "[[rigid]]\nname = \"{name}\"\nmass = {m}\ninertia = {}\nposition = [{}, 0, 0]\n",
            cylinder(m, r, l),
            x + l / 2.0
        );
        x += l;
    }
    text += r#"
[[joint]]
name = "root"
kind = "universal"
child = "a"
anchor = [0, 0, 0]
axes = [[0, 1, 0], [0, 0, 1]]
angles = [0.0, 0.3]
rates = [0.0, 6.0]
[[joint]]
name = "ab"
kind = "hinge"
parent = "a"
child = "b"
anchor = [0.045, 0, 0]
axis = [0, 1, 0]
angles = [0.2]
[[joint]]
name = "bc"
kind = "hinge"
parent = "b"
child = "c"
anchor = [0.071, 0, 0]
axis = [0, 1, 0]
angles = [0.1]
[[probe]]
name = "root"
measure = "joint"
joint = "root"
[[probe]]
name = "ab"
measure = "joint"
joint = "ab"
[[probe]]
name = "bc"
measure = "joint"
joint = "bc"
[[probe]]
name = "tip"
measure = "point"
body = "c"
point = [0.012, 0, 0]
[[probe]]
name = "energy"
measure = "energy"
"#;
    text
}

#[test]
fn start_angles_place_a_spatial_chain() {
    let mut session = load(&universal_chain(), &[]);
    // By hand: in the plane turned by 0.3 about z, the links point 0, 0.2 and 0.3 below x.
    let reach = 0.045 + 0.026 * 0.2f64.cos() + 0.024 * 0.3f64.cos();
    let drop = 0.026 * 0.2f64.sin() + 0.024 * 0.3f64.sin();
    let tip = [reach * 0.3f64.cos(), reach * 0.3f64.sin(), -drop];
    for (axis, expected) in ["tip.x", "tip.y", "tip.z"].iter().zip(tip) {
        let got = value(&mut session, axis);
        assert!((got - expected).abs() < 1e-12, "{axis}: {got} {expected}");
    }
    for (column, expected) in
        [("root.angle0", 0.0), ("root.angle1", 0.3), ("ab.angle0", 0.2), ("bc.angle0", 0.1)]
    {
        assert!((value(&mut session, column) - expected).abs() < 1e-12, "{column}");
    }
    // The rate about z reaches every link.
    assert!((value(&mut session, "root.rate1") - 6.0).abs() < 1e-12);
    assert!(value(&mut session, "ab.rate0").abs() < 1e-12);
    // Reference energy of this start, gravity measured from the root.
    let energy = value(&mut session, "energy.total");
    assert!((energy - 8.28416e-4).abs() < 1e-9, "{energy}");
}

/// Reference at t = 0.05 s: q = (0.419923, 0.581679, -0.312877, 0.214467).
#[test]
fn the_spatial_chain_swings_as_computed_elsewhere() {
    let expected = [0.419923, 0.581679, -0.312877, 0.214467];
    let columns = ["root.angle0", "root.angle1", "ab.angle0", "bc.angle0"];
    let error = |h: f64| {
        let mut session = load(&universal_chain(), &[format!("time_step={h}")]);
        run_to(&mut session, 0.05);
        let off = |(c, e): (&&str, &f64)| (value(&mut session, c) - e).abs();
        columns.iter().zip(&expected).map(off).fold(0.0, f64::max)
    };
    let (coarse, fine) = (error(1e-4), error(5e-5));
    assert!(fine < 5e-3, "{fine}");
    assert!((coarse / fine - 2.0).abs() < 0.25, "{coarse} {fine}");
}
