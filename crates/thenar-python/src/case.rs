//! A scene run from its start to its end: one row of a table of cases.

use crate::error;
use crate::scene::Scene;
use crate::world::SLICE;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::time::Instant;
use thenar_scene::build::Files;
use thenar_scene::session::{Figure, Figures, NamedFigure, Session, TakenBack};

/// The longest run \[s\], as `thenar run` has it.
const SECONDS_MAX: f64 = 1e9;

/// A cell of the row, as Python has it.
#[derive(Debug, IntoPyObject)]
pub enum Cell {
    /// A number, in the unit of its column.
    Number(f64),
    /// A count.
    Count(u64),
    /// A word.
    Word(String),
}

/// Name, unit and cell.
type Named = (String, &'static str, Cell);

/// Runs a scene for so long, or for its own duration, and returns why it failed, or `None`, and the
/// row. Other Python threads run meanwhile; Ctrl-C ends it between two steps.
#[pyfunction]
pub fn run_case(
    py: Python<'_>,
    scene: &Scene,
    seconds: Option<f64>,
) -> PyResult<(Option<String>, Vec<Named>)> {
    if seconds.is_some_and(|s| !(s > 0.0 && s <= SECONDS_MAX)) {
        return Err(PyValueError::new_err("seconds must be more than 0 and at most 1e9"));
    }
    py.detach(|| {
        let mut session = open(scene)?;
        let steps = match seconds {
            Some(s) => (s / session.world().time_step()).round().max(1.0) as u64,
            None => session.steps_wanted(),
        };
        let mut figures = Figures::new(&mut session);
        let mut asked = Instant::now();
        for _ in 0..steps {
            session.step(&mut ());
            figures.take(&mut session);
            if asked.elapsed() > SLICE {
                Python::attach(|py| py.check_signals())?;
                asked = Instant::now();
            }
        }
        let judged = TakenBack::judge(figures.summary().non_finite, steps);
        Ok((judged.err().map(|error| error.to_string()), row(&figures, &session)))
    })
}

/// Names and units of what [`run_case`] gives of this scene, with the cells of its start.
#[pyfunction]
pub fn case_columns(py: Python<'_>, scene: &Scene) -> PyResult<Vec<Named>> {
    py.detach(|| {
        let mut session = open(scene)?;
        let figures = Figures::new(&mut session);
        Ok(row(&figures, &session))
    })
}

fn open(scene: &Scene) -> PyResult<Session> {
    let source = scene.source();
    Session::open(source, Files::beside(&source.file)).map_err(|e| error::scene(&e))
}

fn row(figures: &Figures, session: &Session) -> Vec<Named> {
    let named = |NamedFigure { name, unit, value }| match value {
        Figure::Number(x) => (name, unit, Cell::Number(x)),
        Figure::Count(n) => (name, unit, Cell::Count(n)),
        Figure::Word(word) => (name, unit, Cell::Word(word)),
    };
    figures.row(session).into_iter().map(named).collect()
}
