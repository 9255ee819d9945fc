use super::*;
use crate::model::{Law, Material, patches};
use crate::random::Random;
use crate::testing::{assert_close, jacobian};
use fearless_simd::{Level, dispatch};
use nalgebra::DMatrix;

const LAWS: [Law; 4] =
    [Law::Corotational, Law::NeoHookean, Law::StableNeoHookean, Law::Ogden { alpha: 8.0 }];

/// The octahedron around an edge between the centres of two cubes of 10 mm, slightly out of shape.
fn octahedron() -> Vec<Vec3> {
    let mut random = Random::new(7);
    let at = [
        [-0.5, 0.0, 0.0],
        [0.5, 0.0, 0.0],
        [0.0, -0.5, -0.5],
        [0.0, 0.5, -0.5],
        [0.0, 0.5, 0.5],
        [0.0, -0.5, 0.5],
    ];
    at.iter().map(|x| Vec3::from(*x) * 0.01 + random.vector(1e-4)).collect()
}

const TETS: [[u32; 4]; 4] = [[0, 1, 2, 3], [0, 1, 3, 4], [0, 1, 4, 5], [0, 1, 5, 2]];

/// Elements of different moduli, as those the body fills in part.
fn model(nodes: &[Vec3], law: Law, damping: f64) -> (Patches, BlockMatrix) {
    let material = Material { law, young: 5e4, poisson: 0.43, density: 1000.0 };
    let rest: Vec<RestTet> = (TETS.iter().zip([1.0, 0.8, 0.3, 1.0]))
        .map(|(tet, fill)| {
            let material = Material { young: fill * material.young, ..material };
            RestTet::new(&tet.map(|n| nodes[n as usize]), &material).unwrap()
        })
        .collect();
    let members: Vec<_> = TETS.iter().copied().zip(&rest).collect();
    let mut patches = Patches::default();
    patches.push(0, &members, &Relaxation::NONE, damping);
    patches.arrange(&MemoryModel::default());
    let A = BlockMatrix::with_pattern(6, patches.pairs());
    patches.lay_out(|a, b| A.entry(a, b));
    (patches, A)
}

fn nodes(x: &[f64]) -> Vec<Vec3> {
    x.chunks(3).map(|x| Vec3::new(x[0], x[1], x[2])).collect()
}

fn flat(x: &[Vec3]) -> Vec<f64> {
    x.iter().flat_map(|x| [x.x, x.y, x.z]).collect()
}

fn energy(patches: &Patches, x: &[Vec3]) -> f64 {
    let mut sums = Tally::default();
    dispatch!(Level::new(), simd => patches.tally(simd, x, &MemoryModel::default(), &[], &mut sums));
    sums.energy
}

/// Forces and stiffness, from a step of 1 s.
fn assembled(patches: &Patches, A: &BlockMatrix, x: &[Vec3]) -> (Vec<Vec3>, DMatrix<f64>) {
    let (mut A, mut b) = (A.clone(), vec![Vec3::zeros(); 6]);
    let mut sums = Tally::default();
    dispatch!(Level::new(), simd => patches.assemble(simd, x, &MemoryModel::default(), &[], 1.0, &mut A, &mut b, &mut sums));
    let K =
        DMatrix::from_fn(18, 18, |r, c| A.get(A.entry(r as u32 / 3, c as u32 / 3))[(r % 3, c % 3)]);
    (b, K)
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    let (mut random, rest) = (Random::new(1), octahedron());
    for law in LAWS {
        let (patches, A) = model(&rest, law, 0.0);
        for _ in 0..50 {
            let turn = random.rotation(3.1);
            let x: Vec<Vec3> = rest.iter().map(|x| turn * x + random.vector(0.002)).collect();
            let numeric = jacobian(|x| vec![-energy(&patches, &nodes(x))], &flat(&x), 1e-8);
            assert_close(&[flat(&assembled(&patches, &A, &x).0)], &numeric, 1e-6);
        }
    }
}

#[test]
fn at_rest_stiffness_is_exact_and_only_rigid_motions_cost_nothing() {
    let rest = octahedron();
    for law in LAWS {
        let (patches, A) = model(&rest, law, 0.0);
        let (_, K) = assembled(&patches, &A, &rest);
        let numeric = jacobian(|x| flat(&assembled(&patches, &A, &nodes(x)).0), &flat(&rest), 1e-8);
        let rows: Vec<Vec<f64>> = (0..18).map(|r| K.row(r).iter().map(|k| -k).collect()).collect();
        assert_close(&rows, &numeric, 1e-6);
        let mut values: Vec<f64> = K.symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        assert!(values[..6].iter().all(|v| v.abs() < 1e-10 * values[17]), "{values:?}");
        assert!(values[6] > 3e-3 * values[17], "{values:?}");
    }
}

#[test]
fn crushed_and_inverted_stiffness_is_positive_semi_definite() {
    let (mut random, rest) = (Random::new(3), octahedron());
    for law in LAWS {
        let (patches, A) = model(&rest, law, 0.0);
        for _ in 0..200 {
            let x: Vec<Vec3> = rest.iter().map(|x| x * 0.3 + random.vector(0.008)).collect();
            let (_, K) = assembled(&patches, &A, &x);
            assert!((&K - K.transpose()).amax() < 1e-9 * K.amax());
            let values = K.symmetric_eigenvalues();
            assert!(values.min() > -1e-9 * values.max(), "{values}");
        }
    }
}

#[test]
fn no_net_force_no_net_torque_and_rotation_invariance() {
    let (mut random, rest) = (Random::new(9), octahedron());
    for law in LAWS {
        let (patches, A) = model(&rest, law, 0.0);
        for _ in 0..100 {
            let x: Vec<Vec3> = rest.iter().map(|x| x + random.vector(0.004)).collect();
            let (f, _) = assembled(&patches, &A, &x);
            let scale: f64 = f.iter().map(|f| f.norm()).sum();
            let torque: Vec3 = x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum();
            assert!(f.iter().sum::<Vec3>().norm() < 1e-12 * scale);
            assert!(torque.norm() < 1e-12 * scale * 0.02);
            let turn = random.rotation(3.1);
            let turned: Vec<Vec3> = x.iter().map(|x| turn * x).collect();
            for (f, t) in f.iter().zip(&assembled(&patches, &A, &turned).0) {
                assert!((turn * f - t).norm() < 1e-9 * scale);
            }
        }
    }
}

/// A patch whose elements all deform alike is the sum of its tetrahedra.
#[test]
fn an_even_deformation_costs_what_it_costs_the_tetrahedra() {
    let (mut random, rest) = (Random::new(5), octahedron());
    for law in LAWS {
        let material = Material { law, young: 5e4, poisson: 0.43, density: 1000.0 };
        let tets = TETS.map(|tet| RestTet::new(&tet.map(|n| rest[n as usize]), &material).unwrap());
        let members: Vec<_> = TETS.iter().copied().zip(&tets).collect();
        let mut patches = Patches::default();
        patches.push(0, &members, &Relaxation::NONE, 0.0);
        patches.arrange(&MemoryModel::default());
        for _ in 0..20 {
            let F = Mat3::identity() + Mat3::from_fn(|_, _| random.range(-0.2, 0.2));
            let x: Vec<Vec3> = rest.iter().map(|x| F * x).collect();
            let want: f64 = (tets.iter().zip(TETS))
                .map(|(rest, tet)| respond(rest, &tet.map(|n| x[n as usize])).energy)
                .sum();
            assert!((energy(&patches, &x) / want - 1.0).abs() < 1e-9);
        }
    }
}

/// Eleven patches of three to six nodes beyond which some hang together, crushed at random, so that
/// tetrahedra turn inside out: eight at a time they make what they make one by one.
#[test]
fn eights_sum_to_the_same_as_single_patches() {
    let mut random = Random::new(41);
    let rest: Vec<Vec3> =
        (0..11).flat_map(|_| octahedron()).map(|x| x + random.vector(5e-4)).collect();
    let mut eights = Patches::default();
    for k in 0..11_u32 {
        let law = Law::Corotational;
        let material = Material { law, young: 5e4, poisson: 0.43, density: 1000.0 };
        let tets = TETS.map(|tet| tet.map(|n| 6 * k + n));
        let tets = &tets[..4 - k as usize % 4];
        let shapes: Vec<RestTet> = (tets.iter())
            .map(|tet| RestTet::new(&tet.map(|n| rest[n as usize]), &material).unwrap())
            .collect();
        let members: Vec<_> = tets.iter().copied().zip(&shapes).collect();
        eights.push(0, &members, &Relaxation::NONE, 1e-3 * f64::from(k));
    }
    let A0 = BlockMatrix::with_pattern(66, eights.pairs());
    eights.lay_out(|a, b| A0.entry(a, b));
    let mut singles = eights.clone();
    singles.single = (0..11).collect();
    eights.arrange(&MemoryModel::default());
    assert_eq!((eights.lanes.len(), eights.single.len()), (2, 0));

    for spoil in [1e-3, 4e-3, 9e-3] {
        let x: Vec<Vec3> = rest.iter().map(|x| x + random.vector(spoil)).collect();
        let results = [&eights, &singles].map(|patches| {
            let (mut A, mut b, mut sums) = (A0.clone(), vec![Vec3::zeros(); 66], Tally::default());
            dispatch!(Level::new(), simd => {
                patches.assemble(simd, &x, &MemoryModel::default(), &[], 0.005, &mut A, &mut b, &mut sums);
            });
            let mut told = Tally::default();
            dispatch!(Level::new(), simd => patches.tally(simd, &x, &MemoryModel::default(), &[], &mut told));
            assert_eq!(told.inverted, sums.inverted);
            assert!((told.energy - sums.energy).abs() < 1e-12 * sums.energy);
            (A, b, sums)
        });
        let [(A, b, sums), (A_one, b_one, sums_one)] = &results;
        let largest = b_one.iter().map(|f| f.norm()).fold(0.0, f64::max);
        b.iter().zip(b_one).for_each(|(f, g)| assert!((f - g).norm() < 1e-11 * largest));
        let size = A_one.get(A_one.entry(0, 0)).norm();
        for (i, j) in eights.pairs() {
            let (block, one) = (A.get(A.entry(i, j)), A_one.get(A_one.entry(i, j)));
            assert!((block - one).norm() < 1e-11 * size);
        }
        assert!((sums.energy - sums_one.energy).abs() < 1e-11 * sums_one.energy);
        assert_eq!(sums.inverted, sums_one.inverted);
        assert!(spoil < 5e-3 || sums.inverted > 3);
    }
}

#[test]
fn inverted_tetrahedra_are_counted_one_by_one() {
    let mut x = octahedron();
    let (patches, _) = model(&x, Law::Corotational, 0.0);
    // The corner 2 moves across the axis: the two tetrahedra that have it turn inside out.
    x[2] = Vec3::new(0.0, 0.001, 0.001);
    let mut sums = Tally::default();
    dispatch!(Level::new(), simd => patches.tally(simd, &x, &MemoryModel::default(), &[], &mut sums));
    assert_eq!(sums.inverted, 2);
}

#[test]
fn the_tetrahedra_around_one_long_edge_are_one_patch() {
    let law = Law::Corotational;
    let material = Material { law, young: 5e4, poisson: 0.43, density: 1000.0 };
    assert_eq!(patches(&octahedron(), &TETS, &[material; 4], &[]), [0; 4]);
}
