//! Surfaces that follow nodes or bones.

use super::actors::Soft;
use super::colour::{Rgb, hex};
use thenar_core::model::{EmbeddedSurface, HandModel};
use thenar_core::{Pose, Vec3};

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
    let one = |(node, binding): (&Vec3, &thenar_core::model::Binding)| -> Vec3 {
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
