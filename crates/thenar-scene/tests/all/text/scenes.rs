//! Goal: the shipped scenes show what their titles say. Method: each is run as it is, and its
//! forces and places are checked against weights and geometry. Those that lift what they grip are
//! in `grips`.

use crate::accuracy::Accuracy;
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::BodyId;
use thenar_scene::session::{Session, builtin, read};

fn load(name: &str) -> Session {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let file = scenes.join(name).with_extension("toml");
    Session::load(&file, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Runs until `time` and checks that every step is sound, and contact as accurate as is asked.
fn run_to(session: &mut Session, time: f64) {
    run_and_look(session, time, |_| {});
}

/// [`run_to`]; `after` sees the session after each step.
fn run_and_look(session: &mut Session, time: f64, mut after: impl FnMut(&Session)) {
    let mut accuracy = Accuracy::default();
    while session.world().time() < time - 1e-9 {
        let report = session.step(&mut ());
        accuracy.note(&report);
        assert!(!report.non_finite, "{}", session.world().time());
        assert!(report.penetration_max < 1e-3, "{}", report.penetration_max);
        assert!(report.joint_gap_max < 2e-3, "{}", report.joint_gap_max);
        after(session);
    }
    accuracy.is_met();
}

fn rigid(session: &Session, name: &str) -> u32 {
    let rigids = &session.world().desc().rigids;
    rigids.iter().position(|rigid| rigid.name == name).expect("a rigid body") as u32
}

fn soft(session: &Session, name: &str) -> u32 {
    let softs = &session.world().desc().softs;
    softs.iter().position(|soft| soft.name == name).expect("a soft body") as u32
}

/// Force on `on` from `from`, and the area over which it acts.
fn contact(session: &Session, on: BodyId, from: BodyId) -> (Vec3, f64) {
    let (mut force, mut area) = (Vec3::zeros(), 0.0);
    for contact in session.world().contacts() {
        let sign = match contact.bodies {
            [a, b] if [a, b] == [on, from] => 1.0,
            [a, b] if [a, b] == [from, on] => -1.0,
            _ => continue,
        };
        force += contact.force_W * sign;
        area += if contact.force_W.norm() > 0.0 { contact.area } else { 0.0 };
    }
    (force, area)
}

/// Distance between the distal bones of thumb and index finger.
fn opening(session: &Session) -> f64 {
    let place = |bone| session.world().rigid_pose(rigid(session, bone)).position;
    (place("hand/thumb-distal") - place("hand/index-distal")).norm()
}

#[test]
fn free_motion_stays_near_the_tracked_hand() {
    let mut session = load("free-motion");
    let palm = rigid(&session, "hand/palm");
    while session.steps() < session.steps_wanted() {
        let time = session.world().time() + 0.1;
        run_to(&mut session, time);
        let target = session.input().targets[palm as usize].expect("a target").pose_WB;
        let behind = (target.position - session.world().rigid_pose(palm).position).norm();
        assert!(behind < 0.01, "{behind}");
    }
}

/// Slip of what a hand holds against its skin, weighted by load \[m/s\]: |Σ N v| / Σ N.
fn slip(session: &Session, held: BodyId, hand: BodyId) -> f64 {
    let of = [held, hand];
    let points = session.world().contacts().iter();
    let (slid, load) = points
        .filter(|c| c.bodies.iter().all(|b| of.contains(b)))
        .map(|c| (c.force_W.dot(&c.normal_W), c.slip_W))
        .fold((0.0, 0.0), |(slid, load), (n, v)| (slid + n * v.norm(), load + n));
    assert!(load > 1.0, "it is held, with {load} N");
    slid / load
}

/// Ridges of coarse surfaces that bear in one step and not in the next let a grip creep: a loaf by
/// 40 um/s. Here at other steps than those of the scenes, which other tests look at.
#[test]
fn what_is_held_does_not_creep() {
    // At 16.7 ms the loaf in the hand for touch still settles, by up to 16 um/s, the car by 12 um/s
    // until 3.35 s.
    for (name, object, seconds, steps) in [
        ("bread-grasp", "bread", 3.1..3.6, &[0.005][..]),
        ("bread-squeeze", "bread", 2.6..2.8, &[1.0 / 60.0][..]),
        ("car-grasp", "car", 3.4..3.7, &[0.005, 1.0 / 60.0][..]),
    ] {
        for h in steps {
            let file = format!("{name}.toml");
            let text = builtin(name).expect("a scene").text;
            let step = [format!("time_step={h}")];
            let mut session = Session::from_text(text, Path::new(&file), &step).expect("a scene");
            let hand = BodyId::Soft(soft(&session, "hand"));
            let held = match object {
                "car" => BodyId::Rigid(rigid(&session, object)),
                _ => BodyId::Soft(soft(&session, object)),
            };
            run_to(&mut session, seconds.start);
            while session.world().time() < seconds.end {
                session.step(&mut ());
                let slip = slip(&session, held, hand);
                assert!(slip < 1e-5, "{name}, step {h}: {slip} m/s at {}", session.world().time());
            }
        }
    }
}

/// Nothing but weight acts on a loaf on its table, so it never has more energy than at the start;
/// a contact solver that is stopped too early would set it rolling.
#[test]
fn a_loaf_that_nobody_touches_gains_no_energy() {
    let shipped = builtin("bread-grasp").expect("a scene");
    let mut scene = read(shipped.text, &[]).expect("a scene that can be read");
    scene.hand.clear();
    scene.probe.clear();
    scene.pair.clear();
    let mut session = Session::from_scene(scene, Path::new("loaf.toml")).expect("a scene");
    let energy = |session: &Session| session.world().energy(session.input()).total();
    let start = energy(&session);
    while session.world().time() < 10.0 {
        session.step(&mut ());
        assert!(energy(&session) <= start, "{} {start}", energy(&session));
    }
}

/// Largest change of a distance between two nodes of a body [m], whatever it moved and turned as a
/// whole.
fn strain(before: &[Vec3], now: &[Vec3]) -> f64 {
    let pairs = (0..now.len()).flat_map(|i| (0..i).map(move |k| (i, k)));
    let change =
        |(i, k): (usize, usize)| ((now[i] - now[k]).norm() - (before[i] - before[k]).norm()).abs();
    pairs.map(change).fold(0.0, f64::max)
}

/// The squeezed loaf does not creep.
#[test]
fn squeezed_bread_gives_way_and_recovers() {
    let mut session = load("bread-squeeze");
    let (bread, hand) = (soft(&session, "bread"), soft(&session, "hand"));
    let grip = |s: &Session| {
        let of = [BodyId::Soft(bread), BodyId::Soft(hand)];
        let forces =
            s.world().contacts().iter().filter(|c| c.bodies.iter().all(|b| of.contains(b)));
        forces.map(|c| c.force_W.norm()).sum::<f64>()
    };
    run_to(&mut session, 0.5);
    let whole = session.world().nodes(bread).to_vec();
    run_to(&mut session, 1.3);
    let loose = opening(&session);
    run_to(&mut session, 2.6);
    run_and_look(&mut session, 2.8, |session| {
        let slip = slip(session, BodyId::Soft(bread), BodyId::Soft(hand));
        assert!(slip < 1e-5, "{slip} m/s at {}", session.world().time());
    });
    let (tight, strong) = (opening(&session), grip(&session));
    // Two sides with 6 N each.
    assert!((12.0..14.0).contains(&strong), "{strong}");
    assert!(loose - tight > 0.01, "{loose} {tight}");
    let squeezed = strain(&whole, session.world().nodes(bread));
    run_to(&mut session, 5.0);
    // The hand is off it, and the loaf has its shape again: within a hundredth of its 130 mm.
    assert_eq!(grip(&session), 0.0);
    let left = strain(&whole, session.world().nodes(bread));
    assert!(squeezed > 5e-3 && left < 0.13 / 100.0, "{left} m is left of {squeezed} m");
    let speeds = session.world().node_velocities(bread).iter().map(|v| v.norm());
    assert!(speeds.fold(0.0, f64::max) < 1e-3, "it lies still");
}

#[test]
fn the_table_carries_the_pressing_hand_and_the_flesh_flattens() {
    let mut session = load("table-press");
    let (table, hand) = (BodyId::Rigid(rigid(&session, "table")), soft(&session, "hand"));
    run_to(&mut session, 1.8);
    let (force, area) = contact(&session, BodyId::Soft(hand), table);
    assert!((15.0..60.0).contains(&force.y), "{force}");
    // The part of the skin nearer than 20 um to the table's top, by its own small pieces.
    let x = session.world().collision_vertices(hand);
    let mut near = 0.0;
    for t in &session.world().desc().softs[hand as usize].flesh.collision.triangles {
        let [a, b, c] = t.map(|v| x[v as usize]);
        let piece = (b - a).cross(&(c - a)).norm() / 2.0 / 400.0;
        for (i, j) in (0..20).flat_map(|i| (0..20 - i).map(move |j| (i, j))) {
            let low = |u: f64, v: f64| (a + (b - a) * u / 20.0 + (c - a) * v / 20.0).y < 20e-6;
            let (u, v) = (f64::from(i), f64::from(j));
            near += piece * f64::from(u32::from(low(u + 1.0 / 3.0, v + 1.0 / 3.0)));
            let upper = j + 1 < 20 - i && low(u + 2.0 / 3.0, v + 2.0 / 3.0);
            near += piece * f64::from(u32::from(upper));
        }
    }
    assert!(near > 1e-4 && (area / near - 1.0).abs() < 0.15, "{area} m2, by pieces {near}");
    let lowest = |s: &Session| {
        s.world().collision_vertices(hand).iter().map(|p| p.y).fold(f64::INFINITY, f64::min)
    };
    assert!(lowest(&session).abs() < 5e-4, "{}", lowest(&session));

    // Palm drive and weight balance what the table carries: forces act in pairs.
    let pads = |s: &Session| contact(s, BodyId::Soft(hand), table).0.y;
    run_to(&mut session, 2.6);
    assert_eq!(pads(&session), 0.0);
    run_to(&mut session, 3.9);
    // Some 15 N: fingers that lean on each other press a little harder than each alone.
    assert!((3.0..20.0).contains(&pads(&session)), "{}", pads(&session));
}

#[test]
fn the_glove_sinks_into_the_table_where_the_hand_stays_above() {
    let mut session = load("glove-versus-hand");
    run_to(&mut session, 2.0);
    let tip = |s: &Session, hand: &str| {
        let built = s.hands().iter().find(|h| h.name == hand).expect("a hand");
        let bone = built.model.bones.iter().position(|b| b.name == "index-distal").expect("a bone");
        let pose = s.world().rigid_pose(built.handle.bones.start + bone as u32);
        pose.point(&built.model.bones[bone].ends_B[1]).y
    };
    assert!(tip(&session, "glove") < -0.005, "{}", tip(&session, "glove"));
    assert!(tip(&session, "hand") > 0.0, "{}", tip(&session, "hand"));
    let hand = soft(&session, "hand");
    let vertices = session.world().collision_vertices(hand);
    let lowest = vertices.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    assert!(lowest > -5e-4, "{lowest}");
}

#[test]
fn flesh_keeps_more_of_its_volume_than_skinning() {
    let mut session = load("skinning-comparison");
    let volume = |s: &Session, name: &str| {
        let soft = soft(s, name);
        let nodes = s.world().nodes(soft);
        let tets = &s.world().desc().softs[soft as usize].flesh.tets;
        let of = |tet: &[u32; 4]| {
            let x = tet.map(|n| nodes[n as usize]);
            (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0])) / 6.0
        };
        tets.iter().map(of).sum::<f64>()
    };
    let before = ["skinning", "flesh"].map(|name| volume(&session, name));
    run_to(&mut session, 1.7);
    let after = ["skinning", "flesh"].map(|name| volume(&session, name));
    let lost = [0, 1].map(|k| 1.0 - after[k] / before[k]);
    // A fist: 8 % and 4 % when this was written.
    assert!(lost[0] > 0.06 && lost[1].abs() < 0.7 * lost[0], "{lost:?}");
}
