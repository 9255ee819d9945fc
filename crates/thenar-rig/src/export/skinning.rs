//! Bone weights of surface vertices, from those of the flesh around them.

use super::gltf::VertexSkin;
use thenar_core::model::{Binding, EmbeddedSurface};

/// The bone with the larger weight, and its weight.
pub fn dominant_bone(binding: &Binding) -> (u32, f64) {
    let k = usize::from(binding.weights[1] > binding.weights[0]);
    (binding.bones[k], binding.weights[k])
}

/// The four bones that carry most of each surface vertex, weights of sum 1: the barycentric mean
/// of the bindings of the four nodes around it.
pub fn vertex_skin(
    surface: &EmbeddedSurface,
    tets: &[[u32; 4]],
    bindings: &[Binding],
) -> Vec<VertexSkin> {
    let one = |vertex: &thenar_core::model::SurfaceVertex| {
        let mut sums: Vec<(u32, f64)> = Vec::with_capacity(8);
        for (node, w) in tets[vertex.tet as usize].iter().zip(vertex.weights) {
            let binding = &bindings[*node as usize];
            for (bone, weight) in binding.bones.iter().zip(binding.weights) {
                match sums.iter_mut().find(|(b, _)| b == bone) {
                    Some((_, sum)) => *sum += w * weight,
                    None => sums.push((*bone, w * weight)),
                }
            }
        }
        largest_four(sums)
    };
    surface.vertices.iter().map(one).collect()
}

fn largest_four(mut sums: Vec<(u32, f64)>) -> VertexSkin {
    sums.retain(|(_, w)| *w > 0.0);
    sums.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    sums.truncate(4);
    let total: f64 = sums.iter().map(|(_, w)| w).sum();
    let mut skin = VertexSkin { bones: [0; 4], weights: [0.0; 4] };
    for (k, (bone, weight)) in sums.iter().enumerate() {
        skin.bones[k] = *bone as u16;
        skin.weights[k] = (weight / total) as f32;
    }
    skin
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::model::SurfaceVertex;

    #[test]
    fn a_vertex_takes_the_mean_of_its_nodes() {
        let bind = |a: u32, b: u32, w: f64| Binding { bones: [a, b], weights: [w, 1.0 - w] };
        let bindings = [bind(0, 1, 1.0), bind(0, 1, 0.5), bind(1, 2, 0.25), bind(2, 2, 1.0)];
        let surface = EmbeddedSurface {
            vertices: vec![SurfaceVertex { tet: 0, weights: [0.25; 4] }],
            triangles: vec![],
        };
        // Bone 2: (0.75 + 1) / 4, bone 0: (1 + 0.5) / 4, bone 1: (0.5 + 0.25) / 4.
        let skin = vertex_skin(&surface, &[[0, 1, 2, 3]], &bindings)[0];
        assert_eq!(skin.bones, [2, 0, 1, 0]);
        assert_eq!(skin.weights, [0.4375, 0.375, 0.1875, 0.0]);
    }
}
