//! Goal: a hand that nobody leads says nothing of a wearer. Method: a script closes its fingers as
//! fast as people do, in steps of 10 ms; then a tracker takes it over.

use crate::rig::{Rig, small};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_touch::safety::Status;

/// Fingers close in a tenth of a second from `start` \[s\] on, at some 1 m/s: seen from frame to
/// frame within a tick that is ten times as much.
fn scene(start: f64) -> String {
    let end = start + 0.1;
    small(&format!(
        r#"version = 1
time_step = 0.01
[[hand]]
name = "hand"
model = "right"
[hand.motion]
kind = "keyframes"
[[hand.motion.key]]
time = {start}
pose = "open"
[[hand.motion.key]]
time = {end}
pose = "fist"
"#
    ))
}

/// Returns the fastest that guards take a pad or the palm to be [m/s, rad/s].
fn go(rig: &mut Rig, ms: std::ops::Range<u64>, seen: bool) -> f64 {
    let mut fastest = 0.0_f64;
    for ms in ms {
        if ms % 10 == 0 {
            rig.simulated_frame();
        }
        if seen {
            let pose = rig.pose(0.0);
            rig.wearer.say(rig.now_ns, Some(pose));
        }
        rig.tick();
        rig.clock.core(|core| {
            assert_eq!(core.tripped(), None, "{ms} ms");
            let guards = core.actuators();
            let waits = |status| matches!(status, Status::Waiting { .. });
            assert!(seen || guards.iter().all(|guard| waits(guard.status())), "{ms} ms");
            let pads = guards.iter().flat_map(|guard| guard.axes()).map(|axis| axis.velocity);
            let palm = core.hands()[0].palm().map(|(_, way)| way).into_iter().flatten();
            fastest = pads.chain(palm).map(f64::abs).fold(fastest, f64::max);
        });
    }
    fastest
}

/// Guards let nothing through to a hand that no tracker has led, not even while the clock is young,
/// and judge no speed of it. Taking a hand over, wherever its bones are, is no motion of the wearer
/// either: from then on pads go as fast as the hand is led, at 4 Hz over some centimetres, and
/// forces come.
#[test]
fn a_script_closes_a_hand_and_guards_wait() {
    for mode in [LoopMode::Multirate, LoopMode::Shared] {
        for start in [0.02, 0.2] {
            let settings = Settings { mode, grip: None, ..Settings::default() };
            let mut rig = Rig::of(&scene(start), &settings, Rendering::Tendons);
            rig.clock.remote().arm();
            let until = (1e3 * start) as u64 + 65;
            assert_eq!(go(&mut rig, 0..until, false), 0.0, "{mode:?}");
            let fastest = go(&mut rig, until..until + 3000, true);
            assert!(0.1 < fastest && fastest < 5.0, "{mode:?}: {fastest} m/s, rad/s");
            let live = rig
                .clock
                .core(|core| core.actuators().iter().all(|guard| guard.status() == Status::Live));
            assert!(live, "{mode:?}");
        }
    }
}
