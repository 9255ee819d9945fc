//! What is gripped is lifted and held, whatever its shape, at every step, by both hands.

use crate::stage::{Stage, hold, middle, open};
use thenar_core::model::{BodyId, Digit};
use thenar_scene::grip::{GripKind, Phase};
use thenar_scene::session::Session;

/// A round thing rocks on two soft pads as a pendulum about the line between them, and is damped by
/// flesh alone: at 1 ms by 0.4 mm to either side. More is slip [m].
const ROCKING: f64 = 1e-3;

/// Holds what it lifts: within a tenth of the force, never a fifth above it, and still in the hand,
/// neither going on nor swinging by more than `slip` to either side.
#[track_caller]
fn check(stage: &Stage, slip: f64) {
    let held = hold(&mut stage.session());
    let what = format!("{} {:?} {} s: {held:?}", stage.preset, stage.kind, stage.h);
    assert!((held.force / stage.force - 1.0).abs() < 0.1, "{what}");
    assert!(held.most < 1.2 * stage.force, "{what}");
    // The drives give way to its weight, and gave way to the arm's before.
    assert!((held.lift - 0.1).abs() < 6e-3, "{what}");
    assert!(held.slip < slip && held.swing < slip, "{what}");
    assert_eq!(held.trouble, None, "{what}");
}

#[test]
fn a_ball_is_pinched_at_every_step() {
    for h in [1e-3, 5e-3, 1.0 / 60.0] {
        check(&Stage::ball("paper", GripKind::Pinch, 2.0, h), ROCKING);
    }
}

#[test]
fn the_hand_for_touch_pinches_a_ball() {
    for h in [5e-3, 1.0 / 60.0] {
        check(&Stage::ball("touch", GripKind::Pinch, 2.0, h), ROCKING);
    }
}

#[test]
fn a_left_hand_pinches_as_a_right_one() {
    check(&Stage { side: "left", ..Stage::ball("paper", GripKind::Pinch, 2.0, 5e-3) }, ROCKING);
}

/// One triangle of the paper's hand bears a ball of 45 or 50 mm at each pad: held at one point the
/// first swung by 1.4 mm, the other by 0.3.
#[test]
fn a_larger_ball_does_not_swing_between_two_triangles() {
    for (side, radius) in [("right", 0.0225), ("left", 0.025)] {
        let object =
            format!("[[rigid]]\nshape = {{ kind = \"sphere\", radius = {radius} }}\nmass = 0.05");
        let size = [2.0 * radius; 2];
        let ball = Stage::ball("paper", GripKind::Pinch, 2.0, 5e-3);
        check(&Stage { side, object, size, ..ball }, 1e-4);
    }
}

#[test]
fn three_fingers_and_all_fingers_hold_a_ball() {
    check(&Stage::ball("paper", GripKind::Tripod, 3.0, 5e-3), ROCKING);
    check(&Stage::large_ball("paper", 4.0, 5e-3), ROCKING);
}

/// A ball gripped by the default hand without a force, lifted and held: what each digit bears over
/// the sum, and the force over the slip limit `m g / (2 μ)`.
#[track_caller]
fn held_without_a_force(kind: GripKind, (radius, mass): (f64, f64), h: f64) -> ([f64; 6], f64) {
    let ball = Stage::ball("touch", kind, 1.0, h);
    let object =
        format!("[[rigid]]\nshape = {{ kind = \"sphere\", radius = {radius} }}\nmass = {mass}");
    let stage = Stage { object, size: [2.0 * radius; 2], ..ball };
    let mut session = open(&stage.text().replace("force = 1\n", ""));
    let held = hold(&mut session);
    let what = format!("{radius} m: {held:?}");
    assert!((held.lift - 0.1).abs() < 8e-3 && held.slip < ROCKING, "{what}");
    assert_eq!(held.trouble, None, "{what}");
    let borne = borne(&session);
    let sum: f64 = borne.iter().sum();
    (borne.map(|force| force / sum), held.force / (mass * 9.81 / (2.0 * 0.8)))
}

/// All three digits bear a part of what they press with.
#[test]
fn the_hand_for_touch_holds_balls_in_a_tripod_without_a_force() {
    for (radius, mass, h) in [(0.015, 0.03, 1e-2), (0.02, 0.05, 1.0 / 60.0), (0.03, 0.15, 1e-2)] {
        let (parts, over) = held_without_a_force(GripKind::Tripod, (radius, mass), h);
        assert!((1.1..3.0).contains(&over), "{radius} m: {over}");
        let digits = [Digit::Thumb, Digit::Index, Digit::Middle];
        let least = digits.map(|digit| parts[usize::from(digit.part())]);
        assert!(least.into_iter().all(|part| part > 0.1), "{radius} m: {parts:?}");
    }
}

/// Fingers gather around balls that are smaller than the row of them is long, 60 mm, and the force
/// settles at what people press with.
#[test]
fn all_fingers_bear_a_part_of_balls_in_a_power_grip() {
    for (radius, mass) in [(0.015, 0.03), (0.02, 0.05), (0.025, 0.1), (0.03, 0.15)] {
        let (parts, over) = held_without_a_force(GripKind::Power, (radius, mass), 1e-2);
        assert!((1.1..2.0).contains(&over), "{radius} m: {over}");
        assert!(parts[1..].iter().all(|part| *part > 0.03), "{radius} m: {parts:?}");
    }
}

/// Sides of a cone of 50 mm by 40 mm lean by `atan 0.4` and want at least `1 / (1 - 0.4 / 0.8)` = 2
/// times the slip limit of pads that face each other; pads press 1.5 times that, and more as far as
/// the line between them is not level.
#[test]
fn a_cone_is_held_by_sides_that_lean() {
    let cone = "[[rigid]]\nshape = { kind = \"cone\", radius = 0.02, height = 0.05 }\nmass = 0.04";
    for kind in [GripKind::Pinch, GripKind::Tripod, GripKind::Power] {
        let ball = Stage::ball("touch", kind, 1.0, 1e-2);
        // Its middle is a quarter of its height above its base.
        let stage = Stage { object: cone.into(), size: [0.04, 0.025], ..ball };
        let held = hold(&mut open(&stage.text().replace("force = 1\n", "")));
        let over = held.force / (0.04 * 9.81 / (2.0 * 0.8));
        let what = format!("{kind:?}: {held:?}, {over}");
        assert!((held.lift - 0.1).abs() < 8e-3 && held.slip < ROCKING, "{what}");
        assert!((2.9..6.0).contains(&over) && held.trouble.is_none(), "{what}");
    }
}

#[test]
fn balls_are_pinched_as_people_pinch_them() {
    for (radius, mass) in [(0.015, 0.03), (0.02, 0.05), (0.025, 0.1)] {
        let (_, over) = held_without_a_force(GripKind::Pinch, (radius, mass), 1e-2);
        assert!((1.1..2.0).contains(&over), "{radius} m: {over}");
    }
}

/// Sum of the normal forces of each digit on what is no part of the hand [N].
fn borne(session: &Session) -> [f64; 6] {
    let (hand, mut borne) = (&session.hands()[0], [0.0; 6]);
    let own = |body: BodyId| match body {
        BodyId::Rigid(i) => hand.handle.bones.contains(&i),
        BodyId::Soft(i) => hand.flesh() == Some(i),
    };
    for contact in session.world().contacts() {
        for side in 0..2 {
            if !own(contact.bodies[side]) || own(contact.bodies[1 - side]) {
                continue;
            }
            let digit = match contact.bodies[side] {
                BodyId::Soft(_) => {
                    contact.vertices[side].map(|v| hand.model.collision_digits[v as usize])
                }
                BodyId::Rigid(i) => {
                    Some(hand.model.bones[(i - hand.handle.bones.start) as usize].digit)
                }
            };
            if let Some(digit) = digit {
                borne[usize::from(digit.part())] += contact.force_W.dot(&contact.normal_W);
            }
        }
    }
    borne
}

/// Where nothing is between them, thumb and fingers press against each other with the force asked
/// for: fingers that touch beside each other do not count.
#[test]
fn thumb_and_fingers_press_against_each_other_without_an_object() {
    for (kind, force) in [("pinch", 1.0), ("tripod", 1.0), ("power", 1.0)] {
        let text = format!(
            "version = 1\ntime_step = 0.01\nduration = 3\n[[hand]]\nname = \"hand\"\n\
             [[hand.grip]]\nkind = \"{kind}\"\nforce = {force}\nat = 0.1\n\
             [hand.motion]\nkind = \"keyframes\"\n[[hand.motion.key]]\ntime = 0\npose = \"rest\"\n\
             wrist = {{ position = [0, 0, 0], fingers = [0, 0, -1], back = [0, 1, 0] }}\n"
        );
        let mut session = open(&text);
        for _ in 0..session.steps_wanted() {
            session.step(&mut ());
        }
        let (hand, mut pressed) = (&session.hands()[0], 0.0);
        for contact in session.world().contacts() {
            let digits = [0, 1].map(|side| match contact.bodies[side] {
                BodyId::Soft(_) => {
                    contact.vertices[side].map(|v| hand.model.collision_digits[v as usize])
                }
                BodyId::Rigid(_) => None,
            });
            let thumbs = digits.iter().filter(|digit| **digit == Some(Digit::Thumb)).count();
            if thumbs == 1 {
                pressed += contact.force_W.dot(&contact.normal_W);
            }
        }
        assert!((pressed / force - 1.0).abs() < 0.15, "{kind}: {pressed} N");
        assert_eq!(session.grip_trouble(0), None, "{kind}");
    }
}

#[test]
fn a_cube_and_cylinders_are_held() {
    let ball = || Stage::ball("paper", GripKind::Pinch, 3.0, 5e-3);
    check(
        &Stage {
            object: "[[rigid]]\nshape = { kind = \"box\", size = [0.04, 0.04, 0.04] }\n\
                     rotation = { axis = [0, 1, 0], angle_deg = 45 }\nmass = 0.08"
                .into(),
            ..ball()
        },
        ROCKING,
    );
    let cylinder =
        "[[rigid]]\nshape = { kind = \"cylinder\", radius = 0.02, length = 0.08 }\nmass = 0.1";
    let cylinder = Stage { object: cylinder.into(), size: [0.04, 0.08], drop: 0.03, ..ball() };
    check(&cylinder, ROCKING);
    // A rod lies along the row of the fingers.
    let rod = "[[rigid]]\nshape = { kind = \"cylinder\", radius = 0.015, length = 0.1 }\nmass = 0.1\n\
               rotation = { axis = [0.8, 0, -0.6], angle_deg = 90 }";
    let (kind, size) = (GripKind::Power, [0.03, 0.03]);
    check(&Stage { object: rod.into(), kind, size, force: 4.0, ..ball() }, ROCKING);
}

/// A card of 0.8 mm, and a pen of 8 mm across.
#[test]
fn what_is_thin_is_held() {
    let ball = || Stage::ball("paper", GripKind::Pinch, 1.0, 5e-3);
    let card = "[[rigid]]\nshape = { kind = \"box\", size = [0.054, 0.085, 0.0008] }\n\
                rotation = { axis = [0, 1, 0], angle_deg = -40 }\nmass = 0.005";
    check(&Stage { object: card.into(), size: [8e-4, 0.085], drop: 0.035, ..ball() }, ROCKING);
    let pen =
        "[[rigid]]\nshape = { kind = \"cylinder\", radius = 0.004, length = 0.14 }\nmass = 0.01";
    check(&Stage { object: pen.into(), size: [8e-3, 0.14], drop: 0.06, ..ball() }, ROCKING);
}

/// A ball of 20 kPa gives way by millimetres; its weight is that of 500 kg/m³.
#[test]
fn a_soft_ball_is_held_with_the_force_asked_for() {
    let soft = "[[soft]]\nshape = { kind = \"ball\", radius = 0.02, frequency = 4, layers = 3 }\n\
                material = { young = 20e3, density = 500 }\nstiffness_damping = 0.005";
    let ball = Stage::ball("paper", GripKind::Pinch, 1.0, 5e-3);
    check(&Stage { object: soft.into(), ..ball }, ROCKING);
}

/// An egg of 45 by 58 mm as a mesh of triangles from a file.
#[test]
fn an_egg_from_a_mesh_is_held() {
    let folder = std::env::temp_dir().join(format!("thenar-grip-egg-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    std::fs::write(folder.join("egg.obj"), egg()).expect("a file");
    let ball = Stage::ball("paper", GripKind::Pinch, 1.5, 5e-3);
    let stage = Stage {
        object: "[[rigid]]\nshape = { kind = \"mesh\", file = \"egg.obj\" }\nmass = 0.06".into(),
        size: [0.045, 0.058],
        ..ball
    };
    let mut session = Session::from_text(&stage.text(), &folder.join("egg.toml"), &[])
        .unwrap_or_else(|e| panic!("{e}"));
    let held = hold(&mut session);
    std::fs::remove_dir_all(&folder).expect("the folder");
    assert!((held.force / 1.5 - 1.0).abs() < 0.1 && held.most < 1.8, "{held:?}");
    assert!((held.lift - 0.1).abs() < 6e-3 && held.slip < 1e-3, "{held:?}");
}

/// Rings of triangles around y, narrower at the top: r(y) = b √(1 - (y/a)²) (1 - k y).
fn egg() -> String {
    let (rings, sides) = (16, 24);
    let mut text = String::new();
    let mut vertex = |y: f64, r: f64, turn: f64| {
        let [x, z] = [r * turn.cos(), r * turn.sin()];
        text.push_str(&format!("v {x:.6} {y:.6} {z:.6}\n"));
    };
    vertex(-0.029, 0.0, 0.0);
    for i in 1..rings {
        let s = -(std::f64::consts::PI * f64::from(i) / f64::from(rings)).cos();
        for j in 0..sides {
            let turn = std::f64::consts::TAU * f64::from(j) / f64::from(sides);
            vertex(0.029 * s, 0.0225 * (1.0 - s * s).sqrt() * (1.0 - 0.15 * s), turn);
        }
    }
    vertex(0.029, 0.0, 0.0);
    let at = |i: i32, j: i32| 2 + (i - 1) * sides + j % sides;
    let last = 2 + (rings - 1) * sides;
    for j in 0..sides {
        text.push_str(&format!("f 1 {} {}\n", at(1, j), at(1, j + 1)));
        text.push_str(&format!("f {last} {} {}\n", at(rings - 1, j + 1), at(rings - 1, j)));
        for i in 1..rings - 1 {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            text.push_str(&format!("f {a} {d} {c}\nf {a} {c} {b}\n"));
        }
    }
    text
}

/// Two pads carry 2 μ F: a cube of 100 g with μ = 0.5 slips through below F = 0.98 N. Its sides
/// face the pads of the default hand; the paper's has its index finger across the upper edge, and
/// slips off that.
#[test]
fn the_slip_limit_is_that_of_statics() {
    let cube = |force: f64| Stage {
        object: "[[rigid]]\nshape = { kind = \"box\", size = [0.04, 0.04, 0.04] }\n\
                 rotation = { axis = [0, 1, 0], angle_deg = 30 }\nmass = 0.1"
            .into(),
        friction: 0.5,
        ..Stage::ball("touch", GripKind::Pinch, force, 5e-3)
    };
    let limit = 0.1 * 9.81 / (2.0 * 0.5);
    let (dropped, held) =
        (hold(&mut cube(0.8 * limit).session()), hold(&mut cube(1.8 * limit).session()));
    assert!(dropped.lift < 0.02, "{dropped:?}");
    assert!((held.lift - 0.1).abs() < 8e-3 && held.slip < ROCKING, "{held:?}");
    // Left out, the force is twice the limit.
    let text = cube(1.0).text().replace("force = 1\n", "");
    let state = {
        let mut session = open(&text);
        while session.world().time() < 0.2 {
            session.step(&mut ());
        }
        session.grip_state(0).expect("a grip")
    };
    assert!((state.order.force - 2.0 * limit).abs() < 1e-9, "{state:?}");
}

#[test]
fn a_hand_opens_at_its_time_and_goes_back_to_its_motion() {
    let stage =
        Stage { more: "open = 3.0".into(), ..Stage::ball("paper", GripKind::Pinch, 2.0, 5e-3) };
    let mut session = stage.session();
    while session.world().time() < 4.5 - 1e-9 {
        session.step(&mut ());
        let phase = session.grip_state(0).map(|state| state.phase);
        let t = session.world().time();
        if (2.0..3.0 - 1e-9).contains(&t) {
            assert_eq!(phase, Some(Phase::Holding), "{t} s");
        }
        if t > 3.51 {
            assert_eq!(phase, None, "{t} s");
        }
    }
    // It fell: half a second of free fall is a metre.
    assert!(middle(&session).y < -1.0, "{}", middle(&session).y);
    let mut still = open(&stage.text_without_grip());
    while still.world().time() < 4.5 - 1e-9 {
        still.step(&mut ());
    }
    for bone in session.hands()[0].handle.bones.clone() {
        let [a, b] =
            [&session, &still].map(|s| s.input().targets[bone as usize].expect("a target"));
        assert!((a.pose_WB.position - b.pose_WB.position).norm() < 1e-9, "bone {bone}");
    }
}
