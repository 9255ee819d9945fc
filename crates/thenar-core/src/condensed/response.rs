//! The condensed response of a frame: plain arrays with room for a fixed number of contacts.

use super::RigidState;
use crate::math::{Mat3, Vec3};
use crate::model::Drive;
use crate::solver::monolithic::vectors;
use fearless_simd::{Level, dispatch};

/// One contact of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CondensedContact {
    /// Rows: normal (away from the obstacle), first and second tangent, world.
    pub frame: Mat3,
    /// Contact value d₀ \[m\]: gap along the normal, negative when penetrating, then the slide
    /// along the tangents since the frame, once all has come to rest under the frame's forces with
    /// the proxies unmoved.
    pub value: Vec3,
    /// Friction coefficient.
    pub friction: f64,
    /// Force on the hand in the contact frame, normal first \[N\].
    pub force: Vec3,
}

/// Response of bones and contacts to forces about one frame.
///
/// With n bones and m contacts; row-major; bone degrees of freedom are displacement \[m\] then
/// rotation vector \[rad\], world, and forces likewise N and N m.
///
/// | array | meaning | shape |
/// |---|---|---|
/// | `compliance` | C: bones by wrenches on bones, couplings to the proxies included | 6n × 6n |
/// | `rows` | J: contact values (normal, tangents) by bones | 3m × 6n |
/// | `local` | W: contact values by contact forces, bones held | 3m × 3m |
/// | `lift` | J C | 3m × 6n |
/// | `delassus` | B = J C Jᵀ + W | 3m × 3m |
///
/// C and W are symmetric, and so is B.
///
/// The publisher fills the first three, `contacts`, `springs`, `targets`, for a frame that is not
/// at rest `rest`, for one with loads `loads`, and calls `prepare`. `World::condense` knows the
/// last two without J and W, which it leaves empty.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Condensed {
    bones: usize,
    contacts_max: usize,
    /// Couplings of the bones to their proxies.
    pub springs: Vec<Drive>,
    /// Poses and velocities of the proxies in this frame.
    pub targets: Vec<RigidState>,
    /// Offset of the bones from where they come to rest under the frame's forces and unmoved
    /// proxies, 6n; zero when left empty.
    pub rest: Vec<f64>,
    /// Wrenches on the bones from outside that are no contact and no weight, 6n; none when left
    /// empty.
    pub loads: Vec<f64>,
    /// Compliance C, 6n × 6n: motions of the bones \[m\] and \[rad\] by wrenches on bones \[N\] and
    /// \[N m\], couplings to the proxies included.
    pub compliance: Vec<f64>,
    /// Contacts that touch or may touch before the next frame.
    pub contacts: Vec<CondensedContact>,
    /// Marks the contacts that are limits of joints: the hand's own, there in empty air as well.
    /// When empty, no contact is one.
    pub limits: Vec<bool>,
    /// Jacobian J, 3m × 6n: contact values (normal, tangents) \[m\] by motions of the bones \[m\]
    /// and \[rad\].
    pub rows: Vec<f64>,
    /// Local response W, 3m × 3m: contact values \[m\] by contact forces \[N\], bones held.
    pub local: Vec<f64>,
    /// Product J C, 3m × 6n.
    pub lift: Vec<f64>,
    /// Contact compliance B = J C Jᵀ + W, 3m × 3m \[m/N\].
    pub delassus: Vec<f64>,
    ready: bool,
}

impl Clone for Condensed {
    /// With all of its room.
    fn clone(&self) -> Self {
        let mut copy = Self::new(self.bones, self.contacts_max);
        copy.copy_from(self);
        copy
    }
}

impl Condensed {
    /// Nothing published yet, with room for `contacts_max` contacts.
    pub fn new(bones: usize, contacts_max: usize) -> Self {
        let (n, m) = (6 * bones, 3 * contacts_max);
        Self {
            bones,
            contacts_max,
            springs: Vec::with_capacity(bones),
            targets: Vec::with_capacity(bones),
            rest: Vec::with_capacity(n),
            loads: Vec::with_capacity(n),
            compliance: Vec::with_capacity(n * n),
            contacts: Vec::with_capacity(contacts_max),
            limits: Vec::with_capacity(contacts_max),
            rows: Vec::with_capacity(m * n),
            local: Vec::with_capacity(m * m),
            lift: Vec::with_capacity(m * n),
            delassus: Vec::with_capacity(m * m),
            ready: false,
        }
    }

    /// Bones it is for.
    pub fn bones(&self) -> usize {
        self.bones
    }

    /// Contacts it has room for.
    pub fn contacts_max(&self) -> usize {
        self.contacts_max
    }

    /// True once prepared: the haptic loop may use it.
    pub fn is_ready(&self) -> bool {
        self.ready
    }

    /// Empty, keeping its memory.
    pub fn clear(&mut self) {
        self.springs.clear();
        self.targets.clear();
        self.contacts.clear();
        self.limits.clear();
        for array in self.arrays() {
            array.clear();
        }
        self.ready = false;
    }

    /// Computes the products the haptic loop needs, in O(m n² + m² n). False, and not ready, when
    /// an array has the wrong length, holds a number that is not finite, or there is no room.
    pub fn prepare(&mut self) -> bool {
        let (n, m) = (6 * self.bones, 3 * self.contacts.len());
        for array in [&mut self.rest, &mut self.loads] {
            if array.is_empty() {
                array.resize(n, 0.0);
            }
        }
        self.lift.clear();
        self.delassus.clear();
        self.ready = self.contacts.len() <= self.contacts_max
            && self.springs.len() == self.bones
            && self.targets.len() == self.bones
            && self.rest.len() == n
            && self.loads.len() == n
            && self.compliance.len() == n * n
            && self.rows.len() == m * n
            && self.local.len() == m * m
            && self.is_finite();
        if !self.ready {
            return false;
        }
        // Without bones or contacts there are no chunks; their length must still not be zero.
        let (n, m) = (n.max(1), m.max(1));
        for row in self.rows.chunks_exact(n) {
            // C is symmetric: its rows are its columns.
            self.lift.extend(self.compliance.chunks_exact(n).map(|column| dot(row, column)));
        }
        for (lift, local) in self.lift.chunks_exact(n).zip(self.local.chunks_exact(m)) {
            let values = self.rows.chunks_exact(n).zip(local).map(|(row, w)| dot(lift, row) + w);
            self.delassus.extend(values);
        }
        true
    }

    /// C, J C and B, to be filled by who knows them; then [`Self::finish`].
    pub(crate) fn products(&mut self) -> (&mut Vec<f64>, &mut Vec<f64>, &mut Vec<f64>) {
        (&mut self.compliance, &mut self.lift, &mut self.delassus)
    }

    /// Ready, when all lengths fit and all numbers are finite.
    pub(crate) fn finish(&mut self) -> bool {
        let (n, m) = (6 * self.bones, 3 * self.contacts.len());
        self.ready = self.contacts.len() <= self.contacts_max
            && self.springs.len() == self.bones
            && self.targets.len() == self.bones
            && self.rest.len() == n
            && self.loads.len() == n
            && self.compliance.len() == n * n
            && self.lift.len() == m * n
            && self.delassus.len() == m * m
            && self.is_finite();
        self.ready
    }

    /// Takes over `other` without allocating, given room for its contacts.
    pub fn copy_from(&mut self, other: &Self) {
        self.springs.clone_from(&other.springs);
        self.targets.clone_from(&other.targets);
        self.rest.clone_from(&other.rest);
        self.loads.clone_from(&other.loads);
        self.contacts.clone_from(&other.contacts);
        self.limits.clone_from(&other.limits);
        self.compliance.clone_from(&other.compliance);
        self.rows.clone_from(&other.rows);
        self.local.clone_from(&other.local);
        self.lift.clone_from(&other.lift);
        self.delassus.clone_from(&other.delassus);
        self.ready = other.ready;
    }

    /// `C x` into `out`, both 6n, by the processor's vectors.
    pub fn compliance_times(&self, x: &[f64], out: &mut [f64]) {
        rows_times(&self.compliance, x, out);
    }

    /// Row `row` of `J C` times `x`, 6n numbers, by the processor's vectors.
    pub fn lift_row_times(&self, row: usize, x: &[f64]) -> f64 {
        let n = 6 * self.bones;
        let row = &self.lift[row * n..][..n];
        dispatch!(Level::new(), simd => vectors::dot(simd, row, x))
    }

    /// The three rows of `J C` of contact `i` times `x`, 6n numbers: as
    /// [`Self::lift_row_times`] of each.
    pub fn lift_times(&self, i: usize, x: &[f64]) -> Vec3 {
        let n = 6 * self.bones;
        let (first, others) = self.lift[3 * i * n..][..3 * n].split_at(n);
        let (second, third) = others.split_at(n);
        dispatch!(Level::new(), simd => {
            let normal = vectors::dot(simd, first, x);
            Vec3::new(normal, vectors::dot(simd, second, x), vectors::dot(simd, third, x))
        })
    }

    /// Adds to the displacements `q` of the bones, 6n, what a force of 1 N along row `row` times
    /// `force` \[N\] moves them by.
    pub fn add_lifted(&self, row: usize, force: f64, q: &mut [f64]) {
        let n = 6 * self.bones;
        let row = &self.lift[row * n..][..n];
        dispatch!(Level::new(), simd => vectors::add(simd, q, force, row));
    }

    /// True when contact `i` is the limit of a joint.
    pub fn is_limit(&self, i: usize) -> bool {
        self.limits.get(i).is_some_and(|limit| *limit)
    }

    /// Adds to the `values` of all contacts \[m\] what a `change` of the force of contact `i` \[N\]
    /// moves them by, `B Δf`. B is symmetric: its columns are its rows, which lie together.
    pub fn add_response(&self, i: usize, change: &Vec3, values: &mut [Vec3]) {
        let m = 3 * self.contacts.len();
        let (first, others) = self.delassus[3 * i * m..][..3 * m].split_at(m);
        let (second, third) = others.split_at(m);
        let values = &mut vectors::flat_mut(values)[..m];
        dispatch!(Level::new(), simd => {
            vectors::add_three(simd, values, (*change).into(), [first, second, third])
        });
    }

    /// Own response of contact `i` \[m/N\].
    pub fn block(&self, i: usize) -> Mat3 {
        let m = 3 * self.contacts.len();
        let row =
            |r: usize| Vec3::from_column_slice(&self.delassus[(3 * i + r) * m + 3 * i..][..3]);
        // B is symmetric: its rows are its columns.
        Mat3::from_columns(&[row(0), row(1), row(2)])
    }

    fn arrays(&mut self) -> [&mut Vec<f64>; 7] {
        let Self { rest, loads, compliance, rows, local, lift, delassus, .. } = self;
        [rest, loads, compliance, rows, local, lift, delassus]
    }

    fn is_finite(&self) -> bool {
        let at_rest = self.rest.iter().chain(&self.loads);
        let given = self.compliance.iter().chain(&self.rows).chain(&self.local).chain(at_rest);
        let numbers = given.chain(&self.lift).chain(&self.delassus);
        let contacts = self.contacts.iter().all(|c| {
            c.friction.is_finite()
                && c.frame.iter().chain(&c.value).chain(&c.force).all(|x| x.is_finite())
        });
        let springs =
            self.springs.iter().all(|s| s.stiffness.is_finite() && s.angular_stiffness.is_finite());
        numbers.copied().all(f64::is_finite)
            && contacts
            && springs
            && self.targets.iter().all(RigidState::is_finite)
    }
}

/// Product of two rows: four sums side by side, so that no addition waits for the one before.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (fours, rest) = (a.chunks_exact(4), a.chunks_exact(4).remainder());
    let tail = &b[b.len().min(a.len() - rest.len())..];
    for (a, b) in fours.zip(b.chunks_exact(4)) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let last: f64 = rest.iter().zip(tail).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + last
}

/// Products of the rows of a matrix with `x`.
fn rows_times(matrix: &[f64], x: &[f64], out: &mut [f64]) {
    let rows = matrix.chunks_exact(x.len().max(1)).zip(out.iter_mut());
    dispatch!(Level::new(), simd => {
        for (row, out) in rows {
            *out = vectors::dot(simd, row, x);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use nalgebra::{DMatrix, DVector};

    /// Rows of `J C` times a list are those of three single products, in lists shorter and longer
    /// than a vector.
    #[test]
    fn three_rows_at_once_are_each_of_them() {
        let mut random = Random::new(4);
        for bones in [1, 3, 16] {
            let n = 6 * bones;
            let mut frame = Condensed::new(bones, 2);
            frame.lift = (0..6 * n).map(|_| random.range(-1.0, 1.0)).collect();
            let x: Vec<f64> = (0..n).map(|_| random.range(-1.0, 1.0)).collect();
            for i in 0..2 {
                let each = Vec3::from_fn(|r, _| frame.lift_row_times(3 * i + r, &x));
                assert_eq!(frame.lift_times(i, &x), each);
                let plain = |r: usize| {
                    let row = &frame.lift[(3 * i + r) * n..][..n];
                    row.iter().zip(&x).map(|(a, b)| a * b).sum::<f64>()
                };
                assert!((each - Vec3::from_fn(|r, _| plain(r))).norm() < 1e-13, "{each}");
            }
        }
    }

    /// The change of all values under one contact's force is its column of `J C Jᵀ + W`.
    #[test]
    fn a_force_moves_the_values_of_all_contacts() {
        let mut random = Random::new(3);
        for contacts in [1, 2, 5] {
            let (n, m) = (12, 3 * contacts);
            let mut any =
                |rows: usize| DMatrix::from_fn(rows, rows, |_, _| random.range(-1.0, 1.0));
            let [C, W] = [any(n), any(m)].map(|half| &half * half.transpose());
            let J = DMatrix::from_fn(m, n, |_, _| random.range(-1.0, 1.0));
            let mut frame = Condensed::new(2, contacts);
            let spring = Drive {
                stiffness: 1.0,
                damping: 0.0,
                angular_stiffness: 1.0,
                angular_damping: 0.0,
            };
            frame.springs.resize(2, spring);
            frame.targets.resize(2, RigidState::at_rest(crate::math::Pose::identity()));
            let zero = Vec3::zeros();
            let contact = CondensedContact {
                frame: Mat3::identity(),
                value: zero,
                friction: 0.5,
                force: zero,
            };
            frame.contacts.resize(contacts, contact);
            // Column by column; of J that is row by row of its transpose.
            frame.compliance.extend(C.iter());
            frame.local.extend(W.iter());
            frame.rows.extend(J.transpose().iter());
            assert!(frame.prepare());
            let B = &J * C * J.transpose() + W;
            for i in 0..contacts {
                let change = random.vector(1.0);
                let mut values = vec![Vec3::x(); contacts];
                frame.add_response(i, &change, &mut values);
                let mut force = DVector::zeros(m);
                force.rows_mut(3 * i, 3).copy_from(&change);
                let moved = &B * force;
                for (j, value) in values.iter().enumerate() {
                    let expected =
                        Vec3::x() + Vec3::from_iterator(moved.rows(3 * j, 3).iter().copied());
                    assert!((value - expected).norm() < 1e-12, "{contacts} {i} {j}");
                }
                let own = B.fixed_view::<3, 3>(3 * i, 3 * i);
                assert!((frame.block(i) - own).norm() < 1e-12);
            }
        }
    }
}
