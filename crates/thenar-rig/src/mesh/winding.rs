//! Solid angles: how much of the sky a triangle, or a far cluster of them, covers.

use thenar::{Mat3, Vec3};

/// Signed solid angle of a triangle seen from `p` \[sr\], positive when its back is seen
/// (so that a closed outward-facing mesh sums to 4π inside). Van Oosterom & Strackee 1983.
pub fn solid_angle(p: &Vec3, corners: &[Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|x| x - p);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let numerator = a.dot(&b.cross(&c));
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    // At a corner both vanish and atan2 gives zero; in the triangle's plane it gives ±2π or 0,
    // which is the value on one of the two sides.
    2.0 * numerator.atan2(denominator)
}

/// The multipole expansion of a set of triangles as a cloud of dipoles (Barill et al. 2018,
/// section 3, to second order), about the area-weighted centre.
#[derive(Clone, Debug)]
pub struct Cluster {
    centre: Vec3,
    /// Largest distance of a corner from the centre.
    radius: f64,
    /// Σ area vector.
    dipole: Vec3,
    /// Σ (centroid - centre) ⊗ area vector.
    quadrupole: Mat3,
}

impl Cluster {
    pub fn new<'a>(triangles: impl Iterator<Item = &'a [Vec3; 3]> + Clone) -> Self {
        let area_vector = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a)) * 0.5;
        let centroid = |[a, b, c]: &[Vec3; 3]| (a + b + c) / 3.0;

        let (mut sum, mut area, mut plain, mut count) = (Vec3::zeros(), 0.0, Vec3::zeros(), 0.0);
        for t in triangles.clone() {
            let a = area_vector(t).norm();
            sum += centroid(t) * a;
            area += a;
            plain += centroid(t);
            count += 1.0;
        }
        let centre = if area > 0.0 { sum / area } else { plain / f64::max(count, 1.0) };

        let mut cluster =
            Self { centre, radius: 0.0, dipole: Vec3::zeros(), quadrupole: Mat3::zeros() };
        for t in triangles {
            let n = area_vector(t);
            cluster.dipole += n;
            cluster.quadrupole += (centroid(t) - centre) * n.transpose();
            for p in t {
                cluster.radius = cluster.radius.max((p - centre).norm());
            }
        }
        cluster
    }

    /// The solid angle seen from `p` \[sr\], if `p` is at least so many radii away.
    pub fn solid_angle_if_far(&self, p: &Vec3, radii: f64) -> Option<f64> {
        let r = self.centre - p;
        let r2 = r.norm_squared();
        if r2 <= (radii * self.radius).powi(2) {
            return None;
        }
        let r3 = r2 * r2.sqrt();
        let first = r.dot(&self.dipole) / r3;
        let second = self.quadrupole.trace() / r3 - 3.0 * r.dot(&(self.quadrupole * r)) / (r3 * r2);
        Some(first + second)
    }
}
