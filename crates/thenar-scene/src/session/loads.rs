//! Loads on a hand.

use crate::build::BuiltHand;
use thenar_core::World;
use thenar_core::model::Digit;
use thenar_core::readout::{PatchSum, sum_parts};

/// Load on one part of a hand, or the largest that there was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HandLoad {
    /// Sum of normal forces \[N\].
    pub normal: f64,
    /// Size of the summed tangential force \[N\].
    pub shear: f64,
    /// Area in contact \[m²\].
    pub area: f64,
    /// Mean pressure \[Pa\]: normal force on skin, without that on bones, over area; zero where no
    /// skin touches. Of the most that did, that at the largest normal force.
    pub pressure: f64,
}

impl HandLoad {
    /// Names and units of [`HandLoad::figures`].
    pub const FIGURES: [(&'static str, &'static str); 4] =
        [("normal", "N"), ("shear", "N"), ("area", "m²"), ("pressure", "Pa")];

    /// All numbers, in the order of [`HandLoad::FIGURES`].
    pub fn figures(&self) -> [f64; 4] {
        [self.normal, self.shear, self.area, self.pressure]
    }

    /// Becomes the larger in each number; the pressure stays with its force.
    pub fn grow(&mut self, other: &Self) {
        if other.normal > self.normal {
            self.pressure = other.pressure;
        }
        self.normal = self.normal.max(other.normal);
        self.shear = self.shear.max(other.shear);
        self.area = self.area.max(other.area);
    }
}

/// Palm, thumb, index, middle, ring, little.
pub const PARTS: [Digit; 6] = Digit::PARTS;

/// Loads on each part (see [`PARTS`]) of a hand: on its skin, and on bones where flesh is crushed.
pub fn hand_loads(world: &World, hand: &BuiltHand) -> [HandLoad; 6] {
    let mut sums = [PatchSum::default(); 6];
    // A skeleton touches nothing.
    if let Some(soft) = hand.flesh() {
        sum_parts(world, soft, &mut sums);
    }
    sums.map(|sum| {
        let patch = sum.finish(0.0);
        HandLoad {
            normal: patch.normal,
            shear: patch.shear_W.norm(),
            area: patch.area,
            pressure: patch.pressure_mean(),
        }
    })
}
