//! Balls of tetrahedra, solid or around a core, for validation and play.

use super::lattice_box::TETS_MAX;
use super::soft::{SoftModel, SoftOptions, soft_from_tets, volume};
use crate::RigError;
use crate::error::positive;
use crate::mesh::shapes;
use thenar_core::Vec3;
use thenar_core::model::Material;

/// A ball, centred at the origin, in layers of prisms between spheres of triangles.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Ball {
    /// Outer radius \[m\].
    pub outer: f64,
    /// Radius of the hollow inside \[m\]; zero fills the ball. Nodes at this distance from the
    /// centre are the ones to hold for a rigid bonded core.
    pub inner: f64,
    /// Each face of an icosahedron is split into `frequency`² triangles.
    pub frequency: u32,
    /// Layers of elements.
    pub layers: u32,
    /// Thickness of each layer over that of the one outside it.
    pub growth: f64,
    /// Elements at the pole -y are finer by this factor, those at +y as much coarser.
    pub focus: f64,
}

impl Ball {
    /// An evenly fine ball: elements about `outer / refinement` across.
    pub fn even(outer: f64, inner: f64, refinement: u32) -> Self {
        let layers = (f64::from(refinement) * (1.0 - inner / outer)).ceil().max(1.0) as u32;
        Self { outer, inner, frequency: refinement.max(1), layers, growth: 1.0, focus: 1.0 }
    }
}

/// Builds the ball; `material` is asked at each element's centroid.
pub fn ball(
    shape: &Ball,
    material: impl Fn(&Vec3) -> Material,
    options: &SoftOptions,
) -> Result<SoftModel, RigError> {
    check(shape)?;
    let mut sphere = shapes::sphere(1.0, shape.frequency);
    sphere.positions.iter_mut().for_each(|p| *p = focused(p, shape.focus));
    let per_sphere = sphere.positions.len() as u32;
    let radii = radii(shape);

    let mut nodes: Vec<Vec3> =
        radii.iter().flat_map(|&r| sphere.positions.iter().map(move |p| p * r)).collect();
    let mut tets = Vec::new();
    for layer in 0..radii.len() as u32 - 1 {
        for &triangle in &sphere.triangles {
            let top = triangle.map(|v| v + layer * per_sphere);
            tets.extend(prism(top, top.map(|v| v + per_sphere)));
        }
    }
    if shape.inner == 0.0 {
        let (centre, last) = (nodes.len() as u32, (radii.len() as u32 - 1) * per_sphere);
        nodes.push(Vec3::zeros());
        tets.extend(sphere.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|v| v + last);
            [centre, a, b, c]
        }));
    }
    for tet in &mut tets {
        if volume(&tet.map(|n| nodes[n as usize])) < 0.0 {
            tet.swap(2, 3);
        }
    }
    let centroid = |t: &[u32; 4]| t.iter().map(|&n| nodes[n as usize]).sum::<Vec3>() * 0.25;
    let materials = tets.iter().map(|t| material(&centroid(t))).collect();
    Ok(soft_from_tets("ball", nodes, tets, materials, options)?.0)
}

fn check(shape: &Ball) -> Result<(), RigError> {
    positive("outer", shape.outer)?;
    positive("growth", shape.growth)?;
    positive("focus", shape.focus)?;
    if !(shape.inner >= 0.0 && shape.inner < shape.outer) {
        let expected = "at least 0 and below the outer radius";
        return Err(RigError::Parameter { name: "inner", expected, value: shape.inner });
    }
    let tets = 60 * u64::from(shape.frequency).pow(2) * u64::from(shape.layers);
    if shape.frequency == 0 || shape.layers == 0 || shape.frequency > 1000 || tets > TETS_MAX as u64
    {
        return Err(RigError::invalid(format!(
            "a ball of frequency {} and {} layers has none or more than {TETS_MAX} tetrahedra",
            shape.frequency, shape.layers
        )));
    }
    Ok(())
}

/// Moves a point of the unit sphere towards -y by the conformal map `tan(ψ/2) → tan(ψ/2) / focus`
/// of the angle ψ from -y, which keeps the shape of small triangles.
fn focused(p: &Vec3, focus: f64) -> Vec3 {
    // Stereographic projection from +y: s = tan(ψ/2) is the distance from the axis.
    let ring = f64::hypot(p.x, p.z);
    if ring < 1e-12 {
        return *p;
    }
    let s = (1.0 + p.y) / ring / focus;
    let scale = 2.0 * s / (1.0 + s * s) / ring;
    Vec3::new(p.x * scale, (s * s - 1.0) / (s * s + 1.0), p.z * scale)
}

/// From the outside in; a full ball's last layer is the one of tetrahedra around the centre.
fn radii(shape: &Ball) -> Vec<f64> {
    let steps: Vec<f64> = (0..shape.layers).map(|i| shape.growth.powi(i as i32)).collect();
    let scale = (shape.outer - shape.inner) / steps.iter().sum::<f64>();
    let mut radii = vec![shape.outer];
    for (i, step) in steps.iter().enumerate() {
        let last = i + 1 == steps.len();
        if last && shape.inner == 0.0 {
            break;
        }
        radii.push(if last { shape.inner } else { radii[i] - step * scale });
    }
    radii
}

/// Cuts the prism between two triangles. Each side is cut at its end of smaller index, so that
/// neighbours agree.
fn prism(top: [u32; 3], bottom: [u32; 3]) -> [[u32; 4]; 3] {
    let mut order = [0, 1, 2];
    order.sort_unstable_by_key(|&k| top[k]);
    let [a, b, c] = order.map(|k| top[k]);
    let [d, e, f] = order.map(|k| bottom[k]);
    [[a, b, c, f], [a, b, f, e], [a, e, f, d]]
}
