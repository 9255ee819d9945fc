//! Goal: any shipped scene can have left, right or both hands, of any length. Method: every other
//! choice in turn is built and stepped, in every scene; the mirrored scripts do what the scenes'
//! own do.

use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_scene::format::{Hand, Scene};
use thenar_scene::hands::{Hands, with_hands};
use thenar_scene::session::{Session, builtin, builtins, read};
use thenar_testing::one_in;

const FILE: &str = "test.toml";

/// A scene, with hands as the paper's: where they are is asked, not how they feel.
fn scene(text: &str) -> Scene {
    let hands = 0..text.matches("[[hand]]").count();
    let paper: Vec<String> = hands.map(|k| format!("hand.{k}.preset=paper")).collect();
    read(text, &paper).unwrap_or_else(|fault| panic!("{}: {}", fault.key, fault.problem))
}

fn open(mut scene: Scene, which: Hands, lengths: [Option<f64>; 2]) -> Session {
    with_hands(&mut scene, which, lengths);
    Session::from_scene(scene, Path::new(FILE)).unwrap_or_else(|e| panic!("{which:?}: {e}"))
}

fn sides(session: &Session) -> Vec<Side> {
    session.hands().iter().map(|hand| hand.model.side.expect("a side")).collect()
}

/// Corners of a box around a hand's skin at this moment.
fn bounds(session: &Session, hand: usize) -> [Vec3; 2] {
    let soft = session.hands()[hand].flesh().expect("flesh");
    let points = session.world().nodes(soft);
    let infinite = Vec3::repeat(f64::INFINITY);
    let low = points.iter().fold(infinite, |a, b| a.inf(b));
    [low, points.iter().fold(-infinite, |a, b| a.sup(b))]
}

#[test]
fn every_scene_takes_every_choice() {
    let choices = [Hands::Left, Hands::Right, Hands::Both];
    let all = builtins().iter().flat_map(|builtin| choices.map(|which| (builtin, which)));
    for (builtin, which) in one_in(2, all) {
        let own = scene(builtin.text);
        let mut session = open(scene(builtin.text), which, [None; 2]);
        let name = builtin.name;
        let sides = sides(&session);
        match which {
            Hands::Left => assert!(sides.iter().all(|s| *s == Side::Left), "{name}"),
            Hands::Right => assert!(sides.iter().all(|s| *s == Side::Right), "{name}"),
            _ => assert!(sides.contains(&Side::Left) && sides.contains(&Side::Right), "{name}"),
        }
        assert!(!sides.is_empty());
        assert_eq!(session.softs().len(), own.soft.len() + own.figure.len(), "{name}");
        let is_left =
            |hand: &Hand| hand.model.as_ref().is_some_and(|model| model.value.contains("left"));
        let left = own.hand.iter().filter(|hand| is_left(hand)).count();
        let right = own.hand.len() - left;
        if left > 0 && right > 0 {
            // Hands of the other side go, with what refers to them.
            let kept = match which {
                Hands::Left => left,
                Hands::Right => right,
                _ => left + right,
            };
            assert_eq!(session.hands().len(), kept, "{name}");
            assert!(session.scene().probe.len() <= own.probe.len(), "{name}");
        } else {
            // Hands are mirrored: nothing that refers to one is lost.
            assert_eq!(session.scene().probe.len(), own.probe.len(), "{name}");
            let added = usize::from(own.hand.is_empty()) + usize::from(which == Hands::Both);
            assert_eq!(session.hands().len(), own.hand.len() + added, "{name}");
        }
        added_hands_are_clear(&session, name);
        for _ in 0..5 {
            let report = session.step(&mut ());
            assert!(!report.non_finite && report.penetration_max < 1e-3, "{name} {which:?}");
        }
        session.probe();
    }
}

/// Added hands are 5 cm from other hands and 2 cm from soft bodies at least, and 3 cm up.
fn added_hands_are_clear(session: &Session, name: &str) {
    for added in 0..session.hands().len() {
        if !session.hands()[added].name.contains(" hand") {
            continue;
        }
        let [low, high] = bounds(session, added);
        assert!(low.y > 0.03, "{name}: {low}");
        for other in (0..session.hands().len()).filter(|other| *other != added) {
            let [a, b] = bounds(session, other);
            let apart = (0..3).any(|k| high[k] < a[k] - 0.05 || low[k] > b[k] + 0.05);
            assert!(apart, "{name}: {low} {high} {a} {b}");
        }
        for soft in session.softs() {
            for x in session.world().nodes(soft.soft) {
                let outside = (0..3).any(|k| x[k] < low[k] - 0.02 || x[k] > high[k] + 0.02);
                assert!(outside, "{name}: {x} {low} {high}");
            }
        }
    }
}

#[test]
fn a_mirrored_hand_lifts_the_bread_as_the_scenes_own_does() {
    let text = builtin("bread-grasp").expect("a scene").text;
    let lifted = |which| {
        let mut session = open(scene(text), which, [None; 2]);
        let bread = session.softs()[0].soft;
        let height = |s: &Session| s.world().nodes(bread).iter().map(|x| x.y).sum::<f64>();
        let nodes = session.world().nodes(bread).len() as f64;
        let mut before = 0.0;
        while session.world().time() < 3.4 {
            assert!(!session.step(&mut ()).non_finite);
            if session.world().time() < 0.5 {
                before = height(&session);
            }
        }
        (height(&session) - before) / nodes
    };
    let (right, left) = (lifted(Hands::Scene), lifted(Hands::Left));
    assert!(right > 0.07 && left > 0.07, "{right} {left}");
}

#[test]
fn a_mirrored_wrist_starts_as_in_a_mirror() {
    for name in ["car-grasp", "free-motion", "skinning-comparison"] {
        let text = builtin(name).expect("a scene").text;
        let [own, left] = [Hands::Scene, Hands::Left].map(|h| open(scene(text), h, [None; 2]));
        for (a, b) in own.hands().iter().zip(left.hands()) {
            let wrist = |s: &Session, hand: &thenar_scene::build::BuiltHand| {
                s.world().rigid_pose(hand.handle.bones.start) * hand.wrist_B()
            };
            let (a, b) = (wrist(&own, a), wrist(&left, b));
            let mirrored = |v: Vec3| Vec3::new(-v.x, v.y, v.z);
            assert!((mirrored(a.position) - b.position).norm() < 1e-9, "{name}");
            for axis in [Vec3::y(), Vec3::z()] {
                let (a, b) = (a.vector(&axis), b.vector(&axis));
                assert!((mirrored(a) - b).norm() < 1e-9, "{name}");
            }
        }
        let x = |s: &Session| s.camera().expect("a camera").position.x;
        assert_eq!(x(&own), -x(&left));
    }
}

#[test]
fn lengths_are_those_asked_for() {
    let text = builtin("free-motion").expect("a scene").text;
    let session = open(scene(text), Hands::Both, [Some(0.17), Some(0.2)]);
    for hand in session.hands() {
        let want = if hand.model.side == Some(Side::Left) { 0.17 } else { 0.2 };
        assert!((hand.model.length - want).abs() < 1e-6, "{}", hand.model.length);
    }
    let own = open(scene(text), Hands::Scene, [Some(0.17), None]);
    let usual = open(scene(text), Hands::Scene, [None; 2]);
    assert_eq!(own.hands()[0].model.length, usual.hands()[0].model.length);
}

/// Both hands, and everything that can refer to one.
const FULL: &str = r#"
version = 1
[[hand]]
preset = "paper"
name = "a"
model = "left"
tets = 300
position = [-0.3, 0, 0]
[[hand]]
preset = "paper"
name = "b"
model = "right"
tets = 300
position = [0.3, 0, 0]
[[rigid]]
name = "stick"
mass = 0.1
inertia = [1e-5, 1e-5, 1e-5]
[[joint]]
name = "grip"
kind = "fixed"
parent = "b/palm"
child = "stick"
anchor = [0.3, 0, 0]
[[soft]]
name = "cuff"
shape = { kind = "lattice", size = [0.02, 0.02, 0.02], cells = [1, 1, 1] }
position = [0.3, 0.1, 0]
[[soft.bind]]
nodes = {}
bones = ["b/palm"]
[[pair]]
bodies = ["a", "b"]
contact = false
[[load]]
kind = "joint-torque"
joints = ["a/*", "b/*"]
torque = 0.001
[[load]]
kind = "joint-torque"
joints = ["b/index*"]
torque = 0.001
[[load]]
kind = "force"
body = "b/palm"
force = [1, 0, 0]
[[probe]]
name = "all"
measure = "momentum"
bodies = ["a/*", "b/*", "stick"]
[[probe]]
name = "p"
measure = "pose"
body = "b/palm"
[[probe]]
name = "c"
measure = "contact"
bodies = ["a", "b"]
[[probe]]
name = "f"
measure = "fingers"
hand = "b"
[[probe]]
name = "energy"
measure = "energy"
"#;

#[test]
fn what_refers_to_a_hand_that_is_gone_goes_with_it() {
    let both = open(scene(FULL), Hands::Both, [None; 2]);
    assert_eq!(both.hands().len(), 2);
    assert_eq!(both.scene().probe.len(), 5);
    let left = open(scene(FULL), Hands::Left, [None; 2]);
    let file = left.scene();
    assert_eq!((left.hands().len(), left.hands()[0].name.as_str()), (1, "a"));
    assert_eq!((file.joint.len(), file.pair.len(), file.load.len()), (0, 0, 1));
    assert_eq!((file.probe.len(), file.soft[0].bind.len()), (2, 0));
    let right = open(scene(FULL), Hands::Right, [None; 2]);
    let file = right.scene();
    assert_eq!((right.hands().len(), right.hands()[0].name.as_str()), (1, "b"));
    assert_eq!((file.joint.len(), file.pair.len(), file.load.len()), (1, 0, 3));
    assert_eq!((file.probe.len(), file.soft[0].bind.len()), (4, 1));
}

#[test]
fn an_error_in_a_changed_scene_names_file_and_key() {
    let mut bad = scene(FULL);
    bad.hand[0].name.value = "stick".into();
    let error = Session::from_scene(bad, Path::new("some/folder.toml")).unwrap_err().to_string();
    assert!(error.starts_with("some/folder.toml: `hand[0].name`: "), "{error}");
}
