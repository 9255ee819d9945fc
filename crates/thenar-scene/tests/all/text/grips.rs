//! Goal: shipped scenes that grip by intent hold what they grip as people do. Method: each is run
//! as it is, once; who presses, how hard and how far things slip is read from contact, and weights
//! and friction say what must be.

use crate::accuracy::Accuracy;
use std::ops::Range;
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::{BodyId, Digit};
use thenar_scene::session::{Session, builtin};

const G: f64 = 9.81;

fn shipped(name: &str) -> Session {
    let text = builtin(name).expect("a scene").text;
    Session::from_text(text, Path::new(name), &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs until `time` and checks that every step is sound, and contact as accurate as is asked.
fn run_to(session: &mut Session, time: f64, mut after: impl FnMut(&Session)) {
    let mut accuracy = Accuracy::default();
    while session.world().time() < time - 1e-9 {
        let report = session.step(&mut ());
        assert!(!report.non_finite && report.penetration_max < 1e-3, "{report:?}");
        assert!(report.joint_gap_max < 2e-3, "{report:?}");
        accuracy.note(&report);
        after(session);
    }
    accuracy.is_met();
}

fn body(session: &Session, name: &str) -> BodyId {
    let desc = session.world().desc();
    match desc.rigids.iter().position(|rigid| rigid.name == name) {
        Some(i) => BodyId::Rigid(i as u32),
        None => {
            let soft = desc.softs.iter().position(|soft| soft.name == name).expect("a body");
            BodyId::Soft(soft as u32)
        }
    }
}

fn middle(session: &Session, object: BodyId) -> Vec3 {
    match object {
        BodyId::Rigid(i) => session.world().rigid_pose(i).position,
        BodyId::Soft(i) => {
            let nodes = session.world().nodes(i);
            nodes.iter().sum::<Vec3>() / nodes.len() as f64
        }
    }
}

/// Weight [N].
fn weight(session: &Session, object: BodyId) -> f64 {
    let desc = session.world().desc();
    match object {
        BodyId::Rigid(i) => desc.rigids[i as usize].mass * G,
        BodyId::Soft(i) => {
            let flesh = &desc.softs[i as usize].flesh;
            let of = |tet: &[u32; 4]| {
                let [a, b, c, d] = tet.map(|n| flesh.nodes[n as usize]);
                (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
            };
            flesh.tets.iter().zip(&flesh.materials).map(|(t, m)| m.density * of(t)).sum::<f64>() * G
        }
    }
}

/// What contact does between an object and a hand.
#[derive(Debug, Default)]
struct Touch {
    /// Sums of the normal forces of palm, thumb, index, middle, ring and little finger [N].
    digits: [f64; 6],
    /// Force on the object [N].
    force: Vec3,
    /// Slip weighted by load [m/s].
    slip: f64,
}

impl Touch {
    fn of(session: &Session, hand: usize, object: BodyId) -> Self {
        let built = &session.hands()[hand];
        let flesh = built.flesh().map(BodyId::Soft);
        let mut touch = Self::default();
        for contact in session.world().contacts() {
            for side in 0..2 {
                let own = contact.bodies[side];
                if contact.bodies[1 - side] != object {
                    continue;
                }
                let digit: Digit = match own {
                    own if Some(own) == flesh => {
                        let vertex = contact.vertices[side].expect("a vertex");
                        built.model.collision_digits[vertex as usize]
                    }
                    BodyId::Rigid(bone) if built.handle.bones.contains(&bone) => {
                        built.model.bones[(bone - built.handle.bones.start) as usize].digit
                    }
                    _ => continue,
                };
                let normal = contact.force_W.dot(&contact.normal_W);
                touch.digits[usize::from(digit.part())] += normal;
                touch.force += contact.force_W * if side == 0 { -1.0 } else { 1.0 };
                touch.slip += normal * contact.slip_W.norm();
            }
        }
        touch.slip /= touch.sum().max(1e-9);
        touch
    }

    fn sum(&self) -> f64 {
        self.digits.iter().sum()
    }
}

/// Least force of two sides that carries a weight: each carries its friction [N].
fn slip_limit(session: &Session, object: BodyId, hands: f64) -> f64 {
    let desc = session.world().desc();
    let own = desc.softs[session.hands()[0].flesh().expect("flesh") as usize].flesh.friction;
    let friction = match object {
        BodyId::Rigid(i) => desc.rigids[i as usize].friction,
        BodyId::Soft(i) => desc.softs[i as usize].flesh.friction,
    };
    weight(session, object) / (2.0 * (own * friction).sqrt() * hands)
}

/// Grip force over the slip limit with which people hold dry things.
const HUMAN: Range<f64> = 1.1..2.0;

/// Lifts a thing by `lift` m, and holds it from 3.2 s on: with a force of `over` times what keeps
/// it from slipping, carried by the hand alone, without creep; `least` digits press. `each` sees
/// the session and the thing after each step.
#[track_caller]
fn is_held(
    name: &str,
    object: &str,
    lift: f64,
    least: usize,
    over: Range<f64>,
    mut each: impl FnMut(&Session, BodyId),
) -> Session {
    let mut session = shipped(name);
    let object = body(&session, object);
    run_to(&mut session, 0.5, |session| each(session, object));
    let before = middle(&session, object);
    run_to(&mut session, 3.2, |session| each(session, object));
    let (limit, weight) = (slip_limit(&session, object, 1.0), weight(&session, object));
    let begun = middle(&session, object).y;
    run_to(&mut session, 4.4, |session| {
        each(session, object);
        let touch = Touch::of(session, 0, object);
        let what = format!("{name}, {} s: {touch:?}, limit {limit} N", session.world().time());
        let ratio = 0.5 * touch.sum() / limit;
        assert!(over.contains(&ratio), "{what}");
        assert!((touch.force.y - weight).abs() < 0.02 * weight, "{what}");
        assert!(touch.force.xz().norm() < 0.05 * weight, "{what}");
        assert!(touch.slip < 1e-5, "{what}");
        let pressing = touch.digits.iter().filter(|force| **force > 0.03 * touch.sum()).count();
        assert!(pressing >= least, "{what}");
        assert_eq!(session.grip_trouble(0), None, "{what}");
    });
    let lifted = middle(&session, object).y - before.y;
    assert!((lifted - lift).abs() < 0.1 * lift, "{name} goes up by {lifted} m");
    let sunk = begun - middle(&session, object).y;
    assert!(sunk.abs() < 2e-3, "{name} sinks by {sunk} m");
    session
}

/// The loaf does not creep from the end of the lift on.
#[test]
fn thumb_and_four_fingers_hold_the_loaf() {
    is_held("bread-grasp", "bread", 0.087, 5, HUMAN, |session, bread| {
        if session.world().time() > 3.1 {
            let slip = Touch::of(session, 0, bread).slip;
            assert!(slip < 1e-5, "{slip} m/s at {}", session.world().time());
        }
    });
}

#[test]
fn thumb_and_four_fingers_hold_the_car() {
    is_held("car-grasp", "car", 0.092, 5, HUMAN, |_, _| {});
}

#[test]
fn thumb_and_index_finger_pull_a_card_out_of_its_slot() {
    // A card weighs so little that what people press with at least decides: 0.3 N, some eight times
    // its limit.
    let session = is_held("card", "card", 0.09, 2, 6.0..9.0, |_, _| {});
    // Still upright in the fingers.
    let BodyId::Rigid(card) = body(&session, "card") else { panic!("a rigid card") };
    let up = session.world().rigid_pose(card).vector(&Vec3::y());
    assert!(up.y > 0.9, "{up}");
}

/// Light as the pen is, 0.4 N are some four times its slip limit.
#[test]
fn three_fingers_take_a_pen_off_its_rest() {
    is_held("pen", "pen", 0.086, 3, 4.0..5.0, |_, _| {});
}

/// A shell takes 3 N in sum from its digits at any time, also while they close.
#[test]
fn an_egg_is_held_and_never_pressed_with_more_than_3_newtons() {
    let mut most = 0.0f64;
    let session = is_held("egg", "egg", 0.089, 3, HUMAN, |session, egg| {
        most = most.max(Touch::of(session, 0, egg).sum());
    });
    let egg = body(&session, "egg");
    let limit = 2.0 * slip_limit(&session, egg, 1.0);
    assert!(most < 3.0 && most > 1.1 * limit, "{most} N");
}

#[test]
fn two_hands_carry_a_plank_level_and_share_its_weight() {
    let mut session = shipped("two-hands");
    let plank = body(&session, "plank");
    let BodyId::Rigid(rigid) = plank else { panic!("a rigid plank") };
    run_to(&mut session, 3.3, |_| {});
    let (weight, limit) = (weight(&session, plank), slip_limit(&session, plank, 2.0));
    run_to(&mut session, 4.4, |session| {
        for hand in 0..2 {
            let touch = Touch::of(session, hand, plank);
            let what = format!("hand {hand}, {} s: {touch:?}", session.world().time());
            // Half each, but for what hands that are not mirror images lean on each other.
            assert!((touch.force.y / weight - 0.5).abs() < 0.1, "{what}");
            assert!(HUMAN.contains(&(0.5 * touch.sum() / limit)), "{what}, {limit} N");
            assert!(touch.slip < 1e-5, "{what}");
            let pressing = touch.digits.iter().filter(|force| **force > 0.1).count();
            assert!(pressing >= 3, "{what}");
        }
    });
    let pose = session.world().rigid_pose(rigid);
    assert!((pose.position.y - 0.015 - 0.08).abs() < 0.01, "{pose:?}");
    // Its ends are within 4 mm of one height.
    assert!(pose.vector(&Vec3::x()).y.abs() < 0.01, "{pose:?}");
}

/// A thing put where the egg lies, some millimetres aside of where the hand comes down, gripped by
/// a line without a force and lifted: held by the hand alone, without creep, with no more than
/// thrice what keeps it from slipping.
#[track_caller]
fn is_held_instead_of_the_egg(shape: &str, mass: f64, half_height: f64, kind: &str) {
    let mut text = builtin("egg").expect("a scene").text.to_owned();
    let egg = text.find("[[rigid]]\nname = \"egg\"").expect("an egg");
    let end = egg + text[egg..].find("\n\n").expect("the end of the egg");
    let thing = format!(
        "[[rigid]]\nname = \"egg\"\nshape = {shape}\nmass = {mass}\nposition = [0, {half_height}, 0]\nfriction = 0.8"
    );
    text.replace_range(egg..end, &thing);
    for (now, then) in [
        ("position = [0.077, ", "position = [0.067, "),
        ("force = 0.8\n", ""),
        ("\"tripod\"", &format!("\"{kind}\"")),
    ] {
        assert!(text.contains(now), "{now}");
        text = text.replace(now, then);
    }
    let mut session = Session::from_text(&text, Path::new("egg.toml"), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let thing = body(&session, "egg");
    let before = middle(&session, thing);
    run_to(&mut session, 3.3, |_| {});
    let (limit, weight) = (slip_limit(&session, thing, 1.0), weight(&session, thing));
    run_to(&mut session, 3.8, |session| {
        let touch = Touch::of(session, 0, thing);
        let what = format!("{shape}, {} s: {touch:?}, limit {limit} N", session.world().time());
        assert!((1.1..3.0).contains(&(0.5 * touch.sum() / limit)), "{what}");
        assert!((touch.force.y - weight).abs() < 0.02 * weight, "{what}");
        assert!(touch.slip < 1e-4, "{what}");
        assert_eq!(session.grip_trouble(0), None, "{what}");
    });
    let lifted = middle(&session, thing).y - before.y;
    assert!(lifted > 0.07, "{shape} goes up by {lifted} m");
}

#[test]
fn a_cube_of_40_mm_is_lifted_in_a_tripod() {
    is_held_instead_of_the_egg(
        "{ kind = \"box\", size = [0.04, 0.04, 0.04] }",
        0.1,
        0.02,
        "tripod",
    );
}

#[test]
fn a_cube_of_30_mm_is_lifted_in_a_pinch() {
    is_held_instead_of_the_egg(
        "{ kind = \"box\", size = [0.03, 0.03, 0.03] }",
        0.05,
        0.015,
        "pinch",
    );
}

#[test]
fn an_ellipsoid_is_lifted_in_a_tripod() {
    let shape = "{ kind = \"ellipsoid\", size = [0.06, 0.04, 0.04] }";
    is_held_instead_of_the_egg(shape, 0.06, 0.02, "tripod");
}

/// The middle finger reaches an upright cylinder of 30 mm late, and thumb and index finger do not
/// wait for it.
#[test]
fn an_upright_cylinder_is_lifted_in_a_tripod() {
    let shape = "{ kind = \"cylinder\", radius = 0.015, length = 0.06 }";
    is_held_instead_of_the_egg(shape, 0.06, 0.03, "tripod");
}

/// A grip that is too weak loses the egg, and says so with its force: 60 g at a friction of √(0.5 ·
/// 0.8) = 0.63 need m g / (2 μ) = 0.47 N.
#[test]
fn a_thing_that_slips_out_is_reported() {
    let mut text = builtin("egg").expect("a scene").text.to_owned();
    text = text.replace("force = 0.8\n", "force = 0.2\n");
    let mut session = Session::from_text(&text, Path::new("egg.toml"), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    while session.world().time() < 3.0 {
        session.step(&mut ());
    }
    let said = session.grip_trouble(0).expect("a trouble");
    assert!(said.contains("`egg` slipped out of thumb and fingers"), "{said}");
    let cause = "press with 0.20 N: its weight needs more than 0.47 N at a friction of 0.63";
    assert!(said.ends_with(cause), "{said}");
}

/// The ball of `ball-grip` in its pinch, up in the air: where it is beside the palm, and how fast
/// it creeps there until `end` [m, m/s].
fn pinched(h: f64, end: f64) -> (Vec3, f64) {
    let mut text = builtin("ball-grip").expect("a scene").text.to_owned();
    // The hand stays up, and its fingers closed.
    for (now, late) in [
        ("open = 5.0", "open = 25.0"),
        ("time = 3.8\n", "time = 23.8\n"),
        ("time = 4.7\n", "time = 24.7\n"),
        ("time = 5.3\n", "time = 25.3\n"),
        ("time = 6.0\n", "time = 26.0\n"),
    ] {
        assert!(text.contains(now), "{now}");
        text = text.replace(now, late);
    }
    let step = [format!("time_step={h}")];
    let mut session = Session::from_text(&text, Path::new("pinched.toml"), &step)
        .unwrap_or_else(|error| panic!("{error}"));
    let ball = body(&session, "ball");
    let palm = match body(&session, "hand/palm") {
        BodyId::Rigid(palm) => palm,
        BodyId::Soft(_) => unreachable!("a bone is rigid"),
    };
    let beside =
        |session: &Session| session.world().rigid_pose(palm).inverse_point(&middle(session, ball));
    run_to(&mut session, 3.5, |_| {});
    let at = beside(&session);
    run_to(&mut session, end, |session| {
        let slip = Touch::of(session, 0, ball).slip;
        assert!(slip < 1e-5, "step {h}: {slip} m/s at {} s", session.world().time());
    });
    (at, (beside(&session) - at).norm() / (end - 3.5))
}

#[test]
fn a_pinched_ball_is_held_alike_at_1_5_and_10_ms() {
    let (place, creep) = pinched(5e-3, 8.0);
    assert!(creep < 1e-4, "it creeps by {creep} m/s");
    for h in [1e-3, 1e-2] {
        let (other, creep) = pinched(h, 4.0);
        println!("step {h}: {creep} m/s, {} m from where it is at 5 ms", (other - place).norm());
        assert!(creep < 1e-4, "step {h}: it creeps by {creep} m/s");
        // A pad is 15 mm wide, and the fingers close in steps.
        assert!((other - place).norm() < 1e-3, "{other} at {h} s, {place} at 5 ms");
    }
}
