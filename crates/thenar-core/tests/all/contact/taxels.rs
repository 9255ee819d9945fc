//! Goal: taxels feel the contact forces, all of them and nothing else, whatever their layout, in
//! frames that move with the skin. Method: pressed blocks and fingers with taxels at random, on a
//! grid and alone, against sums over the contact points worked out here, statics, and a body that
//! is turned.

use crate::common::{FLESH, bar, body, finger};
use thenar_core::model::{BodyId, BodyParts, Drive, Flesh, Motion, SoftDesc, WorldDesc};
use thenar_core::random::Random;
use thenar_core::readout::{TaxelError, TaxelPlace, TaxelReadout, TaxelSkin};
use thenar_core::shape::Shape;
use thenar_core::world::Target;
use thenar_core::{Pose, Quat, Vec3, World};

fn add_ground(desc: &mut WorldDesc) {
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    desc.add_rigid(plane);
}

/// Pressure under a block of 20×10×30 mm whose weight is 0.5 N \[Pa\].
const EVEN: f64 = 0.5 / (0.02 * 0.03);

/// The block at rest on the ground, its model frame turned by `turn` about y and pulled along its x
/// \[N\].
fn block_world(turn: Quat, pull: f64) -> World {
    let mut desc = WorldDesc::default();
    add_ground(&mut desc);
    let mut flesh = bar(Vec3::new(0.02, 0.01, 0.03), [4, 2, 6], FLESH);
    flesh.stiffness_damping = 5e-3;
    desc.add_soft(SoftDesc {
        name: "block".into(),
        flesh,
        pose_WM: Pose::new(Vec3::zeros(), turn),
        velocity_W: Vec3::zeros(),
        coupling: None,
    });
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let mass: f64 = world.node_masses(0).iter().sum();
    // Weight and pull act on all of its mass.
    input.gravity = (turn * Vec3::x() * pull - Vec3::y() * 0.5) / mass;
    for _ in 0..300 {
        assert!(!world.step(&input, &mut ()).non_finite);
    }
    world
}

fn place(flesh: &Flesh, parts: &[u8], part: u8, point_M: Vec3) -> TaxelPlace {
    let skin = TaxelSkin::new(flesh, parts.to_vec());
    skin.nearest(part, &point_M, &Vec3::x()).expect("a surface")
}

/// Force on a part of body 0, sum of the sizes of its points' forces, and area, straight from the
/// world. With no parts given, the whole body.
fn sums(world: &World, parts: &[u8], part: u8, bones: &[u32]) -> (Vec3, f64, f64) {
    let mut sums = (Vec3::zeros(), 0.0, 0.0);
    for point in world.contacts() {
        for side in 0..2 {
            let touched = match point.bodies[side] {
                BodyId::Soft(0) => {
                    let vertex = point.vertices[side].expect("a vertex") as usize;
                    parts.get(vertex).copied().unwrap_or(0) == part
                }
                BodyId::Rigid(bone) => bones.contains(&bone),
                BodyId::Soft(_) => false,
            };
            if touched {
                sums.0 += if side == 0 { point.force_W } else { -point.force_W };
                sums.1 += point.force_W.norm();
                sums.2 += point.area;
            }
        }
    }
    sums
}

/// The taxels' forces, by world and by their own axes, sum to these.
#[track_caller]
fn check_sums(taxels: &TaxelReadout, (force_W, size, area): (Vec3, f64, f64)) {
    let sum: Vec3 = taxels.taxels().iter().map(|taxel| taxel.force_W).sum();
    let by_axes: Vec3 = taxels
        .taxels()
        .iter()
        .map(|taxel| {
            let [n, t, s] = taxel.axes_W;
            t * taxel.shear[0] + s * taxel.shear[1] - n * taxel.normal
        })
        .sum();
    let areas: f64 = taxels.taxels().iter().map(|taxel| taxel.area).sum();
    let missed = taxels.missed_W();
    assert!((sum + missed - force_W).norm() <= 1e-12 * size, "{sum} and {missed} for {force_W}");
    assert!((by_axes + missed - force_W).norm() <= 1e-12 * size, "{by_axes} for {force_W}");
    if missed == Vec3::zeros() {
        assert!((areas - area).abs() <= 1e-12 * area, "{areas} for {area}");
    }
    for taxel in taxels.taxels() {
        let [n, t, s] = taxel.axes_W;
        let axes = thenar_core::Mat3::from_columns(&[n, t, s]);
        assert!((axes.transpose() * axes - thenar_core::Mat3::identity()).norm() < 1e-12);
        assert!((axes.determinant() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn forces_sum_to_the_contact_force_whatever_the_layout() {
    let world = block_world(Quat::identity(), 0.1);
    let resultant = sums(&world, &[], 0, &[]);
    assert!((resultant.0 - Vec3::new(-0.1, 0.5, 0.0)).norm() < 1e-3 && resultant.1 > 0.5);
    let flesh = &world.desc().softs[0].flesh;
    let mut random = Random::new(3);
    for count in [1, 2, 3, 4, 5, 6, 17, 100] {
        let mut places: Vec<_> =
            (0..count).map(|_| place(flesh, &[], 0, random.vector(0.03))).collect();
        // Some at one place.
        places.extend_from_within(..count / 2);
        let mut taxels = TaxelReadout::new(&world, 0, &places, f64::INFINITY).unwrap();
        for _ in 0..2 {
            taxels.read(&world);
            check_sums(&taxels, resultant);
            assert_eq!(taxels.missed_W(), Vec3::zeros());
        }
    }
}

#[test]
fn what_is_out_of_reach_is_missed_and_told() {
    let world = block_world(Quat::identity(), 0.1);
    let resultant = sums(&world, &[], 0, &[]);
    let flesh = &world.desc().softs[0].flesh;
    let corner = [place(flesh, &[], 0, Vec3::zeros())];
    let mut felt = 0.0;
    for reach in [0.0, 4e-3, 8e-3, 16e-3, 1.0] {
        let mut taxels = TaxelReadout::new(&world, 0, &corner, reach).unwrap();
        taxels.read(&world);
        check_sums(&taxels, resultant);
        let now = taxels.taxels()[0].force_W.y;
        assert!(now >= felt, "{now} N within {reach} m");
        felt = now;
    }
    assert!((felt - resultant.0.y).abs() < 1e-12 * resultant.1);
}

/// A grid below the block: 4 × 5 taxels away from its edges, so that they look straight down.
fn grid(flesh: &Flesh) -> Vec<TaxelPlace> {
    let at = |i: u32, k: u32| {
        Vec3::new(0.0055 + 0.003 * f64::from(i), 0.0, 0.006 + 0.0045 * f64::from(k))
    };
    let places = (0..4).flat_map(|i| (0..5).map(move |k| (i, k)));
    places.map(|(i, k)| place(flesh, &[], 0, at(i, k))).collect()
}

#[test]
fn a_weight_reads_as_an_even_pressure() {
    let world = block_world(Quat::identity(), 0.0);
    let mut taxels =
        TaxelReadout::new(&world, 0, &grid(&world.desc().softs[0].flesh), f64::INFINITY).unwrap();
    taxels.read(&world);
    let (force_W, size, area) = sums(&world, &[], 0, &[]);
    check_sums(&taxels, (force_W, size, area));
    assert!((force_W.y - 0.5).abs() < 1e-3);
    // The block has grown wider by Poisson's effect, and its edges bear less.
    for taxel in taxels.taxels() {
        assert!((taxel.pressure / EVEN - 1.0).abs() < 0.1, "{} of {EVEN} Pa", taxel.pressure);
    }
}

#[test]
fn shear_points_along_the_taxels_axes_whichever_way_the_body_is_turned() {
    for turn in [0.0, 0.7, -2.5] {
        let turn = Quat::from_axis_angle(&Vec3::y_axis(), turn);
        let world = block_world(turn, 0.05);
        let places = grid(&world.desc().softs[0].flesh);
        let mut taxels = TaxelReadout::new(&world, 0, &places, f64::INFINITY).unwrap();
        taxels.read(&world);
        check_sums(&taxels, sums(&world, &[], 0, &[]));
        for taxel in taxels.taxels() {
            let [n, t, _] = taxel.axes_W;
            assert!((n + Vec3::y()).norm() < 1e-2, "it looks down: {n}");
            assert!((t - turn * Vec3::x()).norm() < 1e-2, "along the model's x: {t}");
            assert!(taxel.normal > 0.0, "pressed: {taxel:?}");
        }
        // Friction holds against the pull: the first shears sum to it, the second to nothing.
        let shear = |k: usize| taxels.taxels().iter().map(|taxel| taxel.shear[k]).sum::<f64>();
        assert!((shear(0) + 0.05).abs() < 1e-3, "{} N", shear(0));
        assert!(shear(1).abs() < 1e-3, "{} N", shear(1));
    }
}

/// A finger in two parts whose outer half is pressed on the ground: taxels of one part feel that
/// part alone.
#[test]
fn taxels_feel_the_parts_that_they_are_on() {
    let mut desc = finger(1e8, 2e-3);
    add_ground(&mut desc);
    let flesh = desc.softs[0].flesh.clone();
    let mut rest = vec![Vec3::zeros(); flesh.collision.vertices.len()];
    flesh.collision.positions(&flesh.tets, &flesh.nodes, &mut rest);
    let parts: Vec<u8> = rest.iter().map(|x| u8::from(x.x > 0.031)).collect();
    let bones = vec![(0, 0), (1, 1)];
    desc.parts.push(BodyParts { soft: 0, vertices: parts.clone(), bones });
    let drive =
        Drive { stiffness: 400.0, damping: 2.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
    desc.drives[0] = Some(drive);
    let start = desc.rigids[0].pose_WB;
    let mut world = World::new(desc).unwrap();
    let mut input = world.input();
    let layout = |part: u8| -> Vec<TaxelPlace> {
        let x = 0.005 + 0.03 * f64::from(part);
        (0..9)
            .map(|k| place(&flesh, &parts, part, Vec3::new(x + 0.003 * f64::from(k), 0.0, 0.008)))
            .collect()
    };
    let both: Vec<TaxelPlace> = layout(0).into_iter().chain(layout(1)).collect();
    let mut readouts = [layout(0), layout(1), both]
        .map(|places| TaxelReadout::new(&world, 0, &places, f64::INFINITY).unwrap());
    let mut pressed = [0.0_f64; 2];
    for i in 0..300 {
        let tilt = Quat::from_axis_angle(&Vec3::z_axis(), -1e-3 * f64::from(i));
        input.targets[0] = Some(Target {
            pose_WB: Pose::new(
                start.position - Vec3::y() * 1e-5 * f64::from(i),
                tilt * start.rotation,
            ),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
        world.step(&input, &mut ());
        let [own, other] = [0, 1].map(|part| sums(&world, &parts, part, &[u32::from(part)]));
        readouts.iter_mut().for_each(|readout| readout.read(&world));
        check_sums(&readouts[0], own);
        check_sums(&readouts[1], other);
        check_sums(&readouts[2], (own.0 + other.0, own.1 + other.1, own.2 + other.2));
        pressed = [pressed[0].max(own.1), pressed[1].max(other.1)];
    }
    assert!(pressed.iter().all(|newtons| *newtons > 0.05), "{pressed:?}");
    assert!(readouts[0].covers(0) && !readouts[0].covers(1) && !readouts[0].covers(7));
}

#[test]
fn places_that_are_none_are_refused() {
    let world = block_world(Quat::identity(), 0.0);
    let flesh = &world.desc().softs[0].flesh;
    let good = place(flesh, &[], 0, Vec3::zeros());
    let bad = |change: &dyn Fn(&mut TaxelPlace)| {
        let mut place = good;
        change(&mut place);
        TaxelReadout::new(&world, 0, &[good, place], 1.0).err()
    };
    let off = Some(TaxelError::OffSurface { taxel: 1 });
    assert_eq!(bad(&|_| ()), None);
    assert_eq!(bad(&|place| place.weights = [0.5, 0.5, 0.5]), off);
    assert_eq!(bad(&|place| place.weights = [2.0, -1.0, 0.0]), off);
    assert_eq!(bad(&|place| place.weights = [f64::NAN; 3]), off);
    assert_eq!(bad(&|place| place.along[0] = f64::INFINITY), off);
    assert_eq!(bad(&|place| place.vertices = [u32::MAX; 3]), off);
    let none = TaxelReadout::new(&world, 1, &[good], 1.0).err();
    assert_eq!(none, Some(TaxelError::NoBody { soft: 1, count: 1 }));
    let skin = TaxelSkin::new(flesh, vec![0; 500]);
    assert!(skin.nearest(3, &Vec3::zeros(), &Vec3::x()).is_none());
    // None at all feel nothing.
    let mut empty = TaxelReadout::new(&world, 0, &[], 1.0).unwrap();
    empty.read(&world);
    assert!(empty.taxels().is_empty() && !empty.covers(0));
}
