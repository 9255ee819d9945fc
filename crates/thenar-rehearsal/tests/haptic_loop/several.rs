//! Goal: two devices on one hand are told apart. Method: two trackers that see one hand in two
//! places, two displays that show it; the loop on a made-up clock, a hand that is held.

use crate::rig::{MS, PRESS, Rig, Wearer, blocked, check_outputs, devices};
use thenar_core::{Pose, Vec3};
use thenar_link::haptic_loop::ManualLoop;
use thenar_link::{HandOutput, Rendering};
use thenar_track::live::LivePose;

/// A hand with as many trackers and displays as there are wearers, of which the first is the rig's
/// own.
fn several(renderings: [Rendering; 2]) -> (Rig, Wearer) {
    let mut rig = Rig::new(&blocked(), renderings[0]);
    let [(first, a, shows_a), (second, b, shows_b)] = renderings.map(devices);
    rig.clock = ManualLoop::new(&blocked(), vec![a, b], vec![shows_a, shows_b]).expect("a loop");
    rig.port = rig.clock.port();
    rig.port.attach(&rig.session).expect("a hand");
    rig.wearer = first;
    (rig, second)
}

/// Some ticks with the finger pressed by `press`, seen by the first tracker and, `by` elsewhere, by
/// the second, if they look.
fn go(rig: &mut Rig, other: &Wearer, ms: u64, press: f64, [first, second]: [bool; 2]) {
    for k in 0..ms {
        rig.blocked_frame();
        let pose = rig.pose(press);
        if second && k % 3 == 0 {
            let LivePose::Angles { wrist, angles } = pose.clone() else { unreachable!() };
            let by = Pose::new(wrist.position + Vec3::x() * 0.07, wrist.rotation);
            other.say(rig.now_ns, Some(LivePose::Angles { wrist: by, angles }));
        }
        if first {
            rig.wearer.say(rig.now_ns, Some(pose));
        }
        other.alive(rig.now_ns + MS);
        rig.tick();
    }
}

fn outputs(wearer: &Wearer) -> Vec<HandOutput> {
    wearer.shown.lock().unwrap().outputs.clone()
}

/// Another tracker that sees the hand 7 cm elsewhere changes no bit of what is felt while the first
/// one sees it. The first is silent: the other takes the hand over, after 0.1 s, with a set-out
/// that is not felt; and keeps it.
#[test]
fn one_tracker_moves_the_hand_until_it_is_silent() {
    let felt = |two: bool| {
        let (mut rig, other) = several([Rendering::Tendons; 2]);
        rig.clock.remote().arm();
        go(&mut rig, &other, 1500, 0.0, [true, two]);
        go(&mut rig, &other, 600, PRESS, [true, two]);
        (rig, other)
    };
    let (alone, _) = felt(false);
    let (mut rig, other) = felt(true);
    assert!(rig.index_force() > 0.2, "{} N", rig.index_force());
    assert_eq!(outputs(&rig.wearer), outputs(&alone.wearer));
    let tracker = |rig: &Rig| rig.clock.core(|core| core.hands()[0].tracker());
    go(&mut rig, &other, 90, PRESS, [false, true]);
    assert_eq!(tracker(&rig), Some(0));
    let before = outputs(&rig.wearer).len();
    go(&mut rig, &other, 900, PRESS, [false, true]);
    assert_eq!(tracker(&rig), Some(1));
    let way: Vec<f64> =
        outputs(&rig.wearer)[before..].iter().map(|o| o.digits[1].pad_force).collect();
    assert!(way.windows(2).all(|pair| pair[1] <= pair[0] + 1e-9), "{:?}", &way[..60]);
    assert!(way[60..].iter().all(|force| *force == 0.0), "{:?}", &way[60..]);
    // The first sees it again: it waits its turn.
    go(&mut rig, &other, 500, PRESS, [true, true]);
    assert_eq!(tracker(&rig), Some(1));
    go(&mut rig, &other, 1800, PRESS, [true, false]);
    assert_eq!(tracker(&rig), Some(0));
    assert!(rig.index_force() > 0.2, "{} N", rig.index_force());
    check_outputs(&outputs(&rig.wearer));
    assert_eq!(rig.clock.core(|core| core.tripped()), None);
}

/// Tendons and stops on one hand: each shows as if it were alone; one that is silent is let go and
/// the other is not; what trips one stops both.
#[test]
fn two_displays_of_one_hand_have_their_own_guards() {
    let (mut rig, stops) = several([Rendering::Tendons, Rendering::Stops]);
    rig.clock.remote().arm();
    go(&mut rig, &stops, 1500, 0.0, [true, false]);
    go(&mut rig, &stops, 600, PRESS, [true, false]);
    let mut alone = Rig::new(&blocked(), Rendering::Tendons);
    alone.clock.remote().arm();
    alone.run(1500, |_| 0.0);
    alone.run(600, |_| PRESS);
    assert_eq!(outputs(&rig.wearer), outputs(&alone.wearer));
    assert!(rig.index_force() > 0.2 && stops.last().digits[1].curl_at_contact.is_some());
    // Nothing is heard of the stops for 0.2 s.
    let full = rig.index_force();
    rig.run(200, |_| PRESS);
    assert!((rig.index_force() / full - 1.0).abs() < 0.01, "{} of {full} N", rig.index_force());
    assert_eq!(stops.last().digits[1].curl_at_contact, None);
    assert_eq!(stops.last().digits[1].pad_force, 0.0);
    // It is heard again, and holds the finger again.
    go(&mut rig, &stops, 900, PRESS, [true, false]);
    assert!(stops.last().digits[1].curl_at_contact.is_some());
    rig.clock.remote().stop();
    go(&mut rig, &stops, 1, PRESS, [true, false]);
    assert_eq!((rig.index_force(), stops.last().digits[1].curl_at_contact), (0.0, None));
}
