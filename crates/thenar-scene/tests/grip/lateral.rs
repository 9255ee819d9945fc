//! A key between the thumb's pad and the side of the bent index finger.

use crate::stage::{Held, hold, open};
use thenar_core::{Pose, Quat, Vec3};
use thenar_scene::grip::{GripHand, GripKind, pads_middle_at};
use thenar_scene::session::Session;

/// A key that stands on a peg between the pads, as a scene.
#[derive(Clone, Debug)]
struct Key {
    side: &'static str,
    /// Along the fingers, upwards, and across, between the pads [m].
    size: [f64; 3],
    mass: f64,
    force: Option<f64>,
    friction: f64,
    /// Time step [s].
    h: f64,
}

impl Key {
    /// Of 30 by 50 by 3 mm.
    fn of(mass: f64, force: Option<f64>) -> Self {
        let size = [0.03, 0.05, 0.003];
        Self { side: "right", size, mass, force, friction: 0.8, h: 5e-3 }
    }

    fn hand(&self, grip: &str, wrist: &Pose) -> String {
        let triple = |v: Vec3| format!("[{}, {}, {}]", v.x, v.y, v.z);
        let (fingers, back) = (triple(wrist.vector(&-Vec3::z())), triple(wrist.vector(&Vec3::y())));
        let key = |(t, y): (f64, f64)| {
            let at = triple(wrist.position + Vec3::y() * y);
            format!(
                "[[hand.motion.key]]\ntime = {t}\npose = \"rest\"\n\
                 wrist = {{ position = {at}, fingers = {fingers}, back = {back} }}\n"
            )
        };
        let keys = [(0.0, 0.0), (2.0, 0.0), (2.8, 0.1), (4.5, 0.1)].map(key).concat();
        let (side, friction) = (self.side, self.friction);
        format!(
            "[[hand]]\nname = \"hand\"\npreset = \"paper\"\nmodel = \"{side}\"\nfriction = {friction}\n\
             {grip}[hand.motion]\nkind = \"keyframes\"\n{keys}"
        )
    }

    /// Wrist of a hand whose pads are level, with their middle at the origin, and the direction
    /// between them.
    fn stand(&self) -> (Pose, Vec3) {
        let text = format!("version = 1\n{}", self.hand("", &Pose::identity()));
        let session = open(&text);
        let hand = &session.hands()[0];
        let bodies = session.world().desc().rigids.len();
        let mut gripping = GripHand::new(hand, bodies).expect("a hand that grips");
        gripping.learn(hand, GripKind::Lateral).expect("a kind");
        let pads = gripping.opposition(GripKind::Lateral).expect("learnt");
        let palm = session.world().rigid_pose(hand.handle.bones.start);
        let axis = palm.vector(&pads.at(self.size[2]).axis);
        let level = Vec3::new(axis.x, 0.0, axis.z).normalize();
        let turn = Quat::rotation_between(&axis, &level).expect("a turn");
        let middle = pads_middle_at(&palm, pads, self.size[2]);
        (Pose::new(-(turn * middle), turn), level)
    }

    fn text(&self) -> String {
        let (wrist, level) = self.stand();
        let Self { size: [x, y, z], mass, friction, h, .. } = self;
        // The pads hold its upper third.
        let drop = y / 6.0;
        let turn_deg = f64::atan2(level.x, level.z).to_degrees();
        let force = self.force.map_or(String::new(), |force| format!("force = {force}\n"));
        let grip =
            format!("[[hand.grip]]\nobject = \"thing\"\nkind = \"lateral\"\nat = 0.1\n{force}");
        // A smooth slot keeps it upright.
        let wall = |(name, side): (&str, f64)| {
            let way = level * (side * (0.5 * z + 0.0025));
            format!(
                "[[rigid]]\nname = \"{name}\"\nshape = {{ kind = \"box\", size = [{x}, 0.012, 0.004] }}\n\
                 motion = \"fixed\"\nposition = [{}, {}, {}]\nfriction = 0\n\
                 rotation = {{ axis = [0, 1, 0], angle_deg = {turn_deg} }}\n",
                way.x,
                -drop - 0.5 * y + 0.006,
                way.z
            )
        };
        let slot = [("near", -1.0), ("far", 1.0)].map(wall).concat();
        format!(
            "version = 1\ntime_step = {h}\nduration = 4.5\n\
             [[rigid]]\nname = \"peg\"\nshape = {{ kind = \"box\", size = [0.012, 0.02, 0.012] }}\n\
             motion = \"fixed\"\nposition = [0, {}, 0]\nfriction = 0.8\n{slot}\
             [[rigid]]\nname = \"thing\"\nshape = {{ kind = \"box\", size = [{x}, {y}, {z}] }}\n\
             mass = {mass}\nfriction = {friction}\nposition = [0, {}, 0]\n\
             rotation = {{ axis = [0, 1, 0], angle_deg = {turn_deg} }}\n{}",
            -drop - 0.5 * y - 0.01,
            -drop,
            self.hand(&grip, &wrist)
        )
    }

    fn session(&self) -> Session {
        open(&self.text())
    }
}

/// Lifts it with the hand, within what drives give way to arm and weight, and holds it still.
#[track_caller]
fn holds(key: &Key) {
    let held: Held = hold(&mut key.session());
    let what = format!("{key:?}: {held:?}");
    assert!((held.lift - 0.1).abs() < 6e-3, "{what}");
    assert!(held.slip < 1e-3, "{what}");
    if let Some(force) = key.force {
        assert!((held.force / force - 1.0).abs() < 0.1, "{what}");
    }
    assert_eq!(held.trouble, None, "{what}");
}

#[test]
fn a_key_is_held_beside_the_index_finger() {
    holds(&Key::of(0.02, Some(2.0)));
    holds(&Key::of(0.02, None));
}

#[test]
fn a_left_hand_holds_a_heavy_key_and_a_thin_one() {
    holds(&Key { side: "left", ..Key::of(0.1, Some(2.0)) });
    holds(&Key { size: [0.03, 0.05, 8e-4], friction: 0.5, ..Key::of(5e-3, Some(1.0)) });
}

#[test]
fn a_key_of_8_mm_is_held_at_long_steps() {
    holds(&Key { size: [0.03, 0.05, 8e-3], h: 1.0 / 60.0, ..Key::of(0.02, Some(2.0)) });
}
