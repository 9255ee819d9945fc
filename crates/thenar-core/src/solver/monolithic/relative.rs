//! Flesh relative to its skinned motion: `v_f = J v_s + w`, and the system in (u, w).
//!
//! With `v = T (u, w) + v̄` the system A v = b of Eq. 9 becomes `Tᵀ A T (u, w) = Tᵀ (b - A v̄)`, in
//! which the coupling springs act on w alone. A here leaves these springs out; they are the
//! diagonal G. Nothing is formed: a product is T, then A, then Tᵀ.

use crate::math::Vec3;
use crate::solver::block_matrix::vector;
use crate::solver::monolithic::Reduction;
use crate::solver::monolithic::vectors::{self, flat, flat_mut};
use crate::solver::{BlockMatrix, Turning};
use fearless_simd::{Level, Simd, dispatch};

/// A node that bones carry.
#[derive(Clone, Copy, Debug)]
pub struct CarriedNode {
    /// Number of the node.
    pub node: u32,
    /// Bones and how many of them count.
    pub bones: [u32; 2],
    /// 1 or 2.
    pub bone_count: u8,
    /// Axes along which the node is held: there its velocity is given in the world, w is that
    /// velocity itself, and the spring ties the bones to the world.
    pub held: [bool; 3],
    /// Skinning weights.
    pub weights: [f64; 2],
    /// Motion of its target as bones turn.
    pub turning: Turning,
    /// `Δt² k + Δt c` \[kg\].
    pub spring: f64,
    /// `Δt k (x - f)` at the start of the step \[N s\].
    pub stretch: Vec3,
}

impl CarriedNode {
    /// True when the node is held along some axis.
    pub fn is_held(&self) -> bool {
        self.held != [false; 3]
    }

    /// The components along the axes that are not held.
    #[inline]
    pub fn free(&self, f: &Vec3) -> Vec3 {
        Vec3::from_fn(|k, _| if self.held[k] { 0.0 } else { f[k] })
    }

    /// `J v_s`: the velocity of the node's target.
    #[inline(always)]
    pub fn follow(&self, v: &[Vec3]) -> Vec3 {
        let mut moved = Vec3::zeros();
        for j in 0..self.bone_count as usize {
            let b = 2 * self.bones[j] as usize;
            moved += v[b] * self.weights[j] + v[b + 1].cross(&self.turning.levers[j]);
        }
        if let Some(apart) = &self.turning.apart {
            let spin = |j: usize| v[2 * self.bones[j] as usize + 1];
            moved += apart.velocity(&(spin(0) - spin(1)));
        }
        moved
    }

    /// `f_s += Jᵀ f`.
    #[inline]
    pub fn pull(&self, impulse: &Vec3, f: &mut [Vec3]) {
        for j in 0..self.bone_count as usize {
            let b = 2 * self.bones[j] as usize;
            f[b] += impulse * self.weights[j];
            f[b + 1] += self.turning.torque(j, impulse);
        }
    }
}

/// Unknowns or residuals of the reduced system.
#[derive(Clone, Debug)]
pub struct Coordinates {
    /// Per freedom of the bodies.
    pub u: Vec<f64>,
    /// Per node.
    pub w: Vec<Vec3>,
}

impl Coordinates {
    /// Zeros of this size.
    pub fn new(freedoms: usize, nodes: usize) -> Self {
        Self { u: vec![0.0; freedoms], w: vec![Vec3::zeros(); nodes] }
    }

    /// Sets all to zero.
    pub fn clear(&mut self) {
        self.u.fill(0.0);
        self.w.fill(Vec3::zeros());
    }

    /// Scalar product.
    pub fn dot(&self, other: &Self) -> f64 {
        dispatch!(Level::new(), simd => {
            vectors::dot(simd, &self.u, &other.u)
                + vectors::dot(simd, flat(&self.w), flat(&other.w))
        })
    }

    /// `self += s other`.
    pub fn add(&mut self, s: f64, other: &Self) {
        dispatch!(Level::new(), simd => {
            vectors::add(simd, &mut self.u, s, &other.u);
            vectors::add(simd, flat_mut(&mut self.w), s, flat(&other.w));
        });
    }

    /// `self = other + s self`.
    pub fn renew(&mut self, s: f64, other: &Self) {
        dispatch!(Level::new(), simd => {
            vectors::renew(simd, &mut self.u, s, &other.u);
            vectors::renew(simd, flat_mut(&mut self.w), s, flat(&other.w));
        });
    }

    /// Takes over all values.
    pub fn copy_from(&mut self, other: &Self) {
        self.u.copy_from_slice(&other.u);
        self.w.copy_from_slice(&other.w);
    }
}

/// The system of one step, seen through T.
#[derive(Clone, Copy, Debug)]
pub struct System<'a> {
    /// Eq. 9's matrix without the coupling springs.
    pub A: &'a BlockMatrix,
    /// Index of the first flesh column in each row of A.
    pub split: &'a [u32],
    /// Z and z.
    pub bodies: &'a Reduction,
    /// Carried nodes.
    pub carried: &'a [CarriedNode],
    /// Components given from outside, per block row of A.
    pub known: &'a [[bool; 3]],
    /// G: spring of each node to its target \[kg\].
    pub springs: &'a [f64],
}

impl System<'_> {
    /// Block row of node 0.
    fn row0(&self) -> usize {
        2 * self.bodies.bodies()
    }

    /// `v = T x`.
    pub fn spread(&self, x: &Coordinates, v: &mut [Vec3]) {
        dispatch!(Level::new(), simd => self.spread_lanes(simd, x, v));
    }

    #[inline(always)]
    fn spread_lanes<S: Simd>(&self, simd: S, x: &Coordinates, v: &mut [Vec3]) {
        self.bodies.spread(simd, &x.u, v);
        self.place_flesh(x, v);
    }

    /// `v = T x + v̄`: the velocities that coordinates stand for.
    pub fn velocities(&self, x: &Coordinates, v: &mut [Vec3]) {
        dispatch!(Level::new(), simd => {
            self.bodies.spread(simd, &x.u, v);
            self.bodies.add_offsets(v);
            self.place_flesh(x, v);
        });
    }

    #[inline(always)]
    fn place_flesh(&self, x: &Coordinates, v: &mut [Vec3]) {
        let (bones, nodes) = v.split_at_mut(self.row0());
        nodes.copy_from_slice(&x.w);
        for c in self.carried {
            let moved = c.follow(bones);
            let node = &mut nodes[c.node as usize];
            *node += if c.is_held() { c.free(&moved) } else { moved };
        }
    }

    /// Coordinates near to given velocities.
    pub fn coordinates(&self, v: &[Vec3], x: &mut Coordinates, work: &mut [Vec3]) {
        let row0 = self.row0();
        self.bodies.rates(v, &mut x.u);
        dispatch!(Level::new(), simd => self.bodies.spread(simd, &x.u, work));
        self.bodies.add_offsets(work);
        x.w.copy_from_slice(&v[row0..]);
        for c in self.carried {
            x.w[c.node as usize] -= c.free(&c.follow(work));
        }
    }

    /// Coordinates near to a given change of velocities.
    pub fn coordinates_of_change(&self, change: &[Vec3], x: &mut Coordinates, work: &mut [Vec3]) {
        let row0 = self.row0();
        work[..row0].copy_from_slice(&change[..row0]);
        self.bodies.add_offsets(work);
        self.bodies.rates(work, &mut x.u);
        dispatch!(Level::new(), simd => self.bodies.spread(simd, &x.u, work));
        x.w.copy_from_slice(&change[row0..]);
        for c in self.carried {
            x.w[c.node as usize] -= c.free(&c.follow(work));
        }
    }

    /// `r = Tᵀ f`; overwrites the bodies' part of f.
    pub fn gather(&self, f: &mut [Vec3], r: &mut Coordinates) {
        dispatch!(Level::new(), simd => self.gather_lanes(simd, f, r));
    }

    #[inline(always)]
    fn gather_lanes<S: Simd>(&self, simd: S, f: &mut [Vec3], r: &mut Coordinates) {
        let (bones, nodes) = f.split_at_mut(self.row0());
        // What bones get from a run of nodes that the same bones carry.
        let (mut pair, mut sums) = ((u32::MAX, u32::MAX), [Vec3::zeros(); 4]);
        for c in self.carried {
            let next = (c.bones[0], if c.bone_count == 2 { c.bones[1] } else { u32::MAX });
            if next != pair {
                hand_over(pair, &mut sums, bones);
                pair = next;
            }
            let at = &nodes[c.node as usize];
            let impulse = if c.is_held() { c.free(at) } else { *at };
            for j in 0..2.min(c.bone_count as usize) {
                sums[2 * j] += impulse * c.weights[j];
                sums[2 * j + 1] += c.turning.levers[j].cross(&impulse);
            }
            if let Some(apart) = &c.turning.apart {
                let torque = apart.torque(&impulse);
                sums[1] += torque;
                sums[3] -= torque;
            }
        }
        hand_over(pair, &mut sums, bones);
        r.w.copy_from_slice(nodes);
        self.bodies.gather(simd, bones, &mut r.u);
    }

    /// `q = A v`; A without springs has no blocks between bodies and flesh.
    #[inline(always)]
    fn times<S: Simd>(&self, simd: S, v: &[Vec3], q: &mut [Vec3]) {
        let (A, row0) = (self.A, self.row0());
        for i in 0..row0 {
            q[i] = vector(A.part_times_lanes(simd, A.row_start[i]..self.split[i], v));
        }
        for i in row0..q.len() {
            q[i] = vector(A.part_times_lanes(simd, self.split[i]..A.row_start[i + 1], v));
        }
    }

    /// `y = Tᵀ A T x + G x`. Leaves `T x` in `v`.
    pub fn product(&self, x: &Coordinates, y: &mut Coordinates, v: &mut [Vec3], q: &mut [Vec3]) {
        dispatch!(Level::new(), simd => self.product_lanes(simd, x, y, v, q));
    }

    #[inline(always)]
    fn product_lanes<S: Simd>(
        &self,
        simd: S,
        x: &Coordinates,
        y: &mut Coordinates,
        v: &mut [Vec3],
        q: &mut [Vec3],
    ) {
        let row0 = self.row0();
        self.spread_lanes(simd, x, v);
        self.times(simd, v, q);
        for c in self.carried.iter().filter(|c| c.is_held()) {
            let pull = (v[row0 + c.node as usize] - c.follow(v)) * c.spring;
            c.pull(&(c.free(&pull) - pull), q);
        }
        self.gather_lanes(simd, q, y);
        self.bodies.add_held(&x.u, &mut y.u);
        for c in self.carried {
            let n = c.node as usize;
            let pull = x.w[n] * c.spring;
            y.w[n] += if c.is_held() { c.free(&pull) } else { pull };
        }
    }

    /// `r = Tᵀ (b - A (T x + v̄))` less the springs.
    pub fn residual(
        &self,
        b: &[Vec3],
        x: &Coordinates,
        r: &mut Coordinates,
        v: &mut [Vec3],
        q: &mut [Vec3],
    ) {
        let row0 = self.row0();
        self.velocities(x, v);
        dispatch!(Level::new(), simd => self.times(simd, v, q));
        q.iter_mut().zip(b).for_each(|(q, b)| *q = b - *q);
        for c in self.carried.iter().filter(|c| c.is_held()) {
            let pull = (v[row0 + c.node as usize] - c.follow(v)) * c.spring + c.stretch;
            c.pull(&(pull - c.free(&pull)), q);
        }
        self.gather(q, r);
        for c in self.carried {
            let n = c.node as usize;
            r.w[n] -= c.free(&(x.w[n] * c.spring + c.stretch));
        }
    }

    /// The components of a block row that are not given from outside.
    pub fn unknown(&self, row: usize, f: &Vec3) -> Vec3 {
        let known = &self.known[row];
        Vec3::from_fn(|k, _| if known[k] { 0.0 } else { f[k] })
    }
}

/// Adds to the bones what was gathered for them (force and torque of the first, then of the second)
/// and begins anew.
#[inline(always)]
fn hand_over(bone_count: (u32, u32), sums: &mut [Vec3; 4], bones: &mut [Vec3]) {
    for (j, bone) in [bone_count.0, bone_count.1].into_iter().enumerate() {
        if bone != u32::MAX {
            bones[2 * bone as usize] += sums[2 * j];
            bones[2 * bone as usize + 1] += sums[2 * j + 1];
        }
    }
    *sums = [Vec3::zeros(); 4];
}
