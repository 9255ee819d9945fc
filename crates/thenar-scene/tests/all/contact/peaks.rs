//! Goal: what is told of soft bodies that touch agrees with itself: no finger bears its load on
//! less skin than the peak pressure says. Method: a grasp and a fist that ship, step by step; means
//! of the read-out of loads beside peaks of vertices.

use thenar_core::readout::ContactReadout;
use thenar_scene::session::{Session, builtin};

/// Peaks of all soft bodies count: each of a patch has one, and its area is that of the larger.
fn no_mean_is_larger_than_the_peak(scene: &str, until: f64) {
    let text = builtin(scene).expect("a scene").text;
    let mut session = Session::from_text(text, std::path::Path::new(scene), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let mut readout = ContactReadout::new(session.world());
    let (mut pressed, mut steps) = (0, 0);
    while session.world().time() < until {
        session.step(&mut ());
        readout.read(session.world());
        let softs = 0..session.world().desc().softs.len() as u32;
        let vertices = softs.flat_map(|soft| readout.vertices(soft));
        let peak = vertices.map(|v| v.pressure).fold(0.0, f64::max);
        for load in session.hand_loads(0) {
            let [time, pressure] = [session.world().time(), load.pressure];
            assert!(pressure <= peak * (1.0 + 1e-9), "{scene}, {time} s: {pressure} of {peak} Pa");
            pressed += usize::from(load.normal > 0.1);
        }
        steps += 1;
    }
    assert!(pressed > steps, "more than a finger presses in most steps: {pressed} in {steps}");
}

#[test]
fn no_mean_pressure_on_the_loaf_is_larger_than_the_peak() {
    no_mean_is_larger_than_the_peak("bread-grasp", 3.0);
}

#[test]
fn no_mean_pressure_in_a_fist_is_larger_than_the_peak() {
    no_mean_is_larger_than_the_peak("fist", 2.0);
}
