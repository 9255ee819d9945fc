//! Report of a fit, for people and as JSON.

use super::assess::{Assessment, Scale};
use super::unknowns::Unknown;
use serde_json::{Value, json};

/// Content of a fit's report.
pub struct FitReport<'a> {
    /// Parameters that were fitted.
    pub unknowns: &'a [Unknown],
    /// Values that were found.
    pub found: &'a Assessment,
    /// Rows of data.
    pub rows: usize,
    /// True if the search ended by itself.
    pub converged: bool,
    /// Steps of the search.
    pub iterations: u32,
    /// Presses computed.
    pub runs: usize,
    /// Elements and time step.
    pub setup: String,
}

/// A sentence on residuals that hang together.
fn persistence(found: &Assessment) -> Option<String> {
    (found.widened > 1.0).then(|| {
        format!(
            "residuals of neighbouring rows are alike (correlation {:.2}): the model misses the data by more than \
             their noise, or the data were filtered; intervals are {:.1} times as wide as independent errors would make them",
            found.persistence, found.widened
        )
    })
}

impl FitReport<'_> {
    /// Lines for people.
    pub fn text(&self) -> String {
        let found = self.found;
        let mut out = Vec::new();
        for (unknown, e) in self.unknowns.iter().zip(&found.estimates) {
            let p = &unknown.parameter;
            let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
            let error = match (p.scale, e.error.is_finite()) {
                (_, false) => "not known".into(),
                (Scale::Factor, _) => format!("± {} %", digits(100.0 * e.error)),
                (Scale::Distance, _) => format!("± {}{unit}", digits(e.error * p.of)),
            };
            let [low, high] = e.interval.map(digits);
            out.push(format!(
                "{}: {}{unit}, standard error {error}, 95 % interval {low} to {high}{unit}",
                p.name,
                digits(e.value)
            ));
            for reason in &e.cannot_tell {
                out.push(format!("  THE DATA CANNOT TELL: {reason}"));
            }
        }
        let names: Vec<&str> = self.unknowns.iter().map(|u| u.parameter.name.as_str()).collect();
        if names.len() > 1 {
            out.push("correlations".into());
            for (i, name) in names.iter().enumerate().skip(1) {
                let row = (0..i).map(|j| format!("{} {:+.4}", names[j], found.correlation[(i, j)]));
                out.push(format!("  {name}: {}", row.collect::<Vec<_>>().join(", ")));
            }
        }
        out.push(format!(
            "residual: {} N (root mean square, {} rows less {} parameters); condition number {}",
            digits(found.scatter),
            self.rows,
            names.len(),
            digits(found.condition)
        ));
        out.extend(persistence(found));
        if !self.converged {
            out.push(format!(
                "the search had not ended after {} steps: take care",
                self.iterations
            ));
        }
        out.push(format!("{}; {} presses computed", self.setup, self.runs));
        out.join("\n")
    }

    /// Answer as JSON.
    pub fn json(&self) -> Value {
        let found = self.found;
        let parameter = |(unknown, e): (&Unknown, &super::assess::Estimate)| {
            let p = &unknown.parameter;
            let error = match p.scale {
                Scale::Factor => e.error * e.value,
                Scale::Distance => e.error * p.of,
            };
            // What has no end has no number in JSON: null.
            json!({
                "name": p.name, "key": unknown.key, "unit": p.unit, "nuisance": p.nuisance,
                "value": e.value, "standard_error": finite(error),
                "interval_95": e.interval.map(finite), "start": if p.nuisance { 0.0 } else { p.of },
                "told": e.cannot_tell.is_empty(), "cannot_tell": e.cannot_tell,
            })
        };
        let n = self.unknowns.len();
        let correlation: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| found.correlation[(i, j)]).collect()).collect();
        json!({
            "parameters": self.unknowns.iter().zip(&found.estimates).map(parameter).collect::<Vec<_>>(),
            "correlation": correlation,
            "residual_rms_n": found.scatter,
            "condition": finite(found.condition),
            "residual_correlation": found.persistence,
            "widened": found.widened,
            "note": persistence(found),
            "rows": self.rows,
            "converged": self.converged,
            "iterations": self.iterations,
            "presses": self.runs,
            "setup": self.setup,
            "version": env!("CARGO_PKG_VERSION"),
        })
    }
}

fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|x| x.is_finite())
}

/// Four significant digits.
pub fn digits(x: f64) -> String {
    if !x.is_finite() {
        return if x > 0.0 { "∞".into() } else { format!("{x}") };
    }
    if x == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e7).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    let places = (3 - x.abs().log10().floor() as i32).max(0) as usize;
    format!("{x:.places$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let all = [49_873.2, 1.23456, 0.012_345_6, 1.5e-5, 0.0, f64::INFINITY].map(digits);
        assert_eq!(all, ["49873", "1.235", "0.01235", "1.500e-5", "0", "∞"]);
    }
}
