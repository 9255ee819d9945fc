//! Chains of links against figures computed in minimal coordinates by two other codes.

use crate::lab::validate::case::{Basis, CaseError, Check, Figure, SceneText, scene};
use crate::lab::validate::run::{Solver, order, step_words};

const DOUBLE_PENDULUM: SceneText = scene!("a03-double-pendulum");
const PLANAR_FINGER: SceneText = scene!("a04-planar-finger");
const UNIVERSAL_FINGER: SceneText = scene!("a05-universal-finger");

/// The step at which tolerances hold, and two coarser ones that show the order \[s\].
const FINE: f64 = 1e-5;
const COARSE: [f64; 2] = [2e-4, 1e-4];

/// Expected values of a chain at one time.
struct Instant<const N: usize> {
    time: f64,
    expected: [f64; N],
}

fn instant<const N: usize>(time: f64, expected: [f64; N]) -> Instant<N> {
    Instant { time, expected }
}

/// Each value at the fine step, and the order at which the errors of all of them vanish. Columns
/// are probe columns with a tolerance.
fn compare<const N: usize>(
    solver: Solver,
    scene: &SceneText,
    columns: [(&str, f64); N],
    instants: &[Instant<N>],
) -> Result<Vec<Figure>, CaseError> {
    let run = |h: f64| -> Result<Vec<[f64; N]>, CaseError> {
        let mut run = solver.with_step(scene, h)?;
        instants.iter().map(|i| run.to(i.time)?.values(columns.map(|(name, _)| name))).collect()
    };
    let coarse = [run(COARSE[0])?, run(COARSE[1])?];
    let fine = run(FINE)?;
    let mut figures = Vec::new();
    for (i, Instant { time, expected }) in instants.iter().enumerate() {
        for (k, (name, tolerance)) in columns.iter().enumerate() {
            let (what, check) = (format!("{name} at {time} s"), Check::Absolute(*tolerance));
            figures.push(Figure::new(what, step_words(FINE), expected[k], fine[i][k], check));
        }
        let off = |got: &[f64; N]| {
            got.iter().zip(expected).map(|(g, e)| (g - e).powi(2)).sum::<f64>().sqrt()
        };
        let p = order(off(&coarse[0][i]), off(&coarse[1][i]), COARSE[0] / COARSE[1]);
        figures.push(order_row(format!("order of the error at {time} s"), p));
    }
    Ok(figures)
}

fn order_row(what: String, p: f64) -> Figure {
    Figure::new(what, "h = 0.2 and 0.1 ms", 1.0, p, Check::Absolute(0.15))
}

/// Relative angles \[rad\] and absolute rates \[rad/s\].
pub fn double_pendulum(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    compare(
        solver,
        &DOUBLE_PENDULUM,
        [("first.angle0", 1e-3), ("second.angle0", 1e-3), ("v1.wz", 1e-3), ("v2.wz", 1e-3)],
        &[
            instant(0.5, [0.570472, 0.633403, -2.78965, -3.18806]),
            instant(1.0, [-0.625088, -0.409497, -3.92228, -1.30310]),
            instant(1.5, [-1.674797, 0.329825, 0.38687, -0.75857]),
            instant(2.0, [-0.482972, -0.841077, 3.06529, 2.94927]),
        ],
    )
}

/// Relative angles from straight down \[rad\]; tip \[m\].
pub fn planar_finger(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let angle = |name| (name, 1e-3);
    compare(
        solver,
        &PLANAR_FINGER,
        [
            angle("q1.angle0"),
            angle("q2.angle0"),
            angle("q3.angle0"),
            ("tip.x", 1e-4),
            ("tip.y", 1e-4),
        ],
        &[
            instant(0.05, [1.222472, 0.488471, -0.168970, 92.0327e-3, -12.4193e-3]),
            instant(0.10, [0.526760, 0.433754, 0.840185, 67.2982e-3, -48.3312e-3]),
            instant(0.20, [-0.860935, -0.430279, 0.038731, -81.9152e-3, -44.0137e-3]),
        ],
    )
}

/// Angles of the universal joint and of both hinges \[rad\], tip \[m\], energy \[J\].
pub fn universal_finger(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let columns = ["root.angle0", "root.angle1", "second.angle0", "third.angle0"];
    let mut figures = compare(
        solver,
        &UNIVERSAL_FINGER,
        columns.map(|name| (name, 1e-3)),
        &[
            instant(0.05, [0.419923, 0.581679, -0.312877, 0.214467]),
            instant(0.10, [1.348794, 0.623286, -0.364660, -0.818978]),
            instant(0.15, [1.865194, 0.130224, 0.077456, 0.715871]),
        ],
    )?;
    let tip = ["tip.x", "tip.y", "tip.z"];
    figures.extend(compare(
        solver,
        &UNIVERSAL_FINGER,
        tip.map(|name| (name, 1e-4)),
        &[instant(0.10, [44.7309e-3, 45.7345e-3, -55.1226e-3])],
    )?);

    let start = solver.with_step(&UNIVERSAL_FINGER, FINE)?.value("energy.total")?;
    let (what, check) = ("energy at the start [J]", Check::Absolute(5e-9));
    figures.push(Figure::new(what, step_words(FINE), 8.28416e-4, start, check));
    let drift = |h: f64| -> Result<f64, CaseError> {
        let series = solver.with_step(&UNIVERSAL_FINGER, h)?.record(0.15, &["energy.total"])?;
        Ok(series.columns[0].iter().fold(0.0, |m, e| f64::max(m, (e - start).abs())))
    };
    let what = "largest change of energy in 0.15 s [J]";
    figures.push(Figure::new(what, step_words(FINE), 0.0, drift(FINE)?, Check::Report));
    let p = order(drift(COARSE[0])?, drift(COARSE[1])?, COARSE[0] / COARSE[1]);
    figures.push(order_row("order at which that change vanishes".into(), p));
    Ok(figures)
}

/// A minute of the planar finger, its joints damped.
pub fn joint_drift(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let columns = ["gap", "misalignment"];
    let mut figures = Vec::new();
    for (h, bound) in [(1e-4, true), (1e-3, false)] {
        let mut overrides: Vec<String> =
            (1..4).map(|k| format!("joint.q{k}.damping=[1e-5]")).collect();
        overrides.push(format!("time_step={h:e}"));
        let mut run = solver.open(&PLANAR_FINGER, &overrides)?;
        let all: Vec<String> = (1..4).flat_map(|k| columns.map(|c| format!("q{k}.{c}"))).collect();
        let names: Vec<&str> = all.iter().map(String::as_str).collect();
        let series = run.record(60.0, &names)?;
        let largest = |of: usize| (0..3).map(|k| series.largest(2 * k + of)).fold(0.0, f64::max);
        let last = |of: usize| (0..3).map(|k| series.last(2 * k + of).abs()).fold(0.0, f64::max);
        let check = if bound { Check::AtMost } else { Check::Report };
        // The monolithic solver's joints are coordinates, which cannot drift.
        let basis = if solver == Solver::Monolithic { Basis::Construction } else { Basis::Theory };
        let row = |what: &str, limit, got| {
            Figure::new(what, step_words(h), limit, got, check).rests_on(basis)
        };
        figures.push(row("largest joint gap in 60 s [m]", 1e-6, largest(0)));
        figures.push(row("largest misalignment in 60 s [rad]", 1e-4, largest(1)));
        figures.push(row("joint gap after 60 s [m]", 1e-6, last(0)));
        figures.push(row("misalignment after 60 s [rad]", 1e-4, last(1)));
    }
    Ok(figures)
}
