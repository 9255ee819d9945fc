//! Polygons cut into triangles.

use super::TRIANGLES_MAX;
use crate::RigError;

/// Errs for a polygon of more corners than a mesh may have triangles, before they are read.
pub(super) fn check_corners(count: usize) -> Result<(), RigError> {
    if count > TRIANGLES_MAX {
        return Err(RigError::invalid(format!(
            "a face has {count} corners or more; a mesh of at most {TRIANGLES_MAX} triangles can be used: simplify it"
        )));
    }
    Ok(())
}

/// Polygons of more corners are halved: a fan of slivers would be slow to search.
const FAN_CORNERS_MAX: usize = 8;

/// Cuts a polygon into a fan, one of many corners by chords; false if it has fewer than three.
pub(super) fn cut(corners: &[u32], triangles: &mut Vec<[u32; 3]>) -> bool {
    match corners {
        [] | [_] | [_, _] => return false,
        [first, rest @ ..] if rest.len() < FAN_CORNERS_MAX => {
            triangles.extend(rest.windows(2).map(|side| [*first, side[0], side[1]]));
        }
        _ => halved(corners, triangles),
    }
    true
}

/// Cuts a polygon into triangles by chords that halve what is left.
fn halved(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    if corners.len() > 2 {
        let (middle, last) = (corners.len() / 2, corners.len() - 1);
        triangles.push([corners[0], corners[middle], corners[last]]);
        halved(&corners[..=middle], triangles);
        halved(&corners[middle..], triangles);
    }
}
