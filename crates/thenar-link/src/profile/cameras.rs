//! Profiles of trackers that see hands by cameras: how often, how late, how noisy.

use super::{Address, Check, Tracking, load};
use crate::LinkError;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use thenar_core::model::Side;
use thenar_touch::TrackerTiming;

/// Shipped profile of poses from the page.
const PAGE: &str = include_str!("../../profiles/page.toml");

/// The profile's content.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Cameras {
    /// Timing of samples, and their scatter.
    pub tracking: Tracking,
}

impl Check for Cameras {
    fn check(&self) -> Result<(), (String, String)> {
        self.tracking.check()
    }

    fn set_side(&mut self, _: Side) {}
}

/// Timing of samples that the profile of `driver` states: `shipped`, changed by this file or else
/// by the user's own.
///
/// # Errors
/// The file cannot be read, or has a key or a value that does not fit.
pub fn camera_timing(
    driver: &str,
    shipped: &str,
    profile: Option<PathBuf>,
) -> Result<TrackerTiming, LinkError> {
    let address = Address { profile, ..Address::default() };
    let profile: Cameras = load(driver, shipped, &address)?;
    Ok(profile.tracking.timing())
}

/// Timing of poses from the page: as shipped, changed by the user's `page.toml`.
///
/// # Errors
/// As [`camera_timing`].
pub fn page_timing() -> Result<TrackerTiming, LinkError> {
    camera_timing("page", PAGE, None)
}

/// Drivers whose profile states delays, `[tracking]`.
const TIMED: [&str; 5] = ["lucidgloves", "cyberglove", "cyberglove3", "hts", "openxr"];

/// True if the profile of this driver has `[tracking]`: there a measured delay is kept.
pub fn states_timing(driver: &str) -> bool {
    TIMED.contains(&driver)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of one's own with `[tracking]` alone is taken by those drivers, and by no other.
    #[test]
    fn delays_are_kept_where_they_are_read() {
        let file = std::env::temp_dir().join(format!("thenar-timed-{}.toml", std::process::id()));
        std::fs::write(&file, "[tracking]\nrate = 77.0\nlatency = 0.033\nnoise = 2e-3\n").unwrap();
        let shipped = [
            ("lucidgloves", crate::lucidgloves::SHIPPED),
            ("cyberglove", include_str!("../../profiles/cyberglove.toml")),
            ("cyberglove3", include_str!("../../profiles/cyberglove3.toml")),
            ("hts", include_str!("../../profiles/hts.toml")),
            ("openxr", include_str!("../../profiles/openxr.toml")),
            ("cybergrasp", include_str!("../../profiles/cybergrasp.toml")),
            ("force-device", include_str!("../../profiles/force-device.toml")),
        ];
        for (driver, text) in shipped {
            let has = text.lines().any(|line| line.starts_with("[tracking]"));
            assert_eq!(has, states_timing(driver), "{driver}");
        }
        let hts = format!("hts:0?profile={}", file.display());
        let glove = format!("cyberglove:/no/such/port?profile={}", file.display());
        for address in [hts, glove] {
            let timing = crate::open(&address).unwrap().tracker.unwrap().timing().unwrap();
            assert_eq!(timing, TrackerTiming { rate: 77.0, latency: 0.033, noise: 2e-3 });
        }
        std::fs::remove_file(&file).unwrap();
    }

    /// Each is what the study of a Quest 2 found: 45 ms, and half a period of 90 Hz.
    #[test]
    fn shipped_profiles_state_a_headset() {
        let hts = include_str!("../../profiles/hts.toml");
        let openxr = include_str!("../../profiles/openxr.toml");
        for (driver, shipped) in [("hts", hts), ("openxr", openxr), ("page", PAGE)] {
            let none = std::env::temp_dir().join(format!("thenar-empty-{driver}.toml"));
            std::fs::write(&none, "").unwrap();
            let timing = camera_timing(driver, shipped, Some(none.clone())).unwrap();
            std::fs::remove_file(&none).unwrap();
            assert_eq!(timing, TrackerTiming::HEADSET, "{driver}");
            assert!((timing.delay() - 0.0506).abs() < 1e-4);
        }
    }

    /// One key of a file of one's own counts; what makes no sense is refused by its name.
    #[test]
    fn a_file_of_ones_own_lies_over_it() {
        let file = std::env::temp_dir().join(format!("thenar-cameras-{}.toml", std::process::id()));
        let read = |text: &str| {
            std::fs::write(&file, text).unwrap();
            camera_timing("page", PAGE, Some(file.clone())).map_err(|e| e.to_string())
        };
        let webcam = read("[tracking]\nrate = 30.0\nlatency = 0.1\n").unwrap();
        assert_eq!(webcam, TrackerTiming { rate: 30.0, latency: 0.1, noise: 1e-3 });
        assert!(read("tracking.latency = 9.0").unwrap_err().contains("tracking.latency"));
        assert!(read("display.rated = 1.0").is_err());
        std::fs::remove_file(&file).unwrap();
    }
}
