//! Solid angles: how much of the sky a triangle, or a far cluster of them, covers.

use thenar_core::{Mat3, Vec3};

/// Signed solid angle of a triangle seen from `p` \[sr\], positive when its back is seen
/// (so that a closed outward-facing mesh sums to 4π inside). Van Oosterom & Strackee 1983.
#[cfg(test)]
fn solid_angle(p: &Vec3, corners: &[Vec3; 3]) -> f64 {
    // At a corner both vanish and atan2 gives zero; in the triangle's plane it gives ±2π or 0,
    // which is the value on one of the two sides.
    let (numerator, denominator) = halves(p, corners);
    2.0 * numerator.atan2(denominator)
}

/// Opposite and adjacent side of half of the solid angle.
fn halves(p: &Vec3, corners: &[Vec3; 3]) -> (f64, f64) {
    let [a, b, c] = corners.map(|x| x - p);
    let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
    let numerator = a.dot(&b.cross(&c));
    let denominator = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
    (numerator, denominator)
}

/// A sum of solid angles as a product of complex numbers: half of each angle is the phase of
/// `denominator + i numerator`, so that one arc tangent serves for all.
pub struct AngleSum {
    re: f64,
    im: f64,
    /// Times that the phase went around.
    turns: f64,
}

impl AngleSum {
    /// The empty sum.
    pub fn new() -> Self {
        Self { re: 1.0, im: 0.0, turns: 0.0 }
    }

    /// Adds the signed solid angle of a triangle seen from `p`, positive when its back is seen (so
    /// that a closed outward-facing mesh sums to 4π inside). Van Oosterom & Strackee 1983.
    pub fn add(&mut self, p: &Vec3, corners: &[Vec3; 3]) {
        let (numerator, denominator) = halves(p, corners);
        let size = numerator.abs() + denominator.abs();
        // At a corner: no angle.
        if size == 0.0 {
            return;
        }
        let (c, s) = (denominator / size, numerator / size);
        let (re, im) = (self.re * c - self.im * s, self.re * s + self.im * c);
        // Two phases on one side of the real axis whose sum lies on the other went across ±π.
        match (self.im >= 0.0, s >= 0.0, im >= 0.0) {
            (true, true, false) => self.turns += 1.0,
            (false, false, true) => self.turns -= 1.0,
            _ => {}
        }
        // Factors are between 1/√2 and 1: kept away from underflow.
        let tiny = re.abs() + im.abs() < 1e-100;
        (self.re, self.im) = if tiny { (re * 1e100, im * 1e100) } else { (re, im) };
    }

    /// The sum \[sr\].
    pub fn solid_angle(&self) -> f64 {
        2.0 * (self.im.atan2(self.re) + 2.0 * std::f64::consts::PI * self.turns)
    }
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

    /// The solid angle seen from `p` \[sr\], if `p` is at least a given number of radii away.
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

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::random::Random;

    #[test]
    fn the_product_of_phases_is_the_sum_of_angles() {
        let mut random = Random::new(7);
        for count in [1, 2, 3, 10, 100, 3000] {
            for scale in [1e-4, 1.0, 1e3] {
                let mut point = || random.vector(scale);
                let p = point() * 0.3;
                let mut triangles: Vec<[Vec3; 3]> =
                    (0..count).map(|_| [point(), point(), point()]).collect();
                // Many that look the same way go around often.
                let first = triangles[0];
                triangles.extend(std::iter::repeat_n(first, count));
                triangles.push([p, first[1], first[2]]);
                let expected: f64 = triangles.iter().map(|t| solid_angle(&p, t)).sum();
                let mut sum = AngleSum::new();
                triangles.iter().for_each(|t| sum.add(&p, t));
                let error = (sum.solid_angle() - expected).abs();
                assert!(error < 1e-11 * count as f64 + 1e-12, "{count} at {scale}: {error}");
            }
        }
    }
}
