//! The surface of flesh laid around the solids of bones.
//!
//! Flesh of thickness t is where the distance to the nearest solid is less than t. Distances of two solids blend
//! where they differ by less than t/2, by the quadratic smooth minimum (Quilez, *Smooth minimum*, 2013), so that limbs join
//! roundly. The surface is cut from cubes, each of six tetrahedra about its diagonal: of these, whatever the values at their
//! corners, the pieces of surface fit together into a closed one (Bloomenthal, *Polygonization of implicit
//! surfaces*, 1988).

use super::plan::PlanSolid;
use super::solid;
use crate::work::Stage;
use crate::{RigError, TriMesh};
use std::collections::HashMap;
use thenar_core::Vec3;

/// Spacing of the grid over the thickness: four points across flesh and back.
const SPACING: f64 = 0.5;
/// Part of the thickness over which distances blend.
const BLEND: f64 = 0.5;
/// As many grid points as memory should be spent on.
const POINTS_MAX: f64 = 3e7;
/// Corners of the surface lie at least this part of a grid edge off the ends, so that no triangle is a sliver.
const INSET: f64 = 0.1;

/// Six tetrahedra of a cube around its diagonal from corner 0 to corner 7; bit k of a corner's number is its place
/// along axis k.
const TETS: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// Distances on a grid.
struct Grid {
    origin: Vec3,
    spacing: f64,
    dims: [usize; 3],
    /// Blended distances.
    values: Vec<f64>,
    /// Distances to the nearest solid.
    nearest: Vec<f64>,
}

/// The surface at distance `thickness` \[m\] around the solids, blended.
///
/// # Errors
/// When the thickness is not positive, or so small beside the figure that the grid would be too large.
pub fn around(solids: &[PlanSolid], thickness: f64) -> Result<TriMesh, RigError> {
    crate::error::positive("thickness of flesh", thickness)?;
    let boxes = solids.iter().map(|s| Ok(solid::mesh(&s.shape)?.transformed(&s.pose_MS).bounds()));
    let boxes = boxes.collect::<Result<Vec<[Vec3; 2]>, RigError>>()?;
    let mut grid = Grid::new(&boxes, thickness)?;
    let stage = Stage::new(
        "laying flesh around bones",
        solids.len(),
        grid.values.len() as f64,
        "ask for thicker flesh",
    )?;
    for (i, (solid, bounds)) in solids.iter().zip(&boxes).enumerate() {
        stage.at(i)?;
        grid.add(solid, bounds, thickness);
    }
    Ok(grid.surface(thickness))
}

impl Grid {
    fn new(boxes: &[[Vec3; 2]], thickness: f64) -> Result<Self, RigError> {
        let spacing = SPACING * thickness;
        let reach = Vec3::repeat(2.0 * thickness);
        let low = boxes.iter().map(|b| b[0]).reduce(|a, b| a.inf(&b));
        let high = boxes.iter().map(|b| b[1]).reduce(|a, b| a.sup(&b));
        let (Some(low), Some(high)) = (low, high) else {
            return Err(RigError::invalid("no bone has a solid to lay flesh around"));
        };
        let (low, high) = (low - reach, high + reach);
        let cells = (high - low) / spacing;
        let points: f64 = cells.iter().map(|c| c.ceil() + 1.0).product();
        if points.is_nan() || points > POINTS_MAX {
            return Err(RigError::invalid(format!(
                "flesh of {thickness} m is too thin for a figure of {:.3} m: ask for at least {:.2e} m",
                (high - low).max(),
                thickness * (points / POINTS_MAX).cbrt()
            )));
        }
        let dims = [0, 1, 2].map(|k| cells[k].ceil() as usize + 1);
        let values = vec![2.0 * thickness; dims.iter().product()];
        let nearest = values.clone();
        Ok(Self { origin: low, spacing, dims, values, nearest })
    }

    fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.dims[1] + j) * self.dims[0] + i
    }

    fn point(&self, at: [usize; 3]) -> Vec3 {
        self.origin + Vec3::from(at.map(|i| i as f64)) * self.spacing
    }

    /// Adds a solid; its box is that of its surface in M.
    fn add(&mut self, solid: &PlanSolid, [low, high]: &[Vec3; 2], thickness: f64) {
        let reach = Vec3::repeat(2.0 * thickness);
        let from = ((low - reach - self.origin) / self.spacing).map(|x| x.floor().max(0.0));
        let to = ((high + reach - self.origin) / self.spacing).map(|x| x.ceil().max(0.0));
        let range = |k: usize| from[k] as usize..=(to[k] as usize).min(self.dims[k] - 1);
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let p_S = solid.pose_MS.inverse_point(&self.point([i, j, k]));
                    let distance = solid.shape.distance(&p_S).value;
                    let (n, width) = (self.index([i, j, k]), BLEND * thickness);
                    let nearest = self.nearest[n].min(distance);
                    // Many solids in one place blend no further than two.
                    let blended = smooth_minimum(self.values[n], distance, width);
                    self.values[n] = blended.max(nearest - 0.25 * width);
                    self.nearest[n] = nearest;
                }
            }
        }
    }

    /// The surface where the value is `level`, lower values inside.
    fn surface(&self, level: f64) -> TriMesh {
        let mut cut = Cut { grid: self, level, vertices: HashMap::new(), mesh: TriMesh::default() };
        let [nx, ny, nz] = self.dims.map(|n| n - 1);
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    cut.cube([i, j, k]);
                }
            }
        }
        cut.mesh
    }
}

/// A surface that is being cut from a grid.
struct Cut<'a> {
    grid: &'a Grid,
    level: f64,
    /// Vertex on each grid edge, by the edge's ends in ascending order.
    vertices: HashMap<[usize; 2], u32>,
    mesh: TriMesh,
}

impl Cut<'_> {
    fn cube(&mut self, at: [usize; 3]) {
        let corner = |c: usize| [0, 1, 2].map(|k| at[k] + (c >> k & 1));
        let corners: [[usize; 3]; 8] = std::array::from_fn(corner);
        let inside = corners.map(|c| self.grid.values[self.grid.index(c)] < self.level);
        if inside == [true; 8] || inside == [false; 8] {
            return;
        }
        for tet in TETS {
            let (within, without): (Vec<usize>, Vec<usize>) =
                tet.into_iter().partition(|&c| inside[c]);
            match (&within[..], &without[..]) {
                (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
                    let triangle = [b, c, d].map(|other| self.vertex(corners[a], corners[other]));
                    self.face(triangle, corners[within[0]], corners[without[0]]);
                }
                (&[a, b], &[c, d]) => {
                    let ring = [(a, c), (a, d), (b, d), (b, c)];
                    let [p, q, r, s] = ring.map(|(i, o)| self.vertex(corners[i], corners[o]));
                    self.face([p, q, r], corners[a], corners[c]);
                    self.face([p, r, s], corners[a], corners[c]);
                }
                _ => {}
            }
        }
    }

    /// The vertex on a grid edge that the surface crosses.
    fn vertex(&mut self, a: [usize; 3], b: [usize; 3]) -> u32 {
        let [m, n] = [a, b].map(|c| self.grid.index(c));
        let (a, b, m, n) = if m < n { (a, b, m, n) } else { (b, a, n, m) };
        let next = self.mesh.positions.len() as u32;
        *self.vertices.entry([m, n]).or_insert_with(|| {
            let (from, to) = (self.grid.values[m], self.grid.values[n]);
            let part = ((self.level - from) / (to - from)).clamp(INSET, 1.0 - INSET);
            self.mesh.positions.push(self.grid.point(a).lerp(&self.grid.point(b), part));
            next
        })
    }

    /// Adds a triangle, turned so that it faces from `inside` to `outside`, two corners of its tetrahedron.
    fn face(&mut self, [a, b, c]: [u32; 3], inside: [usize; 3], outside: [usize; 3]) {
        let p = [a, b, c].map(|v| self.mesh.positions[v as usize]);
        let normal = (p[1] - p[0]).cross(&(p[2] - p[0]));
        let within = normal.dot(&(self.grid.point(inside) - p[0]));
        let without = normal.dot(&(self.grid.point(outside) - p[0]));
        let turned = without < within;
        self.mesh.triangles.push(if turned { [a, c, b] } else { [a, b, c] });
    }
}

/// The lesser of two, rounded where they differ by less than `width`: never more, and less by a quarter of it at most.
fn smooth_minimum(a: f64, b: f64, width: f64) -> f64 {
    let near = (1.0 - (a - b).abs() / width).max(0.0);
    a.min(b) - 0.25 * width * near * near
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embed::check_closed;
    use thenar_core::Pose;
    use thenar_core::shape::Shape;

    fn ball(radius: f64, x: f64) -> PlanSolid {
        let pose_MS = Pose::translation(x, 0.0, 0.0);
        PlanSolid { shape: Shape::Sphere { radius }, pose_MS }
    }

    /// Flesh around one ball is a ball: its volume from an inscribed surface, its points within a few parts of
    /// the spacing.
    #[test]
    fn flesh_around_a_ball_is_a_ball() {
        let mesh = around(&[ball(0.02, 0.1)], 0.01).unwrap();
        check_closed("the surface", &mesh).unwrap();
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 0.03_f64.powi(3);
        assert!((mesh.volume() / exact - 1.0).abs() < 0.03, "{} for {exact}", mesh.volume());
        for p in &mesh.positions {
            let off = ((p - Vec3::x() * 0.1).norm() - 0.03).abs();
            assert!(off < INSET * 0.01, "{off}");
        }
    }

    /// However solids lie to one another, the surface is closed and oriented; apart they stay apart.
    #[test]
    fn surfaces_close_at_any_distance() {
        for i in 0..40 {
            let gap = 0.001 * f64::from(i);
            let mesh = around(&[ball(0.02, 0.0), ball(0.02, 0.04 + gap)], 0.01).unwrap();
            let topology = crate::mesh::Topology::of(&mesh);
            assert!(topology.closed() && topology.oriented(), "{gap}: {topology:?}");
            assert!(mesh.volume() > 0.0);
            // Blending reaches a quarter of half the thickness further.
            let parts = if gap > 0.024 {
                2
            } else if gap < 0.02 {
                1
            } else {
                topology.components
            };
            assert_eq!(topology.components, parts, "{gap}");
        }
    }

    /// A solid that is there many times has no more flesh than one that is there twice, an eighth more than asked at most.
    #[test]
    fn many_pieces_in_one_place_are_not_fatter() {
        let pieces: Vec<PlanSolid> = (0..12).map(|_| ball(0.02, 0.0)).collect();
        let mesh = around(&pieces, 0.01).unwrap();
        let most = mesh.positions.iter().map(|p| p.norm()).fold(0.0, f64::max);
        assert!(most < 0.02 + 0.01 * (1.0 + 0.25 * BLEND) + INSET * 0.01, "{most}");
    }

    #[test]
    fn what_cannot_be_laid_is_said() {
        for (thickness, part) in [(0.0, "thickness"), (f64::NAN, "thickness"), (1e-6, "too thin")] {
            let error = around(&[ball(0.02, 0.0)], thickness).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
        assert!(around(&[], 0.01).is_err());
    }
}
