//! Walls: when they oscillate, and when they give out energy.

use super::{DEVICE, refused, setup};
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::Mat3;
use thenar_touch::CouplingDesign;
use thenar_touch::virtual_user::{
    Device, Wall, forced_wall, passive_onset, predicted_onset, stability_onset,
};

/// Time for which a swing is watched \[s\]: near the onset it changes slowly.
const WATCH: f64 = 40.0;
/// Range in which onsets are sought \[N/m\].
const RANGE: [f64; 2] = [100.0, 10_000.0];

/// Colgate and Schenkel 1997, Gil et al. 2009; eigenvalues of the sampled loop.
pub fn limits(_: Solver) -> Result<Vec<Figure>, CaseError> {
    let at = |period: f64, delay_ticks: usize| Device { period, delay_ticks, ..DEVICE };
    let cases = [
        (at(1e-3, 0), 0.0, 2003.34),
        (at(5e-4, 0), 0.0, 4003.34),
        (at(2e-3, 0), 0.0, 1003.34),
        (at(1e-3, 1), 0.0, 668.51),
        (at(1e-3, 0), 0.5, 2990.10),
    ];
    let [low, high] = RANGE;
    let mut figures = Vec::new();
    for (device, damping, published) in cases {
        let wall = |k: f64| Wall { device, proxy: Wall::plain_proxy(k, damping) };
        let named = |what: &str| match damping {
            0.0 => format!("{what} [N/m]"),
            b => format!("{what}, B = {b} N s/m [N/m]"),
        };
        let mut row = |what: &str, expected: f64, got: f64, tolerance: f64| {
            let check = Check::Relative(tolerance);
            figures.push(Figure::new(named(what), setup(&device), expected, got, check));
        };
        let theory = predicted_onset(low, high, wall);
        row("stable limit by eigenvalues", published, theory, 5e-6);
        let simulated = stability_onset(low, high, WATCH, wall).unwrap_or(f64::NAN);
        row("stable limit, simulated", published, simulated, 0.02);
        if device.delay_ticks == 0 {
            let passive = 2.0 * (device.damping - damping) / device.period;
            let simulated = passive_onset(low, high, wall).unwrap_or(f64::NAN);
            row("passive limit, simulated", passive, simulated, 0.02);
        }
    }
    Ok(figures)
}

/// Handle forced by 5 mm at 1 to 30 Hz: what it gets back at most, as part of what it put in.
pub fn forced(_: Solver) -> Result<Vec<Figure>, CaseError> {
    let proxy = CouplingDesign::default().proxy(0.004, &Mat3::from_diagonal_element(1e-7));
    let mut figures = Vec::new();
    for period in [4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4] {
        let (mut most, mut least_force) = (f64::NEG_INFINITY, f64::INFINITY);
        for frequency in 1..=30 {
            let run = forced_wall(proxy, 5e-3, f64::from(frequency), 4, period).map_err(refused)?;
            most = most.max(run.given / run.stored_max);
            least_force = least_force.min(run.force_max);
        }
        let setup = setup(&Device { period, ..DEVICE });
        // A wall that swallows energy is well within the bound.
        let what = "net energy given / most stored, 1 to 30 Hz";
        figures.push(Figure::new(what, &setup, 0.01, most.max(0.0), Check::AtMost));
        let what = "largest force, least of all frequencies [N]";
        figures.push(Figure::new(what, &setup, 1.0, least_force, Check::AtLeast));
    }
    Ok(figures)
}

/// Abbott and Okamura 2005: min(2 b/T, 2 f_c/Δ).
pub fn quantised(_: Solver) -> Result<Vec<Figure>, CaseError> {
    let [low, high] = RANGE;
    let mut figures = Vec::new();
    for (friction, resolution) in [(0.05, 1e-4), (0.025, 1e-4), (0.05, 5e-5), (0.2, 1e-4)] {
        let device = Device { friction, resolution, ..DEVICE };
        let wall = |k: f64| Wall { device, proxy: Wall::plain_proxy(k, 0.0) };
        let bound = (2.0 * friction / resolution).min(2.0 * device.damping / device.period);
        let found = passive_onset(low, high, wall).unwrap_or(f64::NAN);
        let what =
            format!("passive limit, step {} um, friction {friction} N [N/m]", resolution * 1e6);
        figures.push(Figure::new(what, setup(&device), bound, found, Check::Relative(0.02)));
    }
    Ok(figures)
}
