//! Gain and offset of each sensor, by least squares over prescribed poses.

use super::profile::{Profile, SHIPPED, SHIPPED_3, Sensor};
use super::sensors::{NAMES, SENSORS};
use super::{Classic, CyberGlove3Driver, CyberGloveDriver, Third, open_with};
use crate::calibration::{Calibrate, Fitted, Prompt};
use crate::profile::{Address, load};
use crate::{Driver, LinkError, Opened, Protocol};
use thenar_track::ANGLES;
use toml::{Table, Value};

/// A sensor's values must spread by so much over the poses.
const CHANGE_MIN: f64 = 0.05;

/// A pose: what to do, and the angles that sensors then have \[degrees\].
struct Pose {
    prompt: Prompt,
    angles: &'static [(&'static str, f64)],
}

const POSES: [Pose; 5] = [
    Pose {
        prompt: Prompt {
            name: "flat",
            text: "lay your hand flat on a table, fingers straight and together, the thumb beside \
                   the index finger",
        },
        angles: &[
            ("thumb_roll", 0.0),
            ("thumb_mpj", 0.0),
            ("thumb_ij", 0.0),
            ("thumb_abduction", 0.0),
            ("index_mpj", 0.0),
            ("index_pij", 0.0),
            ("index_dij", 0.0),
            ("middle_mpj", 0.0),
            ("middle_pij", 0.0),
            ("middle_dij", 0.0),
            ("middle_abduction", 0.0),
            ("ring_mpj", 0.0),
            ("ring_pij", 0.0),
            ("ring_dij", 0.0),
            ("ring_abduction", 0.0),
            ("little_mpj", 0.0),
            ("little_pij", 0.0),
            ("little_dij", 0.0),
            ("little_abduction", 0.0),
        ],
    },
    Pose {
        prompt: Prompt {
            name: "spread",
            text: "on the table, spread the fingers as far as is comfortable, the thumb square to \
                   the index finger",
        },
        angles: &[
            ("thumb_abduction", 60.0),
            ("middle_abduction", 20.0),
            ("ring_abduction", 20.0),
            ("little_abduction", 25.0),
        ],
    },
    Pose {
        prompt: Prompt {
            name: "table-top",
            text: "bend the knuckles by a right angle, fingers straight",
        },
        angles: &[
            ("index_mpj", 85.0),
            ("middle_mpj", 85.0),
            ("ring_mpj", 85.0),
            ("little_mpj", 85.0),
        ],
    },
    Pose {
        prompt: Prompt {
            name: "hook",
            text: "keep the knuckles straight, bend the two outer joints of all fingers",
        },
        angles: &[
            ("index_mpj", 0.0),
            ("index_pij", 100.0),
            ("index_dij", 60.0),
            ("middle_mpj", 0.0),
            ("middle_pij", 100.0),
            ("middle_dij", 60.0),
            ("ring_mpj", 0.0),
            ("ring_pij", 100.0),
            ("ring_dij", 60.0),
            ("little_mpj", 0.0),
            ("little_pij", 100.0),
            ("little_dij", 60.0),
        ],
    },
    Pose {
        prompt: Prompt {
            name: "thumb",
            text: "fold the thumb across the palm to the root of the little finger, both its joints \
                   bent",
        },
        angles: &[("thumb_roll", 40.0), ("thumb_mpj", 50.0), ("thumb_ij", 70.0)],
    },
];

/// A profile under which the tracker's angles are sensor values: a radian per full value.
fn raw(mut profile: Profile) -> Profile {
    let one = Sensor { gain: 1.0_f64.to_degrees(), offset: 0.0 };
    profile.sensors = NAMES.iter().map(|name| ((*name).to_string(), one)).collect();
    profile.glove.wrist_turns = false;
    profile
}

/// Values of the sensors in `hand`'s angles under such a profile: `sensors::hand`, backwards. What
/// is not in them is `None`.
fn values(angles: &[f64; ANGLES]) -> [Option<f64>; SENSORS] {
    let a = |k: usize| Some(angles[k]);
    let mut values = [None; SENSORS];
    // Thumb: roll, middle joint, outer joint, abduction.
    [values[0], values[3], values[1], values[2]] = [a(0), a(1), a(2), a(3)];
    for (first, d) in [(4, 1), (7, 2), (11, 3), (15, 4)] {
        [values[first], values[first + 1], values[first + 2]] =
            [a(4 * d), a(4 * d + 2), a(4 * d + 3)];
    }
    (values[10], values[14]) = (a(5), a(13));
    values[18] = Some(angles[17] - angles[13]);
    values
}

/// Least squares of angle = gain (value - offset) for every sensor.
fn fit(means: &[[f64; ANGLES]]) -> Fitted {
    let mut fitted = Fitted::default();
    let mut found = Table::new();
    let by_pose: Vec<_> = means.iter().map(values).collect();
    for (k, name) in NAMES.into_iter().enumerate() {
        let pairs: Vec<(f64, f64)> = (POSES.iter().zip(&by_pose))
            .filter_map(|(pose, values)| {
                let (_, degrees) = pose.angles.iter().find(|(sensor, _)| *sensor == name)?;
                Some((values[k]?, *degrees))
            })
            .collect();
        if pairs.len() < 2 {
            continue;
        }
        let n = pairs.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.0), mean(|p| p.1));
        let xx: f64 = pairs.iter().map(|p| (p.0 - x).powi(2)).sum();
        let xy: f64 = pairs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        let gain = xy / xx;
        if xx < 0.5 * CHANGE_MIN * CHANGE_MIN || !gain.is_finite() || gain == 0.0 {
            fitted.remarks.push(format!("sensor {name} hardly moved: it stays unchanged"));
            continue;
        }
        let round = |x: f64| Value::Float((x * 1e4).round() / 1e4);
        let sensor = [("gain", gain), ("offset", x - y / gain)];
        let table = sensor.into_iter().map(|(key, x)| (key.to_string(), round(x))).collect();
        found.insert(name.into(), Value::Table(table));
    }
    if !found.is_empty() {
        fitted.keys.insert("sensors".into(), Value::Table(found));
    }
    fitted
}

/// Both kinds of gloves are fitted alike.
macro_rules! calibrate {
    ($driver:ty, $shipped:expr, $protocol:ty) => {
        impl Calibrate for $driver {
            fn prompts(&self) -> Vec<Prompt> {
                POSES.iter().map(|pose| pose.prompt).collect()
            }

            fn open_raw(&self, address: &str) -> Result<Opened, LinkError> {
                let parsed = Address::parse(self.name(), address)?;
                let profile = raw(load(self.name(), $shipped, &parsed)?);
                let protocol = |profile| Box::new(<$protocol>::new(profile)) as Box<dyn Protocol>;
                open_with(self.name(), &parsed, profile, protocol)
            }

            fn fit(&self, means: &[[f64; ANGLES]]) -> Fitted {
                fit(means)
            }
        }
    };
}

calibrate!(CyberGloveDriver, SHIPPED, Classic);
calibrate!(CyberGlove3Driver, SHIPPED_3, Third);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profile::Check;

    /// A wearer whose sensors have gains and offsets of their own takes the poses; both are found.
    #[test]
    fn gains_and_offsets_are_found_again() {
        let gain = |k: usize| 70.0 + 5.0 * k as f64 * if k.is_multiple_of(3) { -1.0 } else { 1.0 };
        let offset = |k: usize| 0.3 + 0.01 * k as f64;
        let address = Address::parse("cyberglove", "x").unwrap();
        let profile = raw(load("cyberglove", SHIPPED, &address).unwrap());
        let means: Vec<_> = (POSES.iter())
            .map(|pose| {
                let degrees = |name: &str| pose.angles.iter().find(|(n, _)| *n == name);
                let value = |k: usize| degrees(NAMES[k]).map_or(0.5, |d| d.1 / gain(k) + offset(k));
                profile.pose(&std::array::from_fn::<f64, SENSORS, _>(value)).1
            })
            .collect();
        let fitted = fit(&means);
        assert!(fitted.remarks.is_empty(), "{:?}", fitted.remarks);
        let mut found: Profile = profile.clone();
        found.sensors = fitted.keys["sensors"].clone().try_into().unwrap();
        found.check().unwrap();
        assert_eq!(found.sensors.len(), 19, "all but palm arch and wrist");
        for (k, name) in NAMES.into_iter().enumerate().take(19) {
            let sensor = found.sensors[name];
            assert!((sensor.gain / gain(k) - 1.0).abs() < 1e-4, "{name}: {sensor:?}");
            assert!((sensor.offset - offset(k)).abs() < 1e-4, "{name}: {sensor:?}");
        }
    }

    #[test]
    fn a_sensor_that_never_moves_is_told_and_left() {
        let fitted = fit(&[[0.01; ANGLES]; 5]);
        assert!(fitted.keys.is_empty());
        assert_eq!(fitted.remarks.len(), 19);
    }
}
