//! The table of figures, as text and as JSON.

use super::case::{Basis, Case, CaseError, Check, Figure, Outcome};
use crate::words::counted;
use serde_json::{Value, json};

/// Result of a case.
#[derive(Debug)]
pub struct Finding {
    /// The case.
    pub case: Case,
    /// Figures of the case, or why it could not be run.
    pub figures: Result<Vec<Figure>, CaseError>,
    /// Time that it took \[s\].
    pub wall_s: f64,
}

impl Finding {
    /// True if the case ran, and no figure fails.
    pub fn passes(&self) -> bool {
        let fails = |f: &Figure| f.outcome() == Outcome::Fail;
        self.figures.as_ref().is_ok_and(|list| !list.is_empty() && !list.iter().any(fails))
    }
}

const WIDTHS: [usize; 7] = [4, 46, 29, 15, 15, 12, 12];
const HEADS: [&str; 8] =
    ["case", "what", "mesh, step", "expected", "got", "error", "tolerance", "result"];

/// Head of the table.
pub fn head() -> String {
    let names = row(&HEADS.map(String::from));
    format!("{names}\n{}", "-".repeat(names.chars().count()))
}

/// Rows of one case.
pub fn rows(finding: &Finding) -> String {
    let title = format!("{:<4} {}  ({:.1} s)", finding.case.id, finding.case.title, finding.wall_s);
    let body = match &finding.figures {
        Ok(figures) => figures.iter().map(figure_row).collect::<Vec<_>>().join("\n"),
        Err(error) => format!("     FAIL: {error}"),
    };
    format!("{title}\n{body}")
}

fn figure_row(figure: &Figure) -> String {
    let line = row(&[
        String::new(),
        figure.what.clone(),
        figure.setup.clone(),
        expected(figure),
        number(figure.got),
        if matches!(figure.check, Check::Absolute(_) | Check::Relative(_)) {
            error(figure)
        } else {
            String::new()
        },
        tolerance(&figure.check),
        format!("{}{}", word(figure.outcome()), mark(figure.basis)),
    ]);
    match (figure.outcome(), &figure.cannot) {
        (Outcome::Cannot, Some(reason)) => format!("{line}\n       because {reason}"),
        _ => line,
    }
}

fn row(cells: &[String; 8]) -> String {
    let padded = cells.iter().zip(WIDTHS.iter().chain(&[0])).map(|(cell, width)| {
        let missing = width.saturating_sub(cell.chars().count());
        format!("{cell}{}", " ".repeat(missing))
    });
    padded.collect::<Vec<_>>().join(" ").trim_end().to_string()
}

fn expected(figure: &Figure) -> String {
    let value = number(figure.expected);
    match figure.check {
        Check::AtMost => format!("<= {value}"),
        Check::AtLeast => format!(">= {value}"),
        Check::Within { low, high } => format!("{} to {}", short(low), short(high)),
        // What is only stated may have nothing to be held against.
        Check::Report if figure.expected.is_nan() => String::new(),
        _ => value,
    }
}

/// Three significant digits, without zeros behind them.
fn short(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let places = 2 - x.abs().log10().floor() as i32;
    let ten = 10f64.powi(places);
    format!("{}", (x * ten).round() / ten)
}

fn error(figure: &Figure) -> String {
    match figure.check {
        Check::Relative(_) => format!("{:.1e} rel", figure.error()),
        _ => format!("{:.1e}", figure.error()),
    }
}

fn tolerance(check: &Check) -> String {
    match check {
        Check::Absolute(t) => format!("{t:e}"),
        Check::Relative(t) => format!("{t:e} rel"),
        Check::AtMost | Check::AtLeast => "bound".into(),
        Check::Within { low, high } => format!("{} to {}", short(*low), short(*high)),
        Check::Report => String::new(),
    }
}

/// Seven significant digits.
fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || !x.is_finite() {
        format!("{x}")
    } else if (1e-3..1e6).contains(&size) {
        let digits = (6 - size.log10().floor() as i32).max(0) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.6e}")
    }
}

/// A word for an outcome.
pub fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Pass => "pass",
        Outcome::Fail => "FAIL",
        Outcome::Cannot => "cannot",
        Outcome::Stated => "stated",
    }
}

/// The words behind the outcome of a figure that rests on no theory.
fn mark(basis: Basis) -> &'static str {
    match basis {
        Basis::Theory => "",
        Basis::Construction => ", by construction",
        Basis::Itself => ", against itself",
        Basis::People => ", band of people",
        Basis::Recalled => ", band (R)",
    }
}

/// The word for a basis in JSON.
fn basis_word(basis: Basis) -> &'static str {
    match basis {
        Basis::Theory => "theory",
        Basis::Construction => "construction",
        Basis::Itself => "itself",
        Basis::People => "people",
        Basis::Recalled => "recalled",
    }
}

/// All findings as JSON.
pub fn to_json(findings: &[Finding]) -> Value {
    let figure = |f: &Figure| {
        json!({
            "what": f.what, "setup": f.setup, "expected": f.expected, "got": f.got,
            "error": f.error(), "tolerance": tolerance(&f.check), "result": word(f.outcome()),
            "basis": basis_word(f.basis),
            "cannot": f.cannot.as_ref().filter(|_| f.outcome() == Outcome::Cannot),
        })
    };
    let case = |f: &Finding| {
        let figures = f.figures.as_ref().map(|list| list.iter().map(figure).collect::<Vec<_>>());
        json!({
            "case": f.case.id, "title": f.case.title, "full": f.case.full, "wall_s": f.wall_s,
            "passes": f.passes(), "figures": figures.as_deref().unwrap_or(&[]),
            "problem": f.figures.as_ref().err().map(ToString::to_string),
        })
    };
    json!({ "cases": findings.iter().map(case).collect::<Vec<_>>() })
}

/// The last lines: how many figures passed, failed, could not be met, and how many of those that
/// passed say nothing of nature.
pub fn tally(findings: &[Finding]) -> String {
    let figures = || findings.iter().filter_map(|f| f.figures.as_ref().ok()).flatten();
    let count = |o: Outcome| figures().filter(|f| f.outcome() == o).count();
    let passed = |basis: Basis| {
        figures().filter(|f| f.outcome() == Outcome::Pass && f.basis == basis).count()
    };
    let broken = findings.iter().filter(|f| f.figures.is_err()).count();
    format!(
        "{}: {} pass, {} fail, {} cannot be met, {} stated; {} did not run\n\
         of those that pass {} rest on theory or an independent computation, {} hold by construction, {} compare \
         the program with itself, {} lie in bands of people, {} in bands that are recalled (R)",
        counted(findings.len(), "case"),
        counted(count(Outcome::Pass), "figure"),
        count(Outcome::Fail),
        count(Outcome::Cannot),
        count(Outcome::Stated),
        counted(broken, "case"),
        passed(Basis::Theory),
        passed(Basis::Construction),
        passed(Basis::Itself),
        passed(Basis::People),
        passed(Basis::Recalled),
    )
}
