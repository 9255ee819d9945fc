//! Goal: a tick of the haptic loop allocates nothing, whatever happens in it; nor does the
//! simulation's side. Method: a global allocator that counts, around ticks with poses, bad poses,
//! losses, arming, forces, a trip, and frames with and without a condensed response.

use std::path::Path;
use thenar_core::model::Side;
use thenar_link::haptic_loop::{LoopMode, ManualLoop, Settings, page_tracker};
use thenar_scene::session::Session;
use thenar_testing::allocations;
use thenar_touch::TrackerTiming;
use thenar_track::live::LivePose;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

const SCENE: &str = "version = 1\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\nflesh = false\n";

#[test]
fn ticks_and_frames_allocate_nothing() {
    for mode in [LoopMode::Multirate, LoopMode::Shared, LoopMode::SingleRate] {
        let mut session = Session::from_text(SCENE, Path::new("t.toml"), &[]).expect("a scene");
        let opened = thenar_link::open("null:right").expect("a display");
        let displays = opened.display.into_iter().collect();
        let (mut poses, page) = page_tracker(TrackerTiming::HEADSET);
        let settings =
            Settings { mode, trip_folder: Some(std::env::temp_dir()), ..Settings::default() };
        let mut clock = ManualLoop::new(&settings, vec![page], displays).expect("a loop");
        let mut port = clock.port();
        port.attach(&session).expect("a hand");
        let hand = &session.hands()[0];
        let wrist = session.world().rigid_pose(hand.handle.bones.start) * hand.wrist_B();
        let mut now = thenar_link::now_ns();
        let remote = clock.remote();
        let mut led = |ms: u64| {
            now += 1_000_000;
            let flexion = 0.2 * (1.0 - (ms as f64 * 5e-3).cos());
            let pose = match ms {
                1500..1600 => Some(LivePose::Angles { wrist, angles: [f64::NAN; 20] }),
                1600..1700 => None,
                _ => Some(LivePose::Angles { wrist, angles: [flexion; 20] }),
            };
            poses.put(Side::Right, pose);
            match ms {
                900 => remote.arm(),
                1400 => remote.stop(),
                1450 => remote.arm(),
                _ => {}
            }
            if ms.is_multiple_of(5) {
                port.before_step(&mut session, now).expect("a hand");
                session.step(&mut ());
                port.after_step(&mut session, now);
            }
            assert!(clock.tick(now));
            while clock.records.pop().is_ok() {}
        };
        // The first lead takes its memory.
        (0..20).for_each(&mut led);
        let before = allocations::so_far();
        let mut last = None;
        for ms in 20..1800 {
            let until_now = allocations::so_far();
            led(ms);
            if allocations::so_far() != until_now {
                last = Some(ms);
            }
        }
        let count = allocations::so_far() - before;
        assert_eq!(count, 0, "allocations in 1780 ticks of {mode:?}, the last at {last:?} ms");
    }
}
