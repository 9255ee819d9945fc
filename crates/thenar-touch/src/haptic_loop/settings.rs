//! How a loop runs, and what its displays bound.

use super::{Ability, LoopMode, Watcher};
use crate::safety::Limits;
use crate::{CouplingDesign, FeltBounds, ForceDisplay, GRIP, LoopProfile, Rendering};
use std::path::PathBuf;
use thenar::model::Drive;
use thenar_track::live::OBSERVATION;

/// How the loop runs.
pub struct Settings {
    /// Ticks per second.
    pub rate_hz: f64,
    /// What stands between hand and simulation.
    pub mode: LoopMode,
    /// Couplings to the tracked pose. Those to the bones are the scene's drives.
    pub design: CouplingDesign,
    /// Damping of the loosest grip that the wearer is taken to have \[N s/m\]: what is felt is no stiffer than such a
    /// hand bears behind the delay of its tracker ([`crate::GRIP`]). `None` shows the couplings as they are.
    pub grip: Option<f64>,
    /// Part of a device's rating that the user allows, where it is less than the device's own.
    pub user_fraction: Option<f64>,
    /// Where trips are written down; `None` to keep no files.
    pub trip_folder: Option<PathBuf>,
    /// Sees every record.
    pub watcher: Option<Watcher>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            rate_hz: 1000.0,
            mode: LoopMode::default(),
            design: CouplingDesign::default(),
            grip: Some(GRIP),
            user_fraction: None,
            trip_folder: None,
            watcher: None,
        }
    }
}

/// The couplings that these displays can render: no stiffer than their makers rate, and what speaks
/// against them even so.
pub(super) fn fitted(
    design: &CouplingDesign,
    rate_hz: f64,
    displays: &[Box<dyn ForceDisplay>],
) -> (CouplingDesign, Vec<String>) {
    let profiles: Vec<_> = displays.iter().map(|display| display.loop_profile()).collect();
    let stiffest = |most: f64, profile: &LoopProfile| most.min(profile.rated_stiffness);
    let device_stiffness = profiles.iter().fold(design.device_stiffness, stiffest);
    let design = CouplingDesign { device_stiffness, ..*design };
    let drive = Drive {
        stiffness: device_stiffness,
        damping: design.device_damping,
        angular_stiffness: 0.0,
        angular_damping: 0.0,
    };
    let slower =
        |profile: LoopProfile| LoopProfile { period: profile.period.max(1.0 / rate_hz), ..profile };
    let warnings = profiles.into_iter().map(slower).flat_map(|profile| profile.warnings(&drive));
    (design, warnings.map(|warning| warning.to_string()).collect())
}

/// The loop, and the slowest of these displays that push.
pub(super) fn bounds_of(settings: &Settings, displays: &[Box<dyn ForceDisplay>]) -> FeltBounds {
    let [delay, damping, friction, resolution] = [0.0; 4];
    let (period, rated_stiffness) = (1.0 / settings.rate_hz, f64::INFINITY);
    let alone = LoopProfile { period, delay, damping, friction, resolution, rated_stiffness };
    let slowest = |slow: LoopProfile, profile: LoopProfile| {
        let LoopProfile { period, delay, .. } = profile;
        LoopProfile { period: slow.period.max(period), delay: slow.delay.max(delay), ..slow }
    };
    // Stops hold a finger and vibration moves none: neither gives out energy, however late.
    let pushing = || {
        let pushes = [Rendering::Tendons, Rendering::Wrench];
        displays.iter().filter(move |display| pushes.contains(&display.rendering()))
    };
    let grip = settings.grip.filter(|_| displays.is_empty() || pushing().next().is_some());
    let profiles = pushing().map(|display| display.loop_profile());
    let profile = profiles.fold(alone, slowest);
    FeltBounds { grip, profile, observation: OBSERVATION }
}

/// What each display can do, and within which limits.
pub(super) fn limits_of(settings: &Settings, displays: &[Box<dyn ForceDisplay>]) -> Vec<Ability> {
    // Written so that what is not a number is refused where it is checked.
    let allowed = |own: Limits| match settings.user_fraction {
        Some(fraction) if fraction > own.user_fraction => own,
        Some(user_fraction) => Limits { user_fraction, ..own },
        None => own,
    };
    let able = |display: &dyn ForceDisplay| Ability {
        rendering: display.rendering(),
        limits: allowed(display.limits()),
        torque_limits: display.torque_limits().map(allowed),
    };
    displays.iter().map(|display| able(display.as_ref())).collect()
}
