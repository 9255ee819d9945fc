//! Two poses fit a LucidGlove: the open hand and the fist.

use super::profile::{Digit, Profile};
use super::{LucidGlovesDriver, SHIPPED};
use crate::calibration::{Calibrate, Fitted, Prompt};
use crate::profile::{Address, load};
use crate::{Driver, LinkError, Opened};
use thenar_track::ANGLES;
use toml::Value;

/// A sensor must change by so much between the two.
const CHANGE_MIN: f64 = 0.1;

impl Calibrate for LucidGlovesDriver {
    fn prompts(&self) -> Vec<Prompt> {
        vec![
            Prompt { name: "open", text: "open your hand flat, fingers and thumb straight" },
            Prompt { name: "fist", text: "make a fist, the thumb over the fingers" },
        ]
    }

    fn open_raw(&self, address: &str) -> Result<Opened, LinkError> {
        let parsed = Address::parse(self.name(), address)?;
        let mut profile: Profile = load(self.name(), SHIPPED, &parsed)?;
        // One radian of base flexion per full sensor range.
        let closed = [1.0_f64.to_degrees(), 0.0, 0.0, 0.0];
        let raw = Digit { raw: [0.0, 1.0], open: [0.0; 4], closed, splay: 0.0 };
        let digits = [
            &mut profile.thumb,
            &mut profile.index,
            &mut profile.middle,
            &mut profile.ring,
            &mut profile.little,
        ];
        digits.into_iter().for_each(|digit| *digit = raw.clone());
        super::open_with(&parsed, profile)
    }

    fn fit(&self, means: &[[f64; ANGLES]]) -> Fitted {
        let mut fitted = Fitted::default();
        let [open, fist] = means else { return fitted };
        for (d, name) in ["thumb", "index", "middle", "ring", "little"].into_iter().enumerate() {
            let range = [open[4 * d], fist[4 * d]];
            if (range[1] - range[0]).abs() < CHANGE_MIN {
                fitted
                    .remarks
                    .push(format!("the {name}'s sensor hardly moved: it stays unchanged"));
                continue;
            }
            let raw = range.map(|x| Value::Float((x.clamp(0.0, 1.0) * 1e4).round() / 1e4));
            let table = [("raw".to_string(), Value::Array(raw.into()))].into_iter().collect();
            fitted.keys.insert(name.into(), Value::Table(table));
        }
        fitted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_come_from_the_two_poses() {
        let mut means = [[0.0; ANGLES]; 2];
        (means[0][0], means[1][0]) = (0.25, 0.9);
        (means[0][4], means[1][4]) = (0.8, 0.1);
        let fitted = LucidGlovesDriver.fit(&means);
        assert_eq!(fitted.keys["thumb"]["raw"], Value::Array(vec![0.25.into(), 0.9.into()]));
        assert_eq!(fitted.keys["index"]["raw"], Value::Array(vec![0.8.into(), 0.1.into()]));
        assert_eq!(fitted.remarks.len(), 3, "middle, ring and little finger never moved");
    }
}
