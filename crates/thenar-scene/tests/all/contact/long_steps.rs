//! Goal: at 60 Hz joints of a hand stay closed and nothing gains energy. Method: a fist clenched in
//! the air, and a free hand that lands on a table, at several speeds, steps, heights and tilts,
//! against the balance of energy.

use std::path::Path;
use thenar_scene::session::{Session, read};

const FRAME: f64 = 1.0 / 60.0;

fn session(text: &str) -> Session {
    let scene = read(text, &[]).unwrap_or_else(|f| panic!("{}: {}", f.key, f.problem));
    Session::from_scene(scene, Path::new("test.toml")).unwrap_or_else(|error| panic!("{error}"))
}

/// A hand that opens and closes so many times a second.
fn fist(preset: &str, rate: f64) -> String {
    let mut text = format!(
        "version = 1\ntime_step = {FRAME}\nduration = 1.0\n[[hand]]\npreset = \"{preset}\"\nname = \"hand\"\n\
         [hand.motion]\nkind = \"keyframes\"\n"
    );
    for k in 0..=(2.0 * rate) as u32 {
        let (time, pose) = (f64::from(k) / (2.0 * rate), ["open", "fist"][k as usize % 2]);
        text += &format!("[[hand.motion.key]]\ntime = {time}\npose = \"{pose}\"\n");
        if k == 0 {
            text += "wrist = { position = [0, 0.3, 0], fingers = [0, 0, -1], back = [0, 1, 0] }\n";
        }
    }
    text
}

#[test]
fn the_joints_of_a_fast_fist_stay_closed() {
    for (preset, rate) in [("paper", 2.5), ("paper", 5.0), ("touch", 2.5)] {
        let mut session = session(&fist(preset, rate));
        let mut fastest = 0.0_f64;
        for _ in 0..60 {
            let report = session.step(&mut ());
            assert!(!report.fell_back && !report.non_finite, "{report:?}");
            assert!(report.joint_gap_max < 1e-6, "{preset}, {rate} Hz: {} m", report.joint_gap_max);
            let world = session.world();
            let rates = (0..world.desc().joints.len() as u32).flat_map(|j| world.joint_rates(j));
            fastest = rates.fold(fastest, |most, rate| most.max(rate.abs()));
        }
        assert!(fastest > 4.0 * rate, "{preset}, {rate} Hz: its joints turn at {fastest} rad/s");
    }
}

/// Without a drive a hand has what its fall gives it and no more.
#[test]
fn a_landing_brings_in_no_energy() {
    for preset in ["paper", "touch"] {
        for (h, height, tilt) in [
            (FRAME, 0.25, 30.0),
            (FRAME, 0.15, 30.0),
            (FRAME, 0.4, 30.0),
            (FRAME, 0.25, 90.0),
            (FRAME, 0.3, 60.0),
            (FRAME, 0.3, 120.0),
            (0.02, 0.3, 150.0),
            (0.01, 0.25, 30.0),
            (0.005, 0.2, 45.0),
            (1.0 / 30.0, 0.25, 30.0),
        ] {
            land(preset, h, height, tilt);
        }
    }
}

/// Lets a hand fall from a height \[m\] at a tilt \[degrees\], in steps of length `h` \[s\].
fn land(preset: &str, h: f64, height: f64, tilt: f64) {
    let mut session = session(&format!(
        "version = 1\ntime_step = {h}\nduration = 1.0\n[[rigid]]\nname = \"table\"\n\
         shape = {{ kind = \"plane\" }}\nmotion = \"fixed\"\nfriction = 0.5\n[[hand]]\n\
         preset = \"{preset}\"\n\
         name = \"hand\"\ndriven = false\nposition = [0, {height}, 0]\n\
         rotation = {{ axis = [0.2, 0, 1], angle_deg = {tilt} }}\n"
    ));
    let mut last = session.world().energy(session.input()).total();
    let mut met = false;
    for step in 0..(0.5 / h) as u32 {
        let report = session.step(&mut ());
        assert!(!report.fell_back && report.joint_gap_max < 1e-6, "{report:?}");
        met |= report.contacts_active > 0;
        let now = session.world().energy(session.input()).total();
        let rise = now - last;
        assert!(
            rise < 1e-3,
            "{preset}, h {h}, {height} m, {tilt} degrees: {rise} J to {now} J in step {step}"
        );
        last = now;
    }
    assert!(met, "it must land");
}
