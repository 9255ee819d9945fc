//! Gathers all meshes of a scene in flat arrays, relative to the camera's target.

use super::V;
use super::colour::vector;
use super::normals;
use super::scene3d::{Material, Mesh, Scene3d};
use super::skin::SkinSite;
use std::ops::Range;
use thenar_core::Vec3;

/// Vertices and triangles of a scene. A vertex belongs to one mesh.
#[derive(Default)]
pub(super) struct Geometry {
    /// Places relative to the target \[m\].
    pub points: Vec<V>,
    /// Unit normals.
    pub normals: Vec<V>,
    /// Diffuse reflectance.
    pub colours: Vec<V>,
    /// Part of the ambient light that arrives, 0 to 1.
    pub ambient: Vec<f32>,
    /// Place on a hand of each vertex; `None` where it is not skin.
    pub sites: Vec<Option<SkinSite>>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Mesh of each triangle.
    pub mesh_of: Vec<u32>,
    /// Per mesh: its triangles.
    pub ranges: Vec<Range<u32>>,
    /// Per mesh: its vertices.
    pub vertices: Vec<Range<u32>>,
    /// Per mesh: its look.
    pub materials: Vec<Material>,
    /// Per mesh: both sides are drawn.
    pub two_sided: Vec<bool>,
}

impl Geometry {
    /// Gathers `scene` relative to `origin`. Triangles that point outside their mesh or have a
    /// corner that is not finite are left out.
    pub(super) fn gather(scene: &Scene3d, origin: Vec3) -> Self {
        let mut geometry = Self::default();
        for mesh in &scene.meshes {
            let (first_triangle, first_point) = (geometry.triangles.len(), geometry.points.len());
            geometry.add(mesh, origin);
            geometry.ranges.push(first_triangle as u32..geometry.triangles.len() as u32);
            geometry.vertices.push(first_point as u32..geometry.points.len() as u32);
            geometry.materials.push(mesh.material);
            geometry.two_sided.push(mesh.two_sided);
        }
        geometry.ambient = vec![1.0; geometry.points.len()];
        geometry
    }

    /// Triangles that cast shadows.
    pub(super) fn casters(&self) -> impl Iterator<Item = [u32; 3]> + '_ {
        let casting = self.ranges.iter().zip(&self.materials).filter(|(_, m)| m.casts_shadow);
        casting.flat_map(|(r, _)| self.triangles[r.start as usize..r.end as usize].iter().copied())
    }

    fn add(&mut self, mesh: &Mesh, origin: Vec3) {
        let sound = |t: &&[u32; 3]| {
            t.iter().all(|&i| {
                mesh.positions
                    .get(i as usize)
                    .is_some_and(|p| p.iter().all(|x| x.is_finite() && x.abs() < 1e6))
            })
        };
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(sound).copied().collect();
        let base = vector(mesh.material.colour);
        let tint = |i: usize| match mesh.colours.as_deref().and_then(|c| c.get(i)) {
            Some(c) => base.component_mul(&vector(*c)),
            None => base,
        };
        let site = |i: usize| mesh.sites.as_ref().and_then(|sites| sites.get(i).copied());
        let place = |i: usize| (mesh.positions[i] - origin).cast::<f32>();
        self.mesh_of.resize(self.mesh_of.len() + triangles.len(), self.ranges.len() as u32);
        let first = self.points.len() as u32;

        if let (Some(crease), None) = (mesh.material.crease, &mesh.normals) {
            let corners = normals::creased(&mesh.positions, &triangles, crease);
            for (triangle, corner_normals) in triangles.iter().zip(corners) {
                let next = self.points.len() as u32;
                self.triangles.push([next, next + 1, next + 2]);
                for (&i, n) in triangle.iter().zip(corner_normals) {
                    self.push(place(i as usize), n.cast(), tint(i as usize), site(i as usize));
                }
            }
            return;
        }
        let computed;
        let vertex_normals = match mesh.normals.as_deref() {
            Some(given) if given.len() == mesh.positions.len() => given,
            _ => {
                computed = normals::smooth(&mesh.positions, &triangles);
                &computed
            }
        };
        for (i, n) in vertex_normals.iter().enumerate() {
            self.push(place(i), n.cast(), tint(i), site(i));
        }
        self.triangles.extend(triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// Site between the corners of a triangle, by their weights.
    pub(super) fn site(&self, corners: [u32; 3], weights: &[f32; 3]) -> Option<SkinSite> {
        let [a, b, c] = corners.map(|i| self.sites[i as usize]);
        let (of, w) = ([a?, b?, c?], weights);
        let mix = |value: fn(&SkinSite) -> f32| (0..3).map(|k| value(&of[k]) * w[k]).sum();
        let nail = [mix(|s| s.nail[0]), mix(|s| s.nail[1])];
        Some(SkinSite { blood: mix(|s| s.blood), open: mix(|s| s.open), nail })
    }

    pub(super) fn push(&mut self, point: V, normal: V, colour: V, site: Option<SkinSite>) {
        self.sites.push(site);
        self.points.push(point);
        self.normals.push(normal);
        self.colours.push(colour);
    }
}
