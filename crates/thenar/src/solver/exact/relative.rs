//! Flesh relative to its skinned motion: `v_f = J v_s + w`, and the system in (u, w).
//!
//! With `v = T (u, w) + v̄` the system A v = b of Eq. 9 becomes `Tᵀ A T (u, w) = Tᵀ (b - A v̄)`, in
//! which the coupling springs act on w alone. A here leaves these springs out; they are the
//! diagonal G. Nothing is formed: a product is T, then A, then Tᵀ.

use crate::math::Vec3;
use crate::solver::BlockMatrix;
use crate::solver::exact::Reduction;

/// A node that bones carry.
#[derive(Clone, Copy, Debug)]
pub struct Carried {
    /// Node.
    pub node: u32,
    /// Bones and how many of them count.
    pub bones: [u32; 2],
    /// 1 or 2.
    pub carriers: u8,
    /// Axes along which the node is held: there its velocity is given in the world, w is that
    /// velocity itself, and the spring ties the bones to the world.
    pub held: [bool; 3],
    /// Skinning weights.
    pub weights: [f64; 2],
    /// Weighted levers, world \[m\].
    pub levers: [Vec3; 2],
    /// `Δt² k + Δt c` \[kg\].
    pub spring: f64,
    /// `Δt k (x - f)` at the start of the step \[N s\].
    pub stretch: Vec3,
}

impl Carried {
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
    #[inline]
    pub fn follow(&self, v: &[Vec3]) -> Vec3 {
        let mut moved = Vec3::zeros();
        for j in 0..self.carriers as usize {
            let b = 2 * self.bones[j] as usize;
            moved += v[b] * self.weights[j] + v[b + 1].cross(&self.levers[j]);
        }
        moved
    }

    /// `f_s += Jᵀ f`.
    #[inline]
    pub fn pull(&self, impulse: &Vec3, f: &mut [Vec3]) {
        for j in 0..self.carriers as usize {
            let b = 2 * self.bones[j] as usize;
            f[b] += impulse * self.weights[j];
            f[b + 1] += self.levers[j].cross(impulse);
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
    /// Zeros.
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
        let u: f64 = self.u.iter().zip(&other.u).map(|(a, b)| a * b).sum();
        let mut w = [0.0; 3];
        for (a, b) in self.w.iter().zip(&other.w) {
            for k in 0..3 {
                w[k] += a[k] * b[k];
            }
        }
        u + w[0] + w[1] + w[2]
    }

    /// `self += s other`.
    pub fn add(&mut self, s: f64, other: &Self) {
        self.u.iter_mut().zip(&other.u).for_each(|(a, b)| *a += s * b);
        self.w.iter_mut().zip(&other.w).for_each(|(a, b)| *a += b * s);
    }

    /// `self = other + s self`.
    pub fn renew(&mut self, s: f64, other: &Self) {
        self.u.iter_mut().zip(&other.u).for_each(|(a, b)| *a = b + s * *a);
        self.w.iter_mut().zip(&other.w).for_each(|(a, b)| *a = b + *a * s);
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
    /// Where the flesh columns begin in each row of A.
    pub split: &'a [u32],
    /// Z and z.
    pub bodies: &'a Reduction,
    /// Carried nodes.
    pub carried: &'a [Carried],
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
        self.bodies.spread(&x.u, v);
        self.place_flesh(x, v);
    }

    /// `v = T x + v̄`: the velocities that coordinates stand for.
    pub fn velocities(&self, x: &Coordinates, v: &mut [Vec3]) {
        self.bodies.spread(&x.u, v);
        self.bodies.add_offsets(v);
        self.place_flesh(x, v);
    }

    fn place_flesh(&self, x: &Coordinates, v: &mut [Vec3]) {
        let row0 = self.row0();
        v[row0..].copy_from_slice(&x.w);
        for c in self.carried {
            let moved = c.free(&c.follow(v));
            v[row0 + c.node as usize] += moved;
        }
    }

    /// Coordinates near to given velocities.
    pub fn coordinates(&self, v: &[Vec3], x: &mut Coordinates, work: &mut [Vec3]) {
        let row0 = self.row0();
        self.bodies.rates(v, &mut x.u);
        self.bodies.spread(&x.u, work);
        self.bodies.add_offsets(work);
        x.w.copy_from_slice(&v[row0..]);
        for c in self.carried {
            x.w[c.node as usize] -= c.free(&c.follow(work));
        }
    }

    /// `r = Tᵀ f`; overwrites the bodies' part of f.
    pub fn gather(&self, f: &mut [Vec3], r: &mut Coordinates) {
        let row0 = self.row0();
        for c in self.carried {
            let impulse = c.free(&f[row0 + c.node as usize]);
            c.pull(&impulse, f);
        }
        self.bodies.gather(f, &mut r.u);
        r.w.copy_from_slice(&f[row0..]);
    }

    /// `q = A v`; A without springs has no blocks between bodies and flesh.
    fn times(&self, v: &[Vec3], q: &mut [Vec3]) {
        let row0 = self.row0();
        for i in 0..row0 {
            q[i] = self.A.part_times(self.A.row_start[i]..self.split[i], v);
        }
        for i in row0..q.len() {
            q[i] = self.A.part_times(self.split[i]..self.A.row_start[i + 1], v);
        }
    }

    /// `y = Tᵀ A T x + G x`. Leaves `T x` in `v`.
    pub fn product(&self, x: &Coordinates, y: &mut Coordinates, v: &mut [Vec3], q: &mut [Vec3]) {
        let row0 = self.row0();
        self.spread(x, v);
        self.times(v, q);
        for c in self.carried.iter().filter(|c| c.is_held()) {
            let pull = (v[row0 + c.node as usize] - c.follow(v)) * c.spring;
            c.pull(&(c.free(&pull) - pull), q);
        }
        self.gather(q, y);
        self.bodies.add_held(&x.u, &mut y.u);
        for c in self.carried {
            let n = c.node as usize;
            y.w[n] += c.free(&(x.w[n] * c.spring));
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
        self.times(v, q);
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
