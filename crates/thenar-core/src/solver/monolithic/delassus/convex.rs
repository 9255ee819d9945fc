//! From convex problems to the law, where neither sweeps nor Newton's method find it.
//!
//! With slip speeds `s = μ |d_t|` given for all contacts, the law reads (De Saxcé and Feng 1998)
//!
//! ```text
//!   K ∋ λ  ⊥  W λ + b + s e_n ∈ K*        K the cones of friction, K* their duals
//! ```
//!
//! and is the optimum of a convex problem, `½ λᵀ W λ + (b + s e_n)·λ` over K. Impulses that slip as
//! it was assumed of them obey the law, and there are such slips where zero velocity obeys all rows
//! (Acary, Cadoux, Lemaréchal and Malick 2011). Each problem tells the slips of the next, half of
//! their way; what Newton's method makes of its impulses is tried now and then. A problem is
//! brought nearer to its optimum by alternating directions (ADMM; Boyd et al. 2011, Sec. 5),
//!
//! ```text
//!   x = (W + ρ)⁻¹ (ρ (z - u) - b - s e_n),   z ← K(x + u),   u ← u + x - z
//! ```
//!
//! in units in which each contact's own response is about one, x over-relaxed.

use crate::math::Vec3;
use crate::solver::ContactRows;
use crate::solver::contact_law::is_immovable;
use crate::solver::monolithic::compliance::Compliance;
use crate::solver::monolithic::factor::LANES;
use crate::solver::monolithic::wide_cholesky;
use fearless_simd::Simd;

/// Members at most: with more, the factor costs as much as sweeps are allowed to.
pub const MEMBERS_MAX: usize = 128;
/// Penalty of the alternating directions, in a contact's own response, and Boyd's usual
/// over-relaxation. Nine steps of jammed hands converge with a penalty of 0.1 as well; with 1 two
/// of them do not within 48 problems.
const PENALTY: f64 = 0.3;
const RELAXATION: f64 = 1.6;
/// Alternations for each problem: it need not be solved, as the next one is another.
pub const ALTERNATIONS: usize = 30;

/// A problem and its impulses.
#[derive(Debug)]
pub struct Convex {
    capacity: usize,
    /// Cholesky factor of `W + ρ`, row by row.
    gram: Vec<f64>,
    /// Square root of each member's own response; zero where no impulse moves it.
    scale: Vec<f64>,
    friction: Vec<f64>,
    slip: Vec<f64>,
    /// Velocities without the members' impulses, less their targets, and with them.
    b: Vec<f64>,
    d: Vec<f64>,
    x: Vec<f64>,
    z: Vec<f64>,
    u: Vec<f64>,
}

/// Nothing in it outlives an attempt; a clone has as much room.
impl Clone for Convex {
    fn clone(&self) -> Self {
        Self::new(self.capacity)
    }
}

impl Convex {
    /// Room for this many members.
    pub fn new(capacity: usize) -> Self {
        let most = MEMBERS_MAX.min(capacity);
        let each = || Vec::with_capacity(most);
        let axes = || Vec::with_capacity((3 * most).next_multiple_of(LANES));
        Self {
            capacity,
            gram: Vec::with_capacity(9 * most * most),
            scale: each(),
            friction: each(),
            slip: each(),
            b: axes(),
            d: axes(),
            x: axes(),
            z: axes(),
            u: axes(),
        }
    }

    /// Begins at the present impulses of the members, whose velocities are `d`; false where there
    /// are too many.
    #[inline(always)]
    pub fn begin<S: Simd>(
        &mut self,
        simd: S,
        members: &[u32],
        contacts: &ContactRows,
        W: &Compliance,
        d: &[f64],
    ) -> bool {
        let n = members.len();
        if n > MEMBERS_MAX.min(self.capacity) {
            return false;
        }
        let Self { gram, scale, friction, slip, b, d: velocities, x, z, u, .. } = self;
        let rows = || members.iter().map(|&i| &contacts.rows[i as usize]);
        scale.clear();
        scale.extend(rows().enumerate().map(|(m, row)| {
            let own = W.own(m);
            // A limit has one axis.
            let mean = if row.turns { own.m11 } else { own.trace() / 3.0 };
            if is_immovable(&own) { 0.0 } else { mean.sqrt() }
        }));
        friction.clear();
        friction.extend(rows().map(|row| row.friction));
        gram.clear();
        gram.extend((0..9 * n * n).map(|k| {
            let (i, j) = (k / (3 * n), k % (3 * n));
            let scales = scale[i / 3] * scale[j / 3];
            let W_ij = if scales > 0.0 { f64::from(W.at(i, j)) / scales } else { 0.0 };
            W_ij + if i == j { PENALTY } else { 0.0 }
        }));
        if !wide_cholesky::factor(simd, gram, 3 * n) {
            return false;
        }
        velocities.clear();
        velocities.extend_from_slice(d);
        b.clear();
        b.extend_from_slice(d);
        for (m, row) in rows().enumerate() {
            W.add_answer(simd, m, &-row.lambda, b);
        }
        z.clear();
        z.extend(
            rows().zip(&*scale).flat_map(|(row, scale)| <[f64; 3]>::from(row.lambda * *scale)),
        );
        x.clear();
        x.resize(3 * n, 0.0);
        u.clear();
        u.resize(3 * n, 0.0);
        slip.clear();
        slip.resize(n, 0.0);
        self.take_slips(1.0);
        true
    }

    /// Goes towards the optimum for the present slips, and takes half of what it says of these;
    /// false where numbers make no sense.
    #[inline(always)]
    pub fn go_on<S: Simd>(&mut self, simd: S, W: &Compliance) -> bool {
        let n = self.scale.len();
        for _ in 0..ALTERNATIONS {
            self.alternate(simd);
        }
        self.d.copy_from_slice(&self.b);
        for m in 0..n {
            let lambda = self.impulse(m);
            W.add_answer(simd, m, &lambda, &mut self.d);
        }
        self.take_slips(0.5);
        self.d.iter().all(|d| d.is_finite())
    }

    /// The impulse of a member.
    pub fn impulse(&self, m: usize) -> Vec3 {
        match self.scale[m] > 0.0 {
            true => Vec3::from_column_slice(&self.z[3 * m..3 * m + 3]) / self.scale[m],
            false => Vec3::zeros(),
        }
    }

    /// Velocities without the members' impulses, less their targets \[m/s\].
    pub fn without(&self) -> &[f64] {
        &self.b
    }

    #[inline(always)]
    fn alternate<S: Simd>(&mut self, simd: S) {
        let Self { gram, scale, friction, slip, b, x, z, u, .. } = self;
        let n = scale.len();
        for m in (0..n).filter(|&m| scale[m] > 0.0) {
            for a in 0..3 {
                let (i, slips) = (3 * m + a, if a == 0 { slip[m] } else { 0.0 });
                x[i] = PENALTY * (z[i] - u[i]) - (b[i] + slips) / scale[m];
            }
        }
        wide_cholesky::solve(simd, gram, 3 * n, x);
        for m in (0..n).filter(|&m| scale[m] > 0.0) {
            let at = 3 * m..3 * m + 3;
            let old = Vec3::from_column_slice(&z[at.clone()]);
            let relaxed = RELAXATION * Vec3::from_column_slice(&x[at.clone()])
                + (1.0 - RELAXATION) * old
                + Vec3::from_column_slice(&u[at.clone()]);
            let nearest = in_cone(friction[m], &relaxed);
            z[at.clone()].copy_from_slice(nearest.as_slice());
            u[at].copy_from_slice((relaxed - nearest).as_slice());
        }
    }

    /// Moves the slips by this part towards those of the present velocities.
    fn take_slips(&mut self, part: f64) {
        for (m, slip) in self.slip.iter_mut().enumerate() {
            let now = self.friction[m] * self.d[3 * m + 1].hypot(self.d[3 * m + 2]);
            *slip += part * (now - *slip);
        }
    }
}

/// The point of the cone `|t| ≤ μ n` that is nearest.
fn in_cone(friction: f64, p: &Vec3) -> Vec3 {
    let t = p.y.hypot(p.z);
    // First, as a limit has neither friction nor tangents.
    if friction * t <= -p.x {
        return Vec3::zeros();
    }
    if t <= friction * p.x {
        return *p;
    }
    let n = (p.x + friction * t) / (1.0 + friction * friction);
    let scale = if t > 0.0 { friction * n / t } else { 0.0 };
    Vec3::new(n, scale * p.y, scale * p.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Cone;
    use crate::random::Random;
    use crate::solver::contact_law::Response;
    use crate::solver::monolithic::delassus::sweeps::visit;
    use fearless_simd::{Level, dispatch};

    /// A step of a hand that is jammed between a toy car, a wall and itself, as a soak at 60 Hz
    /// came to it: 39 contacts and seven limits of joints. Of each member whether it is a limit (1
    /// or 0), its friction, its impulse \[N s\] and the velocity there less the target \[m/s\], as
    /// doubles; then the lower triangle of W \[1/kg\], row by row, as floats. Numbers are
    /// little-endian.
    const STEP: &[u8] = include_bytes!("jammed-hand.bin");
    const MEMBERS: usize = 46;
    const ROWS: usize = (3 * MEMBERS).next_multiple_of(LANES);

    struct Jam {
        W: Compliance,
        contacts: ContactRows,
        d: Vec<f64>,
    }

    impl Jam {
        fn new() -> Self {
            Self::without(0)
        }

        /// Leaves the first `rows` rows and columns of W zero.
        fn without(rows: usize) -> Self {
            let (members, W_lower) = STEP.split_at(MEMBERS * 64);
            let mut contacts = ContactRows::with_capacity(0, MEMBERS);
            let mut d = vec![0.0; ROWS];
            for (m, member) in members.as_chunks::<64>().0.iter().enumerate() {
                let numbers = member.as_chunks::<8>().0;
                let of = |k: usize| f64::from_le_bytes(numbers[k]);
                let impulse = Vec3::new(of(2), of(3), of(4));
                contacts.begin(&Vec3::x(), of(1), &Vec3::zeros());
                let row = &mut contacts.rows[m];
                (row.turns, row.lambda) = (of(0) == 1.0, impulse);
                (0..3).for_each(|a| d[3 * m + a] = of(5 + a));
            }
            let numbers = W_lower.as_chunks::<4>().0;
            let entry = |i: usize, j: usize| match i.max(j) < 3 * MEMBERS && i.min(j) >= rows {
                true => f32::from_le_bytes(numbers[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]),
                false => 0.0,
            };
            let batches = ROWS / LANES;
            let mut W = Compliance::new(batches);
            for (p, q) in (0..batches).flat_map(|p| (0..=p).map(move |q| (p, q))) {
                let mut block = [[0.0_f32; LANES]; LANES];
                for (i, row) in block.iter_mut().enumerate() {
                    for (j, value) in row.iter_mut().enumerate() {
                        *value = entry(LANES * p + i, LANES * q + j);
                    }
                }
                W.set(p, q, &block);
            }
            Self { W, contacts, d }
        }

        /// The most that one sweep changes a contact's own velocity \[m/s\].
        fn sweep<S: Simd>(&mut self, simd: S) -> f64 {
            (0..MEMBERS).fold(0.0, |most, m| {
                let own = Response::new(&self.W.own(m));
                let row = &mut self.contacts.rows[m];
                visit(simd, m, &self.W, &own, Cone::Circular, row, &mut self.d).max(most)
            })
        }
    }

    #[test]
    fn the_nearest_of_a_cone_obeys_its_optimality() {
        let mut random = Random::new(51);
        for case in 0..1000 {
            let (mut friction, mut p) = (random.range(0.0, 2.0), random.vector(1.0));
            if case % 4 == 1 {
                // A limit.
                (friction, p.y, p.z) = (0.0, 0.0, 0.0);
            }
            let q = in_cone(friction, &p);
            assert!(q.y.hypot(q.z) <= friction * q.x + 1e-12);
            // What is taken away is square to the point, and pulls no other of the cone nearer.
            let away = p - q;
            assert!(away.dot(&q).abs() < 1e-12, "{p} {q}");
            assert!(away.x + friction * away.y.hypot(away.z) < 1e-12, "{p} {q}");
        }
    }

    /// From impulses that are millimetres per second off the law, which all sweeps of the step had
    /// come to, convex problems lead to some that obey it to the tolerance; also where one of the
    /// limits opens, or a contact cannot move.
    #[test]
    fn a_jammed_step_is_solved() {
        let members: [u32; MEMBERS] = std::array::from_fn(|m| m as u32);
        let limits = (0..MEMBERS).filter(|&m| Jam::new().contacts.rows[m].turns);
        let mut tried = 0;
        for opens in std::iter::once(None).chain(limits.map(Some)) {
            let mut jam = Jam::new();
            if let Some(m) = opens {
                jam.d[3 * m] += 5.0;
            }
            let mut convex = Convex::new(MEMBERS);
            let (off, left) = dispatch!(Level::new(), simd => {
                assert!(convex.begin(simd, &members, &jam.contacts, &jam.W, &jam.d));
                let off = jam.sweep(simd);
                (0..100).for_each(|_| assert!(convex.go_on(simd, &jam.W)));
                jam.d.copy_from_slice(convex.without());
                for m in 0..MEMBERS {
                    let lambda = convex.impulse(m);
                    assert!(lambda.x >= 0.0, "{m} pulls");
                    jam.contacts.rows[m].lambda = lambda;
                    jam.W.add_answer(simd, m, &lambda, &mut jam.d);
                }
                (off, jam.sweep(simd))
            });
            assert!(off > 1e-3, "{off} m/s at first, {opens:?}");
            assert!(left < 1e-5, "{left} m/s are left, {opens:?}");
            tried += 1;
        }
        assert_eq!(tried, 8);
    }

    /// A contact whose sides cannot move and yet close, as between two driven bodies, bears
    /// nothing, and spoils nothing.
    #[test]
    fn what_cannot_move_is_left_out() {
        let members: [u32; MEMBERS] = std::array::from_fn(|m| m as u32);
        let mut jam = Jam::without(3);
        jam.contacts.rows[0].lambda = Vec3::zeros();
        jam.d[..3].copy_from_slice(&[-1.0, 0.3, 0.0]);
        let mut convex = Convex::new(MEMBERS);
        dispatch!(Level::new(), simd => {
            assert!(convex.begin(simd, &members, &jam.contacts, &jam.W, &jam.d));
            (0..100).for_each(|_| assert!(convex.go_on(simd, &jam.W)));
        });
        assert_eq!(convex.impulse(0), Vec3::zeros());
        assert!((1..MEMBERS).all(|m| convex.impulse(m).norm() < 1.0));
    }
}
