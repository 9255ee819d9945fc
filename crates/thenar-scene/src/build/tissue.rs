//! Composition of tissue: named materials, layers, skin and nails.

use super::soft::law;
use crate::format::{
    Hand, HandLayer, HandMaterial, HandRegionWord, HandTissueWord, LawWord, NailTable, SkinTable,
    TissueWord,
};
use crate::text::{Fault, Located};
use thenar_core::model::{
    EmbeddedSurface, Flesh, HandModel, HandRegion, Law, Material, Sheet, Skin, facets,
};
use thenar_rig::hand::{HandOptions, Layer};

/// Law, Young's modulus \[Pa\] and Poisson's ratio of a tissue.
pub fn named(tissue: TissueWord) -> (Law, f64, f64) {
    match tissue {
        TissueWord::Epidermis => (Law::Corotational, 136e3, 0.48),
        TissueWord::Dermis => (Law::Corotational, 80e3, 0.48),
        TissueWord::Subcutis => (Law::Corotational, 34e3, 0.48),
        TissueWord::Pulp => (Law::Corotational, 50e3, 0.4),
        // Given by its modulus in shear.
        TissueWord::Tendon => (Law::Ogden { alpha: 8.5 }, 2.0 * 1.48 * 35.3e3, 0.48),
    }
}

/// A material with what keys say in the place of what it has: a named tissue first, then its parts.
pub fn changed(
    base: Material,
    tissue: Option<&Located<TissueWord>>,
    word: Option<&Located<LawWord>>,
    alpha: Option<&Located<f64>>,
    young: Option<f64>,
    poisson: Option<f64>,
) -> Result<Material, Fault> {
    let mut m = base;
    if let Some(tissue) = tissue {
        (m.law, m.young, m.poisson) = named(tissue.value);
    }
    m.law = law(word, alpha, m.law)?;
    m.young = young.unwrap_or(m.young);
    m.poisson = poisson.unwrap_or(m.poisson);
    Ok(m)
}

/// The material of a hand that is built here, with what its table says.
pub fn of_hand(base: Material, table: Option<&HandMaterial>) -> Result<Material, Fault> {
    let Some(t) = table else { return Ok(base) };
    changed(base, t.tissue.as_ref(), t.law.as_ref(), t.alpha.as_ref(), t.young, t.poisson)
}

/// True if a hand has layers, by its keys or by its tissue.
pub fn is_layered(hand: &Hand) -> bool {
    !hand.layer.is_empty() || has_usual(hand)
}

fn has_usual(hand: &Hand) -> bool {
    hand.tissue.as_ref().is_some_and(|tissue| tissue.value == HandTissueWord::Layered)
}

/// Options with the layers of a hand, and with its material, on which they lie.
pub fn layered(hand: &Hand, options: HandOptions) -> Result<HandOptions, Fault> {
    if !is_layered(hand) {
        return Ok(options);
    }
    let material = of_hand(options.material, hand.material.as_ref())?;
    let layers = match hand.layer.is_empty() {
        true => usual_layers(),
        false => hand
            .layer
            .iter()
            .map(|layer| asked(&layer.value, &material))
            .collect::<Result<_, _>>()?,
    };
    Ok(HandOptions { material, layers, ..options })
}

fn asked(table: &HandLayer, base: &Material) -> Result<Layer, Fault> {
    let t = table;
    let own =
        changed(*base, t.tissue.as_ref(), t.law.as_ref(), t.alpha.as_ref(), t.young, t.poisson)?;
    Ok(Layer {
        region: match t.region {
            HandRegionWord::Pad => Some(HandRegion::Pad),
            HandRegionWord::Nail => Some(HandRegion::Nail),
            HandRegionWord::Palm => Some(HandRegion::Palm),
            HandRegionWord::Back => Some(HandRegion::Back),
            HandRegionWord::All => None,
        },
        depth: t.depth,
        young: Some(own.young),
        poisson: Some(own.poisson),
        law: Some(own.law),
    })
}

/// Subcutis under the skin of pads and palm, as deep as they are.
fn usual_layers() -> Vec<Layer> {
    let (law, young, poisson) = named(TissueWord::Subcutis);
    let layer = |region| Layer {
        region: Some(region),
        depth: [0.0, f64::INFINITY],
        young: Some(young),
        poisson: Some(poisson),
        law: Some(law),
    };
    [HandRegion::Pad, HandRegion::Palm].map(layer).to_vec()
}

/// Skin of the layered hand: half a millimetre of epidermis on one of dermis, 148 N/m.
const USUAL_SKIN: Sheet = Sheet {
    thickness: 1.5e-3,
    young: (0.5 * 136e3 + 80e3) / 1.5,
    poisson: 0.48,
    pretension: 0.0,
    wrinkling: Sheet::WRINKLING,
};

fn skin_sheet(t: &SkinTable) -> Sheet {
    Sheet {
        thickness: t.thickness,
        young: t.young,
        poisson: t.poisson,
        pretension: t.pretension,
        wrinkling: t.wrinkling,
    }
}

/// A plate as a sheet: bound to the bone under it, it does not buckle.
fn nail_sheet(thickness: f64, young: f64, poisson: f64) -> Sheet {
    Sheet { thickness, young, poisson, pretension: 0.0, wrinkling: 1.0 }
}

/// True if a hand's nails are grown to its bones.
pub fn has_nails(hand: &Hand) -> bool {
    hand.nail.is_some() || has_usual(hand)
}

/// The skin and the nails of a hand whose flesh is deformable body `soft`.
pub fn skin_of_hand(hand: &Hand, model: &HandModel, soft: u32) -> Result<Option<Skin>, Fault> {
    let usual = has_usual(hand);
    let skin = hand.skin.as_ref().map(|skin| skin_sheet(&skin.value));
    let skin = skin.or_else(|| usual.then_some(USUAL_SKIN));
    let nail = hand.nail.as_ref().map(|nail| {
        let NailTable { thickness, young, poisson } = nail.value;
        nail_sheet(thickness, young, poisson)
    });
    let nail = nail.or_else(|| usual.then(|| nail_sheet(5e-4, 2e6, 0.3)));
    if skin.is_none() && nail.is_none() {
        return Ok(None);
    }
    let fault = |problem: String| match (&hand.skin, &hand.nail, &hand.tissue) {
        (Some(skin), ..) => skin.fault(problem),
        (_, Some(nail), _) => nail.fault(problem),
        (.., Some(tissue)) => tissue.fault(problem),
        _ => hand.name.fault(problem),
    };
    if nail.is_some() && model.regions.is_empty() {
        let problem = "the model does not know where its nails are: it was built by an earlier version; build it again";
        return Err(hand
            .nail
            .as_ref()
            .map_or_else(|| fault(problem.into()), |nail| nail.fault(problem)));
    }
    let sheets: Vec<Sheet> = skin.into_iter().chain(nail).collect();
    let of_triangle = |k: usize| {
        let is_nail = nail.is_some() && model.regions[k] == HandRegion::Nail;
        if is_nail { Some(u32::from(skin.is_some())) } else { skin.map(|_| 0) }
    };
    let volume = model.node_volumes.iter().sum();
    laid(&model.flesh, &model.flesh.collision, sheets, of_triangle, volume, soft)
        .map(Some)
        .map_err(fault)
}

/// The skin of a soft body, on the surface that touches when it touches anything.
pub fn skin_of_soft(
    table: &Located<SkinTable>,
    flesh: &Flesh,
    surface: &EmbeddedSurface,
    soft: u32,
) -> Result<Skin, Fault> {
    if surface.triangles.is_empty() {
        return Err(table.fault("the body has no surface on which skin could lie"));
    }
    let volume = |tet: &[u32; 4]| {
        let [a, b, c, d] = tet.map(|n| flesh.nodes[n as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
    };
    let volume = flesh.tets.iter().map(volume).sum();
    let sheets = vec![skin_sheet(&table.value)];
    laid(flesh, surface, sheets, |_| Some(0), volume, soft).map_err(|problem| table.fault(problem))
}

/// Lays sheets on a surface; refuses those that have more volume than the body \[m³\].
fn laid(
    flesh: &Flesh,
    surface: &EmbeddedSurface,
    sheets: Vec<Sheet>,
    of_triangle: impl Fn(usize) -> Option<u32>,
    volume: f64,
    soft: u32,
) -> Result<Skin, String> {
    let facets = facets(&flesh.nodes, &flesh.tets, surface, of_triangle);
    let thickness = |sheet: u32| sheets[sheet as usize].thickness;
    let taken: f64 = facets.iter().map(|facet| facet.area * thickness(facet.sheet)).sum();
    if taken > volume {
        let area: f64 = facets.iter().map(|facet| facet.area).sum();
        return Err(format!(
            "skin of {:.3} mm is thicker than the body, which has {:.3} mm of flesh under each place of its surface",
            taken / area * 1e3,
            volume / area * 1e3
        ));
    }
    Ok(Skin { soft, sheets, facets })
}

/// Returns a fault at the key that a layer comes from: its own, `tissue`, or the hand's name.
pub fn layer_fault(hand: &Hand, layer: usize, what: &str) -> Fault {
    match (hand.layer.get(layer.wrapping_sub(1)), &hand.tissue) {
        (Some(layer), _) => layer.fault(what),
        (None, Some(tissue)) => tissue.fault(what),
        (None, None) => hand.name.fault(what),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 (1 + ν) times the modulus in shear.
    #[test]
    fn a_tendon_has_its_published_modulus_in_shear() {
        let (law, young, poisson) = named(TissueWord::Tendon);
        assert_eq!(law, Law::Ogden { alpha: 8.5 });
        assert!((young / (2.0 * (1.0 + poisson)) - 35.3e3).abs() < 1e-9);
    }

    /// 0.5 mm of 136 kPa and 1 mm of 80 kPa bear side by side.
    #[test]
    fn skin_of_two_layers_has_the_sum_of_their_stiffness() {
        let sum = 0.5e-3 * 136e3 + 1e-3 * 80e3;
        assert!((USUAL_SKIN.thickness * USUAL_SKIN.young - sum).abs() < 1e-9 * sum);
    }
}
