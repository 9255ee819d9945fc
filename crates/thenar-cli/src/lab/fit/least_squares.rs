//! Nonlinear least squares: Levenberg's and Marquardt's method on a curve that is expensive to
//! compute and known without derivatives. Pure: what it is given is a function of coordinates of
//! order one.

use nalgebra::{DMatrix, DVector};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Curve at some coordinates, if there is one.
#[derive(Clone, Debug, PartialEq)]
pub enum Trial {
    /// Values of the column.
    Values(Vec<f64>),
    /// No values, for this reason: the coordinates make no sense.
    Impossible(String),
}

/// The curve that is fitted; `E` ends the whole fit.
pub type Curve<'a, E> = &'a (dyn Fn(&[f64]) -> Result<Trial, E> + Sync);

/// Why there is no minimum.
#[derive(Clone, Debug, PartialEq)]
pub enum Trouble<E> {
    /// No curve exists where the fit starts, or beside it.
    NoStart(String),
    /// The curve's own reason to end.
    Ended(E),
}

/// Coordinates at which the sum of squares is least.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The coordinates.
    pub at: Vec<f64>,
    /// Curve less data there.
    pub residuals: Vec<f64>,
    /// Derivatives of the curve there: a row for each datum, a column for each coordinate.
    pub jacobian: DMatrix<f64>,
    /// Steps made.
    pub iterations: u32,
    /// True if the last step was too small to matter.
    pub converged: bool,
}

/// A step smaller than this in all coordinates, which are logarithms or of order one, ends the
/// search.
const STEP_MIN: f64 = 1e-4;
/// No coordinate moves further in one step: a factor of 2.7 on a modulus.
const STEP_MAX: f64 = 1.0;
const ITERATIONS_MAX: u32 = 30;
/// Damping at which nothing better is found any more, relative to the diagonal.
const DAMPING_MAX: f64 = 1e8;

/// Finds the least sum of squares of `curve - data` near `start`. Derivatives are differences of
/// the curve over twice `widths`, computed on all processors; `tell` hears the root mean square
/// after each step.
///
/// # Errors
/// There is no curve at the start, or the curve ends the fit.
pub fn minimise<E: Send>(
    curve: Curve<'_, E>,
    data: &[f64],
    start: &[f64],
    widths: &[f64],
    mut tell: impl FnMut(u32, &[f64], f64),
) -> Result<Minimum, Trouble<E>> {
    let mut at = start.to_vec();
    let mut residuals = match curve(&at).map_err(Trouble::Ended)? {
        Trial::Values(values) => apart(&values, data),
        Trial::Impossible(reason) => return Err(Trouble::NoStart(reason)),
    };
    let mut jacobian = differences(curve, &at, &residuals, data, widths)?;
    let (mut damping, mut iterations, mut converged) = (1e-3, 0, false);
    while iterations < ITERATIONS_MAX && !converged {
        tell(iterations, &at, rms(&residuals));
        let Some((next, left, step)) =
            better(curve, data, &at, &residuals, &jacobian, &mut damping)
                .map_err(Trouble::Ended)?
        else {
            // No step of any length is better: this is a minimum.
            converged = true;
            break;
        };
        (at, residuals) = (next, left);
        jacobian = differences(curve, &at, &residuals, data, widths)?;
        iterations += 1;
        converged = step < STEP_MIN;
    }
    Ok(Minimum { at, residuals, jacobian, iterations, converged })
}

/// Root mean square.
pub fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|r| r * r).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

fn apart(values: &[f64], data: &[f64]) -> Vec<f64> {
    values.iter().zip(data).map(|(v, d)| v - d).collect()
}

type Improvement = (Vec<f64>, Vec<f64>, f64);

/// A place with a smaller sum of squares, its residuals and the largest coordinate of the step to
/// it; the damping falls with success and rises without.
fn better<E>(
    curve: Curve<'_, E>,
    data: &[f64],
    at: &[f64],
    residuals: &[f64],
    J: &DMatrix<f64>,
    damping: &mut f64,
) -> Result<Option<Improvement>, E> {
    let r = DVector::from_column_slice(residuals);
    let (normal, gradient) = (J.transpose() * J, J.transpose() * &r);
    let largest = normal.diagonal().max();
    let cost = r.norm_squared();
    while *damping < DAMPING_MAX {
        let mut matrix = normal.clone();
        for j in 0..matrix.nrows() {
            // A coordinate that the curve does not know of stays where it is.
            matrix[(j, j)] += *damping * normal[(j, j)].max(1e-12 * largest).max(f64::MIN_POSITIVE);
        }
        let Some(factor) = matrix.cholesky() else {
            *damping *= 10.0;
            continue;
        };
        let step = -factor.solve(&gradient);
        let size = step.amax();
        if size < 1e-3 * STEP_MIN {
            return Ok(None);
        }
        let step = step * (STEP_MAX / size).min(1.0);
        let next: Vec<f64> = at.iter().zip(step.iter()).map(|(x, d)| x + d).collect();
        if let Trial::Values(values) = curve(&next)? {
            let left = apart(&values, data);
            if left.iter().map(|r| r * r).sum::<f64>() < cost {
                *damping = (*damping * 0.1).max(1e-9);
                return Ok(Some((next, left, step.amax())));
            }
        }
        *damping *= 10.0;
    }
    Ok(None)
}

/// Derivatives by central differences; one-sided where there is no curve on one side.
fn differences<E: Send>(
    curve: Curve<'_, E>,
    at: &[f64],
    residuals: &[f64],
    data: &[f64],
    widths: &[f64],
) -> Result<DMatrix<f64>, Trouble<E>> {
    let moved = |j: usize, by: f64| {
        let mut x = at.to_vec();
        x[j] += by;
        x
    };
    let places: Vec<Vec<f64>> =
        (0..at.len()).flat_map(|j| [moved(j, widths[j]), moved(j, -widths[j])]).collect();
    let mut trials = evaluate(curve, &places).into_iter();
    let mut J = DMatrix::zeros(data.len(), at.len());
    for (j, width) in widths.iter().enumerate() {
        let mut side = || trials.next().transpose().map_err(Trouble::Ended);
        let (above, below) = (side()?, side()?);
        let here = || residuals.iter().zip(data).map(|(r, d)| r + d).collect::<Vec<_>>();
        let (above, below, over) = match (above, below) {
            (Some(Trial::Values(a)), Some(Trial::Values(b))) => (a, b, 2.0 * width),
            (Some(Trial::Values(a)), _) => (a, here(), *width),
            (_, Some(Trial::Values(b))) => (here(), b, *width),
            (Some(Trial::Impossible(reason)), _) => return Err(Trouble::NoStart(reason)),
            _ => return Err(Trouble::NoStart("nothing can be changed".into())),
        };
        for (i, (a, b)) in above.iter().zip(&below).enumerate() {
            J[(i, j)] = (a - b) / over;
        }
    }
    Ok(J)
}

/// The curve at several places, on all processors, in their order.
fn evaluate<E: Send>(curve: Curve<'_, E>, places: &[Vec<f64>]) -> Vec<Result<Trial, E>> {
    let workers = std::thread::available_parallelism().map_or(1, usize::from).min(places.len());
    let next = AtomicUsize::new(0);
    let (send, receive) = std::sync::mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..workers {
            let (send, next) = (send.clone(), &next);
            scope.spawn(move || {
                while let Some((i, place)) = {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    places.get(i).map(|place| (i, place))
                } {
                    if send.send((i, curve(place))).is_err() {
                        return;
                    }
                }
            });
        }
    });
    drop(send);
    let mut found: Vec<(usize, Result<Trial, E>)> = receive.iter().collect();
    found.sort_by_key(|(i, _)| *i);
    found.into_iter().map(|(_, trial)| trial).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    type Never = std::convert::Infallible;

    fn values(v: Vec<f64>) -> Result<Trial, Never> {
        Ok(Trial::Values(v))
    }

    /// A straight line is fitted in one step, to the closed form.
    #[test]
    fn a_line_is_the_regression_line() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0];
        let y = [1.1, 2.9, 5.2, 6.8, 9.1];
        let curve = |u: &[f64]| values(x.iter().map(|x| u[0] + u[1] * x).collect());
        let found = minimise(&curve, &y, &[1.0, 1.0], &[1e-2; 2], |_, _, _| {}).unwrap();
        // Slope Σ(x - 2)(y - ȳ)/10 = 19.9/10, mean 5.02.
        assert!(
            (found.at[1] - 1.99).abs() < 1e-6 && (found.at[0] - 1.04).abs() < 1e-6,
            "{found:?}"
        );
        assert!(found.converged);
        assert!(found.jacobian.column(0).iter().all(|d| (d - 1.0).abs() < 1e-12));
    }

    /// Two exponentials, from far off, without noise; the start is a factor of twenty away.
    #[test]
    fn a_curve_is_found_again_from_afar() {
        let at = |u: &[f64]| -> Vec<f64> {
            (0..40)
                .map(|i| f64::from(i) * 0.1)
                .map(|t| u[0].exp() * ((u[1].exp() * t).exp() - 1.0))
                .collect()
        };
        let truth = [0.3_f64.ln(), 0.8_f64.ln()];
        let data = at(&truth);
        let curve = |u: &[f64]| values(at(u));
        let found =
            minimise(&curve, &data, &[6.0_f64.ln(), 0.3_f64.ln()], &[1e-3; 2], |_, _, _| {})
                .unwrap();
        for (got, want) in found.at.iter().zip(truth) {
            assert!((got - want).abs() < 1e-5, "{found:?}");
        }
    }

    /// Places without a curve are stepped around: the square root of what is below zero.
    #[test]
    fn what_has_no_curve_is_left_alone() {
        let curve = |u: &[f64]| {
            Ok::<_, Never>(match u[0] {
                u if u < 0.0 => Trial::Impossible("negative".into()),
                u => Trial::Values(vec![u.sqrt(), 2.0 * u.sqrt(), 0.1]),
            })
        };
        let found = minimise(&curve, &[0.1, 0.2, 0.1], &[4.0], &[1e-4], |_, _, _| {}).unwrap();
        assert!((found.at[0] - 0.01).abs() < 1e-5, "{found:?}");
        let never = minimise(&curve, &[0.1, 0.2, 0.1], &[-1.0], &[1e-4], |_, _, _| {});
        assert_eq!(never.unwrap_err(), Trouble::NoStart("negative".into()));
    }

    /// A coordinate that the curve does not know of stays put and has no derivative.
    #[test]
    fn a_coordinate_without_influence_stays() {
        let curve = |u: &[f64]| values(vec![u[0], 2.0 * u[0], 3.0 * u[0]]);
        let found =
            minimise(&curve, &[2.0, 4.0, 6.0], &[0.5, 0.7], &[1e-2; 2], |_, _, _| {}).unwrap();
        assert!((found.at[0] - 2.0).abs() < 1e-6 && (found.at[1] - 0.7).abs() < 1e-9, "{found:?}");
        assert_eq!(found.jacobian.column(1).amax(), 0.0);
    }

    #[test]
    fn whoever_ends_it_ends_it() {
        let curve = |u: &[f64]| {
            if u[0] == 0.0 { Ok(Trial::Values(vec![0.0, 1.0])) } else { Err("asked to end") }
        };
        let ended = minimise(&curve, &[1.0, 2.0], &[0.0], &[0.1], |_, _, _| {}).unwrap_err();
        assert_eq!(ended, Trouble::Ended("asked to end"));
    }
}
