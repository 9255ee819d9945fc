//! Limits of a body's size, and of its distance from the origin of its file.

use crate::RigError;
use thenar_core::Vec3;

/// Smallest and largest admissible longest side of a body \[m\].
pub(crate) const SIZE_RANGE: [f64; 2] = [1e-4, 1e3];
/// Farthest admissible coordinate, in longest sides: double precision then still places a vertex to
/// 1e-9 of the size (1e7 rounding errors of 1.1e-16).
pub(crate) const REACH_MAX: f64 = 1e7;

/// Longest side of what lies within these bounds, if a body may be that long and that far away.
///
/// # Errors
/// Names the length or the distance, and the range.
pub(crate) fn sensible_size([min, max]: [Vec3; 2]) -> Result<f64, RigError> {
    let size = (max - min).max();
    let [low, high] = SIZE_RANGE;
    // A length that is not a number is in no range.
    if !(low..=high).contains(&size) {
        return Err(RigError::invalid(format!(
            "the body is {size:e} m long, outside {low:e} to {high:e} m (is the scale right?)"
        )));
    }
    let far = min.amax().max(max.amax());
    if far > REACH_MAX * size {
        return Err(RigError::invalid(format!(
            "the body of {size:e} m lies {far:e} m from the origin of its file, more than {REACH_MAX:e} \
             times its size: move it there"
        )));
    }
    Ok(size)
}

/// The bounds of points; of none, an empty box.
pub(crate) fn bounds<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> [Vec3; 2] {
    let none = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    points.into_iter().fold(none, |[min, max], p| [min.inf(p), max.sup(p)])
}

/// A place \[m\] in words.
pub(crate) fn place_in_words(p: &Vec3) -> String {
    format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z)
}
