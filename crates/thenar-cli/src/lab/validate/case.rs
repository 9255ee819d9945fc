//! Validation cases, and what they find.

use super::run::Solver;
use thenar_core::world::Failure;

/// Text of a scene, embedded in the program.
#[derive(Clone, Copy, Debug)]
pub struct SceneText {
    /// Name of its file without ending.
    pub name: &'static str,
    /// The text.
    pub text: &'static str,
}

/// The scene `scenes/validation/<name>.toml`.
macro_rules! scene {
    ($name:literal) => {
        $crate::lab::validate::case::SceneText {
            name: $name,
            text: include_str!(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/scenes/validation/",
                $name,
                ".toml"
            )),
        }
    };
}
pub(crate) use scene;

/// One case: scenes are run, figures are read from their probes.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Letter and number, e.g. `A3`.
    pub id: &'static str,
    /// Subject of the case.
    pub title: &'static str,
    /// Too slow for the default run: only under `--full`.
    pub full: bool,
    /// Runs its scenes and measures.
    pub measure: fn(Solver) -> Result<Vec<Figure>, CaseError>,
}

/// A case of the default run.
pub const fn case(
    id: &'static str,
    title: &'static str,
    measure: fn(Solver) -> Result<Vec<Figure>, CaseError>,
) -> Case {
    Case { id, title, full: false, measure }
}

impl Case {
    /// The case, as one that is too slow for the default run.
    pub const fn only_full(self) -> Self {
        Self { full: true, ..self }
    }
}

/// Why a case could not be run.
#[derive(Clone, Debug, thiserror::Error)]
pub enum CaseError {
    /// The scene was refused.
    #[error(transparent)]
    Scene(#[from] thenar_scene::SceneError),
    /// The scene has no such probe column.
    #[error("scene `{scene}` has no probe column `{column}`")]
    Column {
        /// Scene file of the case.
        scene: String,
        /// Column asked for.
        column: String,
    },
    /// The solver failed.
    #[error("scene `{scene}`: {failure}, before t = {time} s")]
    Failed {
        /// Scene file of the case.
        scene: String,
        /// Time \[s\].
        time: f64,
        /// Cause of the failure.
        failure: Failure,
    },
    /// A world refuses the solver's settings.
    #[error("the solver's settings are refused: {0}")]
    Settings(#[from] thenar_core::world::ModelError),
    /// A quantity could not be found in what was measured.
    #[error("{0}")]
    Missing(String),
}

/// Condition under which a figure is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Check {
    /// `|got - expected| <= tolerance`.
    Absolute(f64),
    /// `|got - expected| <= tolerance · |expected|`.
    Relative(f64),
    /// `|got| <= expected`.
    AtMost,
    /// `got >= expected`.
    AtLeast,
    /// `low <= got <= high`; what is expected is their middle.
    Within {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Stated for the reader; nothing is asked of it.
    Report,
}

/// Outcome of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The figure lies within its band.
    Pass,
    /// Not met.
    Fail,
    /// Not met, for a reason that lies in the model and is stated.
    Cannot,
    /// Stated only.
    Stated,
}

/// The grounds of a figure's expected value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Basis {
    /// Theory, a published figure or an independent computation.
    #[default]
    Theory,
    /// Construction of the program: whoever knows it knows the figure. It guards against slips and
    /// says nothing of nature.
    Construction,
    /// Another part of this program.
    Itself,
    /// A band that was measured on people, with its source in `docs/references.md`.
    People,
    /// A band remembered from the literature, none of whose tables was at hand: less than a
    /// measurement.
    Recalled,
}

/// One row of the table: a number measured, beside the one expected.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Quantity that is measured, with its unit.
    pub what: String,
    /// Mesh and time step.
    pub setup: String,
    /// The theory's value, or the bound.
    pub expected: f64,
    /// Value that was computed.
    pub got: f64,
    /// Condition under which it is met.
    pub check: Check,
    /// Grounds of the expected value.
    pub basis: Basis,
    /// Why the model cannot meet it, should it not.
    pub cannot: Option<String>,
}

impl Figure {
    /// A figure with any check.
    pub fn new(
        what: impl Into<String>,
        setup: impl Into<String>,
        expected: f64,
        got: f64,
        check: Check,
    ) -> Self {
        let (what, setup, basis) = (what.into(), setup.into(), Basis::Theory);
        Self { what, setup, expected, got, check, basis, cannot: None }
    }

    /// A figure within a band.
    pub fn within(
        what: impl Into<String>,
        setup: impl Into<String>,
        band: [f64; 2],
        got: f64,
    ) -> Self {
        let [low, high] = band;
        Self::new(what, setup, 0.5 * (low + high), got, Check::Within { low, high })
    }

    /// Says what the expected value rests on, where that is not theory.
    pub fn rests_on(mut self, basis: Basis) -> Self {
        self.basis = basis;
        self
    }

    /// States why the model cannot meet this figure; shown only when it does not.
    pub fn or_cannot(mut self, reason: impl Into<String>) -> Self {
        self.cannot = Some(reason.into());
        self
    }

    /// The deviation that the check compares: absolute, relative, or the value itself for bounds.
    pub fn error(&self) -> f64 {
        let off = self.got - self.expected;
        match self.check {
            Check::Relative(_) => off / self.expected.abs(),
            _ => off,
        }
    }

    /// Outcome of the figure. What is not a number is never met.
    pub fn outcome(&self) -> Outcome {
        let met = match self.check {
            Check::Absolute(tolerance) | Check::Relative(tolerance) => {
                self.error().abs() <= tolerance
            }
            Check::AtMost => self.got.abs() <= self.expected,
            Check::AtLeast => self.got >= self.expected,
            Check::Within { low, high } => (low..=high).contains(&self.got),
            Check::Report => return Outcome::Stated,
        };
        match (met, &self.cannot) {
            (true, _) => Outcome::Pass,
            (false, Some(_)) => Outcome::Cannot,
            (false, None) => Outcome::Fail,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_is_met_within_its_tolerance_only() {
        let outcome = |got, check| Figure::new("x", "", -2.0, got, check).outcome();
        assert_eq!(outcome(-2.1, Check::Absolute(0.11)), Outcome::Pass);
        assert_eq!(outcome(-2.1, Check::Absolute(0.09)), Outcome::Fail);
        assert_eq!(outcome(-2.1, Check::Relative(0.06)), Outcome::Pass);
        assert_eq!(outcome(-2.1, Check::Relative(0.04)), Outcome::Fail);
        assert_eq!(outcome(-1.9, Check::AtLeast), Outcome::Pass);
        assert_eq!(outcome(-2.1, Check::AtLeast), Outcome::Fail);
        for check in [Check::Absolute(1.0), Check::Relative(1.0), Check::AtMost, Check::AtLeast] {
            assert_eq!(outcome(f64::NAN, check), Outcome::Fail);
        }
        let band = |got| Figure::within("x", "", [1.0, 2.5], got).outcome();
        assert_eq!([1.0, 2.5, 0.99, 2.51, f64::NAN].map(band), {
            use Outcome::{Fail, Pass};
            [Pass, Pass, Fail, Fail, Fail]
        });
        let bound = |got| Figure::new("x", "", 0.5, got, Check::AtMost).outcome();
        assert_eq!((bound(-0.4), bound(-0.6)), (Outcome::Pass, Outcome::Fail));
    }

    #[test]
    fn a_reason_never_hides_a_figure_that_is_met() {
        let figure = |got| {
            Figure::new("x", "", 1.0, got, Check::Absolute(0.1)).or_cannot("linear elements lock")
        };
        assert_eq!(figure(1.05).outcome(), Outcome::Pass);
        assert_eq!(figure(1.5).outcome(), Outcome::Cannot);
    }
}
