//! Goal: bones are solid where flesh is crushed, and nowhere else. Method: the tip of a finger of
//! the paper's hand lies between two steel plates, of which one is fixed; a load presses the other
//! one down, and lets it go. Expected from geometry and statics: the plates come no nearer than the
//! bone is thick, the finger's readout shows the load, and no energy comes from nowhere.

use crate::press::{FRICTION_BELOW, Press};
use thenar_core::model::{BodyId, Digit};
use thenar_core::readout::ContactReadout;
use thenar_core::world::ContactPoint;

/// What crushes the tip \[N\].
const CRUSHING: f64 = 200.0;

fn crush(digit: Digit, tets: usize, step: f64) {
    // The thumb's tip is broader: flesh bears nearly all of 200 N there.
    let load = if digit == Digit::Thumb { 3.0 * CRUSHING } else { CRUSHING };
    let mut press = Press::new(digit, tets, step, true);
    let rest = press.thickness();
    press.run(0.5, |t| load * (t / 0.2).min(1.0));
    let (opening, bone) = (press.opening(), press.bone);
    assert!(opening > bone - 0.2e-3, "{opening} m between plates around a bone of {bone} m");
    // Flesh is crushed below 0.3 of its thickness (`flesh/crush.rs`).
    let most = bone + 0.3 * (rest - bone);
    assert!(opening < most, "the flesh is not crushed: {opening} m, bone {bone} m of {rest} m");
    is_told(&press, load);

    let released = press.run(0.5, |t| if t < 0.05 { -1.0 } else { 0.0 });
    assert_eq!(released.inverted_tets, 0, "elements stay inverted");
    let after = press.thickness();
    assert!((after / rest - 1.0).abs() < 0.02, "{after} m of {rest} m after release");
    // A thousandth of the work to crush it is left to the solver's accuracy.
    assert!(press.excess < 3e-4, "{} J from nowhere", press.excess);
}

/// The finger's readout holds the load, whether flesh or bone bears it, and so do the pairs of
/// bodies.
fn is_told(press: &Press, load: f64) {
    assert!(press.on_bone() > 0.1 * load, "the bone bears {} N", press.on_bone());
    let mut readout = ContactReadout::new(&press.world);
    readout.read(&press.world);
    let pair = [BodyId::Soft(press.soft), BodyId::Rigid(press.upper)];
    let above = -readout.pair(&press.world, pair).force_W.y;
    assert!((above / load - 1.0).abs() < 0.02, "{above} N of {load} N from above");
    let finger = readout.parts(press.soft)[press.digit.part() as usize].contact.normal;
    assert!((finger / (2.0 * load) - 1.0).abs() < 0.1, "{finger} N from both sides");
    // What is set for the hand holds for its bones.
    let [above, below] = [press.upper, press.lower].map(BodyId::Rigid);
    let on = |c: &&ContactPoint| c.bodies.contains(&below) && !c.bodies.contains(&above);
    for contact in press.world.contacts().iter().filter(on) {
        assert_eq!(contact.friction, FRICTION_BELOW, "{:?}", contact.bodies);
    }
}

#[test]
fn steel_plates_stop_at_the_bone_at_1_ms() {
    crush(Digit::Index, 600, 1e-3);
}

#[test]
fn steel_plates_stop_at_the_bone_at_5_ms() {
    crush(Digit::Index, 600, 5e-3);
}

#[test]
fn steel_plates_stop_at_the_bone_at_60_hz() {
    crush(Digit::Index, 600, 1.0 / 60.0);
}

#[test]
fn steel_plates_stop_at_the_bones_of_thumb_and_little_finger() {
    for digit in [Digit::Thumb, Digit::Little] {
        crush(digit, 600, 5e-3);
    }
}

#[test]
fn steel_plates_stop_at_the_bone_in_fine_flesh() {
    crush(Digit::Index, 2000, 5e-3);
}

/// In a grip flesh bears all: bones change not a bit.
#[test]
fn a_press_of_5_newtons_does_not_feel_the_bone() {
    let [solid, soft] = [true, false].map(|solid_bones| {
        let mut press = Press::new(Digit::Index, 600, 1e-3, solid_bones);
        press.run(0.3, |t| 5.0 * (t / 0.1).min(1.0));
        assert_eq!(press.on_bone(), 0.0);
        (press.opening(), press.world.state_hash())
    });
    assert_eq!(solid, soft);
}
