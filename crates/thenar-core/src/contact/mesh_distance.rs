//! The signed distance to a mesh, asked of its pieces one by one.

use crate::contact::triangle::{Closest, ROUNDED_UP, closest_on_triangle};
use crate::contact::{Distance, MeshShape};
use crate::math::Vec3;
use std::cell::Cell;

/// From a mesh without triangles.
const FARTHEST: Distance = Distance { value: f64::MAX, gradient: Vec3::new(0.0, 1.0, 0.0) };
/// Nearer than this part of the size, a point counts as on the surface.
const ON_SURFACE: f64 = 1e-10;

impl MeshShape {
    /// Signed distance from `p` (frame of the mesh).
    pub(crate) fn distance(&self, p: &Vec3) -> Distance {
        self.search(p, f64::INFINITY, f64::INFINITY).map_or(FARTHEST, |(distance, _)| distance)
    }

    /// Signed distance from `p` (frame of the mesh) within `reach` of the surface \[m\], or inside
    /// it, otherwise `None`.
    pub(crate) fn distance_within(&self, p: &Vec3, reach: f64) -> Option<Distance> {
        let (found, _) = self.search(p, reach, f64::INFINITY)?;
        Some(found).filter(|d| d.value < reach)
    }

    /// Signed distance like [`MeshShape::distance_within`], soonest found if near item `guess`,
    /// which becomes the item that it is found by.
    pub(crate) fn distance_within_near(
        &self,
        p: &Vec3,
        reach: f64,
        guess: &Cell<u32>,
    ) -> Option<Distance> {
        let known = self.distance_to(p, guess);
        let nearer = known + self.index.rounding;
        let (found, item) = match nearer < reach {
            true => self.search(p, nearer, known).or_else(|| self.search(p, reach, f64::INFINITY)),
            false => self.search(p, reach, f64::INFINITY),
        }?;
        guess.set(item);
        Some(found).filter(|d| d.value < reach)
    }

    /// No less than the distance to the item of a guess; infinite where that is none.
    fn distance_to(&self, p: &Vec3, guess: &Cell<u32>) -> f64 {
        let guessed = self.index.corners.get(guess.get() as usize);
        let distance = |x| closest_on_triangle(p, x).distance_squared.sqrt() * ROUNDED_UP;
        guessed.map_or(f64::INFINITY, distance)
    }

    /// The distance, given that it is no more than `known` on either side. Soonest found if near
    /// item `guess`, which becomes the one that it is found by.
    pub(crate) fn distance_near(&self, p: &Vec3, known: f64, guess: &Cell<u32>) -> Distance {
        let known = known.min(self.distance_to(p, guess));
        let reach = known + self.index.rounding;
        let found =
            self.search(p, reach, known).or_else(|| self.search(p, f64::INFINITY, f64::INFINITY));
        guess.set(found.map_or(u32::MAX, |(_, item)| item));
        found.map_or(FARTHEST, |(distance, _)| distance)
    }

    /// The distance if it is below `reach`, and the item it is found by, if it is no more than
    /// `known` on either side.
    fn search(&self, p: &Vec3, reach: f64, known: f64) -> Option<(Distance, u32)> {
        let index = &self.index;
        let mut best: Option<(Distance, u32)> = None;
        let mut bound = None;
        for &(group, around, node) in &index.pieces {
            // Outside the box around a piece only a nearer surface matters; inside it a farther
            // one can mean that the point is deep.
            let limit = best.map_or(reach, |(b, _)| b.value.min(reach));
            let to_box = around.distance_squared(p);
            let within = if to_box > 0.0 {
                let limit = limit + index.rounding;
                if limit <= 0.0 || to_box >= limit * limit {
                    continue;
                }
                limit * limit
            } else {
                // What is known nearly is no better known by the grid.
                let of_grid = || if known > self.grid.cell { self.grid.bound(p) } else { None };
                let bound = *bound.get_or_insert_with(|| of_grid().map_or(known, |d| d.min(known)));
                (bound + 2.0 * index.rounding).powi(2)
            };
            let find = |reach| index.closest_below(node, p, reach);
            let found = find(within).or_else(|| (to_box == 0.0).then(|| find(f64::INFINITY))?);
            let Some((item, near)) = found else { continue };
            let d = self.signed(p, index.items[item as usize], &near, group);
            if best.is_none_or(|(b, _)| d.value < b.value) {
                best = Some((d, item));
            }
        }
        best
    }

    /// Distance by the nearest point `near` of triangle `t` of a piece.
    fn signed(&self, p: &Vec3, t: u32, near: &Closest, group: u32) -> Distance {
        let index = &self.index;
        let away = p - near.point;
        let length = near.distance_squared.sqrt();
        let normal = index.normal(&self.triangles, t, near.feature);
        let mut outside = away.dot(&normal) >= 0.0;
        if index.rounding > 0.0 {
            outside = true;
        } else if !index.closed[group as usize] && length > self.grid.cell {
            outside = !self.grid.is_inside(p);
        }
        let side = if outside { 1.0 } else { -1.0 };
        let gradient = if length > ON_SURFACE * index.size {
            away * (side / length)
        } else {
            let of_face = index.face_normals[t as usize];
            normal.try_normalize(1e-12).unwrap_or(of_face)
        };
        Distance { value: side * length - index.rounding, gradient }
    }
}
