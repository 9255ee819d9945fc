//! Four fingers bent around a handle carry it by their shape: friction and force do not decide.

use crate::stage::{Held, hold, open};
use thenar_core::Vec3;
use thenar_core::model::Digit;
use thenar_scene::session::Session;

/// A handle in a rack before the fingers of a hand that points down, as one takes a bag.
#[derive(Clone, Debug)]
struct Bag {
    side: &'static str,
    /// Shape of the handle, along the row of fingers.
    shape: &'static str,
    /// Half of its height [m].
    half: f64,
    /// Half of its depth, from the palm on [m].
    deep: f64,
    mass: f64,
    friction: f64,
    /// Time step [s].
    h: f64,
    /// Keys of the grip.
    more: &'static str,
}

/// Round bars of 6, 10 and 20 mm radius, 140 mm long.
const BAR: [&str; 3] = [
    "{ kind = \"capsule\", radius = 0.006, length = 0.14 }",
    "{ kind = \"capsule\", radius = 0.01, length = 0.14 }",
    "{ kind = \"capsule\", radius = 0.02, length = 0.14 }",
];
/// From the axes of the fingers' first bones to the handle [m]: that of an index finger is 12 mm
/// under its skin.
const BEFORE: f64 = 0.02;
/// Part of the first bone, from the knuckle, before which the handle is.
const ALONG: f64 = 0.5;

impl Bag {
    fn of(shape: &'static str, half: f64, mass: f64) -> Self {
        Self { side: "right", shape, half, deep: half, mass, friction: 0.8, h: 5e-3, more: "" }
    }

    fn hand(&self, grip: &str, at: &Vec3) -> String {
        let key = |(t, y): (f64, f64)| {
            let [x, y, z] = [at.x, at.y + y, at.z];
            format!(
                "[[hand.motion.key]]\ntime = {t}\npose = \"open\"\n\
                 wrist = {{ position = [{x}, {y}, {z}], fingers = [0, -1, 0], back = [0, 0, 1] }}\n"
            )
        };
        let keys = [(0.0, 0.0), (2.5, 0.0), (3.3, 0.1), (4.5, 0.1)].map(key).concat();
        let (side, friction) = (self.side, self.friction);
        format!(
            "[[hand]]\nname = \"hand\"\npreset = \"paper\"\nmodel = \"{side}\"\nfriction = {friction}\n\
             {grip}[hand.motion]\nkind = \"keyframes\"\n{keys}"
        )
    }

    /// Where the handle is when the wrist is at the origin [m].
    fn place(&self) -> Vec3 {
        let session = open(&format!("version = 1\n{}", self.hand("", &Vec3::zeros())));
        let (hand, world) = (&session.hands()[0], session.world());
        let mut sum = Vec3::zeros();
        for digit in &Digit::FINGERS[1..] {
            let k = hand.model.bones.iter().position(|bone| bone.digit == *digit).expect("a bone");
            let [from, to] = hand.model.bones[k].ends_B;
            let pose = world.rigid_pose(hand.handle.bones.start + k as u32);
            sum += pose.point(&(from + (to - from) * ALONG)) * 0.25;
        }
        sum - Vec3::z() * (BEFORE + self.deep)
    }

    fn text(&self) -> String {
        let Self { shape, half, mass, friction, h, more, .. } = self;
        let grip =
            format!("[[hand.grip]]\nobject = \"thing\"\nkind = \"hook\"\nat = 0.1\n{more}\n");
        let turn = match shape.contains("capsule") {
            true => "rotation = { axis = [0, 0, 1], angle_deg = 90 }\n",
            false => "",
        };
        let post = |(name, x): (&str, f64)| {
            format!(
                "[[rigid]]\nname = \"{name}\"\nshape = {{ kind = \"box\", size = [0.02, 0.04, 0.04] }}\n\
                 motion = \"fixed\"\nposition = [{x}, {}, 0]\nfriction = 0.8\n",
                -half - 0.02
            )
        };
        // Its lips keep a round bar from rolling off.
        let lip = |(name, x, side): (&str, f64, f64)| {
            format!(
                "[[rigid]]\nname = \"{name}\"\nshape = {{ kind = \"box\", size = [0.02, 0.008, 0.01] }}\n\
                 motion = \"fixed\"\nposition = [{x}, {}, {}]\nfriction = 0.8\n",
                0.004 - half,
                side * (self.deep + 0.007)
            )
        };
        let lips = [("a", -0.065, -1.0), ("b", -0.065, 1.0), ("c", 0.065, -1.0), ("d", 0.065, 1.0)];
        let posts = [("left", -0.065), ("right", 0.065)].map(post).concat();
        let posts = posts + &lips.map(lip).concat();
        format!(
            "version = 1\ntime_step = {h}\nduration = 4.5\n{posts}\
             [[rigid]]\nname = \"thing\"\nshape = {shape}\nmass = {mass}\nfriction = {friction}\n{turn}{}",
            self.hand(&grip, &-self.place())
        )
    }

    fn session(&self) -> Session {
        open(&self.text())
    }
}

/// A handle sinks into pads, and fingers give way to its weight, by less than this [m]: a third of
/// what a finger is thick.
const SINKS: f64 = 5e-3;

/// Carries what it lifts, and lets it hang still.
#[track_caller]
fn carries(bag: &Bag) {
    let held: Held = hold(&mut bag.session());
    let what = format!("{bag:?}: {held:?}");
    assert!(held.lift > 0.1 - SINKS && held.lift < 0.1 + 2e-3, "{what}");
    assert!(held.slip < 1e-3, "{what}");
    // What hangs presses with its weight at least.
    assert!(held.force > 0.45 * bag.mass * 9.81, "{what}");
    assert_eq!(held.trouble, None, "{what}");
}

#[test]
fn bars_of_12_to_40_mm_hang_in_the_fingers() {
    for (shape, half) in BAR.into_iter().zip([0.006, 0.01, 0.02]) {
        carries(&Bag::of(shape, half, 0.3));
    }
}

/// Fingers bent around it carry it however slippery it is.
#[test]
fn a_slippery_bar_hangs_in_the_fingers() {
    for friction in [0.3, 0.05] {
        carries(&Bag { friction, ..Bag::of(BAR[1], 0.01, 0.3) });
    }
}

#[test]
fn a_light_and_a_heavy_bag_are_carried() {
    for mass in [0.1, 2.0] {
        carries(&Bag::of(BAR[1], 0.01, mass));
    }
}

#[test]
fn a_left_hand_and_a_box_for_a_handle() {
    carries(&Bag { side: "left", ..Bag::of(BAR[1], 0.01, 0.5) });
    let shape = "{ kind = \"box\", size = [0.14, 0.02, 0.012] }";
    carries(&Bag { deep: 0.006, ..Bag::of(shape, 0.01, 0.5) });
}

#[test]
fn a_bar_is_carried_at_every_step() {
    for h in [1e-3, 1.0 / 60.0] {
        carries(&Bag { h, ..Bag::of(BAR[1], 0.01, 0.3) });
    }
}

/// Fingers bend towards a force, which a hanging load is part of: they squeeze a bar of 100 g with
/// what is asked.
#[test]
fn a_hook_presses_with_the_force_asked_for() {
    let held = hold(&mut Bag { more: "force = 5", ..Bag::of(BAR[1], 0.01, 0.1) }.session());
    assert!(held.force > 4.5 && held.most < 6.5 && held.trouble.is_none(), "{held:?}");
}

/// A bar 110 mm before the fingers, which are no longer than that, is missed, and the hand says so.
#[test]
fn a_hook_that_closes_beside_a_bar_says_so() {
    let far = Bag { deep: 0.09, more: "force = 2", ..Bag::of(BAR[1], 0.01, 0.3) };
    let held = hold(&mut far.session());
    let trouble = held.trouble.as_ref().unwrap_or_else(|| panic!("{held:?}"));
    assert!(held.lift < 1e-3 && !trouble.is_empty(), "{held:?}");
}
