//! The surface of flesh laid around the solids of bones.
//!
//! Flesh of thickness t is where the distance to the nearest solid is less than t. Distances of two
//! solids blend where they differ by less than t/2, by the quadratic smooth minimum (Quilez,
//! *Smooth minimum*, 2013), so that limbs join roundly.

use super::plan::PlanSolid;
use super::solid;
use crate::mesh::level::Field;
use crate::work::Stage;
use crate::{RigError, TriMesh};
use thenar_core::Vec3;

/// Spacing of the grid over the thickness: four points across flesh and back.
const SPACING: f64 = 0.5;
/// Part of the thickness over which distances blend.
const BLEND: f64 = 0.5;
/// Most grid points that memory should be spent on.
const POINTS_MAX: f64 = 3e7;

/// Distances on a grid.
struct Grid {
    /// Blended distances.
    blended: Field,
    /// Distances to the nearest solid.
    nearest: Vec<f64>,
}

/// The surface at distance `thickness` \[m\] around the solids, blended.
///
/// # Errors
/// When the thickness is not positive, or so small beside the figure that the grid would be too
/// large.
pub fn around(solids: &[PlanSolid], thickness: f64) -> Result<TriMesh, RigError> {
    crate::error::positive("thickness of flesh", thickness)?;
    let boxes = solids.iter().map(|s| Ok(solid::mesh(&s.shape)?.transformed(&s.pose_MS).bounds()));
    let boxes = boxes.collect::<Result<Vec<[Vec3; 2]>, RigError>>()?;
    let mut grid = Grid::new(&boxes, thickness)?;
    let stage = Stage::new(
        "laying flesh around bones",
        solids.len(),
        grid.blended.values.len() as f64,
        "ask for thicker flesh",
    )?;
    for (i, (solid, bounds)) in solids.iter().zip(&boxes).enumerate() {
        stage.at(i)?;
        grid.add(solid, bounds, thickness);
    }
    Ok(grid.blended.surface(thickness))
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
        Ok(Self { blended: Field { origin: low, spacing, dims, values }, nearest })
    }

    /// Adds a solid; its box is that of its surface in M.
    fn add(&mut self, solid: &PlanSolid, [low, high]: &[Vec3; 2], thickness: f64) {
        let reach = Vec3::repeat(2.0 * thickness);
        let field = &mut self.blended;
        let from = ((low - reach - field.origin) / field.spacing).map(|x| x.floor().max(0.0));
        let to = ((high + reach - field.origin) / field.spacing).map(|x| x.ceil().max(0.0));
        let range = |k: usize| from[k] as usize..=(to[k] as usize).min(field.dims[k] - 1);
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let p_S = solid.pose_MS.inverse_point(&field.point([i, j, k]));
                    let distance = solid.shape.distance(&p_S).value;
                    let (n, width) = (field.index([i, j, k]), BLEND * thickness);
                    let nearest = self.nearest[n].min(distance);
                    // Many solids in one place blend no further than two.
                    let blended = smooth_minimum(field.values[n], distance, width);
                    field.values[n] = blended.max(nearest - 0.25 * width);
                    self.nearest[n] = nearest;
                }
            }
        }
    }
}

/// The lesser of two, rounded where they differ by less than `width`: never more, and less by a
/// quarter of it at most.
fn smooth_minimum(a: f64, b: f64, width: f64) -> f64 {
    let near = (1.0 - (a - b).abs() / width).max(0.0);
    a.min(b) - 0.25 * width * near * near
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::embed::check_closed;
    use crate::mesh::level::INSET;
    use thenar_core::Pose;
    use thenar_core::shape::Shape;

    fn ball(radius: f64, x: f64) -> PlanSolid {
        let pose_MS = Pose::translation(x, 0.0, 0.0);
        PlanSolid { shape: Shape::Sphere { radius }, pose_MS }
    }

    /// Flesh around one ball is a ball: its volume from an inscribed surface, its points within a
    /// few parts of the spacing.
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

    /// However solids lie to one another, the surface is closed and oriented; apart they stay
    /// apart.
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

    /// A solid that is there many times has no more flesh than one that is there twice, an eighth
    /// more than asked at most.
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
