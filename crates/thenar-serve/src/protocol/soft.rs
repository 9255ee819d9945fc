//! Deformable bodies in a model message.

use super::arrays::{Array, Arrays};
use serde::Serialize;
use thenar_core::World;
use thenar_core::model::{EmbeddedSurface, Flesh};
use thenar_rig::object::crust;
use thenar_scene::build::SoftBuild;
use thenar_scene::format::SoftShape;
use thenar_scene::session::Session;

/// Colour of bread that was given none, sRGB.
const BREAD: [f64; 3] = [0.843, 0.604, 0.306];

/// A deformable body.
#[derive(Debug, Serialize)]
pub struct Soft {
    name: String,
    look: &'static str,
    colour: Option<[f64; 3]>,
    hand: Option<usize>,
    node_start: usize,
    nodes: Array,
    tets: Array,
    render: Surface,
    collision: Surface,
    skin: Option<Skin>,
}

#[derive(Debug, Serialize)]
struct Surface {
    tets: Array,
    weights: Array,
    triangles: Array,
    colours: Option<Array>,
}

#[derive(Debug, Serialize)]
struct Skin {
    bones: Array,
    weights: Array,
    offsets: Array,
}

/// Describes deformable body `index` of the world.
pub fn soft(session: &Session, index: u32, arrays: &mut Arrays) -> Soft {
    let world = session.world();
    let desc = &world.desc().softs[index as usize];
    let hand = session.hands().iter().position(|hand| hand.flesh() == Some(index));
    let other = session.softs().iter().position(|soft| soft.soft == index);
    let (look, colour, render, colours) = match (hand, other) {
        (Some(h), _) => {
            let hand = &session.hands()[h];
            ("skin", hand.colour, &hand.model.render, None)
        }
        (None, Some(s)) => {
            let built = &session.softs()[s];
            let bread = is_bread(session, s);
            let colours = bread.then(|| crust_colours(built, &desc.flesh));
            (if bread { "bread" } else { "rubber" }, built.colour, &built.render, colours)
        }
        (None, None) => ("rubber", None, &desc.flesh.collision, None),
    };
    Soft {
        name: desc.name.clone(),
        look,
        colour,
        hand,
        node_start: world.node_range(index).start,
        nodes: arrays.points(&desc.flesh.nodes),
        tets: arrays.u32(4, desc.flesh.tets.iter().flatten().copied()),
        render: surface(render, colours, arrays),
        collision: surface(&desc.flesh.collision, None, arrays),
        skin: desc.coupling.is_some().then(|| skin(world, index, arrays)),
    }
}

fn is_bread(session: &Session, soft: usize) -> bool {
    let shape = session.scene().soft.get(soft).map(|soft| &soft.shape.value);
    matches!(shape, Some(SoftShape::Bread(_)))
}

fn surface(
    surface: &EmbeddedSurface,
    colours: Option<Vec<[u8; 4]>>,
    arrays: &mut Arrays,
) -> Surface {
    let vertices = &surface.vertices;
    Surface {
        tets: arrays.u32(1, vertices.iter().map(|v| v.tet)),
        weights: arrays.f32(4, vertices.iter().flat_map(|v| v.weights)),
        triangles: arrays.triangles(&surface.triangles),
        colours: colours.map(|colours| arrays.u8(4, colours.into_iter().flatten())),
    }
}

/// Binding of the nodes to bones; nodes bound to none have weights of zero.
fn skin(world: &World, index: u32, arrays: &mut Arrays) -> Skin {
    let range = world.node_range(index);
    let mut bones = vec![[0_u16; 2]; range.len()];
    let mut weights = vec![[0.0; 2]; range.len()];
    let mut offsets = vec![[0.0; 6]; range.len()];
    for bound in &world.model().coupling.bound {
        let Some(n) = (bound.node as usize).checked_sub(range.start).filter(|n| *n < range.len())
        else {
            continue;
        };
        bones[n] = bound.bones.map(|bone| bone as u16);
        weights[n] = bound.weights;
        let [a, b] = bound.offsets;
        offsets[n] = [a.x, a.y, a.z, b.x, b.y, b.z];
    }
    Skin {
        bones: arrays.u16(2, bones.into_iter().flatten()),
        weights: arrays.f32(2, weights.into_iter().flatten()),
        offsets: arrays.f32(6, offsets.into_iter().flatten()),
    }
}

/// Crust over the loaf's own colour, as sRGB bytes.
fn crust_colours(built: &SoftBuild, flesh: &Flesh) -> Vec<[u8; 4]> {
    let base = built.colour.unwrap_or(BREAD).map(linear);
    let shade = |shade: &[f32; 3]| {
        let [r, g, b] = std::array::from_fn(|k| srgb_byte(base[k] * f64::from(shade[k])));
        [r, g, b, 255]
    };
    crust(&built.render, &flesh.tets, &flesh.nodes).iter().map(shade).collect()
}

/// Linear light of an sRGB component (IEC 61966-2-1).
fn linear(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The sRGB byte of linear light.
fn srgb_byte(c: f64) -> u8 {
    let c = c.clamp(0.0, 1.0);
    let encoded = if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_comes_back_from_linear_light() {
        for byte in 0..=255_u8 {
            assert_eq!(srgb_byte(linear(f64::from(byte) / 255.0)), byte);
        }
        // 0.5 is ((0.5 + 0.055) / 1.055)^2.4 = 0.21404114 of linear light.
        assert!((linear(0.5) - 0.214_041_14).abs() < 1e-8);
    }
}
