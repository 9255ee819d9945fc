use super::*;
use crate::flesh::PAIRS;
use crate::flesh::element::tests::{REST, rest_of};
use crate::model::Law;
use crate::random::Random;
use crate::testing::{assert_close, jacobian};

/// 130 kPa of 1.5 mm.
const SKIN: Sheet = Sheet {
    thickness: 1.5e-3,
    young: 1.3e5,
    poisson: 0.45,
    pretension: 0.0,
    wrinkling: Sheet::WRINKLING,
};

/// Sheets that bear compression, that do not, and in tension at rest.
const SHEETS: [Sheet; 4] = [
    SKIN,
    Sheet { wrinkling: 0.0, ..SKIN },
    Sheet { pretension: 40.0, ..SKIN },
    Sheet { pretension: 10.0, wrinkling: 0.05, poisson: 0.2, ..SKIN },
];

fn piece(sheet: &Sheet, normal: Vec3) -> RestPiece {
    let facet = Facet { tet: 0, sheet: 0, normal: normal.normalize(), area: 3e-5 };
    RestPiece::new(&rest_of(Law::Corotational), &facet, SheetLaw::new(sheet))
}

fn respond(piece: &RestPiece, x: &[Vec3; 4]) -> Response {
    let mut sums = Response {
        energy: 0.0,
        forces: [Vec3::zeros(); 4],
        stiffness: [Mat3::zeros(); 10],
        inverted: false,
    };
    piece.add(x, &mut sums);
    sums
}

fn nodes(x: &[f64]) -> [Vec3; 4] {
    std::array::from_fn(|a| Vec3::new(x[3 * a], x[3 * a + 1], x[3 * a + 2]))
}

fn flat(x: &[Vec3; 4]) -> Vec<f64> {
    x.iter().flat_map(|x| [x.x, x.y, x.z]).collect()
}

fn whole(response: &Response) -> Vec<Vec<f64>> {
    let mut whole = vec![vec![0.0; 12]; 12];
    for (block, (a, b)) in response.stiffness.iter().zip(PAIRS) {
        for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
            whole[3 * a + i][3 * b + j] = block[(i, j)];
            whole[3 * b + j][3 * a + i] = block[(i, j)];
        }
    }
    whole
}

/// The corners moved by up to `reach` \[m\] and turned.
fn moved(random: &mut Random, reach: f64) -> [Vec3; 4] {
    let turn = random.rotation(3.1);
    REST.map(|x| turn * x + random.vector(reach))
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    let mut random = Random::new(11);
    for sheet in SHEETS {
        let mut wrinkled = 0;
        for _ in 0..100 {
            let piece = piece(&sheet, random.vector(1.0));
            let x = moved(&mut random, 0.003);
            let here = respond(&piece, &x);
            let numeric = jacobian(|x| vec![-respond(&piece, &nodes(x)).energy], &flat(&x), 1e-8);
            assert_close(&[flat(&here.forces)], &numeric, 2e-6);
            assert!((piece.energy(&x) - here.energy).abs() <= 1e-15 * here.energy.abs().max(1e-9));
            let stress = piece.law.at(piece.stretched(&x).s).stress;
            wrinkled += usize::from(stress[1] == -piece.law.wrinkles);
        }
        assert!((5..95).contains(&wrinkled), "{wrinkled} of 100 are wrinkled");
    }
}

/// Stretched along both directions nothing is left out; elsewhere what is left is positive.
#[test]
fn the_stiffness_is_exact_in_tension_and_never_negative() {
    let mut random = Random::new(12);
    for sheet in SHEETS {
        let mut taut = 0;
        for _ in 0..200 {
            let piece = piece(&sheet, random.vector(1.0));
            let x = moved(&mut random, 0.003).map(|x| x * 1.1);
            let response = respond(&piece, &x);
            let analytic = whole(&response);
            if piece.law.at(piece.stretched(&x).s).stress[1] > 0.0 {
                taut += 1;
                let force = |x: &[f64]| flat(&respond(&piece, &nodes(x)).forces.map(|f| -f));
                assert_close(&analytic, &jacobian(force, &flat(&x), 1e-8), 2e-5);
            }
            for _ in 0..10 {
                let d: Vec<f64> = (0..12).map(|_| random.range(-1.0, 1.0)).collect();
                let product = |row: &Vec<f64>| row.iter().zip(&d).map(|(a, b)| a * b).sum::<f64>();
                let curved: f64 = analytic.iter().zip(&d).map(|(row, d)| product(row) * d).sum();
                assert!(curved >= -1e-12 * 195.0, "{curved}");
            }
        }
        assert!(taut > 20, "{taut} of 200 are taut");
    }
}

#[test]
fn no_net_force_no_net_torque_and_rotation_invariance() {
    let mut random = Random::new(13);
    for sheet in SHEETS {
        for _ in 0..200 {
            let piece = piece(&sheet, random.vector(1.0));
            let x = moved(&mut random, 0.006);
            let f = respond(&piece, &x).forces;
            let scale: f64 = f.iter().map(|f| f.norm()).sum();
            let net: Vec3 = f.iter().sum();
            let torque: Vec3 = x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum();
            assert!(net.norm() <= 1e-12 * scale && torque.norm() <= 1e-12 * scale * 0.02);
            let (turn, shift) = (random.rotation(3.1), random.vector(0.1));
            let turned = respond(&piece, &x.map(|x| turn * x + shift)).forces;
            for (f, t) in f.iter().zip(&turned) {
                assert!((turn * f - t).norm() <= 1e-9 * scale);
            }
        }
    }
}

/// Deformed along the plane of the sheet by known stretches, against plane stress: uniaxial and
/// even tension, pure compression to wrinkles, and a sheet that is in tension at rest. The force on
/// a node is its gradient times stress.
#[test]
fn a_flat_sheet_obeys_plane_stress() {
    let normal = Vec3::new(0.3, -0.5, 0.8).normalize();
    let t1 = normal.cross(&Vec3::x()).normalize();
    let t2 = normal.cross(&t1);
    let (k, nu) = (195.0, 0.45);
    let bound = 0.21 * k;
    let tense = Sheet { pretension: 20.0, ..SKIN };
    // Stretches along t1 and t2, stress along them.
    let cases = [
        (SKIN, [1.0, 1.0], [0.0, 0.0]),
        // Free sideways: Young's modulus.
        (SKIN, [1.08, 1.0 - 0.45 * 0.08], [k * 0.08, 0.0]),
        // Even: E t/(1 − ν).
        (SKIN, [1.05, 1.05], [k * 0.05 / (1.0 - nu); 2]),
        // Held sideways: E t/(1 − ν²).
        (SKIN, [1.1, 1.0], [k * 0.1 / (1.0 - nu * nu), nu * k * 0.1 / (1.0 - nu * nu)]),
        // Pressed together past its wrinkles, free or even.
        (SKIN, [1.0 + nu * 0.21, 0.7], [0.0, -bound]),
        (SKIN, [0.6, 0.6], [-bound; 2]),
        // No resistance at all to compression: pulled along one direction only.
        (Sheet { wrinkling: 0.0, ..SKIN }, [1.1, 0.8], [k * 0.1, 0.0]),
        (tense, [1.0, 1.0], [20.0, 20.0]),
        (tense, [1.03, 1.03], [20.0 + k * 0.03 / (1.0 - nu); 2]),
    ];
    for (sheet, stretches, stress) in cases {
        let piece = piece(&sheet, normal);
        // Across the sheet anything may happen.
        let F = t1 * t1.transpose() * stretches[0]
            + t2 * t2.transpose() * stretches[1]
            + normal * normal.transpose() * 1.7;
        let got = respond(&piece, &REST.map(|x| F * x)).forces;
        let g = rest_of(Law::Corotational).gradients;
        for (got, g) in got.iter().zip(&g) {
            let want = (t1 * t1.dot(g) * stress[0] + t2 * t2.dot(g) * stress[1]) * -piece.area;
            assert!((got - want).norm() < 1e-12 * piece.area * k * g.norm(), "{stretches:?}");
        }
    }
}

/// The energy is the least over what wrinkles take up: by search.
#[test]
fn the_energy_is_the_least_over_wrinkles() {
    let mut random = Random::new(14);
    for sheet in SHEETS {
        let law = SheetLaw::new(&sheet);
        let c = law.stiffness / (1.0 - law.poisson * law.poisson);
        for _ in 0..60 {
            let s = [random.range(0.4, 1.5), random.range(0.4, 1.5)];
            let s = [s[0].max(s[1]), s[0].min(s[1])];
            let smooth = |p: [f64; 2]| {
                let e = [0, 1].map(|i| s[i] - 1.0 + law.prestrain + p[i]);
                let squares = e[0] * e[0] + e[1] * e[1] + 2.0 * law.poisson * e[0] * e[1];
                0.5 * c * squares + law.wrinkles * (p[0] + p[1])
            };
            // Coordinate descent on a convex function: each minimum in closed form.
            let mut p = [0.0_f64; 2];
            for _ in 0..200 {
                for i in 0..2 {
                    let other = s[1 - i] - 1.0 + law.prestrain + p[1 - i];
                    let e = -law.wrinkles / c - law.poisson * other;
                    p[i] = (e - (s[i] - 1.0 + law.prestrain)).max(0.0);
                }
            }
            let at = law.at(s);
            assert!((at.energy - smooth(p)).abs() < 1e-9 * law.stiffness, "{s:?}");
            assert!(at.stress.iter().all(|&w| w >= -law.wrinkles * (1.0 + 1e-12)));
        }
    }
}

/// A sheet crushed to a line or a point has finite forces and stiffness.
#[test]
fn nothing_breaks_at_no_area() {
    for sheet in SHEETS {
        let piece = piece(&sheet, Vec3::z());
        for x in [[Vec3::zeros(); 4], REST.map(|x| Vec3::x() * x.x), REST.map(|x| Vec3::z() * x.z)]
        {
            let response = respond(&piece, &x);
            assert!(response.energy.is_finite());
            assert!(response.forces.iter().all(|f| f.iter().all(|x| x.is_finite())));
            assert!(response.stiffness.iter().all(|k| k.iter().all(|x| x.is_finite())));
        }
    }
}

/// Against the energy, its forces and its stiffness: what is not foreseen is of third order, and a
/// turn that stretches a stiff sheet is seen.
#[test]
fn surprise_is_what_the_expansion_leaves_out() {
    let mut random = Random::new(15);
    for sheet in SHEETS {
        let mut seen = 0;
        for _ in 0..100 {
            let piece = piece(&sheet, random.vector(1.0));
            let x0 = moved(&mut random, 0.002);
            let x1 = x0.map(|x| x + random.vector(0.002));
            let here = respond(&piece, &x0);
            let d: Vec<f64> = flat(&std::array::from_fn(|a| x1[a] - x0[a]));
            let slope: f64 = flat(&here.forces).iter().zip(&d).map(|(f, d)| -f * d).sum();
            let product = |row: &Vec<f64>| row.iter().zip(&d).map(|(a, b)| a * b).sum::<f64>();
            let half: f64 =
                0.5 * whole(&here).iter().zip(&d).map(|(r, d)| product(r) * d).sum::<f64>();
            let risen = piece.energy(&x1) - here.energy;
            let [unforeseen, curved] = piece.surprise(&x0, &x1);
            if [unforeseen, curved] != [0.0; 2] {
                seen += 1;
                let scale = 1e-11 * piece.area * piece.law.stiffness;
                assert!((curved - half).abs() < scale, "{curved} {half}");
                assert!((unforeseen - (risen - slope - half)).abs() < scale);
            }
        }
        assert!(seen > 50, "{seen} of 100");
    }
}
