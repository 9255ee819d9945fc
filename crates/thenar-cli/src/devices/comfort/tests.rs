//! Goal: force rises in small steps to what is allowed and no further, and a silent device ends it.
//! Method: the guard and a display in memory, in simulated time.

use super::force_ramp::STEPS;
use super::*;
use crate::devices::feel::fake::{Display, MS};
use std::sync::{Arc, Mutex};

/// Never down, never by more than a step's slope allows, ends at the most, and each step is over
/// before it counts.
#[test]
fn force_rises_in_small_steps() {
    let force_ramp = ForceRamp::new(1, 6.0, 1.5, 2.0);
    assert_eq!(force_ramp.at(0.0), Some((0.0, 0.0)));
    assert_eq!(force_ramp.at(2.1), Some((0.0, 0.0)));
    let mut before = 0.0;
    for ms in 0..20_100 {
        let (force, comfortable) = force_ramp.at(f64::from(ms) * 1e-3).unwrap();
        assert!(force >= before && force - before < 2e-3, "{ms} ms: {before} to {force} N");
        assert!(comfortable <= force && force - comfortable <= 0.5 + 1e-9);
        before = force;
    }
    assert_eq!(before, 6.0);
    assert_eq!(force_ramp.at(2.2 + 1.5 * f64::from(STEPS)), None);
}

/// Output on a display while force rises on the middle finger, tick by tick; from `silent_ms` on
/// its device says nothing.
fn risen(
    rendering: Rendering,
    own: Limits,
    part: Option<f64>,
    silent_ms: u64,
) -> (Option<RampEnd>, Vec<HandOutput>) {
    let (clock, shown) = (Arc::new(Mutex::new(0)), Arc::new(Mutex::new(Vec::new())));
    let mut display = Display { rendering, heard_ns: clock.clone(), shown: shown.clone() };
    let limits = allowed(&rendering.limits(own), part);
    let mut trial = Trial::new(&mut display, None, limits, 0.25).unwrap();
    trial.begin(limits).unwrap();
    let force_ramp = ForceRamp::new(2, limits.force_max(), 0.2, limits.ramp);
    let (mut ended, mut ms) = (None, 0);
    while let Some((force, _)) = force_ramp.at(ms as f64 * 1e-3) {
        let now = (1000 + ms) * MS;
        if ms < silent_ms {
            *clock.lock().unwrap() = now;
        }
        ended = force_ramp.tick(&mut trial, now, force).unwrap();
        if ended.is_some() {
            break;
        }
        ms += 1;
    }
    (ended, std::mem::take(&mut *shown.lock().unwrap()))
}

/// Someone who never stops it gets what device and session allow, on that finger and no other.
#[test]
fn the_session_limits_it() {
    let own = Limits { ramp: 0.1, ..Limits::cybergrasp() };
    for (part, most) in [(None, 6.0), (Some(0.25), 3.0), (Some(1.0), 6.0)] {
        let (ended, shown) = risen(Rendering::Tendons, own, part, u64::MAX);
        assert_eq!(ended, None);
        let force = |k: usize| shown.iter().map(|o| o.digits[k].pad_force).fold(0.0, f64::max);
        assert!((force(2) - most).abs() < 1e-9, "{} N of {most} N", force(2));
        assert!([0, 1, 3, 4].iter().all(|k| force(*k) == 0.0));
    }
}

/// A device that falls silent in the middle: its guard fades, and the last that is shown is
/// nothing.
#[test]
fn a_silent_device_ends_it() {
    let own = Limits { ramp: 0.1, ..Limits::cybergrasp() };
    let (ended, shown) = risen(Rendering::Tendons, own, None, 1500);
    assert_eq!(ended, Some(RampEnd::Silent));
    assert!(shown.iter().any(|o| o.digits[2].pad_force > 2.0));
    let last = shown.last().unwrap();
    assert_eq!(last.digits, HandOutput::released(last.side, 0).digits);
    // 20 ms of silence and 50 ms of fading after it.
    assert!(shown.len() < 1500 + 100, "{} ticks", shown.len());
}
