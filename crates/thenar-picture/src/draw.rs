//! Lines, points, arrows and bones.

use super::camera::Camera;
use super::scene3d::{Material, Mesh};
use super::shapes::{Solid, cylinder, sphere, spindle};
use thenar_core::Vec3;

/// Draws lines of constant width on the screen for one camera.
pub struct Pen {
    camera: Camera,
    height: u32,
    /// Width of a line \[px\].
    pub width: f64,
}

impl Pen {
    /// A pen for pictures of this height \[px\].
    pub fn new(camera: &Camera, height: u32, width: f64) -> Self {
        Self { camera: *camera, height, width }
    }

    /// The place of the camera \[m\].
    pub fn eye(&self) -> Vec3 {
        self.camera.position
    }

    /// A line as two triangles turned to the eye, pulled a little towards it so that it shows
    /// on the surface it lies on.
    fn line(&self, a: Vec3, b: Vec3, out: &mut Solid) {
        let eye = self.camera.position;
        let ends = [a, b].map(|p| p + (eye - p) * 2e-3);
        let Some(side) = (b - a).cross(&(eye - a)).try_normalize(1e-15) else { return };
        let forward = self.camera.axes()[2];
        let first = out.positions.len() as u32;
        for p in ends {
            let half =
                self.width / 2.0 * self.camera.pixel_size(forward.dot(&(p - eye)), self.height);
            out.positions.extend([p - side * half, p + side * half]);
        }
        out.triangles.extend([[first, first + 1, first + 2], [first + 1, first + 3, first + 2]]);
    }

    /// A mesh of lines.
    pub fn lines(
        &self,
        segments: impl IntoIterator<Item = [Vec3; 2]>,
        material: Material,
    ) -> Mesh<'static> {
        let mut solid = Solid::default();
        for [a, b] in segments {
            self.line(a, b, &mut solid);
        }
        Mesh { two_sided: true, ..solid.mesh(material) }
    }
}

/// The distinct edges of tetrahedra.
pub fn wires(nodes: &[Vec3], tets: &[[u32; 4]]) -> Vec<[Vec3; 2]> {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(6 * tets.len());
    for tet in tets {
        for (i, j) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            edges.push([tet[i].min(tet[j]), tet[i].max(tet[j])]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    let known = |i: u32| nodes.get(i as usize).copied();
    edges.into_iter().filter_map(|[i, j]| Some([known(i)?, known(j)?])).collect()
}

/// An arrow from `tail` along `vector`, its shaft of this radius \[m\]; nothing when too short.
pub fn arrow(tail: Vec3, vector: Vec3, radius: f64) -> Solid {
    let length = vector.norm();
    let mut solid = Solid::default();
    if length < 1e-9 || !length.is_finite() {
        return solid;
    }
    let head = (4.5 * radius).min(0.6 * length);
    let neck = tail + vector * (1.0 - head / length);
    solid.join(&cylinder(tail, neck, [radius; 2], 10));
    solid.join(&cylinder(neck, tail + vector, [2.4 * radius, 0.0], 12));
    solid
}

/// A bone between its two ends.
pub fn bone(ends: [Vec3; 2], radius: f64) -> Solid {
    spindle(ends[0], ends[1], radius)
}

/// Small balls.
pub fn points(centres: impl IntoIterator<Item = Vec3>, radius: f64) -> Solid {
    let mut solid = Solid::default();
    for centre in centres {
        solid.join(&sphere(centre, radius, 12));
    }
    solid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_tetrahedra_that_share_a_face_have_nine_edges() {
        let nodes = vec![Vec3::zeros(); 5];
        assert_eq!(wires(&nodes, &[[0, 1, 2, 3], [1, 2, 3, 4]]).len(), 9);
        // A node that does not exist draws nothing.
        assert_eq!(wires(&nodes, &[[0, 1, 2, 9]]).len(), 3);
    }
}
