//! One run of a scene: stepped, and read through its probes only.

use super::case::{CaseError, SceneText};
use std::path::Path;
use thenar_core::World;
use thenar_core::world::{ContactPoint, Failure, Input};
use thenar_scene::format::MONOLITHIC_ONCE;
use thenar_scene::session::Session;

/// The solver that cases run with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Solver {
    /// Joints, flesh and contact in one system: the default.
    #[value(alias = MONOLITHIC_ONCE)]
    Monolithic,
    /// The paper's.
    TwoStep,
}

impl Solver {
    /// Opens a scene with overrides such as `time_step=0.0001`.
    pub fn open(self, scene: &SceneText, overrides: &[String]) -> Result<Run, CaseError> {
        let file = format!("scenes/validation/{}.toml", scene.name);
        let kind = match self {
            Self::Monolithic => "solver.kind=monolithic",
            Self::TwoStep => "solver.kind=two-step",
        };
        let overrides: Vec<String> =
            std::iter::once(kind.into()).chain(overrides.iter().cloned()).collect();
        let session = Session::from_text(scene.text, Path::new(&file), &overrides)?;
        Ok(Run { session })
    }

    /// Opens a scene with another time step \[s\].
    pub fn with_step(self, scene: &SceneText, h: f64) -> Result<Run, CaseError> {
        self.open(scene, &[format!("time_step={h:e}")])
    }
}

/// A running scene.
pub struct Run {
    session: Session,
}

/// Rows of some probe columns over time.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Time of each row \[s\].
    pub time: Vec<f64>,
    /// One list per column asked for, in that order.
    pub columns: Vec<Vec<f64>>,
}

impl Run {
    /// Steps until `time` \[s\], to the nearest step.
    pub fn to(&mut self, time: f64) -> Result<&mut Self, CaseError> {
        let h = self.session.world().time_step();
        while self.session.world().time() + 0.5 * h < time {
            self.step()?;
        }
        Ok(self)
    }

    /// One step.
    pub fn step(&mut self) -> Result<(), CaseError> {
        let report = self.session.step(&mut ());
        self.check(report.failure)
    }

    /// An error, with scene and time, if the solver failed.
    pub fn check(&self, failure: Option<Failure>) -> Result<(), CaseError> {
        let (scene, time) = (self.session.name().to_string(), self.time());
        match failure {
            Some(failure) => Err(CaseError::Failed { scene, time, failure }),
            None => Ok(()),
        }
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.session.world().time()
    }

    /// A probe column now, e.g. `tip.x`.
    pub fn value(&mut self, column: &str) -> Result<f64, CaseError> {
        let at = self.column(column)?;
        Ok(self.session.probe()[at])
    }

    /// Some probe columns now.
    pub fn values<const N: usize>(&mut self, columns: [&str; N]) -> Result<[f64; N], CaseError> {
        let mut out = [0.0; N];
        for (value, column) in out.iter_mut().zip(columns) {
            *value = self.value(column)?;
        }
        Ok(out)
    }

    /// Steps until `time` \[s\] and keeps these columns of every step, the present one first.
    pub fn record(&mut self, time: f64, columns: &[&str]) -> Result<Series, CaseError> {
        let at: Result<Vec<usize>, _> = columns.iter().map(|c| self.column(c)).collect();
        let at = at?;
        let mut series = Series { time: Vec::new(), columns: vec![Vec::new(); at.len()] };
        let h = self.session.world().time_step();
        loop {
            series.time.push(self.time());
            let row = self.session.probe();
            series.columns.iter_mut().zip(&at).for_each(|(list, k)| list.push(row[*k]));
            if self.time() + 0.5 * h >= time {
                return Ok(series);
            }
            self.step()?;
        }
    }

    /// Mesh and time step, for the table.
    pub fn setup(&self) -> String {
        self.setup_at(self.world().time_step())
    }

    /// The mesh, and another time step.
    pub fn setup_at(&self, h: f64) -> String {
        match self.mesh() {
            mesh if mesh.is_empty() => step_words(h),
            mesh => format!("{mesh}, {}", step_words(h)),
        }
    }

    /// Elements and nodes of all deformable bodies; empty when there are none.
    pub fn mesh(&self) -> String {
        let softs = &self.session.world().desc().softs;
        let tets: usize = softs.iter().map(|s| s.flesh.tets.len()).sum();
        let nodes: usize = softs.iter().map(|s| s.flesh.nodes.len()).sum();
        if tets == 0 { String::new() } else { format!("{tets} tets, {nodes} nodes") }
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        self.session.world()
    }

    /// Area of the points that bear load \[m²\], of all contacts: the patch of theory, where
    /// surfaces part at its rim at once. What a probe calls area has a rim of skin besides, that is
    /// within 20 µm and unloaded.
    pub fn bearing_area(&self) -> f64 {
        let bears = |c: &&ContactPoint| c.force_W.dot(&c.normal_W) > 0.0;
        self.world().contacts().iter().filter(bears).map(|c| c.area).sum()
    }

    /// Input of the last step.
    pub fn input(&self) -> &Input {
        self.session.input()
    }

    /// The session, for what probes do not give.
    pub fn session(&mut self) -> &mut Session {
        &mut self.session
    }

    fn column(&self, name: &str) -> Result<usize, CaseError> {
        self.session.columns().iter().position(|c| c.name == name).ok_or_else(|| {
            CaseError::Column { scene: self.session.name().into(), column: name.into() }
        })
    }
}

/// A time step in words.
pub fn step_words(h: f64) -> String {
    format!("h = {} ms", (h * 1e9).round() / 1e6)
}

impl Series {
    /// Times at which column `k` changes sign, interpolated \[s\].
    pub fn zero_crossings(&self, k: usize) -> Vec<f64> {
        let y = &self.columns[k];
        let crossed = |i: &usize| (y[*i] > 0.0) != (y[*i + 1] > 0.0);
        let place =
            |i: usize| self.time[i] + (self.time[i + 1] - self.time[i]) * y[i] / (y[i] - y[i + 1]);
        (0..y.len().saturating_sub(1)).filter(crossed).map(place).collect()
    }

    /// Last value of column `k`.
    pub fn last(&self, k: usize) -> f64 {
        self.columns[k].last().copied().unwrap_or(f64::NAN)
    }

    /// Largest |value| of column `k`.
    pub fn largest(&self, k: usize) -> f64 {
        self.columns[k].iter().fold(0.0, |m, y| f64::max(m, y.abs()))
    }
}

/// Order of convergence from the errors at steps that shrink by `factor`.
pub fn order(coarse: f64, fine: f64, factor: f64) -> f64 {
    (coarse.abs() / fine.abs()).ln() / factor.ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum;

    #[test]
    fn the_old_spelling_of_a_solver_is_taken_and_not_offered() {
        assert_eq!(Solver::from_str(MONOLITHIC_ONCE, false), Ok(Solver::Monolithic));
        let named = |solver: &Solver| solver.to_possible_value().map(|v| v.get_name().to_owned());
        let offered: Vec<_> = Solver::value_variants().iter().filter_map(named).collect();
        assert_eq!(offered, ["monolithic", "two-step"]);
    }
}
