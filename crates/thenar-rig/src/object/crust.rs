//! The colour of bread.

use crate::TriMesh;
use thenar_core::Vec3;
use thenar_core::model::EmbeddedSurface;

/// Colours that baking gives a loaf at each vertex of its surface, from the rest shape: brown on
/// top, golden at the sides, pale below, a little uneven. Factors on linear red, green and blue.
pub fn crust(surface: &EmbeddedSurface, tets: &[[u32; 4]], nodes: &[Vec3]) -> Vec<[f32; 3]> {
    let mut positions = vec![Vec3::zeros(); surface.vertices.len()];
    surface.positions(tets, nodes, &mut positions);
    let mesh = TriMesh { positions, triangles: surface.triangles.clone() };
    let (low, high) = mesh
        .positions
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.y), h.max(p.y)));
    let colour = |(p, n): (&Vec3, &Vec3)| -> [f32; 3] {
        let rise = (p.y - low) / (high - low).max(1e-9);
        let spots =
            (p.x * 310.0).sin() * (p.z * 270.0 + 1.3).sin() + (p.x * 95.0 + p.z * 120.0).sin();
        let bake = (0.25 + 0.45 * rise + 0.3 * n.y.max(0.0) + 0.05 * spots).clamp(0.0, 1.0) as f32;
        let (pale, brown) = ([1.15, 1.2, 1.3], [0.62, 0.46, 0.33]);
        std::array::from_fn(|k| pale[k] + bake * (brown[k] - pale[k]))
    };
    mesh.positions.iter().zip(&mesh.normals()).map(colour).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::{Bread, bread};

    #[test]
    fn bread_is_darker_on_top_than_below() {
        let loaf = bread(&Bread::loaf()).expect("the loaf is sound").0;
        let nodes = &loaf.flesh.nodes;
        let shades = crust(&loaf.render, &loaf.flesh.tets, nodes);
        let mut positions = vec![Vec3::zeros(); shades.len()];
        loaf.render.positions(&loaf.flesh.tets, nodes, &mut positions);
        let mean = |wanted: &dyn Fn(f64) -> bool| {
            let some: Vec<f32> = positions
                .iter()
                .zip(&shades)
                .filter(|(p, _)| wanted(p.y))
                .map(|(_, shade)| shade.iter().sum::<f32>())
                .collect();
            some.iter().sum::<f32>() / some.len() as f32
        };
        let top = positions.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
        let bottom = positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
        let (third, span) = ((top - bottom) / 3.0, [bottom, top]);
        let (above, below) = (mean(&|y| y > span[1] - third), mean(&|y| y < span[0] + third));
        assert!(above < 0.75 * below, "{above} {below}");
    }
}
