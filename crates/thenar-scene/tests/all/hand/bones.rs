//! Goal: a scene chooses whether bones are solid, and what a bone bears is its finger's. Method: a
//! hand lies on a floor under a weight of 200 kg, which its flesh alone cannot bear; loads are
//! summed up from the contacts of the world. Of fingers that are driven through each other the
//! distance of the bones' axes is computed here.

use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::BodyId;
use thenar_core::shape::Shape;
use thenar_scene::session::Session;

fn load(hand: &str) -> Session {
    let text = format!(
        "version = 1
        time_step = 0.005
        duration = 0.3
        [[hand]]
        preset = \"paper\"
        name = \"hand\"
        position = [0.0, 0.025, 0.0]
        driven = false
        {hand}
        [[rigid]]
        name = \"floor\"
        motion = \"fixed\"
        shape = {{ kind = \"plane\" }}
        [[rigid]]
        name = \"weight\"
        position = [0.0, 0.07, -0.09]
        mass = 200.0
        shape = {{ kind = \"box\", size = [0.3, 0.02, 0.3] }}"
    );
    Session::from_text(&text, Path::new("test.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn bones_with_shape(session: &Session) -> usize {
    let bones = session.hands()[0].handle.bones.clone();
    let rigids = &session.world().desc().rigids;
    bones.filter(|b| rigids[*b as usize].shape.is_some()).count()
}

#[test]
fn bones_are_solid_unless_the_scene_says_otherwise() {
    assert_eq!(bones_with_shape(&load("")), 16);
    assert_eq!(bones_with_shape(&load("bones = \"solid\"")), 16);
    assert_eq!(bones_with_shape(&load("bones = \"none\"")), 0);
    // A skeleton without flesh touches nothing.
    let skeleton = load("flesh = false");
    assert_eq!(bones_with_shape(&skeleton), 0);
    assert_eq!((skeleton.hands()[0].flesh(), skeleton.world().desc().softs.len()), (None, 0));
    let flesh = load("").hands()[0].flesh().expect("flesh");
    assert_eq!(load("").world().desc().softs[flesh as usize].name, "hand");
}

#[test]
fn what_bones_bear_counts_for_the_hand() {
    let mut session = load("");
    for _ in 0..session.steps_wanted() {
        assert!(!session.step(&mut ()).non_finite);
    }
    let hand = &session.hands()[0];
    let [mut on_flesh, mut on_bones] = [0.0; 2];
    for contact in session.world().contacts() {
        for body in contact.bodies {
            let normal = contact.force_W.dot(&contact.normal_W);
            match body {
                BodyId::Soft(soft) if Some(soft) == hand.flesh() => on_flesh += normal,
                BodyId::Rigid(b) if hand.handle.bones.contains(&b) => on_bones += normal,
                _ => {}
            }
        }
    }
    assert!(on_bones > 100.0, "{on_bones} N on bones, {on_flesh} N on flesh");
    let told: f64 = session.hand_loads(0).iter().map(|load| load.normal).sum();
    let all = on_flesh + on_bones;
    assert!((told / all - 1.0).abs() < 1e-9, "{told} N of {all} N");
}

/// The middle lines of a bone's capsules, world, and their radius \[m\].
fn capsules(session: &Session, name: &str) -> (Vec<[Vec3; 2]>, f64) {
    let world = session.world();
    let bone = world.desc().rigids.iter().position(|r| r.name == name).expect(name);
    let rigid = &world.desc().rigids[bone];
    let pose = world.rigid_pose(bone as u32) * rigid.pose_BS;
    let Some(Shape::Compound(parts)) = &rigid.shape else { panic!("{name}") };
    let mut thickness = 0.0;
    let lines = parts.iter().map(|part| {
        let Shape::Capsule { radius, half_length } = part.shape else { panic!("{name}") };
        thickness = radius;
        let pose = pose * part.pose_SP;
        [-half_length, half_length].map(|y| pose.point(&Vec3::new(0.0, y, 0.0)))
    });
    (lines.collect(), thickness)
}

/// Least distance of two segments, by parts of a hundredth of their lengths and once more around
/// the best.
fn distance(a: &[Vec3; 2], b: &[Vec3; 2]) -> f64 {
    let at = |s: &[Vec3; 2], t: f64| s[0] + (s[1] - s[0]) * t.clamp(0.0, 1.0);
    let around = |s0: f64, t0: f64, part: f64| {
        let steps = || (-100..=100).map(|i| part * f64::from(i));
        let pairs = steps().flat_map(|s| steps().map(move |t| (s0 + s, t0 + t)));
        pairs.map(|(s, t)| ((at(a, s) - at(b, t)).norm(), s, t)).min_by(|p, q| p.0.total_cmp(&q.0))
    };
    let (_, s, t) = around(0.5, 0.5, 0.005).expect("a place");
    around(s, t, 5e-5).expect("a place").0
}

/// A thumb and an index finger whose targets lie beyond each other: flesh is crushed between the
/// bones, which do not pass.
#[test]
fn bones_of_two_fingers_do_not_pass_each_other() {
    for h in [0.001, 0.005, 1.0 / 60.0] {
        let key = |time: f64, pose: &str| {
            format!(
                "[[hand.motion.key]]\ntime = {time}\n{pose}\n\
                 wrist = {{ position = [0, 0.12, 0], fingers = [0, 1, 0], back = [0, 0, -1] }}\n"
            )
        };
        let text = format!(
            "version = 1\ntime_step = {h}\nduration = 1.0\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\n\
             bone_drive = {{ stiffness = 1e4, damping = 100, angular_stiffness = 10, angular_damping = 0.1 }}\n\
             [hand.motion]\nkind = \"keyframes\"\n{}{}",
            key(0.0, "pose = \"open\""),
            key(
                0.5,
                "pose = \"pinch\"\njoints = { thumb-cmc = { flexion_deg = 30, spread_deg = 18 }, thumb-mcp = { flexion_deg = 25 }, index-mcp = { flexion_deg = 85 }, index-pip = { flexion_deg = 70 } }"
            )
        );
        let mut session = Session::from_text(&text, Path::new("test.toml"), &[]).unwrap();
        let mut least = f64::INFINITY;
        for _ in 0..session.steps_wanted() {
            assert!(!session.step(&mut ()).non_finite);
            let [thumb, index] = ["hand/thumb-distal", "hand/index-distal"];
            let ((a, ra), (b, rb)) = (capsules(&session, thumb), capsules(&session, index));
            let pairs = a.iter().flat_map(|a| b.iter().map(move |b| distance(a, b)));
            least = pairs.map(|apart| apart - ra - rb).fold(least, f64::min);
        }
        // As bones hold steel plates: within 0.2 mm. Within the contact margin they touch.
        assert!(least > -2e-4, "{h} s: {} mm", least * 1e3);
        assert!(least < 1e-3, "{h} s: {} mm, so the bones hold nothing", least * 1e3);
    }
}
