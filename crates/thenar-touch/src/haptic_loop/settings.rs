//! Settings of a loop, and the bounds that its displays set.

use super::{Capability, LoopMode, RecordCallback};
use crate::safety::Limits;
use crate::{CouplingDesign, FeltBounds, ForceDisplay, GRIP, LoopProfile, MARGIN, Rendering};
use std::path::PathBuf;
use thenar_core::model::Drive;
use thenar_track::live::OBSERVATION;

/// Settings of the loop.
pub struct Settings {
    /// Ticks per second.
    pub rate_hz: f64,
    /// Mode of touch between hand and simulation.
    pub mode: LoopMode,
    /// Couplings to the tracked pose. Those to the bones are the scene's drives.
    pub design: CouplingDesign,
    /// Damping of the loosest grip that the wearer is taken to have \[N s/m\]: what is felt is no
    /// stiffer than such a hand bears behind the delay of its tracker ([`crate::GRIP`]). `None`
    /// shows the couplings as they are.
    pub grip: Option<f64>,
    /// Part of a device's rating that the user allows, where it is less than the device's own.
    pub user_fraction: Option<f64>,
    /// Folder for records of trips; `None` to keep no files.
    pub trip_folder: Option<PathBuf>,
    /// Sees every record.
    pub watcher: Option<RecordCallback>,
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
    settings: &Settings,
    displays: &[Box<dyn ForceDisplay>],
) -> (CouplingDesign, Vec<String>) {
    let Settings { design, rate_hz, grip, .. } = settings;
    let profiles = displays.iter().map(|display| (display.rendering(), display.loop_profile()));
    let stiffest = |most: f64, (_, profile): (_, LoopProfile)| most.min(profile.rated_stiffness);
    let device_stiffness = profiles.clone().fold(design.device_stiffness, stiffest);
    let design = CouplingDesign { device_stiffness, ..*design };
    let drive = Drive {
        stiffness: device_stiffness,
        damping: design.device_damping,
        angular_stiffness: 0.0,
        angular_damping: 0.0,
    };
    let warnings = profiles.flat_map(|(rendering, profile)| {
        let period = profile.period.max(1.0 / rate_hz);
        warnings(rendering, *grip, &LoopProfile { period, ..profile }, &drive)
    });
    (design, warnings.collect())
}

/// Warnings of a coupling as such a display shows it to a wearer of this grip: cut to what the grip
/// bears behind the display's own delay, before any tracker's. There are none where it moves no
/// finger by itself.
fn warnings(
    rendering: Rendering,
    grip: Option<f64>,
    profile: &LoopProfile,
    coupling: &Drive,
) -> Vec<String> {
    if !is_pushing(rendering) {
        return Vec::new();
    }
    let most = grip.map_or(f64::INFINITY, |grip| MARGIN * profile.felt_stiffness_max(grip));
    let stiffness = if coupling.stiffness > most { most } else { coupling.stiffness };
    let shown = Drive { stiffness, ..*coupling };
    profile.warnings(&shown).iter().map(ToString::to_string).collect()
}

/// Stops hold a finger and vibration moves none: neither gives out energy, however late.
fn is_pushing(rendering: Rendering) -> bool {
    matches!(rendering, Rendering::Tendons | Rendering::Wrench)
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
    let pushing = || displays.iter().filter(|display| is_pushing(display.rendering()));
    let holds_only = !displays.is_empty() && pushing().next().is_none();
    let grip = settings.grip.filter(|_| !holds_only);
    let profiles = pushing().map(|display| display.loop_profile());
    let profile = profiles.fold(alone, slowest);
    FeltBounds { grip, profile, observation: OBSERVATION, holds_only }
}

/// Returns the abilities of each display, and their limits.
pub(super) fn limits_of(
    settings: &Settings,
    displays: &[Box<dyn ForceDisplay>],
) -> Vec<Capability> {
    // Written so that what is not a number is refused where it is checked.
    let allowed = |own: Limits| match settings.user_fraction {
        Some(fraction) if fraction > own.user_fraction => own,
        Some(user_fraction) => Limits { user_fraction, ..own },
        None => own,
    };
    let able = |display: &dyn ForceDisplay| Capability {
        rendering: display.rendering(),
        limits: allowed(display.limits()),
        torque_limits: display.torque_limits().map(allowed),
    };
    displays.iter().map(|display| able(display.as_ref())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A LucidGlove's servos: 50 Hz, 100 ms late, 1 N s/m.
    const SERVOS: LoopProfile = LoopProfile {
        period: 0.02,
        delay: 0.1,
        damping: 1.0,
        friction: 0.5,
        resolution: 5e-4,
        rated_stiffness: 200.0,
    };

    fn said(rendering: Rendering, grip: Option<f64>, profile: &LoopProfile) -> Vec<String> {
        let [angular_stiffness, angular_damping] = [0.0; 2];
        let drive = Drive { stiffness: 200.0, damping: 0.2, angular_stiffness, angular_damping };
        warnings(rendering, grip, profile, &drive)
    }

    /// By hand: 2 (1 - 0.2) / 20 ms = 80 N/m, (1 + 0.2) / 110 ms = 11 N/m.
    #[test]
    fn a_coupling_is_warned_of_where_it_is_felt_whole() {
        let [passive, stable] = &said(Rendering::Tendons, None, &SERVOS)[..] else {
            panic!("two rules are broken")
        };
        assert!(passive.ends_with("the passivity limit of 80 N/m"), "{passive}");
        assert!(stable.ends_with("the stability limit of 11 N/m"), "{stable}");
        // A grip of 1 N s/m is shown 0.85 / 110 ms = 7.7 N/m at most, below all limits; one of 1000
        // N s/m all of the coupling.
        assert!(said(Rendering::Tendons, Some(GRIP), &SERVOS).is_empty());
        assert_eq!(said(Rendering::Tendons, Some(1e3), &SERVOS).len(), 2);
        // Servos that stop a finger give out nothing.
        for grip in [None, Some(GRIP)] {
            assert!(said(Rendering::Stops, grip, &SERVOS).is_empty());
            assert!(said(Rendering::Vibration, grip, &SERVOS).is_empty());
        }
        // 2 x 0.5 N / 0.2 m.
        let coarse = LoopProfile { resolution: 0.2, ..SERVOS };
        let [steps] = &said(Rendering::Wrench, Some(GRIP), &coarse)[..] else { panic!("one rule") };
        assert!(steps.ends_with("8 N/m is above the quantisation limit of 5 N/m"), "{steps}");
    }
}
