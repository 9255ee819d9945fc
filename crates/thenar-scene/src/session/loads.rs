//! What presses on a hand.

use crate::build::BuiltHand;
use crate::grip::digit_touched;
use thenar_core::Vec3;
use thenar_core::model::Digit;
use thenar_core::world::ContactPoint;

/// What presses on one part of a hand, or the most that did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HandLoad {
    /// Sum of normal forces \[N\].
    pub normal: f64,
    /// Size of the summed tangential force \[N\].
    pub shear: f64,
    /// Area in contact \[m²\].
    pub area: f64,
    /// Mean pressure \[Pa\]: normal force on skin, without that on bones, over area; zero where no skin
    /// touches. Of the most that did, that at the largest normal force.
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
pub const PARTS: [Digit; 6] =
    [Digit::Palm, Digit::Thumb, Digit::Index, Digit::Middle, Digit::Ring, Digit::Little];

/// What presses on each part (see [`PARTS`]) of a hand: on its skin, and on bones where flesh is crushed.
pub fn hand_loads(contacts: &[ContactPoint], hand: &BuiltHand) -> [HandLoad; 6] {
    let mut sums = [(HandLoad::default(), Vec3::zeros(), 0.0); 6];
    for contact in contacts {
        for side in 0..2 {
            let digit = digit_touched(contact, side, hand);
            let part = PARTS.iter().position(|part| Some(*part) == digit);
            let Some(part) = part else { continue };
            let normal = contact.force_W.dot(&contact.normal_W);
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let (load, shear_W, on_skin) = &mut sums[part];
            load.normal += normal;
            load.area += contact.area;
            *shear_W += (contact.force_W - contact.normal_W * normal) * sign;
            *on_skin += if contact.touches_skin() { normal } else { 0.0 };
        }
    }
    sums.map(|(load, shear_W, on_skin)| {
        let pressure = if load.area > 0.0 { on_skin / load.area } else { 0.0 };
        HandLoad { shear: shear_W.norm(), pressure, ..load }
    })
}
