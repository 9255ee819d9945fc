//! Test of whether a triangle of skin is farther than [`TOUCHING`] from a mesh, by the planes of
//! the faces near it.
//!
//! Skin lies along what it touches, and a distance that is known in one place tells little of the
//! next. But no face is nearer than its plane, nor than the box around it, and few faces are near a
//! triangle.

use crate::contact::Shape;
use crate::contact::aabb::Aabb;
use crate::contact::area::TOUCHING;
use crate::math::Vec3;
use std::cell::Cell;

/// Most faces that are kept: with more of them, distances decide sooner, as up to 153 places of a
/// triangle ask each face.
const FACES_MAX: usize = 64;
/// Places as far as [`TOUCHING`] but for rounding are not told.
const FARTHER: f64 = TOUCHING * (1.0 + 1e-6);

/// The faces of a closed mesh that come near to a triangle, some of which is outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Faces {
    x: [Vec3; 3],
    faces: [Face; FACES_MAX],
    count: usize,
}

/// Heights of the triangle's corners over the plane of a face \[m\], positive on the side of the
/// place outside, and the box around it.
#[derive(Clone, Copy, Debug)]
struct Face {
    heights: [f64; 3],
    bounds: Aabb,
}

impl Face {
    const NONE: Self = Self { heights: [0.0; 3], bounds: Aabb::EMPTY };
}

impl Faces {
    /// Faces of a shape near triangle `x`, in the frame of the shape; `None` where they tell
    /// nothing. `guess` as in [`Shape::distance_near`].
    pub fn near(shape: &Shape, x: [Vec3; 3], guess: &Cell<u32>) -> Option<Self> {
        let Shape::Mesh(mesh) = shape else { return None };
        let index = &mesh.index;
        if index.rounding > 0.0 || !index.is_solid {
            return None;
        }
        let mut near = Self { x, faces: [Face::NONE; FACES_MAX], count: 0 };
        let mut found = 0;
        let up = (x[1] - x[0]).cross(&(x[2] - x[0])).try_normalize(0.0)?;
        index.tree.overlapping(&Aabb::of_points(&x).inflate(FARTHER), |item| {
            let corners = &index.corners[item as usize];
            let normal = &index.face_normals[index.items[item as usize] as usize];
            let heights = x.map(|p| normal.dot(&(p - corners[0])));
            let of_face = corners.map(|p| up.dot(&(p - x[0])));
            if is_apart(&heights) || is_apart(&of_face) {
                return;
            }
            if found < FACES_MAX {
                near.faces[found] = Face { heights, bounds: Aabb::of_points(corners) };
            }
            found += 1;
        });
        near.count = found;
        let outside = (found <= FACES_MAX).then(|| near.outermost())?;
        if mesh.distance_near(&x[outside], f64::INFINITY, guess).value <= TOUCHING {
            return None;
        }
        for face in &mut near.faces[..found] {
            let side = face.heights[outside].signum();
            face.heights = face.heights.map(|height| side * height);
        }
        Some(near)
    }

    /// The corner that is farthest from the plane it is nearest to.
    fn outermost(&self) -> usize {
        let faces = &self.faces[..self.count];
        let least =
            |k: usize| faces.iter().map(|f| f.heights[k].abs()).fold(f64::INFINITY, f64::min);
        (0..3).max_by(|&i, &j| least(i).total_cmp(&least(j))).unwrap_or(0)
    }

    /// True when the triangle between three places, given by their weights of corners 1 and 2, is
    /// outside, farther than [`TOUCHING`] from all faces: the way there from the place outside,
    /// over the same side of all planes, goes through none.
    pub fn are_beyond(&self, places: [[f64; 2]; 3]) -> bool {
        let [start, one, two] = self.x;
        self.faces[..self.count].iter().all(|Face { heights: [a, b, c], bounds }| {
            let height = |[u, v]: [f64; 2]| a + u * (b - a) + v * (c - a);
            let lowest = places.map(height).into_iter().fold(f64::INFINITY, f64::min);
            lowest > FARTHER
                || lowest > 0.0 && {
                    let at = places.map(|[u, v]| start + u * (one - start) + v * (two - start));
                    !Aabb::of_points(&at).inflate(FARTHER).overlaps(bounds)
                }
        })
    }
}

/// True when three points lie farther than [`TOUCHING`] from a plane, all on one side of it.
fn is_apart(heights: &[f64; 3]) -> bool {
    heights.iter().all(|h| *h > FARTHER) || heights.iter().all(|h| *h < -FARTHER)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::MeshShape;
    use crate::contact::grid::tests::grid_of;
    use crate::contact::tests::{boxed, cube};
    use crate::random::Random;
    use std::sync::Arc;

    /// Triangles about faces, edges and corners of a cube: those found to be beyond are, and most
    /// of those beyond are found.
    #[test]
    fn what_is_beyond_is_outside_and_does_not_touch() {
        let (points, triangles) = cube(0.04, 3);
        let mesh = MeshShape::new(points, triangles, grid_of(&boxed(0.02), 0.03, 13));
        let shape = Shape::Mesh(Arc::new(mesh.clone()));
        let mut random = Random::new(4);
        let (mut told, mut all, mut parts_told, mut parts) = (0, 0, 0, 0);
        for i in 0..2000 {
            // Upon a face, along it or not.
            let flat = if i % 2 == 0 { 0.05 } else { 1.0 };
            let middle = random.vector(0.022);
            let middle = Vec3::new(middle.x, 0.0201, middle.z);
            let x = [0; 3].map(|_| {
                let arm = random.vector(0.004);
                middle + Vec3::new(arm.x, flat * arm.y, arm.z)
            });
            let Some(faces) = Faces::near(&shape, x, &Cell::new(0)) else { continue };
            let at = |u: f64, v: f64| x[0] + u * (x[1] - x[0]) + v * (x[2] - x[0]);
            for (j, k) in (0..=8).flat_map(|j| (0..=8 - j).map(move |k| (j, k))) {
                let (u, v) = (f64::from(j) / 8.0, f64::from(k) / 8.0);
                let p = at(u, v);
                let is_beyond = mesh.distance(&p).value > TOUCHING;
                assert!(is_beyond || !faces.are_beyond([[u, v]; 3]), "{i}: {p}");
                all += u32::from(is_beyond);
                told += u32::from(faces.are_beyond([[u, v]; 3]));
            }
            // Of parts with such corners, places inside.
            for (j, k) in (0..8).flat_map(|j| (0..8 - j).map(move |k| (f64::from(j), f64::from(k))))
            {
                let part = [[j, k], [j + 1.0, k], [j, k + 1.0]].map(|w| w.map(|w| w / 8.0));
                let is_beyond = |w: [f64; 3]| {
                    let [u, v] = [0, 1].map(|i| (0..3).map(|c| w[c] * part[c][i]).sum::<f64>());
                    mesh.distance(&at(u, v)).value > TOUCHING
                };
                let inside = [[0.4, 0.4, 0.2], [0.4, 0.2, 0.4], [0.2, 0.4, 0.4], [0.5, 0.5, 0.0]];
                let are_beyond = inside.into_iter().all(is_beyond);
                assert!(are_beyond || !faces.are_beyond(part), "{i}: {part:?}");
                parts += u32::from(are_beyond);
                parts_told += u32::from(faces.are_beyond(part));
            }
        }
        assert!(all > 20_000 && 10 * told > 9 * all, "{told} of {all}");
        assert!(parts > 20_000 && 10 * parts_told > 8 * parts, "{parts_told} of {parts}");
    }
}
