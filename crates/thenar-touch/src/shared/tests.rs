//! Goal: the condensed, fast solve is the uncondensed one. Method: a random elastic system of bones
//! and nodes, solved directly with all unknowns; active sets by enumeration; Coulomb's law checked
//! on the direct solution; one-dimensional cases by hand.

use super::*;
use crate::RigidState;
use nalgebra::{DMatrix, DVector};
use thenar_core::math::{Mat3, Pose, Quat, Vec3, tangents};
use thenar_core::model::Drive;
use thenar_core::random::Random;

const BONES: usize = 2;
const NODES: usize = 6;
const CONTACTS: usize = 4;
const TOTAL: usize = 6 * BONES + 3 * NODES;

/// Bones and nodes with a random stiffness; the first contacts hold one node each.
struct Full {
    stiffness: DMatrix<f64>,
    rows: DMatrix<f64>,
    spring: Drive,
    targets: Vec<RigidState>,
    contacts: Vec<CondensedContact>,
}

impl Full {
    fn new(seed: u64, friction: f64) -> Self {
        let mut random = Random::new(seed);
        let root = DMatrix::from_fn(TOTAL, TOTAL, |_, _| random.range(-10.0, 10.0));
        let spring =
            Drive { stiffness: 300.0, damping: 0.0, angular_stiffness: 40.0, angular_damping: 0.0 };
        let mut stiffness = &root * root.transpose() + DMatrix::identity(TOTAL, TOTAL) * 100.0;
        for b in 0..BONES {
            for k in 0..6 {
                let k_ii = if k < 3 { spring.stiffness } else { spring.angular_stiffness };
                stiffness[(6 * b + k, 6 * b + k)] += k_ii;
            }
        }
        let mut rows = DMatrix::zeros(3 * CONTACTS, TOTAL);
        let contacts = (0..CONTACTS)
            .map(|i| {
                let n = random.vector(1.0).normalize();
                let (t1, t2) = tangents(&n);
                let frame = Mat3::from_rows(&[n.transpose(), t1.transpose(), t2.transpose()]);
                rows.view_mut((3 * i, 6 * BONES + 3 * i), (3, 3)).copy_from(&frame);
                // Two touch and carry force within their cones, two are open.
                let force = if i < 2 { Vec3::new(1.0, 0.2 * friction, 0.0) } else { Vec3::zeros() };
                let gap = if i < 2 { 0.0 } else { random.range(0.0, 1e-3) };
                CondensedContact { frame, value: Vec3::x() * gap, friction, force }
            })
            .collect();
        let targets = (0..BONES)
            .map(|_| RigidState::at_rest(Pose::new(random.vector(0.1), random.rotation(3.0))))
            .collect();
        Self { stiffness, rows, spring, targets, contacts }
    }

    /// The publisher's work, by dense elimination of the nodes.
    fn condense(&self) -> Condensed {
        let (b, f) = (6 * BONES, 3 * NODES);
        let k_ff = self.stiffness.view((b, b), (f, f)).clone_owned().try_inverse().unwrap();
        let k_fb = self.stiffness.view((b, 0), (f, b)).clone_owned();
        let j_f = self.rows.columns(b, f).clone_owned();
        let rows = -&j_f * &k_ff * &k_fb;
        let local = &j_f * &k_ff * j_f.transpose();
        let schur = self.stiffness.view((0, 0), (b, b)) - k_fb.transpose() * &k_ff * &k_fb;
        let compliance = schur.try_inverse().unwrap();
        let mut frame = Condensed::new(BONES, CONTACTS);
        frame.springs = vec![self.spring; BONES];
        frame.targets.clone_from(&self.targets);
        frame.contacts.clone_from(&self.contacts);
        let row_major = |m: &DMatrix<f64>| m.transpose().as_slice().to_vec();
        frame.compliance = row_major(&compliance);
        frame.rows = row_major(&rows);
        frame.local = row_major(&local);
        assert!(frame.prepare());
        frame
    }

    fn load(&self, proxies: &[RigidState]) -> DVector<f64> {
        let mut load = DVector::zeros(TOTAL);
        for (i, (proxy, target)) in proxies.iter().zip(&self.targets).enumerate() {
            let away = proxy.pose_WB.position - target.pose_WB.position;
            let turn = proxy.pose_WB.rotation * target.pose_WB.rotation.inverse();
            for k in 0..3 {
                load[6 * i + k] = self.spring.stiffness * away[k];
                load[6 * i + 3 + k] = self.spring.angular_stiffness * turn.scaled_axis()[k];
            }
        }
        load
    }

    /// Displacement of everything under these proxies and contact forces.
    fn displaced(&self, proxies: &[RigidState], forces: &DVector<f64>) -> DVector<f64> {
        let before: Vec<f64> = self
            .contacts
            .iter()
            .flat_map(|c| c.force.iter().copied().collect::<Vec<_>>())
            .collect();
        let change = forces - DVector::from_vec(before);
        let load = self.load(proxies) + self.rows.transpose() * change;
        self.stiffness.clone().lu().solve(&load).unwrap()
    }

    fn values(&self, u: &DVector<f64>) -> DVector<f64> {
        let mut d = &self.rows * u;
        self.contacts.iter().enumerate().for_each(|(i, c)| d[3 * i] += c.value.x);
        d
    }

    fn moved_proxies(&self, random: &mut Random) -> Vec<RigidState> {
        let moved = |target: &RigidState| {
            let pose = target.pose_WB;
            let turn = random.rotation(0.02);
            RigidState::at_rest(Pose::new(
                pose.position + random.vector(0.02),
                turn * pose.rotation,
            ))
        };
        self.targets.iter().map(moved).collect()
    }
}

fn stacked(forces: &[Vec3]) -> DVector<f64> {
    DVector::from_iterator(3 * forces.len(), forces.iter().flat_map(|f| [f.x, f.y, f.z]))
}

/// The bones of a frame, displaced.
fn placed(shared: &SharedConstraints, frame: &[RigidState]) -> Vec<RigidState> {
    let mut bones = frame.to_vec();
    shared.place(frame, &mut bones);
    bones
}

#[test]
fn unmoved_proxies_leave_the_frame_as_it_is() {
    let full = Full::new(1, 0.5);
    let frame = full.condense();
    let mut shared = SharedConstraints::new(BONES, CONTACTS);
    shared.begin(&frame);
    let resolution = shared.resolve(&frame, &full.targets, 1e-3, 1e-12, 10);
    assert_eq!((resolution.sweeps, resolution.active), (1, 2));
    let want: Vec<Vec3> = full.contacts.iter().map(|c| c.force).collect();
    assert!((stacked(shared.forces()) - stacked(&want)).amax() < 1e-12);
    let bone = placed(&shared, &full.targets)[0];
    assert!((bone.pose_WB.position - full.targets[0].pose_WB.position).norm() < 1e-12);
}

/// Without friction the solution is one of 2^m sets of touching contacts, each a linear system.
#[test]
fn frictionless_contact_is_the_direct_solution() {
    let (mut random, mut several) = (Random::new(2), 0);
    for seed in 1..=30 {
        let full = Full::new(seed, 0.0);
        let frame = full.condense();
        let proxies = full.moved_proxies(&mut random);
        let mut shared = SharedConstraints::new(BONES, CONTACTS);
        shared.begin(&frame);
        shared.resolve(&frame, &proxies, 1e-3, 1e-13, 5000);

        let free = full.values(&full.displaced(&proxies, &DVector::zeros(3 * CONTACTS)));
        let inverse = full.stiffness.clone().try_inverse().unwrap();
        let response = &full.rows * inverse * full.rows.transpose();
        let mut found = 0;
        for set in 0..1u32 << CONTACTS {
            let active: Vec<usize> = (0..CONTACTS).filter(|i| set >> i & 1 == 1).collect();
            let k = active.len();
            let a = DMatrix::from_fn(k, k, |r, c| response[(3 * active[r], 3 * active[c])]);
            let b = DVector::from_fn(k, |r, _| -free[3 * active[r]]);
            let solved = if k == 0 { b } else { a.lu().solve(&b).unwrap() };
            let mut forces = DVector::zeros(3 * CONTACTS);
            active.iter().zip(solved.iter()).for_each(|(i, f)| forces[3 * i] = *f);
            let u = full.displaced(&proxies, &forces);
            let d = full.values(&u);
            let holds = (0..CONTACTS).all(|i| forces[3 * i] >= 0.0 && d[3 * i] >= -1e-12);
            if !holds {
                continue;
            }
            found += 1;
            several += u32::from(k > 1);
            assert!((stacked(shared.forces()) - forces).amax() < 1e-7, "seed {seed}");
            let bones = placed(&shared, &full.targets);
            for (b, (bone, target)) in bones.iter().zip(&full.targets).enumerate() {
                let moved = bone.pose_WB.position - target.pose_WB.position;
                let turn = bone.pose_WB.rotation * target.pose_WB.rotation.inverse();
                let turn = turn.scaled_axis();
                for k in 0..3 {
                    assert!((moved[k] - u[6 * b + k]).abs() < 1e-9, "seed {seed}");
                    assert!((turn[k] - u[6 * b + 3 + k]).abs() < 1e-9, "seed {seed}");
                }
            }
        }
        assert_eq!(found, 1, "seed {seed}: the matrix is definite, so one set fits");
    }
    assert!(several > 3, "contacts must touch together: {several}");
}

/// With friction the forces found must obey Coulomb on the uncondensed system, over several ticks,
/// each sliding against where the last one left the contact.
#[test]
fn friction_obeys_coulomb_on_the_uncondensed_system() {
    let (mut random, mut stuck, mut slid) = (Random::new(3), 0, 0);
    for seed in 1..=20 {
        let full = Full::new(seed, 0.4);
        let frame = full.condense();
        let mut shared = SharedConstraints::new(BONES, CONTACTS);
        shared.begin(&frame);
        let mut before = full.values(&DVector::zeros(TOTAL));
        for tick in 0..3 {
            let proxies = full.moved_proxies(&mut random);
            shared.resolve(&frame, &proxies, 1e-3, 1e-13, 20_000);
            let d = full.values(&full.displaced(&proxies, &stacked(shared.forces())));
            for (i, force) in shared.forces().iter().enumerate() {
                let context = format!("seed {seed} tick {tick} contact {i}");
                assert!(force.x >= 0.0 && d[3 * i] > -1e-10, "{context}");
                assert!(force.x * d[3 * i] < 1e-10, "{context}");
                let slide = d.rows(3 * i + 1, 2) - before.rows(3 * i + 1, 2);
                let (t, limit) = (force.yz(), 0.4 * force.x);
                if force.x > 1e-6 && t.norm() < limit * (1.0 - 1e-6) {
                    stuck += 1;
                    assert!(slide.norm() < 1e-9, "{context}: {slide}");
                } else if force.x > 1e-6 {
                    slid += 1;
                    assert!(t.norm() < limit * (1.0 + 1e-9), "{context}");
                    let against = t.dot(&slide) + t.norm() * slide.norm();
                    assert!(against < 1e-9, "{context}: {against}");
                }
            }
            before = d;
        }
    }
    assert!(stuck > 3 && slid > 3, "{stuck} stuck, {slid} slid");
}

/// One bone on one spring, else free, above a floor.
fn over_a_floor(gap: f64, friction: f64) -> Condensed {
    let mut frame = Condensed::new(1, 1);
    let spring =
        Drive { stiffness: 500.0, damping: 0.0, angular_stiffness: 0.5, angular_damping: 0.0 };
    frame.springs.push(spring);
    frame.targets.push(RigidState::at_rest(Pose::identity()));
    frame.compliance = (0..36)
        .map(|i| match (i / 6 == i % 6, i / 6 < 3) {
            (false, _) => 0.0,
            (true, true) => 1.0 / spring.stiffness,
            (true, false) => 1.0 / spring.angular_stiffness,
        })
        .collect();
    let contact_frame =
        Mat3::from_rows(&[Vec3::y().transpose(), Vec3::x().transpose(), (-Vec3::z()).transpose()]);
    frame.contacts.push(CondensedContact {
        frame: contact_frame,
        value: Vec3::x() * gap,
        friction,
        force: Vec3::zeros(),
    });
    frame.rows = vec![0.0; 18];
    for (r, row) in contact_frame.row_iter().enumerate() {
        (0..3).for_each(|c| frame.rows[6 * r + c] = row[c]);
    }
    frame.local = vec![0.0; 9];
    assert!(frame.prepare());
    frame
}

/// Pressed below the floor and dragged: normal force k (depth - gap); the tangential one follows
/// the spring up to μ times it, keeps there, and comes back along the spring.
#[test]
fn a_dragged_bone_sticks_slides_and_sticks_again() {
    let frame = over_a_floor(0.002, 0.5);
    let mut shared = SharedConstraints::new(1, 1);
    shared.begin(&frame);
    let mut at = |x: f64, y: f64| {
        let proxy = RigidState::at_rest(Pose::translation(x, y, 0.0));
        shared.resolve(&frame, &[proxy], 1e-3, 1e-12, 100);
        shared.forces()[0]
    };
    assert_eq!(at(0.0, -0.001), Vec3::zeros(), "not there yet");
    let close = |got: Vec3, want: Vec3| assert!((got - want).norm() < 1e-9, "{got} {want}");
    close(at(0.0, -0.006), Vec3::new(2.0, 0.0, 0.0));
    close(at(0.001, -0.006), Vec3::new(2.0, -0.5, 0.0));
    close(at(0.005, -0.006), Vec3::new(2.0, -1.0, 0.0));
    close(at(0.004, -0.006), Vec3::new(2.0, -0.5, 0.0));
    close(at(0.001, -0.006), Vec3::new(2.0, 1.0, 0.0));
    close(at(0.001, -0.001), Vec3::zeros());
    close(at(0.001, -0.004), Vec3::new(1.0, 0.0, 0.0));
    let bone = placed(&shared, &[RigidState::at_rest(Pose::identity())])[0];
    assert!((bone.pose_WB.position - Vec3::new(0.001, -0.002, 0.0)).norm() < 1e-9);
    // In this tick it came down by a millimetre; a new frame does not make it stop.
    assert!((bone.velocity_W - Vec3::new(0.0, -1.0, 0.0)).norm() < 1e-6);
    shared.begin(&frame);
    shared.resolve(&frame, &[RigidState::at_rest(Pose::identity())], 1e-3, 1e-12, 100);
    let bone = placed(&shared, &[RigidState::at_rest(Pose::identity())])[0];
    assert!((bone.velocity_W - Vec3::new(0.0, -1.0, 0.0)).norm() < 1e-6);
}

/// In free space bones follow their couplings alone: q = C k δ.
#[test]
fn without_contacts_bones_follow_their_couplings() {
    let mut frame = over_a_floor(0.0, 0.5);
    frame.contacts.clear();
    frame.rows.clear();
    frame.local.clear();
    assert!(frame.prepare());
    let mut shared = SharedConstraints::new(1, 1);
    shared.begin(&frame);
    let low = RigidState::at_rest(Pose::translation(0.0, -0.01, 0.0));
    assert_eq!(shared.resolve(&frame, &[low], 1e-3, 1e-9, 10).active, 0);
    let bone = placed(&shared, &[RigidState::at_rest(Pose::identity())])[0];
    assert!((bone.pose_WB.position - low.pose_WB.position).norm() < 1e-12);
    let mut nothing = Condensed::new(0, 0);
    assert!(nothing.prepare());
    let mut shared = SharedConstraints::new(0, 0);
    shared.begin(&nothing);
    assert_eq!(shared.resolve(&nothing, &[], 1e-3, 1e-9, 10).active, 0);
}

#[test]
fn unusable_frames_move_nothing() {
    let mut frame = over_a_floor(0.0, 0.5);
    frame.compliance[7] = f64::NAN;
    assert!(!frame.prepare() && !frame.is_ready());
    let mut frame = over_a_floor(0.0, 0.5);
    frame.rows.pop();
    assert!(!frame.prepare());
    let frame = over_a_floor(0.0, 0.5);
    let mut shared = SharedConstraints::new(1, 1);
    let low = [RigidState::at_rest(Pose::translation(0.0, -1.0, 0.0))];
    assert_eq!(shared.resolve(&frame, &low, 1e-3, 1e-9, 10), Resolution::default(), "not begun");
    shared.begin(&frame);
    let turned = Quat::from_scaled_axis(Vec3::z() * f64::NAN);
    let bad = [RigidState::at_rest(Pose::new(Vec3::zeros(), turned))];
    assert_eq!(shared.resolve(&frame, &bad, 1e-3, 1e-9, 10).active, 0);
    assert!(placed(&shared, &low)[0].is_finite());
}
