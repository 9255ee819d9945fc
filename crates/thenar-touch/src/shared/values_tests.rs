//! Goal: contacts that a tick need not look at change nothing. Method: the same sweeps over all
//! values, worked out plainly, beside [`SharedConstraints`] over many ticks of contacts that close,
//! slide, stick and open.

use super::*;
use crate::RigidState;
use nalgebra::{DMatrix, DVector};
use thenar_core::kernels::project;
use thenar_core::math::{Mat3, Pose, Vec3};
use thenar_core::model::{Cone, Drive};
use thenar_core::random::Random;

const BONES: usize = 3;
const CONTACTS: usize = 24;
const SWEEPS: u32 = 12;
const FRAMES: usize = 12;
const SPRING: Drive =
    Drive { stiffness: 300.0, damping: 0.0, angular_stiffness: 0.1, angular_damping: 0.0 };

/// Three bones on springs, whose many contacts are up to 2 cm away; some bear force, some are
/// limits.
fn frame(random: &mut Random) -> Condensed {
    let (n, m) = (6 * BONES, 3 * CONTACTS);
    let mut any = |rows: usize, columns: usize, size: f64| {
        DMatrix::from_fn(rows, columns, |_, _| random.range(-size, size))
    };
    let (bones, local, rows) = (any(n, n, 1.0), any(m, m, 1e-3), any(m, n, 0.5));
    let stiffness = DMatrix::from_fn(n, n, |r, c| match (r == c, r % 6 < 3) {
        (false, _) => 0.0,
        (true, true) => SPRING.stiffness,
        (true, false) => SPRING.angular_stiffness,
    });
    let compliance = (&bones * bones.transpose() * 0.01 + stiffness).try_inverse().unwrap();
    // Turns move contacts by levers of centimetres.
    let rows = DMatrix::from_fn(m, n, |r, c| rows[(r, c)] * [1.0, 0.02][usize::from(c % 6 >= 3)]);
    let local = &local * local.transpose() + DMatrix::identity(m, m) * 1e-4;
    let mut frame = Condensed::new(BONES, CONTACTS);
    frame.springs = vec![SPRING; BONES];
    frame.targets = vec![RigidState::at_rest(Pose::identity()); BONES];
    for i in 0..CONTACTS {
        let (presses, limit) = (i % 6 == 0, i % 4 == 1);
        let force = if presses { Vec3::new(0.3, 0.02, -0.01) } else { Vec3::zeros() };
        let gap = if presses { 0.0 } else { random.range(0.0, 0.02) };
        let value = Vec3::new(gap, random.range(-1e-4, 1e-4), random.range(-1e-4, 1e-4));
        let friction = if limit { 0.0 } else { 0.5 };
        frame.contacts.push(CondensedContact { frame: Mat3::identity(), value, friction, force });
        frame.limits.push(limit);
    }
    let row_major = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
    frame.compliance = row_major(&compliance);
    frame.rows = row_major(&rows);
    frame.local = row_major(&local);
    assert!(frame.prepare());
    frame
}

/// Every value in every tick.
struct Plain {
    forces: Vec<Vec3>,
    anchors: Vec<Vec3>,
}

impl Plain {
    fn tick(&mut self, frame: &Condensed, at: &[Vec3], acts: impl Fn(usize) -> bool) {
        let (n, m) = (6 * BONES, 3 * CONTACTS);
        let load =
            DVector::from_fn(
                n,
                |r, _| {
                    if r % 6 < 3 { SPRING.stiffness * at[r / 6][r % 6] } else { 0.0 }
                },
            );
        let lifted = DMatrix::from_row_slice(m, n, &frame.lift) * load;
        let answers = DMatrix::from_row_slice(m, m, &frame.delassus);
        let changes: Vec<Vec3> =
            self.forces.iter().zip(&frame.contacts).map(|(f, c)| f - c.force).collect();
        let answered = &answers * DVector::from_iterator(m, changes.iter().flatten().copied());
        let mut d: Vec<Vec3> = (0..CONTACTS)
            .map(|i| {
                let of = |all: &DVector<f64>| Vec3::from_fn(|r, _| all[3 * i + r]);
                frame.contacts[i].value + of(&lifted) + of(&answered) - self.anchors[i]
            })
            .collect();
        for _ in 0..SWEEPS {
            for i in (0..CONTACTS).filter(|i| acts(*i)) {
                let (own, friction) = (frame.block(i), frame.contacts[i].friction);
                let new = project(Cone::Circular, friction, &own, &d[i], &self.forces[i]);
                let change = new - self.forces[i];
                self.forces[i] = new;
                for (j, d) in d.iter_mut().enumerate() {
                    *d += answers.fixed_view::<3, 3>(3 * j, 3 * i) * change;
                }
            }
        }
        for (anchor, d) in self.anchors.iter_mut().zip(&d) {
            *anchor += Vec3::new(0.0, d.y, d.z);
        }
    }
}

/// For a hand that touches and for the same hand in empty air, over a dozen frames.
#[test]
fn what_stays_open_need_not_be_known() {
    for empty_air in [false, true] {
        let mut random = Random::new(11);
        let (mut closed, mut opened, mut worked_out, mut bore) = (0, 0, 0, 0);
        let make = if empty_air { SharedConstraints::in_empty_air } else { SharedConstraints::new };
        let mut shared = make(BONES, CONTACTS);
        for _ in 0..FRAMES {
            let frame = frame(&mut random);
            let acts = |i: usize| !empty_air || frame.is_limit(i);
            let none = Vec3::zeros();
            let start = |(i, c): (usize, &CondensedContact)| if acts(i) { c.force } else { none };
            let forces = frame.contacts.iter().enumerate().map(start).collect();
            let mut plain = Plain { forces, anchors: vec![none; CONTACTS] };
            shared.begin(&frame);
            let [ways, rates] = [(); 2].map(|()| [(); BONES].map(|()| random.vector(0.02)));
            for tick in 1..=40 {
                let t = 0.1 * f64::from(tick);
                let at = std::array::from_fn::<_, BONES, _>(|b| {
                    ways[b].component_mul(&rates[b].map(|rate| (100.0 * rate * t).sin()))
                });
                let proxies = at.map(|at| RigidState::at_rest(Pose::new(at, Default::default())));
                let before = plain.forces.clone();
                plain.tick(&frame, &at, acts);
                shared.resolve(&frame, &proxies, 1e-3, 0.0, SWEEPS);
                for (i, (got, want)) in shared.forces().iter().zip(&plain.forces).enumerate() {
                    let off = (got - want).norm();
                    assert!(off < 1e-9, "tick {tick}, contact {i}: {got} of {want} N");
                    closed += u32::from(before[i].x == 0.0 && want.x > 0.0);
                    opened += u32::from(before[i].x > 0.0 && want.x == 0.0);
                    bore += usize::from(want.x > 0.0);
                }
                worked_out += shared.worked_out();
            }
        }
        assert!(closed > 5 && opened > 5, "{closed} closed, {opened} opened");
        let all = FRAMES * 40 * CONTACTS;
        println!("{worked_out} of {all} worked out, {bore} bore force");
        assert!(worked_out >= bore && worked_out < all / 2, "{worked_out} of {all}, {bore} bore");
    }
}
