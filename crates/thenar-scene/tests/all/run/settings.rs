//! Goal: settings do to a running scene what their help says. Method: small scenes against closed
//! formulas, before and after a change; every setting of every shipped scene at both its ends.

use std::path::Path;
use thenar_core::Vec3;
use thenar_scene::session::{Session, builtin, builtins};
use thenar_scene::tuning::{Range, Scale, Setting, SettingError, SettingValue};

fn session(text: &str) -> Session {
    Session::from_text(text, Path::new("test.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn shipped(name: &str) -> Session {
    session(builtin(name).expect("a scene").text)
}

/// A shipped scene with the paper's hand.
fn papers(name: &str) -> Session {
    let text = builtin(name).expect("a scene").text;
    let paper = ["hand.0.preset=paper".to_owned()];
    Session::from_text(text, Path::new("test.toml"), &paper).unwrap_or_else(|e| panic!("{e}"))
}

fn set(session: &mut Session, key: &str, value: f64) {
    session.set(key, &SettingValue::Number(value)).unwrap_or_else(|e| panic!("{e}"));
}

fn get(session: &Session, key: &str) -> Setting {
    session.settings().into_iter().find(|s| s.key == key).unwrap_or_else(|| panic!("no {key}"))
}

fn run(session: &mut Session, seconds: f64) {
    let end = session.world().time() + seconds;
    while session.world().time() < end - 1e-9 {
        assert!(!session.step(&mut ()).non_finite);
    }
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len() as f64
}

/// A cube that stands on a table without friction.
const CUBE: &str = r#"
version = 1
time_step = 0.002
[[rigid]]
name = "table"
shape = { kind = "plane" }
motion = "fixed"
friction = 0
[[soft]]
name = "cube"
shape = { kind = "lattice", size = [0.05, 0.05, 0.05], cells = [4, 4, 4], split = "five" }
material = { young = 20e3, poisson = 0.3, density = 1000 }
mass_damping = 5
stiffness_damping = 0.01
position = [0, 0.025, 0]
friction = 0
[[load]]
kind = "traction"
body = "cube"
faces = { side = "y-max" }
total = [0, -1, 0]
"#;

#[test]
fn a_loaded_cube_is_pressed_in_in_proportion_to_one_over_young() {
    let mut session = session(CUBE);
    let height = |s: &Session| {
        let nodes = s.world().nodes(0);
        let top: Vec<Vec3> = (0..nodes.len())
            .filter(|n| (s.meshes()[0].nodes[*n].y - 0.025).abs() < 1e-9)
            .map(|n| nodes[n])
            .collect();
        let bottom = (0..nodes.len()).filter(|n| (s.meshes()[0].nodes[*n].y + 0.025).abs() < 1e-9);
        mean(&top).y - mean(&bottom.map(|n| nodes[n]).collect::<Vec<_>>()).y
    };
    run(&mut session, 1.0);
    for young in [20e3, 40e3, 80e3] {
        set(&mut session, "object_young", young);
        run(&mut session, 1.0);
        // Force and half the weight over E and the face: 1 N + 0.61 N, 2.5e-3 m².
        let weight = 1000.0 * 0.05f64.powi(3) * 9.81;
        let want = (1.0 + 0.5 * weight) / (young * 0.05 * 0.05) * 0.05;
        let got = 0.05 - height(&session);
        // Rotated linear elements: small strain, up to 3.2 % here.
        assert!((got / want - 1.0).abs() < 0.05, "{young}: {got} {want}");
    }
    // Poisson's ratio tells how much of it comes out at the sides: the mean strain sideways is
    // that times the mean strain downwards.
    let width = |s: &Session| {
        let side = |at: f64| {
            let nodes = s.world().nodes(0).iter().zip(&s.meshes()[0].nodes);
            let on: Vec<Vec3> = nodes.filter(|n| (n.1.x - at).abs() < 1e-9).map(|n| *n.0).collect();
            mean(&on).x
        };
        side(0.025) - side(-0.025)
    };
    for poisson in [0.0, 0.2, 0.4] {
        set(&mut session, "object_poisson", poisson);
        run(&mut session, 1.0);
        let strain = (0.05 - height(&session)) / 0.05;
        let wider = width(&session) / 0.05 - 1.0;
        assert!((wider - poisson * strain).abs() < 0.02 * strain, "{poisson}: {wider} {strain}");
    }
}

/// A block on a slope of 20°.
const SLOPE: &str = r#"
version = 1
time_step = 0.002
gravity = [3.3552, -9.2184, 0]
[[rigid]]
name = "slope"
shape = { kind = "plane" }
motion = "fixed"
[[rigid]]
name = "block"
shape = { kind = "box", size = [0.06, 0.04, 0.08] }
mass = 0.2
position = [0, 0.02, 0]
"#;

#[test]
fn friction_decides_whether_a_block_slides() {
    let mut session = session(SLOPE);
    let speed = |s: &Session| s.world().rigid_velocity(1)[0].x;
    // tan 20° = 0.364.
    set(&mut session, "friction", 0.45);
    run(&mut session, 0.5);
    assert!(speed(&session).abs() < 1e-6);
    set(&mut session, "friction", 0.2);
    run(&mut session, 0.5);
    let want = (3.3552 - 0.2 * 9.2184) * 0.5;
    assert!((speed(&session) / want - 1.0).abs() < 0.01, "{} {want}", speed(&session));
    set(&mut session, "friction", 0.6);
    // Brakes with (0.6 - 0.364) × 9.2 m/s²: 2.18 m/s² against 0.756 m/s.
    run(&mut session, 0.5);
    assert!(speed(&session).abs() < 1e-6);
}

#[test]
fn gravity_mass_and_time_step_act_at_once() {
    let mut session = session(SLOPE);
    set(&mut session, "friction", 1.5);
    run(&mut session, 0.2);
    let pressing =
        |s: &Session| s.world().contacts().iter().map(|c| c.force_W.dot(&c.normal_W)).sum::<f64>();
    assert!((pressing(&session) / (0.2 * 9.2184) - 1.0).abs() < 1e-3);
    set(&mut session, "object_mass", 0.5);
    run(&mut session, 0.2);
    assert!((pressing(&session) / (0.5 * 9.2184) - 1.0).abs() < 1e-3);
    let whole = (3.3552_f64.powi(2) + 9.2184_f64.powi(2)).sqrt();
    set(&mut session, "gravity", 0.5 * whole);
    run(&mut session, 0.2);
    assert!((pressing(&session) / (0.25 * 9.2184) - 1.0).abs() < 1e-3);
    let (time, steps) = (session.world().time(), session.steps());
    set(&mut session, "time_step", 0.01);
    session.step(&mut ());
    assert!((session.world().time() - time - 0.01).abs() < 1e-12);
    assert_eq!(session.steps(), steps + 1);
}

/// A hand that holds its start pose.
const HAND: &str = r#"
version = 1
time_step = 0.005
[[hand]]
preset = "paper"
name = "hand"
model = "right"
tets = 300
position = [0, 0.3, 0]
"#;

#[test]
fn a_stronger_hand_sags_less_and_softer_bonds_let_flesh_hang() {
    let mut session = session(HAND);
    let sag = |s: &Session| {
        let target = s.input().targets[0].expect("a target").pose_WB.position.y;
        target - s.world().rigid_pose(0).position.y
    };
    run(&mut session, 1.0);
    let usual = sag(&session);
    set(&mut session, "drive_stiffness", 4.0);
    run(&mut session, 1.0);
    // The springs carry the same weight.
    assert!((usual / sag(&session) / 4.0 - 1.0).abs() < 0.05, "{usual} {}", sag(&session));

    let hang = |s: &Session| {
        let mut targets = vec![Vec3::zeros(); s.world().nodes(0).len()];
        s.world().skin_targets(0, &mut targets);
        let masses = s.world().node_masses(0);
        let below = s.world().nodes(0).iter().zip(&targets).map(|(x, f)| f.y - x.y);
        below.zip(masses).map(|(y, m)| y * m).sum::<f64>() / masses.iter().sum::<f64>()
    };
    let flesh: f64 = session.world().node_masses(0).iter().sum();
    set(&mut session, "hand_young", 5e3);
    for k in [1e8, 1e9] {
        set(&mut session, "coupling_stiffness", k);
        run(&mut session, 1.0);
        // All springs together carry the flesh: Σ k_i (f_i - x_i) = m g.
        let coupling = session.world().desc().softs[0].coupling.as_ref().expect("bound");
        let mut targets = vec![Vec3::zeros(); session.world().nodes(0).len()];
        session.world().skin_targets(0, &mut targets);
        let nodes = session.world().nodes(0).iter();
        let force: f64 = nodes
            .zip(&targets)
            .zip(coupling.springs.stiffness())
            .map(|((x, f), k)| k * (f.y - x.y))
            .sum();
        assert!((force / (flesh * 9.81) - 1.0).abs() < 0.02, "{force} {}", flesh * 9.81);
        assert!(hang(&session) > 0.0);
        // A uniform hang: density over stiffness per volume times g, within the unevenness of
        // flesh.
        let even = flesh * 9.81 / coupling.springs.stiffness().sum::<f64>();
        assert!((hang(&session) / even - 1.0).abs() < 0.5, "{} {even}", hang(&session));
    }
}

#[test]
fn damping_stops_a_wobble() {
    let left = |damping: f64| {
        let mut session = session(CUBE);
        set(&mut session, "flesh_damping", damping);
        set(&mut session, "time_step", 1e-3);
        run(&mut session, 0.3);
        session.world().energy(session.input()).kinetic
    };
    assert!(left(0.03) < 0.05 * left(0.0), "{} {}", left(0.03), left(0.0));
}

#[test]
fn what_is_set_stays_through_a_restart_and_what_is_not_stays_the_scenes() {
    let mut session = shipped("bread-squeeze");
    let before = session.settings();
    set(&mut session, "object_young", 4e3);
    run(&mut session, 0.05);
    session.restart();
    assert_eq!(session.world().time(), 0.0);
    assert_eq!(get(&session, "object_young").value, SettingValue::Number(4e3));
    for (old, new) in before.iter().zip(session.settings()) {
        if old.key != "object_young" {
            assert_eq!(*old, new);
        }
    }
    // Crust and crumb keep their ratio of 2.
    let materials = &session.world().desc().softs.last().expect("bread").flesh.materials;
    let young = |f: fn(f64, f64) -> f64, from| materials.iter().map(|m| m.young).fold(from, f);
    assert!((young(f64::max, 0.0) - 4e3).abs() < 1e-6);
    let scene = shipped("bread-squeeze");
    let own = &scene.world().desc().softs.last().expect("bread").flesh.materials;
    for (a, b) in materials.iter().zip(own) {
        assert!((a.young / b.young - 4e3 / 16e3).abs() < 1e-9);
        assert_eq!((a.poisson, a.density), (b.poisson, b.density));
    }
}

#[test]
fn choices_change_the_solver() {
    let mut session = papers("bread-grasp");
    let choose = |s: &mut Session, key: &str, word: &str| {
        s.set(key, &SettingValue::Choice(word.into())).unwrap_or_else(|e| panic!("{e}"));
    };
    run(&mut session, 0.1);
    let Range::Choices { choices } = get(&session, "solver").range else { panic!("no choices") };
    assert_eq!(choices, ["monolithic", "two-step", "two-step, frozen flesh (paper)"]);
    choose(&mut session, "solver", choices[2]);
    use thenar_core::model::{Cone, FleshInStep1};
    let solver = session.world().desc().solver;
    assert_eq!((solver.step1_flesh, solver.close_joints), (FleshInStep1::Frozen, false));
    // The scene's own tolerances stay.
    let scene = papers("bread-grasp").world().desc().solver;
    let budget = |s: thenar_core::model::SolverSettings| (s.cg_tolerance, s.contact_sweeps_max);
    assert_eq!(budget(solver), budget(scene));
    choose(&mut session, "solver", "two-step");
    choose(&mut session, "cone", "linearised");
    let solver = session.world().desc().solver;
    assert_eq!((solver.step1_flesh, solver.close_joints), (FleshInStep1::Lumped, true));
    assert_eq!(solver.cone, Cone::Linearised);

    // Springs in bone need the monolithic solver.
    let touch = ["hand.0.preset=touch".to_owned()];
    let text = builtin("bread-grasp").expect("a scene").text;
    let mut touch = Session::from_text(text, Path::new("test.toml"), &touch).expect("a scene");
    let word = SettingValue::Choice("two-step".into());
    let error = touch.set("solver", &word).unwrap_err().to_string();
    assert_eq!(error, "`solver`: expected one of \"monolithic\", got \"two-step\"");

    // Nor does a scene without a hand offer the dense reference.
    let Range::Choices { choices } = get(&shipped("falling-box"), "solver").range else {
        panic!("no choices")
    };
    assert_eq!(choices, ["monolithic", "two-step", "two-step, frozen flesh (paper)"]);
}

/// A setting replaces what the scene said, so that no rounding of a factor is left.
#[test]
fn springs_that_are_set_are_those_of_a_scene_that_says_so() {
    let springs = |s: &Session| {
        let coupling = s.world().desc().softs[0].coupling.as_ref().expect("bound");
        coupling.springs.stiffness().collect::<Vec<_>>()
    };
    let text = builtin("bread-grasp").expect("a scene").text;
    let said = ["hand.0.preset=paper", "hand.0.coupling_stiffness=3.7e9"].map(str::to_owned);
    let said = Session::from_text(text, Path::new("test.toml"), &said).expect("a scene");
    let mut tuned = papers("bread-grasp");
    assert_ne!(springs(&tuned), springs(&said));
    for stiffness in [1.1e8, 3.7e9] {
        set(&mut tuned, "coupling_stiffness", stiffness);
    }
    assert_eq!(springs(&tuned), springs(&said));
}

#[test]
fn every_setting_of_every_scene_may_go_to_its_ends() {
    for scene in builtins() {
        let mut session = shipped(scene.name);
        for setting in session.settings() {
            assert!(setting.help.len() > 40 && !setting.label.is_empty(), "{}", setting.key);
            let ends = match &setting.range {
                Range::Number { min, max, scale } => {
                    assert!(min < max && (*scale == Scale::Linear || *min > 0.0));
                    vec![SettingValue::Number(*min), SettingValue::Number(*max)]
                }
                Range::Choices { choices } => {
                    choices.iter().map(|c| SettingValue::Choice((*c).into())).collect()
                }
            };
            let back = setting.value.clone();
            for value in ends.into_iter().chain([back]) {
                session.set(setting.key, &value).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
                assert_eq!(get(&session, setting.key).value, value);
                let report = session.step(&mut ());
                assert!(!report.non_finite, "{} {} {value:?}", scene.name, setting.key);
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let mut session = papers("car-grasp");
    let hash = session.world().state_hash();
    let before = session.settings();
    let mut refused = |key: &str, value| session.set(key, &value).unwrap_err().to_string();
    let near = refused("fricton", SettingValue::Number(0.5));
    assert_eq!(near, "no setting \"fricton\" in this scene; did you mean `friction`?");
    assert!(refused("object_young", SettingValue::Number(1e4)).starts_with("no setting"));
    let high = refused("friction", SettingValue::Number(2.5));
    assert_eq!(high, "`friction`: expected 0 to 2, got 2.5");
    for bad in [f64::NAN, f64::INFINITY, -0.1] {
        assert!(refused("friction", SettingValue::Number(bad)).contains("expected 0 to 2"));
    }
    let word = refused("friction", SettingValue::Choice("high".into()));
    assert!(word.ends_with("got \"high\""), "{word}");
    let choice = refused("cone", SettingValue::Choice("square".into()));
    assert_eq!(choice, "`cone`: expected one of \"circular\", \"linearised\", got \"square\"");
    assert!(matches!(
        session.set("cone", &SettingValue::Number(1.0)),
        Err(SettingError::Value { key: "cone", .. })
    ));
    assert_eq!(session.settings(), before);
    assert_eq!(session.world().state_hash(), hash);
}

#[test]
fn settings_are_written_as_the_protocol_says() {
    let session = shipped("bread-grasp");
    let json = serde_json::to_value(session.settings()).expect("JSON");
    let find = |key: &str| {
        let all = json.as_array().expect("an array").iter();
        all.clone().find(|s| s["key"] == key).cloned().unwrap_or_else(|| panic!("no {key}"))
    };
    let mut friction = find("friction");
    for text in ["label", "help", "group"] {
        assert!(friction[text].take().is_string());
    }
    let want = serde_json::json!({
        "key": "friction", "label": null, "help": null, "group": null, "unit": "1",
        "value": 0.8, "own": 0.8, "min": 0.0, "max": 2.0, "scale": "linear",
    });
    assert_eq!(friction, want);
    let cone = find("cone");
    assert_eq!(cone["choices"], serde_json::json!(["circular", "linearised"]));
    assert_eq!(cone["value"], "circular");
    assert!(cone.get("min").is_none());
    let value: SettingValue = serde_json::from_str("0.5").expect("a number");
    assert_eq!(value, SettingValue::Number(0.5));
    let value: SettingValue = serde_json::from_str("\"circular\"").expect("a word");
    assert_eq!(value, SettingValue::Choice("circular".into()));
}
