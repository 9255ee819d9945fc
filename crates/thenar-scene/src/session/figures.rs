//! Figures of a whole run, as one row of a table.

use super::{Session, Summary};
use thenar_core::model::Digit;
use thenar_core::world::Energy;

/// A cell of the row.
#[derive(Clone, Debug, PartialEq)]
pub enum Figure {
    /// A number, in the unit of its column.
    Number(f64),
    /// A count.
    Count(u64),
    /// A word.
    Word(String),
}

/// A named cell.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedFigure {
    /// Name without unit, e.g. `fingers.thumb.normal_max`.
    pub name: String,
    /// SI unit; `1` for pure numbers, empty for words.
    pub unit: &'static str,
    /// The cell.
    pub value: Figure,
}

/// Figures of a run: extremes of all steps, and four numbers of every probe.
///
/// The row depends on the scene alone: not on time, machine or threads.
#[derive(Debug)]
pub struct Figures {
    summary: Summary,
    probes: Vec<Spread>,
    rows: u64,
}

/// Spread of a column of the probe table.
#[derive(Clone, Copy, Debug)]
struct Spread {
    last: f64,
    sum: f64,
    min: f64,
    max: f64,
}

impl Spread {
    const NOTHING: Self = Self { last: 0.0, sum: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY };

    fn take(&mut self, value: f64) {
        self.last = value;
        self.sum += value;
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }

    fn named(&self, rows: u64) -> [(&'static str, f64); 4] {
        let mean = self.sum / rows as f64;
        [("last", self.last), ("mean", mean), ("min", self.min), ("max", self.max)]
    }
}

impl Figures {
    /// Figures of a run that starts now; the present state is the first row of the probe table.
    pub fn new(session: &mut Session) -> Self {
        let summary = Summary::new(session);
        let probes = vec![Spread::NOTHING; session.columns().len()];
        let mut figures = Self { summary, probes, rows: 0 };
        figures.take_probes(session);
        figures
    }

    /// Takes in the step just done; probes count where their table has a row.
    pub fn take(&mut self, session: &mut Session) {
        self.summary.take(session);
        if session.steps().is_multiple_of(session.probe_every()) {
            self.take_probes(session);
        }
    }

    fn take_probes(&mut self, session: &mut Session) {
        self.rows += 1;
        self.probes.iter_mut().zip(session.probe()).for_each(|(spread, value)| spread.take(*value));
    }

    /// Extremes over the steps taken so far.
    pub fn summary(&self) -> &Summary {
        &self.summary
    }

    /// The row: extremes first, under the same names for every scene, then `PROBE.last`, `.mean`,
    /// `.min` and `.max` over the rows of the probe table.
    pub fn row(&self, session: &Session) -> Vec<NamedFigure> {
        let mut row = extremes(&self.summary, session);
        for (column, spread) in session.columns().iter().zip(&self.probes) {
            row.extend(spread.named(self.rows).map(|(word, value)| NamedFigure {
                name: format!("{}.{word}", column.name),
                unit: column.unit,
                value: Figure::Number(value),
            }));
        }
        row
    }
}

/// Names follow the report of `thenar run`.
fn extremes(s: &Summary, session: &Session) -> Vec<NamedFigure> {
    let world = session.world();
    let count = |name: &str, value: u64| named(name, "1", Figure::Count(value));
    let number = |name: &str, unit, value: f64| named(name, unit, Figure::Number(value));
    let joules = |name: &str, energy: &Energy| number(name, "J", energy.total());
    let mut row = vec![
        count("steps", session.steps()),
        number("simulated", "s", world.time()),
        count("contacts_max", s.contacts_max.into()),
        count("contacts_dropped_max", s.contacts_dropped_max.into()),
        number("max_joint_gap", "m", s.joint_gap_max),
        number("max_penetration", "m", s.penetration_max),
        count("inverted_tets_max", s.inverted_tets_max.into()),
        number("inverted_longest", "s", s.inverted_longest as f64 * world.time_step()),
        count("non_finite", s.non_finite),
        count("fell_back", s.fell_back),
        count("divided", s.divided),
        count("contact_cut_short", s.contact_cut_short),
        count("contact_unconverged", s.contact_unconverged),
        number("contact_residual_max", "m/s", s.contact_residual_max),
        joules("energy.initial", &s.energy_initial),
        joules("energy.final", &s.energy_final),
        number("energy.max", "J", s.energy_max),
    ];
    for (digit, peak) in Digit::FINGERS.iter().zip(&s.fingers) {
        let figures = super::HandLoad::FIGURES.iter().zip(peak.figures());
        row.extend(figures.map(|((name, unit), value)| {
            // The pressure is that of the largest normal force, no largest of its own.
            let ending = if *name == "pressure" { "at_normal_max" } else { "max" };
            number(&format!("fingers.{}.{name}_{ending}", digit.name()), unit, value)
        }));
    }
    row.push(named("state_hash", "", Figure::Word(format!("{:016x}", world.state_hash()))));
    row
}

fn named(name: &str, unit: &'static str, value: Figure) -> NamedFigure {
    NamedFigure { name: name.into(), unit, value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// A box that falls freely for a tenth of a second: its height is h - g t²/2 by the scheme's
    /// own sum.
    #[test]
    fn probes_spread_and_names_differ() {
        let text = "version = 1\nduration = 0.1\ntime_step = 0.01\n[[rigid]]\nname = \"a\"\nmass = 1\n\
                    shape = { kind = \"sphere\", radius = 0.02 }\nposition = [0, 10, 0]\n\
                    [[probe]]\nname = \"v\"\nmeasure = \"velocity\"\nbody = \"a\"\n";
        let mut session = Session::from_text(text, Path::new("fall.toml"), &[]).unwrap();
        let mut figures = Figures::new(&mut session);
        for _ in 0..10 {
            session.step(&mut ());
            figures.take(&mut session);
        }
        let row = figures.row(&session);
        let of = |name: &str| match row.iter().find(|f| f.name == name).map(|f| &f.value) {
            Some(Figure::Number(x)) => *x,
            other => panic!("{name}: {other:?}"),
        };
        // v = -g t at 0, 0.01, …, 0.1 s: 11 rows, whose mean is half the last.
        let g = 9.81;
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        close(of("v.vy.last"), -g * 0.1);
        close(of("v.vy.mean"), -g * 0.05);
        close(of("v.vy.min"), -g * 0.1);
        close(of("v.vy.max"), 0.0);
        let mut names: Vec<_> = row.iter().map(|f| &f.name).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), row.len());
    }
}
