//! Layers of flesh by depth under the skin.

use super::options::HandOptions;
use super::sides::Sides;
use crate::RigError;
use crate::lattice::Lattice;
use crate::mesh::Bvh;
use crate::work::Stage;
use thenar_core::model::{HandRegion, Law, Material};

/// Flesh between two depths under the skin.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Where; everywhere if `None`.
    pub region: Option<HandRegion>,
    /// From and to \[m\]; 0 is the skin, infinite as deep as the hand is.
    pub depth: [f64; 2],
    /// Young's modulus \[Pa\]; else that of the hand's material.
    pub young: Option<f64>,
    /// Poisson's ratio; else that of the hand's material.
    pub poisson: Option<f64>,
    /// Law; else that of the hand's material.
    pub law: Option<Law>,
}

impl Layer {
    /// True if some place may lie in both.
    fn meets(&self, other: &Self) -> bool {
        let [a, b] = [self.depth, other.depth];
        let apart = self.region.zip(other.region).is_some_and(|(a, b)| a != b);
        !apart && a[0] < b[1] && b[0] < a[1]
    }

    /// True if a place of this region and depth \[m\] lies in it.
    pub(super) fn holds(&self, region: HandRegion, depth: f64) -> bool {
        self.region.is_none_or(|own| own == region)
            && self.depth[0] <= depth
            && depth < self.depth[1]
    }

    /// The material of the layer, on that of the hand.
    pub(super) fn material(&self, base: &Material) -> Material {
        Material {
            law: self.law.unwrap_or(base.law),
            young: self.young.unwrap_or(base.young),
            poisson: self.poisson.unwrap_or(base.poisson),
            density: base.density,
        }
    }

    fn place(&self) -> &'static str {
        self.region.map_or("hand", HandRegion::name)
    }
}

/// Errs on the first layer that makes no sense, by its number from 1.
pub(super) fn check(options: &HandOptions) -> Result<(), RigError> {
    for (k, layer) in options.layers.iter().enumerate() {
        let fault = |what: String| Err(RigError::Layer { layer: k + 1, what });
        let [from, to] = layer.depth;
        if !(from >= 0.0 && to > from) {
            return fault(format!(
                "its depth [{from}, {to}] m must rise from 0 or more: it would have no thickness"
            ));
        }
        let Material { law, young, poisson, .. } = layer.material(&options.material);
        if !(young > 0.0 && young < 1e13) {
            return fault(format!("its Young's modulus must be positive, not {young} Pa"));
        }
        let least = if matches!(law, Law::Ogden { .. }) { 0.0 } else { -1.0 };
        if !(poisson > -1.0 && poisson >= least && poisson < 0.5) {
            let range = if least == 0.0 { "from 0 (with Ogden's law)" } else { "above -1" };
            return fault(format!(
                "its Poisson's ratio must be {range} and below 0.5, not {poisson}"
            ));
        }
        if let Some(other) = options.layers[..k].iter().position(|other| other.meets(layer)) {
            return fault(format!("it overlaps layer {}; a place can lie in one only", other + 1));
        }
    }
    Ok(())
}

/// The layer of each inside point, if any, counted from 0.
///
/// # Errors
/// When a layer ends deeper than its part of the body reaches.
pub(super) fn of_samples(
    layers: &[Layer],
    lattice: &Lattice,
    sides: &Sides,
    surface: &Bvh,
) -> Result<Vec<Option<u32>>, RigError> {
    let count = lattice.sample_count();
    if layers.is_empty() {
        return Ok(vec![None; count]);
    }
    // Deeper than all layers, the depth need not be known. Points lie up to half their distance off
    // the deepest place.
    let bounds = layers.iter().flat_map(|layer| layer.depth);
    let deepest = bounds.filter(|depth| depth.is_finite()).fold(0.0, f64::max);
    let reach = deepest + lattice.sample_spacing();
    let stage = Stage::new("measuring depths under the skin", 16, 60.0 * count as f64, "")?;
    let mut thickest = [0.0_f64; HandRegion::ALL.len()];
    let mut of_samples = Vec::with_capacity(count);
    for i in 0..count {
        if i % count.div_ceil(16) == 0 {
            stage.at(16 * i / count)?;
        }
        let p = lattice.sample_position(i);
        let region = sides.of(&p).0;
        let depth = surface.closest_within(&p, reach).map_or(reach, |closest| closest.distance);
        thickest[region as usize] = thickest[region as usize].max(depth);
        let layer = layers.iter().position(|layer| layer.holds(region, depth));
        of_samples.push(layer.map(|layer| layer as u32));
    }
    for (k, layer) in layers.iter().enumerate() {
        let of = |&region: &HandRegion| layer.region.is_none_or(|own| own == region);
        let there = HandRegion::ALL.iter().filter(|region| of(region));
        let thick = there.map(|&region| thickest[region as usize]).fold(0.0, f64::max);
        let end = layer.depth[if layer.depth[1].is_finite() { 1 } else { 0 }];
        if end > thick + lattice.sample_spacing() {
            return Err(RigError::Layer {
                layer: k + 1,
                what: format!(
                    "it reaches {:.1} mm under the skin, but the {} is thinner: its deepest place lies {:.1} mm \
                     under the skin",
                    end * 1e3,
                    layer.place(),
                    thick * 1e3
                ),
            });
        }
    }
    Ok(of_samples)
}

#[cfg(test)]
mod tests;
