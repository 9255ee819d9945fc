//! Preconditioned conjugate gradients to a velocity tolerance.
//!
//! Each iteration lowers the energy of the error, `eᵀ K e`, by exactly `d = α r·z` (Hestenes and
//! Stiefel 1952), so the error left is the sum of the decreases to come. They are continued as a
//! geometric series at the slowest rate of the last few iterations, and turned into a speed by the
//! largest that one of these moved:
//!
//! ```text
//!   error ≈ 2 max|T Δx| sqrt(ρ / (1 - ρ)),   ρ = max d_k+1 / d_k
//! ```
//!
//! It is an estimate, tested to hold over six decades, not a bound.

use crate::math::Vec3;
use crate::solver::TURN_LEVER;
use crate::solver::monolithic::vectors::longest2;
use crate::solver::monolithic::{Coordinates, System};
use fearless_simd::{Level, dispatch};

/// Safety factor of the error estimate.
const SAFETY: f64 = 2.0;
/// Iterations that the estimate looks back on.
const WINDOW: usize = 4;
/// Decreases are not trusted to shrink slower than this.
const RATE_MAX: f64 = 0.95;
/// Nor faster: a first decrease is mostly that of the stiffest motions, and says little of free
/// ones.
const RATE_MIN: f64 = 1e-9;
/// Round-off: part of the largest speed beyond which no accuracy is asked for.
const ROUND_OFF: f64 = 1e-13;
/// An iteration is trusted to leave at most this many times the energy that others did.
const LEFT_SAFETY: f64 = 100.0;
/// From this share of its iterations on, a solve that may give up looks at what is left. Errors
/// rise at first.
const LOOKS_FROM: f64 = 0.4;
/// Gives up where more than this many times the share of its iterations is left of the way, in
/// decades of the error. In eight runs of the default and the paper's hand, free, in a fist and a
/// pinch, at 5 to 20 ms, 57 of 1448 solves that would have met the tolerance in time are given up,
/// and 1335 that would not have take half of their iterations.
const WAY_LEFT: f64 = 1.2;
/// Iterations without a new least residual after which there is nothing more to gain.
const PATIENCE: u32 = 30;

/// Outcome of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PcgOutcome {
    /// Iterations done.
    pub iterations: u32,
    /// Estimated largest velocity error \[m/s\]; not a number when the system holds one that is not
    /// finite.
    pub error: f64,
    /// The error asked for was reached, as far as numbers of this size allow.
    pub converged: bool,
    /// The largest part of the error's energy that an iteration has left, as far as is known.
    pub left: Option<f64>,
}

/// Vectors that the iteration works in.
#[derive(Clone, Debug)]
pub struct Workspace {
    /// Residual; the caller sets it to that of the start value.
    pub r: Coordinates,
    z: Coordinates,
    p: Coordinates,
    /// Another, for products.
    pub q: Coordinates,
    /// Velocity-like vectors of the whole system.
    pub v: Vec<Vec3>,
    /// Flesh, likewise.
    pub f: Vec<Vec3>,
}

impl Workspace {
    /// Room for this many unknowns.
    pub fn new(freedoms: usize, bodies: usize, nodes: usize) -> Self {
        let zeros = Coordinates::new(freedoms, nodes);
        let rows = vec![Vec3::zeros(); 2 * bodies + nodes];
        Self {
            r: zeros.clone(),
            z: zeros.clone(),
            p: zeros.clone(),
            q: zeros,
            v: rows.clone(),
            f: rows,
        }
    }
}

/// Stopping rules of the iteration.
#[derive(Clone, Copy, Debug)]
pub struct StoppingCriteria {
    /// Largest velocity error \[m/s\].
    pub tolerance: f64,
    /// Fewest iterations: a weak preconditioner may seem to converge at first.
    pub iterations_min: u32,
    /// Most iterations.
    pub iterations_max: u32,
    /// A speed of the solution \[m/s\]: of this, nothing below round-off is asked for.
    pub scale: f64,
    /// Part of an error's energy that iterations with this preconditioner have left: where it is
    /// small enough to meet the tolerance, the preconditioner is not asked again.
    pub left: Option<f64>,
    /// Ends as soon as the most iterations will probably not be enough, where something else is at
    /// hand.
    pub gives_up: bool,
}

impl StoppingCriteria {
    /// True when an error that has come down from its largest to this will probably not meet the
    /// tolerance in time.
    fn is_hopeless(&self, iterations: u32, largest: f64, error: f64) -> bool {
        let done = f64::from(iterations) / f64::from(self.iterations_max);
        let way = |from: f64| (from / self.tolerance).ln();
        self.gives_up && done >= LOOKS_FROM && way(error) > WAY_LEFT * (1.0 - done) * way(largest)
    }
}

/// Improves `x` from the residual in `work.r` until the estimated error is small enough;
/// `precondition(r, z)` computes `z = P⁻¹ r`.
pub fn solve(
    system: &System<'_>,
    mut precondition: impl FnMut(&Coordinates, &mut Coordinates),
    x: &mut Coordinates,
    stop: StoppingCriteria,
    work: &mut Workspace,
) -> PcgOutcome {
    debug_assert_eq!(x.u.len(), work.r.u.len(), "freedoms of bodies, of their residual");
    debug_assert_eq!(x.w.len(), work.r.w.len(), "nodes, of their residual");
    debug_assert!(stop.tolerance > 0.0, "a tolerance of {} m/s, not above 0", stop.tolerance);
    let Workspace { r, z, p, q, v, f } = work;
    precondition(r, z);
    p.copy_from(z);
    let mut rz = r.dot(z);
    let first = rz;
    let (mut least, mut waited) = (f64::INFINITY, 0);
    let (mut rates, mut speeds) = ([0.0_f64; WINDOW], [0.0_f64; WINDOW]);
    let mut drop_before = f64::INFINITY;
    let mut scale = stop.scale;
    let mut largest = stop.tolerance;
    let mut solved = PcgOutcome { iterations: 0, error: 0.0, converged: true, left: stop.left };
    // A residual that has come down to round-off cannot come down further.
    while rz > ROUND_OFF * ROUND_OFF * first || (solved.iterations == 0 && rz > 0.0) {
        system.product(p, q, v, f);
        let along = p.dot(q);
        let slope = p.dot(r);
        if along <= 0.0 || slope == 0.0 {
            // All directions are used up, or the matrix is not positive definite.
            solved.converged = solved.iterations > 0 && solved.error <= stop.tolerance;
            return solved;
        }
        // Not r·z: where directions are used up p is left with round-off, of which r·z knows
        // nothing, and the step would be anything.
        let alpha = slope / along;
        let drop = alpha * slope;
        let moved = alpha.abs() * largest_speed(v, system.bodies.bodies());
        x.add(alpha, p);
        r.add(-alpha, q);
        if let Some(left) = stop.left.filter(|_| moved.is_finite() && stop.iterations_min <= 1) {
            let rate = (LEFT_SAFETY * left).clamp(RATE_MIN, RATE_MAX);
            let error = SAFETY * moved * (rate / (1.0 - rate)).sqrt();
            if error <= stop.tolerance {
                return PcgOutcome { iterations: solved.iterations + 1, error, ..solved };
            }
        }
        precondition(r, z);
        let rz_new = r.dot(z);
        // Polak-Ribière: bears a preconditioner that is not quite symmetric.
        let beta = -alpha * z.dot(q) / rz;
        solved.iterations += 1;

        let at = solved.iterations as usize % WINDOW;
        (rates[at], speeds[at]) = (drop / drop_before, moved);
        // What the next iteration will lower, if its step is as long.
        let ahead = alpha * rz_new.max(0.0) / drop;
        solved.left = Some(solved.left.unwrap_or(0.0).max(ahead));
        let slowest = rates.iter().copied().fold(ahead, f64::max);
        let rate = slowest.clamp(RATE_MIN, RATE_MAX);
        let speed = speeds.iter().copied().fold(0.0, f64::max);
        solved.error = SAFETY * speed * (rate / (1.0 - rate)).sqrt();
        scale = scale.max(moved);
        largest = largest.max(solved.error);
        drop_before = drop;
        if rz_new < 0.5 * least {
            (least, waited) = (rz_new, 0);
        } else {
            waited += 1;
        }
        // `max` leaves out what is not a number: the step itself must be one.
        if !(moved.is_finite() && solved.error.is_finite()) {
            return PcgOutcome { error: f64::NAN, converged: false, ..solved };
        }
        // Where the decreases hardly shrink (a slender bar at rest) they tell nothing of their sum.
        let enough = solved.error <= stop.tolerance && slowest < RATE_MAX;
        if (enough || speed <= ROUND_OFF * scale) && solved.iterations >= stop.iterations_min {
            return solved;
        }
        let ran_out = solved.iterations >= stop.iterations_max || waited > PATIENCE;
        if ran_out || stop.is_hopeless(solved.iterations, largest, solved.error) {
            return PcgOutcome { converged: false, ..solved };
        }
        p.renew(beta, z);
        rz = rz_new;
    }
    if !rz.is_finite() {
        return PcgOutcome { error: f64::NAN, converged: false, ..solved };
    }
    solved.converged = rz >= 0.0;
    solved.error = solved.error.min(ROUND_OFF * scale);
    solved
}

/// Largest speed in a velocity-like vector \[m/s\].
pub fn largest_speed(v: &[Vec3], bodies: usize) -> f64 {
    let (bones, nodes) = v.split_at(2 * bodies);
    let turning = bones.iter().skip(1).step_by(2).map(|v| v.norm_squared());
    let turning2 = turning.fold(0.0, f64::max) * TURN_LEVER * TURN_LEVER;
    let linear = bones.iter().step_by(2).map(|v| v.norm_squared());
    let nodes2 = dispatch!(Level::new(), _simd => longest2(nodes));
    linear.fold(nodes2.max(turning2), f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stop(iterations_max: u32) -> StoppingCriteria {
        let tolerance = 1e-5;
        StoppingCriteria {
            tolerance,
            iterations_min: 1,
            iterations_max,
            scale: 0.0,
            left: None,
            gives_up: true,
        }
    }

    /// Iterations after which a solve is given up whose error falls from 10⁻² by `decades` decades
    /// in each, after a tenth of the iterations in which it does not.
    fn given_up(stop: &StoppingCriteria, decades: f64) -> Option<u32> {
        let rises = stop.iterations_max / 10;
        (1..=stop.iterations_max).find(|&k| {
            let error = 1e-2 * 10_f64.powf(-decades * f64::from(k.saturating_sub(rises)));
            stop.is_hopeless(k, 1e-2, error)
        })
    }

    #[test]
    fn what_converges_in_time_is_not_given_up_and_what_does_not_is_early() {
        for most in [10, 33, 100, 400] {
            let in_time = 3.0 / f64::from(most - most / 10);
            assert_eq!(given_up(&stop(most), in_time), None, "{most}");
            let early = given_up(&stop(most), 0.5 * in_time).expect("half as fast");
            assert!(f64::from(early) <= 0.41 * f64::from(most) + 1.0, "{early} of {most}");
            assert_eq!(given_up(&StoppingCriteria { gives_up: false, ..stop(most) }, 0.0), None);
        }
        // Nothing that meets the tolerance is hopeless, whatever the iterations.
        assert!(!stop(10).is_hopeless(9, 1e-5, 1e-5) && !stop(10).is_hopeless(10, 1e-2, 0.9e-5));
    }
}
