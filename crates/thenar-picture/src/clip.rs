//! From world triangles to triangles on the screen, clipped to what can be seen.

use super::V;
use super::assemble::Geometry;
use super::camera::View;

/// Triangles reach at most so far from the picture's middle \[px\]; beyond, they are cut.
const GUARD: f32 = 16_000.0;

/// Factor on the nearness of a mesh drawn over everything.
const ON_TOP: f32 = 1e4;

/// A vertex on the screen: x, y \[px\], and one over its distance \[1/m\].
pub(super) type ScreenVertex = [f32; 3];

/// The screen triangles of a scene, turned so that their signed area is positive
/// (y downwards). Cut triangles come with new vertices, appended to the geometry.
pub(super) struct Screen {
    /// Per vertex of the geometry.
    pub vertices: Vec<ScreenVertex>,
    /// Corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Mesh of each triangle, ascending.
    pub mesh_of: Vec<u32>,
}

impl Screen {
    pub(super) fn project(geometry: &mut Geometry, view: &View) -> Self {
        let eyes: Vec<V> = geometry.points.iter().map(|&p| view.to_eye(p)).collect();
        let mut screen = Self {
            vertices: eyes.iter().map(|&e| on_screen(e, view)).collect(),
            triangles: Vec::with_capacity(geometry.triangles.len()),
            mesh_of: Vec::with_capacity(geometry.triangles.len()),
        };
        for t in 0..geometry.triangles.len() {
            let corners = geometry.triangles[t];
            let mesh = geometry.mesh_of[t];
            let triangle = corners.map(|i| eyes[i as usize]);
            if triangle.iter().all(|e| inside_all(e, view)) {
                screen.add(corners, mesh, geometry);
            } else {
                screen.add_cut(corners, triangle, mesh, geometry, view);
            }
        }
        for (mesh, material) in geometry.materials.iter().enumerate() {
            if material.on_top {
                let range = geometry.vertices[mesh].clone();
                for vertex in &mut screen.vertices[range.start as usize..range.end as usize] {
                    vertex[2] *= ON_TOP;
                }
            }
        }
        screen
    }

    /// Adds a triangle if it shows its front, or either side of a two-sided mesh.
    fn add(&mut self, corners: [u32; 3], mesh: u32, geometry: &Geometry) {
        let [a, b, c] = corners.map(|i| self.vertices[i as usize]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let turned = if area < 0.0 {
            [corners[0], corners[2], corners[1]]
        } else if geometry.two_sided[mesh as usize] && area > 0.0 {
            corners
        } else {
            return;
        };
        self.triangles.push(turned);
        self.mesh_of.push(mesh);
    }

    fn add_cut(
        &mut self,
        corners: [u32; 3],
        triangle: [V; 3],
        mesh: u32,
        geometry: &mut Geometry,
        view: &View,
    ) {
        let polygon = cut(&triangle, view);
        if polygon.len() < 3 {
            return;
        }
        let first = self.vertices.len() as u32;
        let on_top = if geometry.materials[mesh as usize].on_top { ON_TOP } else { 1.0 };
        for w in &polygon {
            let mix =
                |values: &[V]| -> V { (0..3).map(|k| values[corners[k] as usize] * w[k]).sum() };
            let (point, normal) = (mix(&geometry.points), mix(&geometry.normals));
            let colour = mix(&geometry.colours);
            let ambient = (0..3).map(|k| geometry.ambient[corners[k] as usize] * w[k]).sum();
            geometry.push(point, normal, colour, geometry.site(corners, w));
            geometry.ambient.push(ambient);
            let eye: V = (0..3).map(|k| triangle[k] * w[k]).sum();
            let [x, y, inverse] = on_screen(eye, view);
            self.vertices.push([x, y, inverse * on_top]);
        }
        for k in 1..polygon.len() as u32 - 1 {
            self.add([first, first + k, first + k + 1], mesh, geometry);
        }
    }
}

fn on_screen(eye: V, view: &View) -> ScreenVertex {
    let inverse = 1.0 / eye.z;
    [
        view.width / 2.0 + view.focal * eye.x * inverse,
        view.height / 2.0 - view.focal * eye.y * inverse,
        inverse,
    ]
}

/// Signed distances to the near plane and the four guard planes, positive inside.
fn distances(e: &V, view: &View) -> [f32; 5] {
    let reach = GUARD / view.focal * e.z;
    [e.z - view.near, reach - e.x, reach + e.x, reach - e.y, reach + e.y]
}

fn inside_all(e: &V, view: &View) -> bool {
    distances(e, view).iter().all(|&d| d >= 0.0)
}

/// The part of a triangle inside all planes (Sutherland-Hodgman), as barycentric weights.
fn cut(triangle: &[V; 3], view: &View) -> Vec<[f32; 3]> {
    let mut polygon = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for plane in 0..5 {
        let distance = |w: &[f32; 3]| {
            let e: V = (0..3).map(|k| triangle[k] * w[k]).sum();
            distances(&e, view)[plane]
        };
        let mut kept: Vec<[f32; 3]> = Vec::with_capacity(polygon.len() + 1);
        for i in 0..polygon.len() {
            let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
            let (da, db) = (distance(&a), distance(&b));
            if da >= 0.0 {
                kept.push(a);
            }
            if (da >= 0.0) != (db >= 0.0) {
                let f = da / (da - db);
                kept.push(std::array::from_fn(|k| a[k] + f * (b[k] - a[k])));
            }
        }
        polygon = kept;
    }
    polygon
}
