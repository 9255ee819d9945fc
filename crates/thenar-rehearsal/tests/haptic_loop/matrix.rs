//! Goal: a hand that rests on what it feels comes to rest, whatever hand it is, however it is seen,
//! in every mode and on what it holds, alone or with the other hand, which follows its script and
//! its grip. Method: rehearsals with the paper's hands at 200 tetrahedra, one wearer, tracker, mode
//! and scene each.
//!
//! Every 29th case runs here, which takes all hands, trackers, modes and scenes in turn;
//! `THENAR_CASES=all` runs them all, `THENAR_CASES="two hands"` those of a scene.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use thenar_link::haptic_loop::LoopMode;
use thenar_rehearsal::{FingerImpedance, Outcome, Rehearsal};
use thenar_scene::session::Session;
use thenar_touch::TrackerTiming;

/// With the time at which the hand holds or presses.
const SCENES: [(&str, &str, f64); 4] = [
    ("table", include_str!("../../../thenar-scene/scenes/table-press.toml"), 1.2),
    ("bread", include_str!("../../../thenar-scene/scenes/bread-grasp.toml"), 2.1),
    ("car", include_str!("../../../thenar-scene/scenes/car-grasp.toml"), 2.1),
    ("two hands", include_str!("../../../thenar-scene/scenes/two-hands.toml"), 2.1),
];
const MODES: [LoopMode; 3] = [LoopMode::Shared, LoopMode::Multirate, LoopMode::SingleRate];
/// Mass \[kg\], damping \[N s/m\], stiffness \[N/m\].
const HANDS: [[f64; 3]; 8] = [
    [0.02, 1.0, 50.0],
    [0.02, 1.0, 500.0],
    [0.05, 1.0, 150.0],
    [0.02, 10.0, 50.0],
    [0.2, 1.0, 50.0],
    [2.0, 1.0, 50.0],
    [2.0, 10.0, 50.0],
    [2.0, 10.0, 500.0],
];
/// Rate \[Hz\] and latency \[s\].
const TRACKERS: [[f64; 2]; 4] = [[60.0, 0.0], [120.0, 0.0], [90.0, 0.02], [60.0, 0.05]];

fn hands(scene: &str) -> usize {
    scene.matches("[[hand]]").count()
}

/// Makes each hand of a scene the paper's, at 200 tetrahedra.
fn small(scene: &str) -> Vec<String> {
    let of = |k: usize| [format!("hand.{k}.preset=paper"), format!("hand.{k}.tets=200")];
    (0..hands(scene)).flat_map(of).collect()
}

fn rehearsed(case: usize) -> (String, Rehearsal, Outcome) {
    // Of every 29th, which divides none of these numbers, each has a share.
    let [modes, hands, trackers] = [MODES.len(), HANDS.len(), TRACKERS.len()];
    let mode = MODES[case % modes];
    let [mass, damping, stiffness] = HANDS[case / modes % hands];
    let [rate, latency] = TRACKERS[case / (modes * hands) % trackers];
    let (scene, text, until) = SCENES[case / (modes * hands * trackers)];
    let session = Session::from_text(text, Path::new("test.toml"), &small(text)).expect("a scene");
    let what = Rehearsal {
        human: FingerImpedance { mass, damping, stiffness },
        tracker: TrackerTiming { rate, latency, noise: 0.0 },
        mode,
        grip: Some(1.0),
        until,
        press: 0.01,
        sway: None,
        // What the push took off the felt stiffness, as noise of the tracker, has grown back after
        // three seconds.
        after: 4.0,
    };
    let out = what.run(session).expect("a hand that holds");
    let name = format!(
        "{case}: {scene} {mode:?}, {mass} kg {damping} N s/m {stiffness} N/m, {rate} Hz {latency} s: {:.0} N/m at {:.1} ms",
        out.stiffness,
        1e3 * out.delay
    );
    (name, what, out)
}

/// What is left at worst of a disturbance in the middle of the window that is looked at: of the
/// hand's own damping the rule leaves `b - 0.85` N s/m, and it decays within `2 m/(b - 0.85)`.
fn left(what: &Rehearsal) -> f64 {
    let FingerImpedance { mass, damping, .. } = what.human;
    (-(what.after - 0.5) * (damping - 0.85) / (2.0 * mass)).exp()
}

/// 20 mN and 0.1 mm rms, 0.1 mJ a second; but a hand that its own damping does not bring to rest
/// meanwhile sways with no more than is left of what disturbed it: contact, which took it away by
/// F/k, and the push, by v₀/ω.
fn check(name: &str, what: &Rehearsal, out: &Outcome) {
    let (worst, left) = (out.worst(), left(what));
    let FingerImpedance { mass, stiffness, .. } = what.human;
    let away = left * (worst.mean / stiffness + 0.5 * 0.05 / (mass * stiffness).sqrt());
    println!("{name}: {worst:?} {:?}, {away} m left", out.trips);
    let [motion, force] = [1e-4 + away, 0.02 + away * out.stiffness];
    assert!(out.trips.is_empty() && out.live, "{name}: {:?}", out.trips);
    assert!(worst.mean > 0.02, "{name}: nothing is felt");
    assert!(worst.motion_rms < motion && worst.rms < force, "{name}: {worst:?}");
    // A hand that sways still is given no more than the rule takes off its damping, 0.85 N s/m, and
    // what it goes along with the force from the window's begin to its end, less than twice 1.42
    // times its sway.
    let speed = worst.motion_rms * ((stiffness + out.stiffness) / mass).sqrt();
    let most = 1e-4 + 0.85 * speed * speed + 2.84 * worst.motion_rms * worst.mean;
    assert!(worst.given < most, "{name}: {worst:?}");
    assert!(worst.beyond < 1e-3, "{name}: given beyond its damping, {worst:?}");
}

#[test]
fn every_hand_comes_to_rest() {
    let all = MODES.len() * HANDS.len() * TRACKERS.len() * SCENES.len();
    let wanted = thenar_testing::cases_wanted();
    // A simulation within the tick takes a third of a minute on soft bread.
    let table = all / SCENES.len();
    let quick = |case: usize| MODES[case % MODES.len()] != LoopMode::SingleRate || case < table;
    // It also refuses more hands than one.
    let can = |case: &usize| {
        hands(SCENES[case / table].1) == 1 || MODES[case % MODES.len()] != LoopMode::SingleRate
    };
    let cases = (0..all).filter(can).filter(|case| match wanted.as_deref() {
        Some("all") => true,
        Some(text) => SCENES[case / table].0.contains(text),
        None => case % 29 == 5 && quick(*case),
    });
    let cases: Vec<usize> = cases.collect();
    assert!(!cases.is_empty(), "no scene is named {wanted:?}");
    let (next, threads) = (AtomicUsize::new(0), std::thread::available_parallelism());
    std::thread::scope(|scope| {
        for _ in 0..threads.map_or(1, |n| n.get()) {
            scope.spawn(|| {
                while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let (name, what, out) = rehearsed(*case);
                    check(&name, &what, &out);
                }
            });
        }
    });
}

/// 2 kg, 1 N s/m and 50 N/m have a damping ratio of 0.05 or less: what disturbs them decays within
/// `2 m/b` = 4 s, touched or not. At their 1.2 Hz observation makes up for a tracker at once, and
/// nothing is taken off their damping: from 3 to 9 s after the push the sway falls by e^(-6/4), and
/// neither mode nor rule has a part in it.
#[test]
fn a_heavy_loose_hand_decays_as_it_does_by_itself() {
    let swayed = [3.0, 9.0].map(|after| heavy(after).1.worst().motion_rms);
    let (falls, own) = (swayed[1] / swayed[0], (-6.0_f64 / 4.0).exp());
    assert!((falls / own).ln().abs() < 0.3, "to {falls} of {swayed:?}, by itself to {own}");
}

/// 2 kg, 1 N s/m and 50 N/m, pressed on a table and looked at for the second that ends so long
/// after the push \[s\].
fn heavy(after: f64) -> (Rehearsal, Outcome) {
    let (_, text, until) = SCENES[0];
    let session = Session::from_text(text, Path::new("test.toml"), &small(text)).expect("a scene");
    let human = FingerImpedance { mass: 2.0, damping: 1.0, stiffness: 50.0 };
    let tracker = TrackerTiming { rate: 120.0, latency: 0.0, noise: 0.0 };
    let (mode, grip, press, sway) = (LoopMode::Shared, Some(1.0), 0.01, None);
    let what = Rehearsal { human, tracker, mode, grip, until, press, sway, after };
    let out = what.run(session).expect("a hand that presses");
    println!("{after} s: {:?}", out.worst());
    (what, out)
}

/// How long a hand sways by itself \[s\]: until the sway that contact, which takes it away by F/k,
/// and the push, by v₀/ω, begin falls by e^(-t b/2m) to a tenth of a millimetre.
fn own_decay(human: &FingerImpedance, force: f64) -> f64 {
    let FingerImpedance { mass, damping, stiffness } = *human;
    let start = force / stiffness + 0.5 * 0.05 / (mass * stiffness).sqrt();
    2.0 * mass / damping * (start / 1e-4).ln()
}

/// Given as long as its own damping takes, and two seconds, the same hand is still: 0.1 mm and 20
/// mN rms, 0.1 mJ a second.
#[test]
fn a_heavy_loose_hand_is_still_after_its_own_decay() {
    let (what, first) = heavy(1.0);
    let wait = own_decay(&what.human, first.worst().mean);
    assert!((10.0..40.0).contains(&wait), "{wait} s");
    let (_, out) = heavy(wait + 2.0);
    let worst = out.worst();
    assert!(out.trips.is_empty() && out.live && worst.mean > 0.02, "{:?} {worst:?}", out.trips);
    assert!(worst.motion_rms < 1e-4 && worst.rms < 0.02, "{worst:?} after {wait} s");
    assert!(worst.given < 1e-4, "{worst:?}");
}
