//! Surfaces that follow nodes or bones.

use super::actors::Soft;
use super::colour::{Rgb, hex};
use thenar::model::{EmbeddedSurface, HandModel};
use thenar::{Pose, Vec3};

/// Node positions \[m\].
pub type Nodes = Vec<Vec3>;

/// Vertices of a surface for these nodes.
pub fn embedded(surface: &EmbeddedSurface, tets: &[[u32; 4]], nodes: &[Vec3]) -> Vec<Vec3> {
    let mut positions = vec![Vec3::zeros(); surface.vertices.len()];
    surface.positions(tets, nodes, &mut positions);
    positions
}

/// Node positions of a hand by linear blend skinning (Eq. 6), for these poses of its bones.
pub fn skinned(hand: &HandModel, poses: &[Pose]) -> Nodes {
    let change: Vec<Pose> =
        hand.bones.iter().zip(poses).map(|(bone, pose)| *pose * bone.pose_MB.inverse()).collect();
    let one = |(node, binding): (&Vec3, &thenar::model::Binding)| -> Vec3 {
        (0..2).map(|k| change[binding.bones[k] as usize].point(node) * binding.weights[k]).sum()
    };
    hand.flesh.nodes.iter().zip(&hand.bindings).map(one).collect()
}

/// A colour for each bone, neighbours apart.
pub fn bone_colour(bone: u32) -> Rgb {
    const COLOURS: [u32; 8] =
        [0xd9a441, 0xc0504d, 0x4f81bd, 0x7cb35a, 0x8064a2, 0x2fa7a0, 0xe07b39, 0x5b6abf];
    hex(COLOURS[bone as usize % COLOURS.len()])
}

/// The blend of the bones' colours over the surface of a hand, as their weights blend.
pub fn bone_colours(soft: &Soft) -> Option<Vec<Rgb>> {
    let hand = soft.hand?;
    let skin = thenar_rig::export::vertex_skin(soft.render, &hand.flesh.tets, &hand.bindings);
    let blend = |s: &thenar_rig::export::VertexSkin| -> Rgb {
        let mut sum = [0.0; 3];
        for (bone, weight) in s.bones.iter().zip(s.weights) {
            let colour = bone_colour(u32::from(*bone));
            (0..3).for_each(|k| sum[k] += weight * colour[k]);
        }
        sum
    };
    Some(skin.iter().map(blend).collect())
}

/// Bread: brown on top, golden at the sides, pale below, a little uneven. From the rest shape.
pub fn crust_colours(surface: &EmbeddedSurface, tets: &[[u32; 4]], nodes: &[Vec3]) -> Vec<Rgb> {
    let positions = embedded(surface, tets, nodes);
    let normals = super::normals::smooth(&positions, &surface.triangles);
    let (low, high) = positions
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.y), h.max(p.y)));
    let colour = |(p, n): (&Vec3, &Vec3)| -> Rgb {
        let rise = (p.y - low) / (high - low).max(1e-9);
        let spots =
            (p.x * 310.0).sin() * (p.z * 270.0 + 1.3).sin() + (p.x * 95.0 + p.z * 120.0).sin();
        let bake = (0.25 + 0.45 * rise + 0.3 * n.y.max(0.0) + 0.05 * spots).clamp(0.0, 1.0) as f32;
        let (pale, brown) = ([1.15, 1.2, 1.3], [0.62, 0.46, 0.33]);
        std::array::from_fn(|k| pale[k] + bake * (brown[k] - pale[k]))
    };
    positions.iter().zip(&normals).map(colour).collect()
}
