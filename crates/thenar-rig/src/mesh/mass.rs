//! Mass, centre and inertia of bodies bounded by meshes.

use crate::{RigError, TriMesh};
use thenar_core::{Mat3, Vec3};

/// Mass properties of a body, in the frame of its mesh.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MassProperties {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub centre: Vec3,
    /// Inertia about the centre of mass, along the mesh's axes \[kg m²\].
    pub inertia: Mat3,
}

impl MassProperties {
    /// Properties of the solid inside a closed, outward-facing mesh, exactly: the integrals of 1, x
    /// and x xᵀ over the tetrahedra between an origin and each triangle.
    pub fn of_solid(mesh: &TriMesh, density: f64) -> Result<Self, RigError> {
        let [min, max] = mesh.bounds();
        let origin = (min + max) * 0.5;
        let mut moments = Moments::default();
        for t in 0..mesh.triangles.len() {
            let corners = mesh.corners(t).map(|p| p - origin);
            let [a, b, c] = corners;
            let volume = a.dot(&b.cross(&c)) / 6.0;
            moments.add_simplex(volume, &[a, b, c], 4.0);
        }
        moments.finish(&origin, density)
    }

    /// Properties of the surface itself, given a thickness \[m\] small against its size: each
    /// triangle is a plate, its spread through the thickness included.
    pub fn of_shell(mesh: &TriMesh, thickness: f64, density: f64) -> Result<Self, RigError> {
        let [min, max] = mesh.bounds();
        let origin = (min + max) * 0.5;
        let mut moments = Moments::default();
        for t in 0..mesh.triangles.len() {
            let n = mesh.area_vector(t);
            let area = n.norm();
            if area > 0.0 {
                let volume = area * thickness;
                let corners = mesh.corners(t).map(|p| p - origin);
                moments.add_simplex(volume, &corners, 3.0);
                moments.second +=
                    n * n.transpose() * (volume * thickness * thickness / (12.0 * area * area));
            }
        }
        moments.finish(&origin, density)
    }

    /// Properties of this body scaled to this mass \[kg\].
    pub fn with_mass(mut self, mass: f64) -> Self {
        self.inertia *= mass / self.mass;
        self.mass = mass;
        self
    }
}

/// Integrals over a body: 1, x and x xᵀ.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    pub volume: f64,
    pub first: Vec3,
    pub second: Mat3,
}

impl Moments {
    /// Adds a simplex of `vertices` vertices (4: tetrahedron, 3: triangle), of which those at the
    /// origin are left out of `corners`.
    /// `∫ x xᵀ = V / (n (n+1)) (s sᵀ + Σ p pᵀ)` with n vertices p of sum s.
    fn add_simplex(&mut self, volume: f64, corners: &[Vec3; 3], vertices: f64) {
        let sum: Vec3 = corners.iter().sum();
        let squares: Mat3 = corners.iter().map(|p| p * p.transpose()).sum();
        self.volume += volume;
        self.first += sum * (volume / vertices);
        self.second += (sum * sum.transpose() + squares) * (volume / (vertices * (vertices + 1.0)));
    }

    /// Adds a cube of this volume and edge at `p`.
    pub fn add_cube(&mut self, volume: f64, edge: f64, p: &Vec3) {
        self.volume += volume;
        self.first += p * volume;
        self.second += (p * p.transpose() + Mat3::identity() * (edge * edge / 12.0)) * volume;
    }

    /// Mass properties, when the moments are those of a real body.
    pub fn finish(&self, origin: &Vec3, density: f64) -> Result<MassProperties, RigError> {
        if !(self.volume.is_finite() && self.volume > 0.0) {
            return Err(RigError::invalid(format!(
                "the mesh encloses no volume ({:e} m³)",
                self.volume
            )));
        }
        let centre = self.first / self.volume;
        let spread = self.second - centre * centre.transpose() * self.volume;
        let inertia = (Mat3::identity() * spread.trace() - spread) * density;
        let inertia = (inertia + inertia.transpose()) * 0.5;
        let moments = inertia.symmetric_eigen().eigenvalues;
        let largest = moments.max();
        if !(largest.is_finite() && moments.min() > 1e-12 * largest && largest > 0.0) {
            return Err(RigError::invalid(format!(
                "the mesh has no inertia about some axis (principal moments {:e} to {largest:e} kg m²)",
                moments.min()
            )));
        }
        Ok(MassProperties { mass: density * self.volume, centre: centre + origin, inertia })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use thenar_core::{Pose, Quat};

    fn close(a: &Mat3, b: &Mat3, tolerance: f64) {
        assert!((a - b).norm() < tolerance * b.norm(), "{a} {b}");
    }

    #[test]
    fn a_displaced_turned_box_has_the_textbook_inertia() {
        let half = Vec3::new(0.01, 0.02, 0.03);
        let turn = Quat::from_euler_angles(0.3, -1.1, 2.0);
        let pose = Pose::new(Vec3::new(3.0, -2.0, 10.0), turn);
        let body =
            MassProperties::of_solid(&shapes::cuboid(&half).transformed(&pose), 700.0).unwrap();
        let mass = 700.0 * 8.0 * half.product();
        let square = half.component_mul(&half);
        let diagonal = Vec3::new(square.y + square.z, square.z + square.x, square.x + square.y);
        let expected = Mat3::from_diagonal(&diagonal) * (mass / 3.0);
        let r = turn.to_rotation_matrix();
        assert!((body.mass / mass - 1.0).abs() < 1e-11);
        assert!((body.centre - pose.position).norm() < 1e-12);
        close(&body.inertia, &(r * expected * r.transpose()), 1e-10);
    }

    #[test]
    fn a_corner_tetrahedron_has_the_textbook_inertia() {
        // Corner at the origin, legs 1: I_xx = I_yy = I_zz = m 3/40, I_xy = m/80 about the centre
        // (∫x² = m/10, ∫xy = m/20, centre ¼).
        let positions = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mesh = TriMesh::new(positions, triangles).unwrap();
        let body = MassProperties::of_solid(&mesh, 6.0).unwrap();
        assert!((body.mass - 1.0).abs() < 1e-14);
        assert!((body.centre - Vec3::repeat(0.25)).norm() < 1e-14);
        let expected =
            Mat3::from_diagonal_element(3.0 / 40.0 - 1.0 / 80.0) + Mat3::repeat(1.0 / 80.0);
        close(&body.inertia, &expected, 1e-13);
    }

    #[test]
    fn a_sphere_and_a_spherical_shell_approach_theirs() {
        let ball = shapes::sphere(0.04, 40);
        let body = MassProperties::of_solid(&ball, 1000.0).unwrap();
        let exact = Mat3::from_diagonal_element(0.4 * body.mass * 0.04f64.powi(2));
        close(&body.inertia, &exact, 2e-3);
        let shell = MassProperties::of_shell(&ball, 1e-4, 1000.0).unwrap();
        let exact = Mat3::from_diagonal_element(2.0 / 3.0 * shell.mass * 0.04f64.powi(2));
        close(&shell.inertia, &exact, 2e-3);
        assert!((shell.mass / (1e-4 * 1000.0 * ball.area()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_thin_plate_has_inertia_through_its_thickness() {
        let positions = vec![Vec3::zeros(), Vec3::x(), Vec3::x() + Vec3::y(), Vec3::y()];
        let plate = TriMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        let body = MassProperties::of_shell(&plate, 0.2, 5.0).unwrap();
        let expected = Mat3::from_diagonal(&Vec3::new(1.04, 1.04, 2.0)) / 12.0;
        assert!((body.mass - 1.0).abs() < 1e-14);
        close(&body.inertia, &expected, 1e-13);
    }

    #[test]
    fn no_volume_is_an_error() {
        let positions = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
        let flat = TriMesh::new(positions, vec![[0, 1, 2], [0, 2, 1]]).unwrap();
        let error = MassProperties::of_solid(&flat, 1.0).unwrap_err().to_string();
        assert!(error.contains("no volume"), "{error}");
    }
}
