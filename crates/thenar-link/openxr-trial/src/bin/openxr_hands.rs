//! Prints what the device at the given address, such as `openxr:`, reports, one line each: hands,
//! losses and messages, until its input ends.
//!
//! `hand left X Y Z A B C W RADIUS ...` for 25 joints, `lost left`, `told MESSAGE`.

use std::io::Read;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use thenar_core::model::Side;
use thenar_link::{HandSample, Tracker};
use thenar_scene::live::LivePose;

fn main() {
    static ENDED: AtomicBool = AtomicBool::new(false);
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        ENDED.store(true, Ordering::Relaxed);
    });
    let address = std::env::args().nth(1).unwrap_or_else(|| "openxr:".into());
    let mut tracker = match thenar_link::open(&address).map(|opened| opened.tracker) {
        Ok(Some(tracker)) => tracker,
        Ok(None) => return println!("told no tracker"),
        Err(error) => return println!("told {error}"),
    };
    while !ENDED.load(Ordering::Relaxed) {
        tell(&mut *tracker);
        std::thread::sleep(Duration::from_millis(1));
    }
    drop(tracker);
    println!("ended");
}

fn tell(tracker: &mut dyn Tracker) {
    for (side, name) in [(Side::Left, "left"), (Side::Right, "right")] {
        match tracker.latest(side) {
            Some(HandSample { pose: Some(LivePose::Joints { joints, radii }), .. }) => {
                let mut line = format!("hand {name}");
                for (joint, radius) in joints.iter().zip(radii) {
                    let numbers = joint.position.iter().chain(joint.rotation.coords.iter());
                    numbers.chain([radius]).for_each(|number| line += &format!(" {number}"));
                }
                println!("{line}");
            }
            Some(HandSample { pose: None, .. }) => println!("lost {name}"),
            Some(other) => println!("told another pose: {other:?}"),
            None => {}
        }
    }
    tracker.messages().iter().for_each(|text| println!("told {text}"));
}
