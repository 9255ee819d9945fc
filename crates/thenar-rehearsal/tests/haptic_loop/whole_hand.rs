//! Goal: a whole soft hand is felt through the product's own loop alike in all modes, at any rate
//! of the simulation. Method: a hand of about 600 tetrahedra over a table, led through exact poses
//! in simulated time; ticks of 1 ms.

use std::f64::consts::TAU;
use std::path::Path;
use thenar_core::Vec3;
use thenar_link::haptic_loop::{LoopMode, Settings};
use thenar_rehearsal::{Comparison, Led, Study, moved, scripted};
use thenar_scene::session::Session;
use thenar_touch::{BLEND, CouplingDesign, GRIP, TrackerTiming};

/// Fingertips a few millimetres above a table.
const OVER_A_TABLE: &str = include_str!("../../../thenar-cli/scenes/validation/e09-press.toml");
/// An arm that is seen in each tick.
const AT_ONCE: TrackerTiming = TrackerTiming { rate: 1000.0, latency: 0.0, noise: 0.0 };
/// Before anything is asked of a hand: it sets out and comes to rest \[ms\].
const BEFORE: u64 = 1800;

fn open(text: &str, period: u64, set: &[&str]) -> Session {
    let mut all: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
    all.push("hand.hand.preset=paper".to_owned());
    all.push(format!("time_step={}", 1e-3 * period as f64));
    Session::from_text(text, Path::new("test.toml"), &all).unwrap()
}

fn settings(mode: LoopMode) -> Settings {
    Settings { mode, grip: None, ..Settings::default() }
}

/// Down by two centimetres and up, once a second.
const PRESS: Study = Study {
    way: Vec3::new(0.0, -0.02, 0.0),
    frequency: 1.0,
    cycles: 1,
    tracker: AT_ONCE,
    design: CouplingDesign {
        device_stiffness: 800.0,
        bone_stiffness: 800.0,
        lever: 0.02,
        damping_ratio: 1.0,
        device_damping: 0.2,
    },
    grip: None,
};

fn led(study: &Study, mode: LoopMode, period: u64, set: &[&str]) -> Comparison {
    study.run(open(OVER_A_TABLE, period, set), mode).unwrap()
}

/// Frames of 60 and 20 Hz that arrive a period late, against the simulation within the tick.
/// Neither that nor shared constraints give out energy; these are as stiff as the simulation itself
/// and without jumps.
#[test]
fn shared_constraints_feel_like_the_simulation_within_the_tick() {
    let whole = led(&PRESS, LoopMode::SingleRate, 16, &[]);
    let most = whole.force.iter().fold(0.0_f64, |a, f| a.max(*f));
    let tell = |one: &Comparison| {
        println!(
            "{:?} {} ms: {} N/m, {} ms late, {} N rms, gives {} J of {} J, jumps by {} N",
            one.mode,
            one.period,
            one.stiffness,
            one.delay_ms,
            one.rms_from(&whole),
            one.given,
            one.stored_max,
            one.jump_max
        );
    };
    tell(&whole);
    assert!((25.0..35.0).contains(&most), "the hand is pressed with {most} N");
    assert!(whole.given < 0.01 * whole.stored_max);
    // 800 N/m to the hand, 200 N/m and 1 N s/m to the bones.
    let (r, damper) = (0.8, 1.0);
    for (period, jump) in [(16, 0.2), (50, 0.4)] {
        let shared = led(&PRESS, LoopMode::Shared, period, &[]);
        let paper = led(&PRESS, LoopMode::Multirate, period, &[]);
        // So late, it gives out energy; felt as stiff as a loose grip bears, less than that grip
        // takes up at each of the 16 bones, `b a² ω²/2` a second.
        let bounded = Study { grip: Some(GRIP), ..PRESS };
        let bounded = led(&bounded, LoopMode::Multirate, period, &[]);
        [&shared, &paper, &bounded].iter().for_each(|one| tell(one));
        // Multirate is as late as the rule says for frames a period old; observation leads the slow
        // press by some 2 ms.
        let frame = period as f64;
        let rule = 2.0 * frame / r - 0.5 * frame + 1e3 * ((1.0 - r * r) * damper / 1000.0 + BLEND);
        assert!((paper.delay_ms / rule).ln().abs() < 0.1, "{} of {rule} ms", paper.delay_ms);
        assert!(shared.given < 0.01 * shared.stored_max, "{period} ms: {} J given", shared.given);
        let off = shared.stiffness / whole.stiffness - 1.0;
        assert!(off.abs() < 0.01, "{period} ms: {} of {}", shared.stiffness, whole.stiffness);
        let [ours, papers] = [&shared, &paper].map(|one| one.rms_from(&whole));
        assert!(ours < 0.01 * most && papers > 10.0 * ours, "{period} ms: {ours}, {papers} N rms");
        assert!(shared.jump_max < jump, "{period} ms: {} N in a tick", shared.jump_max);
        let takes = 16.0 * GRIP * 0.5 * (0.01 * TAU).powi(2);
        assert!(bounded.given < takes && paper.given > 3.0 * takes, "{} J", bounded.given);
    }
}

/// A glove of soft couplings (200 N/m to its proxies) on stiff bones (400 and 1600 N/m), up and
/// down by 10 cm once a second: what is felt at most, where the fingertips leave the table, is 0.1
/// N for each of 16 couplings. Shared constraints give less than a thousandth of what a loose grip
/// takes up meanwhile at each bone.
#[test]
fn a_soft_coupling_to_stiff_bones_is_quiet_in_free_air() {
    for (drive, period) in [(400, 16), (1600, 16), (1600, 50)] {
        let design = CouplingDesign { device_stiffness: 200.0, ..CouplingDesign::default() };
        let up = Study { way: Vec3::y() * 0.1, cycles: 2, design, ..PRESS };
        let set = format!("hand.hand.bone_drive.stiffness={drive}");
        for mode in [LoopMode::Shared, LoopMode::Multirate] {
            let one = led(&up, mode, period, &[&set]);
            let most = one.force.iter().fold(0.0_f64, |a, f| a.max(f.abs()));
            println!("{drive} N/m, {mode:?} {period} ms: {most} N, gives {} J", one.given);
            assert!(most < 1.6, "{drive} N/m, {mode:?} {period} ms: {most} N");
            let takes = 2.0 * 16.0 * GRIP * 0.5 * (0.05 * TAU).powi(2);
            let passive = mode == LoopMode::Multirate || one.given < 1e-3 * takes;
            assert!(passive, "{drive} N/m, {period} ms: {} of {takes} J", one.given);
        }
    }
}

/// A simulation at 20 Hz stalls for half a second while the hand goes on pressing and lifting.
#[test]
fn a_stalled_simulation_keeps_the_period_and_a_continuous_force() {
    for (mode, jump_max) in [(LoopMode::Shared, 0.3), (LoopMode::Multirate, 3.0)] {
        let session = open(OVER_A_TABLE, 50, &[]);
        let start = scripted(&session, 0.0).unwrap();
        let mut hand = Led::new(session, &settings(mode), AT_ONCE).unwrap();
        let (mut before, mut jump, mut oldest) = (0.0, 0.0_f64, 0.0_f64);
        let (mut in_stall, mut work, mut stored) = (Vec::new(), 0.0, 0.0_f64);
        for ms in 0..BEFORE + 2000 {
            // Down by 2 cm within 400 ms, then a swing of 5 mm at 2 Hz.
            let since = ms.saturating_sub(BEFORE);
            let down = 0.02 * (since as f64 / 400.0).min(1.0);
            let swing = 0.005 * (TAU * 2e-3 * since.saturating_sub(400) as f64).sin();
            let stalled = (600..1100).contains(&since);
            hand.tick(Some(&moved(&start, -Vec3::y() * (down + swing))), stalled).unwrap();
            let report = hand.stage().hand(|hand| *hand.report());
            assert!(ms == 0 || report.step == 1e-3, "the period is kept");
            let force = hand.force().y;
            if ms > BEFORE {
                oldest = oldest.max(report.simulation_age);
                jump = jump.max((force - before).abs());
                work += 1e-3 * hand.power();
                stored = stored.max(-work);
            }
            if stalled {
                in_stall.push(force);
            }
            before = force;
        }
        let [low, high] = [f64::min, f64::max].map(|f| in_stall.iter().copied().reduce(f).unwrap());
        println!("{mode:?}: {jump} N a tick, {work} of {stored} J, {low} to {high} N, {oldest} s");
        assert!(oldest > 0.5 && oldest < 0.7, "{oldest} s");
        assert!(jump < jump_max, "{mode:?}: {jump} N from one tick to the next");
        assert!(work < 0.01 * stored, "{mode:?} gives {work} J");
        // The hand is felt all the while; with shared constraints the force follows the swing, in
        // multirate it stays.
        let follows = if mode == LoopMode::Shared { 5.0 } else { 0.0 };
        assert!(low > 5.0 && high < 60.0 && high - low > follows, "{mode:?}: {low} to {high} N");
    }
}
