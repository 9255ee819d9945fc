//! Blocks on an incline that falls towards +x at an angle.

use super::{G, INCLINE, INCLINE_SOFT, TIPPING, threshold};
use crate::lab::validate::case::{CaseError, Check, Figure, SceneText};
use crate::lab::validate::run::{Run, Solver};

/// Mass of the block \[kg\].
const MASS: f64 = 0.008;

/// Overrides that turn the incline and lay `body` (e.g. `rigid.block`) of some height \[m\] on it.
fn at_angle(degrees: f64, body: &str, height: f64) -> Vec<String> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let turn = format!("rotation={{ euler_deg = [0, 0, {}] }}", -degrees);
    let position = [0.5 * height * sin, 0.5 * height * cos, 0.0];
    vec![
        format!("rigid.incline.{turn}"),
        format!("{body}.{turn}"),
        format!("{body}.position={position:?}"),
    ]
}

/// A block of either kind on the incline.
struct Block {
    scene: &'static SceneText,
    body: &'static str,
    word: &'static str,
}

const BLOCKS: [Block; 2] = [
    Block { scene: &INCLINE, body: "rigid.block", word: "rigid" },
    Block { scene: &INCLINE_SOFT, body: "soft.block", word: "soft" },
];

impl Block {
    fn open(&self, solver: Solver, degrees: f64, friction: f64) -> Result<Run, CaseError> {
        let mut overrides = at_angle(degrees, self.body, 0.02);
        overrides.push(format!("pair.0.friction={friction}"));
        solver.open(self.scene, &overrides)
    }

    /// Velocity of the centre of mass down the slope \[m/s\].
    fn speed(run: &mut Run, degrees: f64) -> Result<f64, CaseError> {
        let [px, py] = run.values(["momentum.px", "momentum.py"])?;
        let (sin, cos) = degrees.to_radians().sin_cos();
        Ok((px * cos - py * sin) / MASS)
    }

    /// Middle of the block \[m\].
    fn place(run: &mut Run) -> Result<[f64; 2], CaseError> {
        run.values(["block.x", "block.y"])
    }
}

pub fn incline(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for block in &BLOCKS {
        for (degrees, friction, expected) in
            [(20.0, 0.3, 0.589702), (30.0, 0.5, 0.657145), (35.0, 0.6, 0.805256)]
        {
            let mut run = block.open(solver, degrees, friction)?;
            let early = Block::speed(run.to(0.2)?, degrees)?;
            let late = Block::speed(run.to(0.5)?, degrees)?;
            let what = format!("{}: a at {degrees} deg, mu {friction} [m/s2]", block.word);
            let a = (late - early) / 0.3;
            figures.push(Figure::new(what, run.setup(), expected, a, Check::Relative(0.01)));
        }

        // A soft cube first settles into its own weight.
        let mut run = block.open(solver, 20.0, 0.4)?;
        let [x0, y0] = Block::place(run.to(0.5)?)?;
        let [x1, y1] = Block::place(run.to(10.5)?)?;
        let what = format!("{}: drift in 10 s at 20 deg, mu 0.4 [mm]", block.word);
        let drift = 1e3 * (x1 - x0).hypot(y1 - y0);
        figures.push(Figure::new(what, run.setup(), 0.1, drift, Check::AtMost));

        // Past the threshold by a twentieth of a degree it gains more than a quarter of this.
        let angle = threshold(18.0, 26.0, 0.05, |degrees| {
            let mut run = block.open(solver, degrees, 0.4)?;
            let early = Block::speed(run.to(0.3)?, degrees)?;
            let late = Block::speed(run.to(0.6)?, degrees)?;
            Ok(late - early < 0.3 * 0.25 * G * 0.05_f64.to_radians())
        })?;
        let what = format!("{}: starts to slide at, mu 0.4 [deg]", block.word);
        let expected = 0.4_f64.atan().to_degrees();
        let setup = block.open(solver, 20.0, 0.4)?.setup();
        figures.push(Figure::new(what, setup, expected, angle, Check::Absolute(0.2)));
    }
    Ok(figures)
}

/// A box tips when the plumb line through its centre leaves its base: tan θ = 20/50.
pub fn tipping(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let angle = threshold(15.0, 30.0, 0.05, |degrees| {
        let mut run = solver.open(&TIPPING, &at_angle(degrees, "rigid.box", 0.05))?;
        let [qz, qw] = run.to(3.0)?.values(["box.qz", "box.qw"])?;
        let turned = 2.0 * qz.atan2(qw) + degrees.to_radians();
        Ok(turned.abs() < 1.0_f64.to_radians())
    })?;
    let mut run = solver.open(&TIPPING, &at_angle(20.0, "rigid.box", 0.05))?;
    let start = run.values(["box.x", "box.y"])?;
    let end = run.to(3.0)?.values(["box.x", "box.y"])?;
    let moved = 1e3 * (end[0] - start[0]).hypot(end[1] - start[1]);
    let setup = run.setup();
    Ok(vec![
        Figure::new(
            "tips at [deg]",
            &setup,
            0.4_f64.atan().to_degrees(),
            angle,
            Check::Absolute(0.5),
        ),
        Figure::new("slips below that, in 3 s at 20 deg [mm]", setup, 0.1, moved, Check::AtMost),
    ])
}
