//! Goal: a comparison tells the truth about two solvers. Method: where both must agree, a
//! difference of zero is expected; where the paper's scheme is known to diverge (over-correction
//! above 2, `World::joint_over_correction`), it must be reported, and the monolithic solver must go
//! on.

use std::path::Path;
use thenar_scene::compare::sweep::{Plan, SweepError, sweep};
use thenar_scene::compare::{
    Cause, CompareError, CompareMode, Comparison, MONOLITHIC, Scheme, TWO_STEP,
};
use thenar_scene::session::Session;

const BODY: &str = r#"
version = 1
[[rigid]]
name = "stone"
mass = 0.2
inertia = [1e-4, 2e-4, 3e-4]
velocity = [1, 2, 0]
angular_velocity = [3, 10, -2]
"#;

fn twice(open: impl Fn() -> Session) -> [Session; 2] {
    [open(), open()]
}

fn text(text: &str) -> Session {
    Session::from_text(text, Path::new("scene.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// The finger of validation D5: two bones in flesh, bent by a torque at their hinge.
fn finger(stiffness: f64, h: f64) -> Session {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../thenar-cli/scenes/validation");
    let bind = (0..3).map(|i| format!("soft.flesh.bind.{i}.stiffness={stiffness:e}"));
    let set: Vec<String> = bind.chain([format!("time_step={h}")]).collect();
    Session::load(&scenes.join("d05-finger.toml"), &set).unwrap_or_else(|e| panic!("{e}"))
}

fn run(comparison: &mut Comparison, steps: u64) {
    (0..steps).for_each(|_| comparison.step(&mut [(), ()]));
}

#[test]
fn a_free_body_moves_alike_with_both() {
    let sessions = twice(|| text(BODY));
    let mut comparison =
        Comparison::new(sessions, CompareMode::Trajectories, Scheme::AsSet).unwrap();
    run(&mut comparison, 500);
    let stone = comparison.summary().objects[0];
    // Round-off of 0.5 s at 2 m/s and 10 rad/s.
    assert!(stone.position.max < 1e-12, "{:?}", stone.position);
    assert!(stone.rotation.max < 1e-11, "{:?}", stone.rotation);
    let fallen = comparison.sessions()[MONOLITHIC].world().rigid_pose(0).position;
    assert!((fallen.x - 0.5).abs() < 1e-9, "and it did move: {fallen}");
}

#[test]
fn the_same_comparison_gives_the_same_bits() {
    let table = || {
        let sessions = twice(|| finger(1e7, 1e-3));
        let mut comparison =
            Comparison::new(sessions, CompareMode::Trajectories, Scheme::Paper).unwrap();
        let mut rows: Vec<u64> = Vec::new();
        for _ in 0..50 {
            run(&mut comparison, 1);
            rows.extend(comparison.row().iter().map(|x| x.to_bits()));
        }
        assert_eq!(rows.len(), 50 * comparison.columns().len());
        rows
    };
    assert_eq!(table(), table());
}

#[test]
fn a_scheme_that_diverges_is_reported_and_the_other_goes_on() {
    let sessions = twice(|| finger(1e9, 5e-3));
    let gamma = sessions[0].world().joint_over_correction(1);
    assert!(gamma > 4.0, "{gamma}: the paper's scheme must diverge here");
    let mut comparison =
        Comparison::new(sessions, CompareMode::Trajectories, Scheme::Paper).unwrap();
    run(&mut comparison, 300);
    let [two_step, monolithic] = &comparison.summary().sides;
    let lost = two_step.diverged.expect("it diverges");
    assert!(lost.time > 0.0 && lost.time < 1.5, "{lost}");
    if let Cause::Energy { energy, bound } = lost.cause {
        assert!(energy > bound);
    }
    assert!(monolithic.diverged.is_none() && monolithic.failed == 0);
    let time = comparison.sessions()[MONOLITHIC].world().time();
    assert!((time - 1.5).abs() < 1e-9, "the survivor went on to the end: {time}");
    let row = comparison.row();
    let columns = comparison.columns();
    let of = |name: &str| row[columns.iter().position(|c| c.name == name).unwrap()];
    assert!(of("two-step.energy").is_nan() && of("monolithic.energy").is_finite());
}

/// Where trajectories part for good, single steps from the same state stay close.
#[test]
fn single_steps_show_the_error_of_one_step() {
    let sessions = twice(|| finger(1e9, 5e-3));
    let mut comparison =
        Comparison::new(sessions, CompareMode::SingleSteps, Scheme::Paper).unwrap();
    run(&mut comparison, 100);
    let paper = comparison.summary().position.max;
    assert!(!comparison.has_diverged(TWO_STEP) && paper > 1e-7 && paper < 5e-3, "{paper}");

    let sessions = twice(|| finger(1e9, 5e-3));
    let mut comparison =
        Comparison::new(sessions, CompareMode::SingleSteps, Scheme::Closed).unwrap();
    run(&mut comparison, 100);
    let closed = comparison.summary().position.max;
    assert!(closed < 0.2 * paper, "{closed} {paper}");
}

#[test]
fn a_sweep_finds_where_the_paper_diverges() {
    let plan = Plan { stiffness: vec![1e6, 1e9], time_steps: vec![5e-3], from: 0.05, seconds: 0.1 };
    let scene = finger(1e7, 1e-3).scene().clone();
    let mut told = 0;
    let points = sweep(&scene, Path::new("scene.toml"), &plan, |_| told += 1).unwrap();
    assert_eq!((points.len(), told), (2, 2));
    let [soft, stiff] = [&points[0], &points[1]];
    assert!(soft.over_correction < 1.5 && stiff.over_correction > 4.0);
    assert!(soft.schemes.iter().all(|s| s.diverged.is_none()));
    assert!(stiff.schemes[0].diverged.is_some() && stiff.schemes[2].diverged.is_none());
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let fixed = "version = 1\n[[rigid]]\nname = \"wall\"\nmotion = \"fixed\"\n\
                 shape = { kind = \"plane\" }\n";
    let nothing = Comparison::new(twice(|| text(fixed)), CompareMode::Trajectories, Scheme::AsSet);
    assert_eq!(nothing.err(), Some(CompareError::NothingMoves));

    let plan = Plan { stiffness: vec![1e6], time_steps: vec![1e-3], from: 0.0, seconds: 0.1 };
    let scene = text(BODY).scene().clone();
    let refused = sweep(&scene, Path::new("scene.toml"), &plan, |_| {});
    assert!(matches!(refused, Err(SweepError::NoCoupling)));
}
