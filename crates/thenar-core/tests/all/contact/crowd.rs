//! Goal: a crowd of rigid bodies costs in proportion to their number, and whatever touches is found
//! as long as bodies are not inside each other by the dozen. Method: balls packed as densely as
//! possible, grains smaller than the margin, pebbles on a tray, and balls all in one place, against
//! pairs counted one by one.

use crate::common::body;
use std::collections::BTreeSet;
use thenar_core::model::{BodyId, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::world::StepReport;
use thenar_core::{Vec3, World};

fn add_ball(desc: &mut WorldDesc, radius: f64, at: Vec3) {
    let mass = 0.001;
    let mut ball = body("ball", mass, [0.4 * mass * radius * radius; 3], at);
    ball.shape = Some(Shape::Sphere { radius });
    desc.add_rigid(ball);
}

/// One step without weight; what it reports, and the pairs that have a contact.
fn step(mut desc: WorldDesc) -> (StepReport, BTreeSet<[u32; 2]>) {
    desc.gravity = Vec3::zeros();
    let mut world = World::new(desc).unwrap();
    let report = world.step(&world.input(), &mut ());
    let pairs = world.contacts().iter().map(|contact| {
        let number = |id: BodyId| match id {
            BodyId::Rigid(i) => i,
            BodyId::Soft(_) => unreachable!("all bodies are rigid"),
        };
        let mut pair = contact.bodies.map(number);
        pair.sort_unstable();
        pair
    });
    (report, pairs.collect())
}

/// The pairs of these balls whose gap is at most so much.
fn near(places: &[Vec3], radius: f64, gap: f64) -> BTreeSet<[u32; 2]> {
    let count = places.len() as u32;
    (0..count)
        .flat_map(|i| (i + 1..count).map(move |j| [i, j]))
        .filter(|pair| {
            let [a, b] = pair.map(|i| places[i as usize]);
            (a - b).norm() <= 2.0 * radius + gap
        })
        .collect()
}

#[test]
fn a_dense_packing_is_found_whole() {
    // Face-centred cubic: every ball within touches twelve.
    let radius = 0.005;
    let mut desc = WorldDesc::default();
    let side = 2.0 * radius / 2.0_f64.sqrt();
    let mut places = Vec::new();
    for (i, j, k) in
        (0..512).map(|n| (n % 8, n / 8 % 8, n / 64)).filter(|(i, j, k)| (i + j + k) % 2 == 0)
    {
        places.push(Vec3::new(f64::from(i), f64::from(j), f64::from(k)) * side);
        add_ball(&mut desc, radius, places[places.len() - 1]);
    }
    let expected = near(&places, radius, 0.1 * radius);
    assert!(expected.len() > 4 * places.len(), "most balls have twelve neighbours");
    let (report, found) = step(desc);
    assert_eq!(report.contacts_dropped, 0);
    assert_eq!(found, expected);
}

#[test]
fn grains_far_smaller_than_the_margin_touch_all_the_same() {
    // Within the margin of 1 mm nearly every grain is near every other; those that overlap are few.
    let radius = 1e-4;
    let mut desc = WorldDesc::default();
    let mut places = Vec::new();
    for n in 0..343_u32 {
        let at = [n % 7, n / 7 % 7, n / 49].map(|i| 1.99 * radius * f64::from(i));
        places.push(Vec3::from(at));
        add_ball(&mut desc, radius, places[places.len() - 1]);
    }
    let margin = desc.solver.contact_margin;
    assert!(near(&places, radius, margin).len() > 100 * places.len());
    let (_, found) = step(desc);
    let missing: Vec<_> = near(&places, radius, 0.0).difference(&found).copied().collect();
    assert_eq!(missing, Vec::<[u32; 2]>::new());
}

#[test]
fn one_body_may_bear_hundreds() {
    let radius = 0.002;
    let mut desc = WorldDesc::default();
    let (mass, half) = (1.0, Vec3::new(0.1, 0.01, 0.1));
    let mut tray = body("tray", mass, [mass * 0.0034; 3], Vec3::y() * -0.01);
    tray.shape = Some(Shape::Cuboid { half });
    let tray = desc.add_rigid(tray);
    for n in 0..400 {
        let at = [n % 20, n / 20].map(|i| 0.008 * (f64::from(i) - 9.5));
        add_ball(&mut desc, radius, Vec3::new(at[0], radius, at[1]));
    }
    let (report, found) = step(desc);
    assert_eq!(report.contacts_dropped, 0);
    assert_eq!(found, (1..=400).map(|i| [tray, i]).collect());
}

#[test]
fn balls_in_one_place_are_counted_and_not_all_looked_at() {
    // What is looked at grows with the balls, not with their pairs; each is held by some others.
    for count in [200_u32, 800] {
        let mut desc = WorldDesc::default();
        for i in 0..count {
            add_ball(&mut desc, 0.01, Vec3::y() * 1e-7 * f64::from(i));
        }
        let (report, found) = step(desc);
        let all = (count * (count - 1) / 2) as usize;
        assert!(!report.non_finite);
        // 32 pairs per ball, and for each ball 32 of those after it.
        assert!(found.len() <= 64 * count as usize, "{count} balls: {} pairs", found.len());
        assert_eq!(found.len() + report.contacts_dropped as usize, all, "{count} balls");
        let held: BTreeSet<u32> = found.iter().flatten().copied().collect();
        assert_eq!(held.len(), count as usize);
    }
}
