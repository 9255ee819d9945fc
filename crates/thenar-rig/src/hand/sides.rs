//! Pad, nail, palm and back: which side of which bone a place lies on.

use super::digits::{DigitRig, leave};
use super::regions::{bone_distance, digit_distance, palm_rays, segment_point};
use crate::mesh::Bvh;
use thenar_core::Vec3;
use thenar_core::model::HandRegion;

/// Width of a nail over that of its digit, and of a nail as long as it is wide: those of eleven
/// thumbs 24 mm wide measured 170 mm², 13 mm each way (pilot study, Int. J. Exerc. Sci. Conf. Proc.
/// 8(5), 15; abstract).
const NAIL_WIDTH: f64 = 0.54;

/// The regions of a hand at rest.
pub(super) struct Sides<'a> {
    digits: &'a [DigitRig],
    /// Half the width of the nail of each digit \[m\].
    nails: Vec<f64>,
}

impl<'a> Sides<'a> {
    /// `surface` is the hand's skin.
    pub fn new(digits: &'a [DigitRig], surface: &Bvh) -> Self {
        let half_width = |rig: &DigitRig| {
            let [a, b] = rig.bone(2);
            let (middle, length) = ((a + b) / 2.0, (b - a).norm());
            let sides = [rig.flexion, -rig.flexion];
            let ends = sides.map(|aside| leave(surface, &middle, &aside, length));
            NAIL_WIDTH * (ends[0] - ends[1]).norm() / 2.0
        };
        Self { digits, nails: digits.iter().map(half_width).collect() }
    }

    /// Region of a place in the hand or on its skin, and the digit whose last bone it lies at.
    pub fn of(&self, p: &Vec3) -> (HandRegion, Option<usize>) {
        let to_finger = |k: &usize| digit_distance(p, &self.digits[*k]);
        let nearest = (0..self.digits.len()).min_by(|a, b| to_finger(a).total_cmp(&to_finger(b)));
        // The metacarpals have the axes of the wrist: +y out of the back.
        let to_palm = |ray: &[Vec3; 2]| (p - segment_point(p, ray)).norm();
        let ray = palm_rays(self.digits).min_by(|a, b| to_palm(a).total_cmp(&to_palm(b)));
        let palm = ray.map(|ray| p - segment_point(p, &ray));
        let Some(digit) = nearest.filter(|k| palm.is_none_or(|off| to_finger(k) < off.norm()))
        else {
            let back = palm.is_some_and(|off| off.y > 0.0);
            return (if back { HandRegion::Back } else { HandRegion::Palm }, None);
        };
        let rig = &self.digits[digit];
        let away = |k: &usize| bone_distance(p, rig, *k);
        let bone = (0..3).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(2);
        // A digit that closes moves its tip this way.
        let palmar = rig.flexion.cross(&rig.direction(bone));
        let off = p - segment_point(p, &rig.bone(bone));
        let region = match (bone, off.dot(&palmar) > 0.0) {
            (2, true) => HandRegion::Pad,
            (2, false) if self.is_under_nail(p, &off, digit) => HandRegion::Nail,
            (_, true) => HandRegion::Palm,
            (_, false) => HandRegion::Back,
        };
        (region, (bone == 2).then_some(digit))
    }

    /// True if a place on the back of a last bone, so far off the line between its ends, lies
    /// within the nail's outline, which ends at the digit's tip, where the skin begins to face
    /// forwards.
    fn is_under_nail(&self, p: &Vec3, off: &Vec3, digit: usize) -> bool {
        let (rig, half) = (&self.digits[digit], self.nails[digit]);
        let along = rig.direction(2);
        let from_tip = (rig.tip - p).dot(&along);
        let aside = (p - rig.bone(2)[0]).dot(&rig.flexion).abs();
        let faces_back = off.dot(&along.cross(&rig.flexion)) > 0.5 * off.dot(&along);
        faces_back && from_tip < 2.0 * half && aside < half
    }
}
