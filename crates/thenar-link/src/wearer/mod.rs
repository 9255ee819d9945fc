//! Comfort of a wearer: how much force on each finger at most, how slowly it comes after arming,
//! how much softer.
//!
//! A small file for each person, `wearers/NAME.toml` beside the profiles of devices, with a table
//! for each kind of device. It only ever takes away from what device and session allow
//! ([`ComfortDisplay`]).

mod comfort_display;

pub use comfort_display::{ComfortDisplay, limited_to_comfort};

use crate::LinkError;
use crate::profile::{read_table, save, settings_folder};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thenar_touch::DIGITS;
use thenar_touch::safety::Limits;
use toml::Table;

/// The wearer whose settings count where none is named.
pub const SOMEBODY: &str = "default";

/// Largest ramp that can be meant \[s\].
const RAMP_MAX: f64 = 60.0;
/// Largest force that can be meant \[N\], as in profiles of displays.
const FORCE_MAX: f64 = 100.0;

/// Comfortable limits with one kind of device.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Comfort {
    /// Largest force on each finger, thumb first \[N\]; of a device that pushes the whole hand, the
    /// least of them.
    pub force: [f64; DIGITS],
    /// Time in which force comes up after arming, where it is longer than the device's \[s\].
    #[serde(default)]
    pub ramp: f64,
    /// Part of the stiffness that is felt, 0 to 1.
    #[serde(default = "whole")]
    pub stiffness: f64,
}

fn whole() -> f64 {
    1.0
}

impl Comfort {
    /// Refuses what nobody can want.
    fn check(&self) -> Result<(), (&'static str, String)> {
        let bad = |x: &&f64| !(0.0..=FORCE_MAX).contains(*x);
        if let Some(force) = self.force.iter().find(bad) {
            return Err(("force", format!("has {force:?} N, expected 0 to {FORCE_MAX}")));
        }
        if !(0.0..=RAMP_MAX).contains(&self.ramp) {
            return Err(("ramp", format!("is {:?} s, expected 0 to {RAMP_MAX}", self.ramp)));
        }
        if !(0.0..=1.0).contains(&self.stiffness) {
            return Err(("stiffness", format!("is {:?}, expected 0 to 1", self.stiffness)));
        }
        Ok(())
    }

    /// The device's own limits, with no more than is comfortable, and changes in proportion: from
    /// nothing to the most in the same time as before. Of a device that pushes one point, `part` of
    /// its range is left.
    pub fn within(&self, own: &Limits, part: f64) -> Limits {
        let user_fraction = (own.user_fraction * part).clamp(0.0, own.user_fraction);
        // No change at all would leave a force where it is.
        let change = part.clamp(LEAST_CHANGE, 1.0);
        Limits {
            user_fraction,
            slew: own.slew * change,
            step_max: own.step_max * change,
            ramp: own.ramp.max(self.ramp),
            ..*own
        }
    }

    /// The keys of a file.
    fn keys(&self) -> Table {
        let force = self.force.map(toml::Value::Float).to_vec();
        let numbers = [("ramp", self.ramp), ("stiffness", self.stiffness)];
        std::iter::once(("force".to_string(), toml::Value::Array(force)))
            .chain(numbers.map(|(key, x)| (key.to_string(), toml::Value::Float(x))))
            .collect()
    }
}

/// Changes are cut to this part at least: a guard without any would never let go.
const LEAST_CHANGE: f64 = 0.05;

impl std::fmt::Display for Comfort {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [t, i, m, r, l] = self.force;
        write!(f, "at most {t:.2} {i:.2} {m:.2} {r:.2} {l:.2} N from the thumb on")?;
        if self.ramp > 0.0 {
            write!(f, ", coming up within {} s or more", self.ramp)?;
        }
        if self.stiffness < 1.0 {
            write!(f, ", {:.0} % of the stiffness", 100.0 * self.stiffness)?;
        }
        Ok(())
    }
}

/// A person who wears devices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wearer {
    /// File of the settings; `None` for somebody without any.
    pub file: Option<PathBuf>,
    devices: BTreeMap<String, Comfort>,
}

impl Wearer {
    /// The settings of the wearer of this name, or of nobody in particular, of whom there may be
    /// none.
    ///
    /// # Errors
    /// The name is none, a named wearer has no settings, or the file cannot be read or has a key or
    /// value that does not fit.
    pub fn load(name: Option<&str>) -> Result<Self, LinkError> {
        match (wearer_file(name.unwrap_or(SOMEBODY))?, name) {
            (Some(file), _) if file.exists() => Self::read(&file),
            (_, None) => Ok(Self::default()),
            (_, Some(name)) => Err(LinkError::Setting {
                what: format!("wearer `{name}`"),
                cause: "has no settings yet; `thenar devices comfort` finds them".into(),
            }),
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// It cannot be read, or has a key or value that does not fit.
    pub fn read(file: &Path) -> Result<Self, LinkError> {
        let what = format!("wearer {}", file.display());
        let refuse = |what: String, cause: String| LinkError::Setting { what, cause };
        let devices: BTreeMap<String, Comfort> =
            read_table(file).map_err(|cause| refuse(what.clone(), cause))?;
        for (device, comfort) in &devices {
            comfort
                .check()
                .map_err(|(key, cause)| refuse(format!("{what}, {device}.{key}"), cause))?;
        }
        Ok(Self { file: Some(file.into()), devices })
    }

    /// Comfortable limits with devices of this driver.
    pub fn with(&self, driver: &str) -> Option<&Comfort> {
        self.devices.get(driver)
    }
}

/// Keeps what is comfortable with devices of `driver`. Other devices and comments of the file stay.
///
/// # Errors
/// Nobody can want it, or the file is no TOML or cannot be written.
pub fn keep(file: &Path, driver: &str, comfort: &Comfort) -> Result<(), LinkError> {
    comfort.check().map_err(|(key, cause)| LinkError::Setting {
        what: format!("wearer {}, {driver}.{key}", file.display()),
        cause,
    })?;
    let table = toml::Value::Table(comfort.keys());
    save(file, std::iter::once((driver.to_string(), table)).collect())
}

/// Path of a wearer's settings, whether or not there are any; `None` where the system has no place
/// for settings.
///
/// # Errors
/// The name is none for a file.
pub fn wearer_file(name: &str) -> Result<Option<PathBuf>, LinkError> {
    let fits = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    if name.is_empty() || name.len() > 64 || !name.chars().all(fits) {
        let cause = "expected 1 to 64 letters, digits, - and _".into();
        return Err(LinkError::Setting {
            what: format!("wearer `{}`", thenar_input::brief(name)),
            cause,
        });
    }
    Ok(settings_folder().map(|folder| folder.join("wearers").join(format!("{name}.toml"))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn comfort() -> Comfort {
        Comfort { force: [2.0, 3.0, 3.0, 2.5, 1.0], ramp: 4.0, stiffness: 0.8 }
    }

    fn file(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("thenar-wearer-{name}-{}.toml", std::process::id()))
    }

    #[test]
    fn what_is_kept_is_read_again_and_the_rest_stays() {
        let file = file("kept");
        let own = "# Anna\n[lucidgloves] # the old one\nforce = [1.0, 1.0, 1.0, 1.0, 1.0] # weak\n";
        std::fs::write(&file, own).unwrap();
        keep(&file, "cybergrasp", &comfort()).unwrap();
        let wearer = Wearer::read(&file).unwrap();
        assert_eq!(wearer.with("cybergrasp"), Some(&comfort()));
        let old = wearer.with("lucidgloves").unwrap();
        assert_eq!((old.force, old.ramp, old.stiffness), ([1.0; 5], 0.0, 1.0));
        assert_eq!(wearer.with("bhaptics"), None);
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.starts_with(own) && text.contains("[cybergrasp]\n"), "{text}");
        keep(&file, "cybergrasp", &Comfort { stiffness: 1.0, ..comfort() }).unwrap();
        assert_eq!(Wearer::read(&file).unwrap().with("cybergrasp").unwrap().stiffness, 1.0);
        let nan = Comfort { ramp: f64::NAN, ..comfort() };
        assert!(keep(&file, "cybergrasp", &nan).is_err());
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn what_nobody_can_want_is_refused_by_its_name() {
        let file = file("bad");
        for (text, told) in [
            ("[x]\nforce = [1.0, 1.0, 1.0, 1.0, -1.0]", "x.force: has -1.0 N, expected 0 to 100"),
            ("[x]\nforce = [1.0, 1.0, 1.0, 1.0, nan]", "x.force: has NaN N"),
            ("[x]\nforce = [1.0]", "force"),
            (
                "[x]\nforce = [1.0, 1.0, 1.0, 1.0, 1.0]\nramp = 1e9",
                "x.ramp: is 1000000000.0 s, expected 0 to 60",
            ),
            (
                "[x]\nforce = [1.0, 1.0, 1.0, 1.0, 1.0]\nstiffness = 1.5",
                "x.stiffness: is 1.5, expected 0 to 1",
            ),
            ("[x]\nforce = [1.0, 1.0, 1.0, 1.0, 1.0]\nstrength = 1.0", "unknown field `strength`"),
            ("force = 1", "invalid type"),
            ("[x", "TOML parse error"),
        ] {
            std::fs::write(&file, text).unwrap();
            let message = Wearer::read(&file).unwrap_err().to_string();
            assert!(message.starts_with("wearer ") && message.contains(told), "{text}: {message}");
            assert!(!message.contains('\n'), "{message}");
        }
        std::fs::remove_file(&file).unwrap();
        for name in ["", "../anna", "a b", &"x".repeat(65)] {
            assert!(Wearer::load(Some(name)).unwrap_err().to_string().contains("1 to 64 letters"));
        }
    }

    /// A part of the range: less force, changes in proportion, a ramp that is no quicker; and never
    /// more than before.
    #[test]
    fn limits_only_become_narrower() {
        let own = Limits::cybergrasp();
        let less = comfort().within(&own, 0.5);
        assert_eq!(less.force_max(), 3.0);
        assert_eq!((less.slew, less.step_max, less.ramp), (300.0, 0.6, 4.0));
        less.check().unwrap();
        let quick = Comfort { ramp: 0.1, ..comfort() };
        assert_eq!(quick.within(&own, 7.0), own);
        let none = quick.within(&own, 0.0);
        assert!(none.force_max() == 0.0 && none.check().is_ok());
    }
}
