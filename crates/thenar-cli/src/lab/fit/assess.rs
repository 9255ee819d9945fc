//! Assessment of parameters by data: estimates, intervals, correlations, and where the data say
//! nothing. Pure.

use super::least_squares::{Minimum, rms};
use super::student::t95;
use nalgebra::DMatrix;

/// Relation of a parameter to the coordinate in which it is searched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// `value = unit · exp(u)`: what is positive by its nature. Intervals are factors.
    Factor,
    /// `value = unit · u`: what may have either sign, such as an offset.
    Distance,
}

/// A parameter of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name of the unknown.
    pub name: String,
    /// Unit of its value, for people.
    pub unit: String,
    /// Value of the coordinate's unit: where a modulus starts, what an offset is measured by.
    pub of: f64,
    /// Relation of the value to the coordinate.
    pub scale: Scale,
    /// Nobody asked for it; it is there so that others are not spoilt.
    pub nuisance: bool,
}

impl Parameter {
    /// Value of the unknown at a coordinate.
    pub fn value(&self, u: f64) -> f64 {
        match self.scale {
            Scale::Factor => self.of * u.exp(),
            Scale::Distance => self.of * u,
        }
    }
}

/// A parameter found.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// Value that fits best.
    pub value: f64,
    /// Standard error of the coordinate: of the value's logarithm for a factor, of `value / of` for
    /// a distance; infinite where the data do not say.
    pub error: f64,
    /// The 95 % interval of the value.
    pub interval: [f64; 2],
    /// Why the data cannot tell it.
    pub cannot_tell: Vec<String>,
}

/// All that is found.
#[derive(Clone, Debug)]
pub struct Assessment {
    /// One for each parameter.
    pub estimates: Vec<Estimate>,
    /// Correlations of the estimates.
    pub correlation: DMatrix<f64>,
    /// Root mean square of what is left, with the freedoms taken off.
    pub scatter: f64,
    /// Ratio of the largest to the least singular value of the derivatives, their columns scaled to
    /// length one; infinite where some combination of parameters does not show at all.
    pub condition: f64,
    /// Correlation of each residual with the next.
    pub persistence: f64,
    /// By how much errors were widened since neighbouring residuals are alike: 1 where they are
    /// not.
    pub widened: f64,
}

/// Correlations beyond this say that two parameters are seen together only.
pub const CORRELATION_MAX: f64 = 0.98;
/// A combination of scaled columns whose singular value is this part of the largest is not seen:
/// what differences of runs that stop at tolerances of 1e-5 leave of it is noise.
const SEEN: f64 = 1e-5;

/// Judges a minimum. `span_max`: an interval over which a parameter changes by more than this
/// factor tells nothing (for a distance: wider than this many of its units).
pub fn assess(parameters: &[Parameter], minimum: &Minimum, span_max: f64) -> Assessment {
    let (n, p) = minimum.jacobian.shape();
    let freedoms = n.saturating_sub(p).max(1);
    let scatter = rms(&minimum.residuals) * (n as f64 / freedoms as f64).sqrt();
    let persistence = persistence(&minimum.residuals);
    let widened = widening(persistence, n);

    // Columns of length one, so that units do not matter; what has no column has no influence.
    let lengths: Vec<f64> = minimum.jacobian.column_iter().map(|c| c.norm()).collect();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let mute = |j: usize| !(lengths[j] > 1e-9 * longest && lengths[j] > 0.0);
    let heard: Vec<usize> = (0..p).filter(|&j| !mute(j)).collect();
    let unit = DMatrix::from_fn(n, heard.len(), |i, k| {
        minimum.jacobian[(i, heard[k])] / lengths[heard[k]]
    });
    let (inverse, unseen, condition) = inverse_square(unit);

    let mut correlation = DMatrix::identity(p, p);
    for (a, &i) in heard.iter().enumerate() {
        for (b, &j) in heard.iter().enumerate() {
            let both = (inverse[(a, a)] * inverse[(b, b)]).sqrt();
            correlation[(i, j)] = if a == b { 1.0 } else { inverse[(a, b)] / both };
        }
    }
    let mut estimates: Vec<Estimate> = Vec::with_capacity(p);
    for (j, parameter) in parameters.iter().enumerate() {
        let at = heard.iter().position(|&h| h == j);
        let blind = at.is_none_or(|k| unseen.iter().any(|v| v[k].abs() > 0.1));
        let error = match at {
            Some(k) if !blind => scatter * widened * inverse[(k, k)].max(0.0).sqrt() / lengths[j],
            _ => f64::INFINITY,
        };
        let reach = t95(freedoms) * error;
        let u = minimum.at[j];
        let interval = [parameter.value(u - reach), parameter.value(u + reach)];
        let estimate =
            Estimate { value: parameter.value(u), error, interval, cannot_tell: Vec::new() };
        estimates.push(estimate);
    }
    for j in 0..p {
        let reasons = reasons(parameters, &estimates, &correlation, j, mute(j), scatter, span_max);
        estimates[j].cannot_tell = reasons;
    }
    let condition = if heard.len() < p { f64::INFINITY } else { condition };
    Assessment { estimates, correlation, scatter, condition, persistence, widened }
}

/// Why the data cannot tell parameter `j`.
fn reasons(
    parameters: &[Parameter],
    estimates: &[Estimate],
    correlation: &DMatrix<f64>,
    j: usize,
    mute: bool,
    scatter: f64,
    span_max: f64,
) -> Vec<String> {
    let (parameter, estimate) = (&parameters[j], &estimates[j]);
    if mute {
        return vec!["the forces do not depend on it at all".into()];
    }
    let mut reasons = Vec::new();
    let others = (0..parameters.len()).filter(|&k| k != j);
    let alike: Vec<usize> =
        others.filter(|&k| correlation[(j, k)].abs() > CORRELATION_MAX).collect();
    for &k in &alike {
        let (other, r) = (&parameters[k].name, correlation[(j, k)]);
        reasons.push(format!(
            "it goes with `{other}` (correlation {r:.4}, beyond {CORRELATION_MAX}): the data show the two together only"
        ));
    }
    let [low, high] = estimate.interval;
    let span = match parameter.scale {
        Scale::Factor => high / low,
        Scale::Distance => (high - low) / parameter.of,
    };
    if span.is_nan() || span > span_max {
        let how = match parameter.scale {
            Scale::Factor if span.is_finite() => format!("spans a factor of {span:.3}"),
            Scale::Distance if span.is_finite() => {
                format!("is {:.3e} {} wide", high - low, parameter.unit)
            }
            _ => "has no end".into(),
        };
        let limit = match parameter.scale {
            Scale::Factor => format!("a factor of {span_max}"),
            Scale::Distance => format!("{:e} {}", span_max * parameter.of, parameter.unit),
        };
        reasons.push(format!(
            "its 95 % interval {how}, more than {limit}: the force changes too little with it for a scatter of {scatter:.3e} N"
        ));
    }
    reasons
}

/// `(UᵀU)⁻¹` of a matrix with columns of length one, by its singular values; what is not seen is
/// left out and told, as directions. The third is the condition number.
fn inverse_square(unit: DMatrix<f64>) -> (DMatrix<f64>, Vec<Vec<f64>>, f64) {
    let p = unit.ncols();
    if p == 0 {
        return (DMatrix::zeros(0, 0), Vec::new(), f64::INFINITY);
    }
    let svd = unit.svd(false, true);
    let values = &svd.singular_values;
    let largest = values.max();
    let mut inverse = DMatrix::zeros(p, p);
    let mut unseen = Vec::new();
    // Fewer rows than columns leave directions that have no singular value.
    let Some(directions) = svd.v_t.as_ref().filter(|v| v.nrows() == p) else {
        return (DMatrix::identity(p, p), vec![vec![1.0; p]], f64::INFINITY);
    };
    for (k, sigma) in values.iter().enumerate() {
        let v = directions.row(k).transpose();
        if *sigma <= SEEN * largest {
            unseen.push(v.iter().copied().collect());
        }
        // A direction that is not seen counts by the bound of what is: correlations then show who
        // goes with whom.
        let sigma = sigma.max(SEEN * largest);
        inverse += &v * v.transpose() / (sigma * sigma);
    }
    let condition = if unseen.is_empty() { largest / values.min() } else { f64::INFINITY };
    (inverse, unseen, condition)
}

/// Correlation of each residual with the next.
fn persistence(residuals: &[f64]) -> f64 {
    let all: f64 = residuals.iter().map(|r| r * r).sum();
    let next: f64 = residuals.windows(2).map(|w| w[0] * w[1]).sum();
    if all > 0.0 { next / all } else { 0.0 }
}

/// By what errors of a mean grow where each residual is like the one before: `√((1+r)/(1-r))` of a
/// series of first order. Correlations that independent errors have by chance, up to 2/√n, change
/// nothing.
fn widening(persistence: f64, n: usize) -> f64 {
    if persistence <= 2.0 / (n as f64).sqrt() {
        return 1.0;
    }
    let r = persistence.min(0.99);
    ((1.0 + r) / (1.0 - r)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(name: &str) -> Parameter {
        let (name, unit) = (name.to_string(), "m".to_string());
        Parameter { name, unit, of: 1.0, scale: Scale::Distance, nuisance: false }
    }

    fn linear(columns: &[&[f64]], residuals: &[f64]) -> Minimum {
        let jacobian = DMatrix::from_fn(residuals.len(), columns.len(), |i, j| columns[j][i]);
        let at = vec![1.0; columns.len()];
        Minimum { at, residuals: residuals.to_vec(), jacobian, iterations: 1, converged: true }
    }

    /// Regression `y = a + b x` on x = 0..4: `s² = SSR/3`, `var b = s²/10`,
    /// `var a = s² (1/5 + 4/10)`, correlation `-x̄ /√(Σx²/n)` = -2/√6.
    #[test]
    fn errors_of_a_line_are_those_of_the_closed_form() {
        let left = [0.1, -0.2, 0.1, 0.1, -0.1];
        let m = linear(&[&[1.0; 5], &[0.0, 1.0, 2.0, 3.0, 4.0]], &left);
        let found = assess(&[distance("a"), distance("b")], &m, 100.0);
        let variance = 0.08_f64 / 3.0;
        assert!((found.scatter.powi(2) - variance).abs() < 1e-12);
        assert_eq!(found.widened, 1.0);
        let [a, b] = [&found.estimates[0], &found.estimates[1]];
        assert!((b.error - (variance / 10.0).sqrt()).abs() < 1e-12, "{b:?}");
        assert!((a.error - (variance * 0.6).sqrt()).abs() < 1e-12, "{a:?}");
        assert!((found.correlation[(0, 1)] + 2.0 / 6f64.sqrt()).abs() < 1e-12);
        // Student's t of three freedoms.
        assert!((b.interval[1] - 1.0 - 3.182_446 * b.error).abs() < 1e-6);
        assert!(a.cannot_tell.is_empty() && b.cannot_tell.is_empty());
    }

    /// A modulus known to one part in ten: the interval is a factor on either side.
    #[test]
    fn intervals_of_moduli_are_factors() {
        let modulus = Parameter { of: 50e3, scale: Scale::Factor, ..distance("young") };
        let mut m = linear(&[&[1.0; 4]], &[0.1, -0.1, 0.1, -0.1]);
        m.at = vec![0.0];
        let found = assess(std::slice::from_ref(&modulus), &m, 3.0);
        let error = (0.04_f64 / 3.0 / 4.0).sqrt();
        let e = &found.estimates[0];
        let factor = (3.182_446 * error).exp();
        assert!(
            (e.interval[1] / 50e3 - factor).abs() < 1e-6
                && (50e3 / e.interval[0] - factor).abs() < 1e-6
        );
        assert!(e.cannot_tell.is_empty());
        // The same data, judged more strictly.
        let strict = assess(&[modulus], &m, 1.2);
        assert!(
            strict.estimates[0].cannot_tell[0].contains("spans a factor of 1.44"),
            "{strict:?}"
        );
    }

    /// Two parameters with the same effect: neither is known, and a third is.
    #[test]
    fn parameters_that_go_together_are_not_told_apart() {
        let x = [1.0, 2.0, 3.0, 4.0, 5.0];
        let twice = x.map(|x| -2.0 * x);
        let left = [0.1, -0.1, 0.0, 0.1, -0.1];
        let m = linear(&[&x, &twice, &[1.0, -1.0, 1.0, -1.0, 1.0]], &left);
        let found = assess(&[distance("a"), distance("b"), distance("c")], &m, 10.0);
        for k in [0, 1] {
            let e = &found.estimates[k];
            assert!(e.error.is_infinite() && e.cannot_tell[0].contains("correlation"), "{e:?}");
        }
        assert!(found.condition.is_infinite());
        let c = &found.estimates[2];
        assert!(c.cannot_tell.is_empty() && c.error < 0.1, "{c:?}");
    }

    #[test]
    fn what_has_no_influence_is_said_to_have_none() {
        let m = linear(&[&[0.0; 4], &[1.0, 2.0, 3.0, 5.0]], &[0.1, -0.1, 0.1, -0.1]);
        let found = assess(&[distance("a"), distance("b")], &m, 10.0);
        assert_eq!(found.estimates[0].cannot_tell, ["the forces do not depend on it at all"]);
        assert!(found.estimates[1].cannot_tell.is_empty());
        let none = assess(&[distance("a")], &linear(&[&[0.0; 3]], &[0.0; 3]), 10.0);
        assert!(!none.estimates[0].cannot_tell.is_empty());
    }

    /// A model that misses by a slow wave: neighbours are alike, and errors grow as for a third of
    /// the data.
    #[test]
    fn residuals_that_persist_widen_what_is_claimed() {
        let wave: Vec<f64> = (0..100).map(|i| (f64::from(i) * 0.3).sin()).collect();
        let m = linear(&[&[1.0; 100]], &wave);
        let found = assess(&[distance("a")], &m, 10.0);
        let r = found.persistence;
        assert!((r - 0.3_f64.cos()).abs() < 0.02, "{r}");
        assert!((found.widened.powi(2) - (1.0 + r) / (1.0 - r)).abs() < 1e-9);
    }
}
