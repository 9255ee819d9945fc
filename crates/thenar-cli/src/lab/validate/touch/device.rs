//! Forces that a device is given, whatever is wanted of it.

use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_scene::session::Random;
use thenar_touch::safety::{Guard, Limits, Signal};
use thenar_touch::{CYBERGRASP_FORCE_MAX, tendon_pull};

/// Ticks of 1 ms.
const TICKS: u64 = 20_000;

/// CyberGrasp at its full rating: at most 12 N per finger, pull only, whatever is wanted.
pub fn cybergrasp(_: Solver) -> Result<Vec<Figure>, CaseError> {
    let limits = Limits { user_fraction: 1.0, ..Limits::cybergrasp() };
    let mut guard = Guard::<1>::new(limits, 100).map_err(|e| CaseError::Missing(e.to_string()))?;
    guard.arm();
    let (mut random, mut wanted) = (Random::new(12), 0.0_f64);
    let (mut largest, mut least, mut change, mut before) = (0.0_f64, f64::INFINITY, 0.0_f64, 0.0);
    let (mut wrong_sign, mut pulled) = (0_u32, 0_u32);
    for tick in 1..=TICKS {
        let now = tick * 1_000_000;
        // Nothing until the guard has engaged; then anything, held for a while.
        if tick > 3000 && tick % 50 == 0 {
            wanted = 60.0 * random.symmetric();
        }
        let [sent] = guard.tick(
            now,
            &Signal {
                force: [wanted],
                velocity: [-0.05],
                simulation_ns: now,
                tracking_ns: now,
                device_ns: now,
                enabled: true,
            },
        );
        largest = largest.max(sent);
        least = least.min(sent);
        change = change.max((sent - before).abs());
        // After 20 ms the slew limit has let everything through.
        if tick > 3000 && tick % 50 == 49 {
            let right = tendon_pull(wanted, CYBERGRASP_FORCE_MAX);
            wrong_sign += u32::from((sent - right).abs() > 1e-9);
            pulled += u32::from(sent > 0.0);
        }
        before = sent;
    }
    let setup = "T = 1 ms, 20 s of +-60 N";
    let row = |what: &str, expected, got, check| {
        Figure::new(what, setup, expected, got, check).rests_on(Basis::Construction)
    };
    Ok(vec![
        row("largest force sent [N]", CYBERGRASP_FORCE_MAX, largest, Check::AtMost),
        row("the rating is reached [N]", CYBERGRASP_FORCE_MAX, largest, Check::Relative(1e-9)),
        row("least force sent (pull only) [N]", 0.0, least, Check::AtLeast),
        row("largest change in a tick [N]", 12.0 / 20.0, change, Check::Relative(1e-9)),
        row("times sent is not wanted, clamped", 0.0, f64::from(wrong_sign), Check::AtMost)
            .rests_on(Basis::Itself),
        row("times it pulled", 100.0, f64::from(pulled), Check::AtLeast),
    ])
}
