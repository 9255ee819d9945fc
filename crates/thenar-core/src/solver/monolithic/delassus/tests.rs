//! W against `J K⁻¹ Jᵀ`, with K formed column by column from its products, in double precision.

use super::*;
use crate::math::Mat3;
use crate::random::Random;
use crate::solver::monolithic::factor::Factor;
use crate::solver::monolithic::symbolic::Symbolic;
use crate::solver::monolithic::{CarriedNode, Coordinates, Reduction};
use crate::solver::{BlockMatrix, RelativeTerm, Turning};
use nalgebra::{DMatrix, DVector};

/// Bodies 0 and 1 carry the first part of the flesh; body 2 and the second part are free.
const BODIES: usize = 3;
const CARRIED: usize = 60;
const NODES: usize = 90;

fn matrix(random: &mut Random, positions: &[Vec3]) -> BlockMatrix {
    let near = |a: usize, b: usize| {
        (a < CARRIED) == (b < CARRIED) && (positions[a] - positions[b]).norm() < 0.35
    };
    let row0 = 2 * BODIES;
    let pairs = (0..NODES).flat_map(|a| (0..a).map(move |b| (a, b)));
    let pairs: Vec<_> = pairs.filter(|&(a, b)| near(a, b)).collect();
    let mut numbers: Vec<(u32, u32)> =
        pairs.iter().map(|&(a, b)| ((row0 + a) as u32, (row0 + b) as u32)).collect();
    numbers.extend((0..BODIES as u32).map(|b| (2 * b + 1, 2 * b)));
    let mut A = BlockMatrix::with_pattern(row0 + NODES, numbers.iter().copied());
    for &(i, j) in &numbers[..pairs.len()] {
        let ends = [(i, random.vector(1.0)), (j, -random.vector(1.0))];
        for ((i, u), (j, v)) in ends.iter().flat_map(|e| ends.iter().map(move |f| (e, f))) {
            A.add(A.entry(*i, *j), &(u * v.transpose()));
        }
    }
    for i in 0..row0 + NODES {
        let d = random.vector(0.5);
        A.add(A.diagonal[i], &(Mat3::identity() * 0.3 + d * d.transpose()));
    }
    A
}

fn carried(random: &mut Random, node: usize) -> CarriedNode {
    let weight = random.range(0.0, 1.0);
    let apart = RelativeTerm::Blended { axis: random.vector(0.2), arm: random.vector(0.1) };
    let levers = [random.vector(0.1), random.vector(0.1)];
    let turning = Turning { levers, apart: node.is_multiple_of(2).then_some(apart) };
    CarriedNode {
        node: node as u32,
        bones: [0, 1],
        bone_count: 2,
        held: [false; 3],
        weights: [weight, 1.0 - weight],
        turning,
        spring: random.range(0.1, 1.0),
        stretch: Vec3::zeros(),
    }
}

/// The preconditioner `apply` against the dense K: on its own, as conjugate gradients hide what it
/// gets wrong. Right-hand sides are as large as bodies make them, or as small as single precision
/// does not reach.
fn solves_what_k_multiplies(
    random: &mut Random,
    K: &DMatrix<f64>,
    mut apply: impl FnMut(&DVector<f64>, &mut DVector<f64>),
) {
    let n = K.nrows();
    let mut got = DVector::zeros(n);
    for scale in [1.0, 1e60, 1e-60, 0.0] {
        let want = DVector::from_fn(n, |_, _| scale * random.range(-1.0, 1.0));
        apply(&(K * &want), &mut got);
        let error = (&got - &want).amax();
        assert!(error <= 1e4 * f64::from(f32::EPSILON) * scale, "{scale}: {error}");
    }
}

/// Contacts far apart, each with its own columns.
#[test]
fn half_solves_give_the_dense_compliance() {
    assert_eq!(
        compare_with_dense(NODES, &[0, 1]),
        3 * (40 - 5) + 5,
        "three per contact, one per turn"
    );
}

/// Contacts that crowd on few nodes and bodies share columns. The group of three bodies has two
/// batches of half solves.
#[test]
fn shared_columns_give_the_dense_compliance() {
    assert_eq!(
        compare_with_dense(5, &[0, 1, 2]),
        3 * 5 + 6 * BODIES + 5,
        "nodes, bodies and turns"
    );
}

/// 35 contacts on the first `nodes` nodes and on bodies, and five turns; `group` are the bodies
/// that share the flesh's group. Returns how many columns were solved for.
fn compare_with_dense(nodes: usize, group: &[u32]) -> usize {
    let mut random = Random::new(23);
    let positions: Vec<Vec3> = (0..NODES).map(|_| random.vector(0.5)).collect();
    let A = matrix(&mut random, &positions);
    let mut bodies = Reduction::new(&[true; BODIES], &[], &[], &[group.to_vec()]);
    let v = vec![Vec3::zeros(); 2 * BODIES + NODES];
    assert!(bodies.refresh(&A, &[], &v, 1e-3));
    let carried: Vec<CarriedNode> = (0..CARRIED).map(|n| carried(&mut random, n)).collect();
    let mut springs = vec![0.0; NODES];
    carried.iter().for_each(|c| springs[c.node as usize] = c.spring);
    let split: Vec<u32> = (0..A.rows())
        .map(|i| if i < 2 * BODIES { A.row_start[i + 1] } else { A.row_start[i] })
        .collect();
    let known = vec![[false; 3]; A.rows()];
    let (bodies, carried) = (&bodies, &carried[..]);
    let system = System { A: &A, split: &split, bodies, carried, known: &known, springs: &springs };
    let group = bodies.group_of_body(0).map(|g| g as u32);
    let group_of_node = (0..NODES).map(|n| group.filter(|_| n < CARRIED)).collect();
    let mut coarse = Coarse::new(bodies, group_of_node, carried, &A);
    coarse.refresh(&system, true);
    let factor = Factor::new(Symbolic::new(&A, 2 * BODIES, &positions, true));
    let mut direct = Direct::new(factor, &coarse, bodies.groups());
    assert!(direct.refresh(&system, &coarse));

    // Flesh on flesh, on bodies, and bodies on the world and against each other.
    let mut contacts = ContactRows::with_capacity(BODIES, 40);
    for i in 0..40 {
        if i % 8 == 0 {
            contacts.begin_turn(&random.vector(1.0).normalize(), 0.0);
            contacts.hold_rigid(1, Vec3::zeros(), -1.0);
        } else {
            contacts.begin(&random.vector(1.0).normalize(), 0.5, &Vec3::zeros());
        }
        for _ in 0..(i % 4) * 2 {
            let node = (random.range(0.0, 1.0) * nodes as f64) as u32;
            contacts.hold_node(node.min(nodes as u32 - 1), random.range(-1.0, 1.0));
        }
        if i % 4 < 2 {
            contacts.hold_rigid((i % 3) as u32, random.vector(0.1), -1.0);
        }
        contacts.rows[i].target.x = if i < 23 { 1.0 } else { -1.0 };
    }
    let mut delassus = Delassus::new(40, 40, BODIES, &direct, bodies.freedoms());
    delassus.measure(&contacts, &v);
    delassus.begin(&mut contacts, &direct);
    delassus.extend(&system, &coarse, &direct, &contacts);
    // The rest joins in a second round.
    assert!((23..40).all(|i| delassus.members.admit(i)));
    delassus.extend(&system, &coarse, &direct, &contacts);

    let n = bodies.freedoms() + 3 * NODES;
    let flat = |x: &Coordinates| {
        let w = x.w.iter().flat_map(|w| [w.x, w.y, w.z]);
        DVector::from_iterator(n, x.u.iter().copied().chain(w))
    };
    let (mut x, mut y) =
        (Coordinates::new(bodies.freedoms(), NODES), Coordinates::new(bodies.freedoms(), NODES));
    let (mut v, mut f) = (v.clone(), v);
    let mut K = DMatrix::zeros(n, n);
    for k in 0..n {
        x.clear();
        match k.checked_sub(bodies.freedoms()) {
            None => x.u[k] = 1.0,
            Some(k) => x.w[k / 3][k % 3] = 1.0,
        }
        system.product(&x, &mut y, &mut v, &mut f);
        K.set_column(k, &flat(&y));
    }
    solves_what_k_multiplies(&mut random, &K, |r, z| {
        let (u, w) = r.as_slice().split_at(bodies.freedoms());
        y.u.copy_from_slice(u);
        let w = w.as_chunks::<3>().0;
        y.w.iter_mut().zip(w).for_each(|(y, w)| *y = Vec3::from(*w));
        direct.apply(&system, &coarse, &y, &mut x);
        *z = flat(&x);
    });
    let mut J = DMatrix::zeros(n, 120);
    for (m, &member) in delassus.members().iter().enumerate() {
        let row = &contacts.rows[member as usize];
        for axis in 0..3 {
            f.fill(Vec3::zeros());
            contacts.scatter(row, &row.frame.row(axis).transpose(), &mut f);
            system.gather(&mut f, &mut y);
            J.set_column(3 * m + axis, &flat(&y));
        }
    }
    let K = K.cholesky().expect("the system is positive definite");
    let expected = J.transpose() * K.solve(&J);
    let size = expected.diagonal().max();
    for i in 0..120 {
        for j in 0..120 {
            let error = f64::from(delassus.W.at(i, j)) - expected[(i, j)];
            assert!(error.abs() < 1e-5 * size, "W[{i}, {j}] is off by {error} of {size}");
            assert_eq!(delassus.W.at(i, j), delassus.W.at(j, i));
        }
    }
    delassus.handles.list().len()
}
