//! Goal: probes of touch give what the contact read-out holds, and pairs take friction by load.
//! Method: small scenes against statics and Coulomb's law, and probes against each other.

use std::path::Path;
use thenar_scene::session::Session;

fn try_load(text: &str) -> Result<Session, String> {
    let text = format!("version = 1\n{text}");
    Session::from_text(&text, Path::new("test.toml"), &[]).map_err(|e| e.to_string())
}

fn load(text: &str) -> Session {
    try_load(text).unwrap_or_else(|e| panic!("{e}"))
}

fn value(session: &mut Session, column: &str) -> f64 {
    let at = session.columns().iter().position(|c| c.name == column);
    let at = at.unwrap_or_else(|| panic!("no column {column}"));
    session.probe()[at]
}

/// The sum of all columns whose names start so.
fn total(session: &mut Session, start: &str, f: impl Fn(f64) -> f64) -> f64 {
    let wanted: Vec<bool> = session.columns().iter().map(|c| c.name.starts_with(start)).collect();
    let values = session.probe().iter().zip(wanted);
    values.filter(|(_, wanted)| *wanted).map(|(v, _)| f(*v)).sum()
}

fn run(session: &mut Session) {
    for _ in 0..session.steps_wanted() {
        assert!(!session.step(&mut ()).non_finite);
    }
}

#[track_caller]
fn near(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "got {got}, expected {expected} ± {tolerance}");
}

/// A pad on a scripted bone, pressed on a plate: skin, bone, plate and vertices tell of one force.
#[test]
fn the_same_force_acts_on_skin_bone_and_plate() {
    let text = include_str!("../../../../../docs/scene.md");
    let example =
        text.split("```toml\n").find(|t| t.contains("a \"bone\"") || t.contains("core_radius"));
    let example = example.unwrap().split("```").next().unwrap().replacen("version = 1", "", 1);
    let mut session = load(&format!(
        "{example}
        [[probe]]
        name = \"on plate\"
        measure = \"contact-force\"
        body = \"plate\"
        [[probe]]
        name = \"p\"
        measure = \"vertices\"
        body = \"pad\"
        [[probe]]
        name = \"a\"
        measure = \"vertices\"
        body = \"pad\"
        quantity = \"area\"
        [[probe]]
        name = \"f\"
        measure = \"vertices\"
        body = \"pad\"
        quantity = \"force\"
        [[probe]]
        name = \"s\"
        measure = \"vertices\"
        body = \"pad\"
        quantity = \"state\""
    ));
    run(&mut session);
    let force = value(&mut session, "plate.normal");
    assert!(force > 0.02, "{force} N");
    near(value(&mut session, "on plate.fy"), -force, 1e-9);
    // At rest the bone bears what the plate gives.
    near(value(&mut session, "bone.fy"), force, 1e-3 * force);
    let areas: Vec<f64> = {
        let start = session.columns().iter().position(|c| c.name == "a.0").unwrap();
        let count = session.world().collision_vertices(0).len();
        session.probe()[start..start + count].to_vec()
    };
    let first = session.columns().iter().position(|c| c.name == "p.0").unwrap();
    assert_eq!(session.columns()[first].unit, "Pa");
    let pressures = session.probe()[first..first + areas.len()].to_vec();
    let integral: f64 = pressures.iter().zip(&areas).map(|(p, a)| p * a).sum();
    near(integral, force, 1e-9);
    near(
        pressures.iter().copied().fold(0.0, f64::max),
        value(&mut session, "plate.pressure_max"),
        1e-6,
    );
    near(total(&mut session, "f.", |x| x), force, 1e-9); // no friction: only y
    // One normal, no friction: the sum of sizes is the resultant. Mean pressure is force over area.
    near(value(&mut session, "plate.normal_sum"), force, 1e-9);
    near(value(&mut session, "plate.shear_sum"), 0.0, 1e-12);
    let area = value(&mut session, "plate.area");
    let mean = value(&mut session, "plate.pressure_mean");
    near(mean * area, force, 1e-9);
    assert!(
        area > 1e-6 && mean < value(&mut session, "plate.pressure_max"),
        "{area} m², {mean} Pa"
    );
    // Without friction all that presses slides.
    let pressed = pressures.iter().filter(|p| **p > 0.0).count();
    near(total(&mut session, "s.", |x| x), 2.0 * pressed as f64, 0.0);
    near(value(&mut session, "plate.state"), 2.0, 0.0);
}

/// A hand lowered on a plate: its fingers and palm together bear what the plate does.
#[test]
fn fingers_and_palm_bear_what_the_plate_does() {
    let fingers = ["palm", "thumb", "index", "middle", "ring", "little"];
    let hand = "gravity = [0, 0, 0]
        duration = 0.05
        [[hand]]
        preset = \"paper\"
        name = \"hand\"";
    let lowest = |x: &[thenar_core::Vec3]| x.iter().map(|x| x.y).fold(f64::INFINITY, f64::min);
    let height = lowest(load(hand).world().collision_vertices(0)) + 0.0015;
    let probes: String = fingers
        .iter()
        .map(|f| {
            format!("\n[[probe]]\nname = \"{f}\"\nmeasure = \"finger\"\nhand = \"hand\"\nfinger = \"{f}\"")
        })
        .collect();
    let mut session = load(&format!(
        "{hand}
        [[rigid]]
        name = \"plate\"
        shape = {{ kind = \"plane\" }}
        motion = \"fixed\"
        position = [0, {height}, 0]
        [[probe]]
        name = \"c\"
        measure = \"contact\"
        bodies = [\"hand\", \"plate\"]
        [[probe]]
        name = \"old\"
        measure = \"fingers\"
        hand = \"hand\"
        {probes}"
    ));
    run(&mut session);
    let force = value(&mut session, "c.fy");
    assert!(force > 0.01, "{force} N");
    let sum: f64 = fingers.iter().map(|f| value(&mut session, &format!("{f}.fy"))).sum();
    near(sum, force, 1e-10);
    let mut touching = 0;
    for f in &fingers[1..] {
        let normal = value(&mut session, &format!("{f}.normal"));
        near(normal, value(&mut session, &format!("old.{f}.normal")), 1e-10);
        near(
            value(&mut session, &format!("{f}.shear")),
            value(&mut session, &format!("old.{f}.shear")),
            1e-10,
        );
        let [area, mean] =
            ["area", "pressure_mean"].map(|figure| value(&mut session, &format!("{f}.{figure}")));
        near(mean * area, normal, 1e-9);
        near(mean, value(&mut session, &format!("old.{f}.pressure")), 1e-6 * mean);
        touching += u32::from(normal > 0.0);
        assert_eq!(value(&mut session, &format!("{f}.state")) > 0.0, normal > 0.0);
    }
    assert!(touching > 0);
    let [normal, shear] = ["normal", "shear_sum"].map(|figure| {
        let column = |f: &&str| value(&mut session, &format!("{f}.{figure}"));
        fingers.iter().map(column).sum::<f64>()
    });
    near(value(&mut session, "c.normal_sum"), normal, 1e-10);
    near(value(&mut session, "c.shear_sum"), shear, 1e-10);
    // Sizes are no less than the size of the sum.
    assert!(shear >= value(&mut session, "c.shear") - 1e-12, "{shear} N");
    let bones: f64 = fingers.iter().map(|f| value(&mut session, &format!("{f}.bone_fy"))).sum();
    near(bones, force, 0.2 * force); // still settling
}

/// A block pulled on a plane by a load between two of the table's points.
#[test]
fn a_pair_takes_friction_by_load() {
    for (kind, pull, slips) in [
        ("monolithic", 2.0, false),
        ("monolithic", 3.2, true),
        ("two-step", 2.0, false),
        ("two-step", 3.2, true),
    ] {
        let mut session = load(&format!(
            "duration = 0.3
            gravity = [0, -10, 0]
            solver = {{ kind = \"{kind}\" }}
            [[rigid]]
            name = \"floor\"
            shape = {{ kind = \"plane\" }}
            motion = \"fixed\"
            [[rigid]]
            name = \"box\"
            shape = {{ kind = \"box\", size = [0.08, 0.02, 0.08] }}
            mass = 0.5
            position = [0, 0.01, 0]
            [[pair]]
            bodies = [\"box\", \"floor\"]
            friction_by_load = [[1, 0.7], [9, 0.54], [20, 0.4]]
            [[load]]
            kind = \"force\"
            body = \"box\"
            force = [{pull}, 0, 0]
            [[probe]]
            name = \"box\"
            measure = \"velocity\"
            body = \"box\"
            [[probe]]
            name = \"c\"
            measure = \"contact\"
            bodies = [\"box\", \"floor\"]"
        ));
        run(&mut session);
        // At 5 N the coefficient is 0.62.
        let speed = if slips { 0.3 * (pull - 3.1) / 0.5 } else { 0.0 };
        near(value(&mut session, "box.vx"), speed, 2e-3);
        near(value(&mut session, "c.shear"), if slips { 3.1 } else { pull }, 0.031);
        // Well below the limit it holds (near it, single corners may be at theirs).
        near(value(&mut session, "c.state"), if slips { 2.0 } else { 1.0 }, 0.0);
    }
}

/// A block drawn over a plane. At the tables' rows it bears what the power law of the measurements
/// says, to 1 %; between them straight lines lie above the law by up to 3 %, between 2 and 5 N.
#[test]
fn skin_on_a_material_drags_by_its_load() {
    let p = 0.54_f64.ln() / 20_f64.ln();
    for (name, at_one) in [("skin-on-aluminium", 0.832), ("skin-on-rubber", 1.248)] {
        for load in [0.5, 1.0, 3.0, 8.0, 20.0] {
            let mut session = drag(name, load);
            run(&mut session);
            let normal = value(&mut session, "contact.normal_sum");
            near(normal, load, 1e-3 * load);
            let mu = value(&mut session, "contact.shear") / normal;
            let between = [3.0, 8.0].contains(&load);
            near(mu, at_one * f64::powf(load, p), if between { 0.03 * mu } else { 0.01 * mu });
            near(value(&mut session, "contact.state"), 2.0, 0.0);
        }
    }
    for (name, mu) in [("skin-on-glass-dry", 0.6), ("skin-on-glass-wet", 0.78)] {
        for load in [0.2, 10.0] {
            let mut session = drag(name, load);
            run(&mut session);
            near(value(&mut session, "contact.shear") / load, mu, 0.01 * mu);
        }
    }
}

/// The shipped scene of a block drawn over a plane, under this load \[N\].
fn drag(friction: &str, load: f64) -> Session {
    let text = include_str!("../../../../thenar-cli/scenes/validation/f04-drag.toml");
    let changes = [
        format!("pair.0.friction={friction}"),
        format!("rigid.block.mass={}", load / 10.0),
        format!("load.0.force=[{}, 0, 0]", 2.0 * load),
    ];
    Session::from_text(text, Path::new("f04-drag.toml"), &changes).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn wrong_tables_are_refused_with_the_reason() {
    let scene = |pair: &str| {
        try_load(&format!(
            "[[rigid]]
            name = \"floor\"
            shape = {{ kind = \"plane\" }}
            motion = \"fixed\"
            [[rigid]]
            name = \"box\"
            shape = {{ kind = \"box\", size = [0.04, 0.02, 0.04] }}
            mass = 0.5
            [[pair]]
            bodies = [\"box\", \"floor\"]
            {pair}"
        ))
        .err()
        .unwrap_or_default()
    };
    assert_eq!(scene("friction_by_load = [[0, 0.5]]"), "");
    for (pair, reason) in [
        ("", "a pair needs `friction`, `friction_by_load`"),
        ("friction = 0.2\nfriction_by_load = [[1, 0.5]]", "not both"),
        ("friction = \"skin-on-rubber\"\nfriction_by_load = [[1, 0.5]]", "not both"),
        ("friction = \"skin-on-ruber\"", "did you mean \"skin-on-rubber\"?"),
        (
            "friction = \"velcro\"",
            "expected one of \"skin-on-aluminium\", \"skin-on-rubber\", \"skin-on-glass-dry\", \"skin-on-glass-wet\"",
        ),
        ("friction = [1]", "`pair[0].friction`: expected a finite number from 0 to 100"),
        ("friction_by_load = []", "at least one"),
        ("friction_by_load = [[2, 0.5], [1, 0.4]]", "rising loads, got 1 N after 2 N"),
        ("friction_by_load = [[1, 0.5], [2, 200]]", "coefficients of at most 100"),
        ("friction_by_load = [[-1, 0.5]]", "expected"),
    ] {
        let error = scene(pair);
        assert!(error.contains(reason), "{pair}: {error}");
    }
}
