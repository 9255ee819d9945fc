//! Joint limits in the solve without contact: bounds that bear load are held, `A u = t`.
//!
//! A bound is a row on how two bodies turn against each other, so it involves u alone, and holding
//! it needs no compliance of the flesh: conjugate gradients stay in the space of motions that keep
//! it (the projected method of Gould, Hribar and Nocedal 2001). With M the bodies' block of the
//! preconditioner,
//!
//! ```text
//!   H = M⁻¹ Aᵀ,   G = A H,   z_u = (1 - H G⁻¹ A) M⁻¹ r_u,   λ = -G⁻¹ Hᵀ r_u  at the end
//! ```
//!
//! Which bounds are held is guessed from the step before; those that pull are let go, those that
//! would be passed are added, until `0 ≤ λ ⊥ J v - wanted ≥ 0` for all of them (an active set).

use crate::capacity_vec::CapacityVec;
use crate::math::Vec3;
use crate::solver::TURN_LEVER;
use crate::solver::monolithic::coarse::Coarse;
use crate::solver::monolithic::jacobi::BlockJacobi;
use crate::solver::monolithic::{Coordinates, System, small_cholesky};

/// A pivot of G below this part of its diagonal: the rows depend on each other.
const DEPENDENT: f64 = 1e-6;

/// A bound on how a child turns against its parent.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// Child body of the joint.
    pub child: u32,
    /// Parent; the world when `None`.
    pub parent: Option<u32>,
    /// The turn of the child that leads away from the bound, world, of unit length.
    pub axis_W: Vec3,
    /// That turning should be at least this fast, at [`TURN_LEVER`] \[m/s\].
    pub wanted: f64,
    /// Impulse at [`TURN_LEVER`] \[N s\]: before a solve that of the last step, afterwards the one
    /// that is part of the velocities.
    pub impulse: f64,
}

/// The bounds of all joints and how they are held.
#[derive(Clone, Debug)]
pub struct HeldBounds {
    /// All bounds of this step.
    pub bounds: CapacityVec<Bound>,
    freedoms: usize,
    /// Bounds that are held, by their places in `bounds`.
    members: CapacityVec<u32>,
    /// A and H: a row of all freedoms for each of them.
    rows: Vec<f64>,
    answers: Vec<f64>,
    /// Cholesky factor of G.
    gram: Vec<f64>,
    /// A number for each.
    values: Vec<f64>,
}

impl HeldBounds {
    /// Room for `bounds` bounds.
    pub fn new(bounds: usize, freedoms: usize) -> Self {
        // Of the two bounds of an axis one is held at a time.
        let most = bounds.div_ceil(2);
        Self {
            bounds: CapacityVec::with_capacity(bounds),
            freedoms,
            members: CapacityVec::with_capacity(most),
            rows: vec![0.0; most * freedoms],
            answers: vec![0.0; most * freedoms],
            gram: vec![0.0; most * most],
            values: vec![0.0; most],
        }
    }

    /// Holds the bounds that bore load in the step before.
    pub fn guess(&mut self) {
        self.members.clear();
        let loaded = (0..self.bounds.len()).filter(|&i| self.bounds[i].impulse > 0.0);
        let most = self.values.len();
        self.members.extend(loaded.take(most).map(|i| i as u32));
    }

    /// Holds none.
    pub fn release(&mut self) {
        self.members.clear();
        self.bounds.iter_mut().for_each(|bound| bound.impulse = 0.0);
    }

    /// Prepares for the present members and brings x onto their bounds. False, and none is held,
    /// when they depend on each other.
    pub fn hold(
        &mut self,
        system: &System<'_>,
        coarse: &Coarse,
        jacobi: &BlockJacobi,
        x: &mut Coordinates,
    ) -> bool {
        let (n, m) = (self.freedoms, self.members.len());
        for k in 0..m {
            let bound = self.bounds[self.members[k] as usize];
            let row = &mut self.rows[k * n..(k + 1) * n];
            row.fill(0.0);
            for (body, sign) in [(Some(bound.child), TURN_LEVER), (bound.parent, -TURN_LEVER)] {
                let Some(body) = body.filter(|&b| moves(system, b)) else { continue };
                for (dof, column) in system.bodies.columns(body as usize) {
                    let turn = Vec3::new(column[3], column[4], column[5]);
                    row[dof] += sign * turn.dot(&bound.axis_W);
                }
            }
            let answer = &mut self.answers[k * n..(k + 1) * n];
            answer.copy_from_slice(row);
            jacobi.solve_bodies(system, coarse, answer);
        }
        for k in 0..m {
            for l in 0..=k {
                self.gram[k * m + l] = dot(row(&self.rows, n, k), row(&self.answers, n, l));
            }
            self.values[k] = self.gram[k * m + k];
        }
        let gram = &mut self.gram[..m * m];
        let sound = small_cholesky::factor(gram, m)
            && (0..m).all(|k| gram[k * m + k].powi(2) > DEPENDENT * self.values[k]);
        if !sound {
            self.release();
            return false;
        }
        for k in 0..m {
            let bound = &self.bounds[self.members[k] as usize];
            self.values[k] = bound.wanted - turning(system, bound, &x.u);
        }
        self.spread(1.0, &mut x.u);
        true
    }

    /// `z = (1 - H G⁻¹ A) z`.
    pub fn project(&mut self, z: &mut Coordinates) {
        for k in 0..self.members.len() {
            self.values[k] = dot(row(&self.rows, self.freedoms, k), &z.u);
        }
        self.spread(-1.0, &mut z.u);
    }

    /// `u += s H G⁻¹ values`.
    fn spread(&mut self, s: f64, u: &mut [f64]) {
        let (n, m) = (self.freedoms, self.members.len());
        let values = &mut self.values[..m];
        small_cholesky::forward(&self.gram[..m * m], m, values);
        small_cholesky::backward(&self.gram[..m * m], m, values);
        for (k, value) in values.iter().enumerate() {
            let pairs = u.iter_mut().zip(row(&self.answers, n, k));
            pairs.for_each(|(u, h)| *u += s * value * h);
        }
    }

    /// Finds the impulses from the residual `r` at the solution x, and lets go or adds bounds. True
    /// when there was nothing to change: no bound pulls, and none is passed by more than
    /// `tolerance` \[m/s\].
    pub fn revise(
        &mut self,
        system: &System<'_>,
        x: &Coordinates,
        r: &Coordinates,
        tolerance: f64,
    ) -> bool {
        let (n, m) = (self.freedoms, self.members.len());
        for k in 0..m {
            self.values[k] = -dot(row(&self.answers, n, k), &r.u);
        }
        small_cholesky::forward(&self.gram[..m * m], m, &mut self.values[..m]);
        small_cholesky::backward(&self.gram[..m * m], m, &mut self.values[..m]);
        self.bounds.iter_mut().for_each(|bound| bound.impulse = 0.0);
        for (&i, impulse) in self.members.iter().zip(&self.values) {
            self.bounds[i as usize].impulse = *impulse;
        }
        let before = self.members.len();
        let bounds = &self.bounds;
        self.members.retain(|&i| bounds[i as usize].impulse >= 0.0);
        let mut settled = self.members.len() == before;
        for (i, bound) in self.bounds.iter().enumerate() {
            let passed = bound.wanted - turning(system, bound, &x.u);
            let free = bound.impulse == 0.0 && !self.members.contains(&(i as u32));
            let movable =
                moves(system, bound.child) || bound.parent.is_some_and(|p| moves(system, p));
            if free && movable && passed > tolerance && self.members.len() < self.values.len() {
                self.members.push(i as u32);
                settled = false;
            }
        }
        settled
    }
}

fn row(rows: &[f64], n: usize, k: usize) -> &[f64] {
    &rows[k * n..(k + 1) * n]
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn moves(system: &System<'_>, body: u32) -> bool {
    system.bodies.group_of_body(body as usize).is_some()
}

/// Returns the speed at which the bodies turn away from the bound, at [`TURN_LEVER`] \[m/s\].
fn turning(system: &System<'_>, bound: &Bound, u: &[f64]) -> f64 {
    let of = |body: u32| {
        let columns = system.bodies.columns(body as usize);
        let turn: Vec3 = columns.map(|(d, c)| Vec3::new(c[3], c[4], c[5]) * u[d]).sum();
        system.bodies.offset(body as usize)[1] + turn
    };
    let relative = of(bound.child) - bound.parent.map_or(Vec3::zeros(), of);
    TURN_LEVER * relative.dot(&bound.axis_W)
}
