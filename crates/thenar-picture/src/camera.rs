//! The eye: a pinhole camera.

use super::V;
use thenar_core::Vec3;

/// Nothing nearer than this part of the viewing distance is drawn.
const NEAR: f64 = 0.02;

/// A perspective camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Place of the eye, world \[m\].
    pub position: Vec3,
    /// Point that appears in the middle of the picture, world \[m\].
    pub target: Vec3,
    /// Direction that appears upwards.
    pub up: Vec3,
    /// Vertical field of view \[rad\].
    pub fov_y: f64,
}

impl Camera {
    /// A camera that looks along `direction` and shows all `points` in a picture of this
    /// `aspect` (width / height), with `margin` (say 0.1) of the half-size left free around.
    pub fn fitted(points: &[Vec3], direction: Vec3, fov_y: f64, aspect: f64, margin: f64) -> Self {
        let probe = Self { position: -direction, target: Vec3::zeros(), up: Vec3::y(), fov_y };
        let axes = probe.axes();
        let (mut low, mut high) = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        for p in points.iter().filter(|p| p.iter().all(|x| x.is_finite())) {
            let q = Vec3::new(axes[0].dot(p), axes[1].dot(p), axes[2].dot(p));
            low = low.inf(&q);
            high = high.sup(&q);
        }
        if low.x > high.x {
            (low, high) = (Vec3::repeat(-0.1), Vec3::repeat(0.1));
        }
        let middle = (low + high) / 2.0;
        let half = (high - low) / 2.0;
        let slope_y = (fov_y / 2.0).tan() * (1.0 - margin);
        let slope_x = slope_y * aspect;
        let distance = half.z + (half.x / slope_x).max(half.y / slope_y).max(1e-6);
        let target = axes[0] * middle.x + axes[1] * middle.y + axes[2] * middle.z;
        Self { position: target - axes[2] * distance, target, up: Vec3::y(), fov_y }
    }

    /// Unit vectors to the right, upwards and forwards, world.
    pub fn axes(&self) -> [Vec3; 3] {
        let unit = |v: Vec3, otherwise: Vec3| v.try_normalize(1e-12).unwrap_or(otherwise);
        let forward = unit(self.target - self.position, -Vec3::z());
        let sideways = forward.cross(&self.up);
        let right = sideways.try_normalize(1e-9).unwrap_or_else(|| {
            let other = if forward.x.abs() < 0.5 { Vec3::x() } else { Vec3::z() };
            forward.cross(&other).normalize()
        });
        [right, right.cross(&forward), forward]
    }

    /// Returns a world point's pixels from the upper left corner, and its distance along the view
    /// \[m\]; `None` behind the near plane.
    #[cfg(test)]
    pub fn project(&self, point: &Vec3, width: u32, height: u32) -> Option<([f64; 2], f64)> {
        let [right, up, forward] = self.axes();
        let d = point - self.position;
        let z = forward.dot(&d);
        if z < self.near() {
            return None;
        }
        let focal = self.focal(height);
        let x = f64::from(width) / 2.0 + focal * right.dot(&d) / z;
        let y = f64::from(height) / 2.0 - focal * up.dot(&d) / z;
        Some(([x, y], z))
    }

    /// Focal length \[px\].
    pub fn focal(&self, height: u32) -> f64 {
        f64::from(height) / 2.0 / (self.fov_y.clamp(1e-3, 3.0) / 2.0).tan()
    }

    /// Size of one pixel on an object `depth` metres away \[m\].
    pub fn pixel_size(&self, depth: f64, height: u32) -> f64 {
        depth / self.focal(height)
    }

    fn near(&self) -> f64 {
        NEAR * (self.target - self.position).norm().max(1e-9)
    }
}

/// A camera made ready for one picture, in single precision about the target.
pub(super) struct View {
    /// The eye.
    pub eye: V,
    pub right: V,
    pub up: V,
    pub forward: V,
    /// Focal length \[px\].
    pub focal: f32,
    pub near: f32,
    pub width: f32,
    pub height: f32,
}

impl View {
    pub(super) fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let [right, up, forward] = camera.axes().map(|a| a.cast::<f32>());
        Self {
            eye: (camera.position - camera.target).cast(),
            right,
            up,
            forward,
            focal: camera.focal(height) as f32,
            near: camera.near() as f32,
            width: width as f32,
            height: height as f32,
        }
    }

    /// A point in the eye's axes: right, up, forward.
    pub(super) fn to_eye(&self, p: V) -> V {
        let d = p - self.eye;
        V::new(self.right.dot(&d), self.up.dot(&d), self.forward.dot(&d))
    }

    /// Direction through a place in the picture, with unit forward part.
    pub(super) fn ray(&self, x: f32, y: f32) -> V {
        self.forward
            + self.right * ((x - self.width / 2.0) / self.focal)
            + self.up * ((self.height / 2.0 - y) / self.focal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn looking_down_z() -> Camera {
        Camera {
            position: Vec3::new(0.0, 0.0, 2.0),
            target: Vec3::zeros(),
            up: Vec3::y(),
            fov_y: std::f64::consts::FRAC_PI_2,
        }
    }

    #[test]
    fn projects_to_the_hand_computed_pixel() {
        // At 90 degrees the focal length is half the height: 200 px. A point at (0.5, 0.25, 0) is
        // 2 m away: x = 300 + 200 * 0.5 / 2 = 350, y = 200 - 200 * 0.25 / 2 = 175.
        let ([x, y], z) =
            looking_down_z().project(&Vec3::new(0.5, 0.25, 0.0), 600, 400).expect("in front");
        assert!((x - 350.0).abs() < 1e-9 && (y - 175.0).abs() < 1e-9 && (z - 2.0).abs() < 1e-12);
        assert!(looking_down_z().project(&Vec3::new(0.0, 0.0, 3.0), 600, 400).is_none());
    }

    #[test]
    fn a_ray_passes_through_what_it_was_projected_from() {
        let camera = Camera {
            position: Vec3::new(0.4, 0.9, 1.3),
            target: Vec3::new(0.1, 0.2, -0.1),
            up: Vec3::y(),
            fov_y: 0.7,
        };
        let p = Vec3::new(0.17, 0.31, 0.05);
        let ([x, y], z) = camera.project(&p, 640, 480).expect("in front");
        let view = View::new(&camera, 640, 480);
        let hit = view.eye + view.ray(x as f32, y as f32) * z as f32;
        assert!((hit - (p - camera.target).cast::<f32>()).norm() < 1e-6);
    }

    #[test]
    fn a_fitted_camera_shows_every_point_and_wastes_little() {
        let points: Vec<Vec3> = (0..8)
            .map(|i| {
                let bit = |k: i32| f64::from((i >> k) & 1) - 0.5;
                Vec3::new(5.0 + 0.2 * bit(0), 1.0 + 0.1 * bit(1), -3.0 + 0.4 * bit(2))
            })
            .collect();
        let camera = Camera::fitted(&points, Vec3::new(-1.0, -0.8, -0.6), 0.6, 1.5, 0.05);
        let mut fullest: f64 = 0.0;
        for p in &points {
            let ([x, y], _) = camera.project(p, 600, 400).expect("in front");
            let (u, v) = ((x / 300.0 - 1.0).abs(), (y / 200.0 - 1.0).abs());
            assert!(u <= 0.951 && v <= 0.951, "{u} {v}");
            fullest = fullest.max(u).max(v);
        }
        assert!(fullest > 0.6, "{fullest}");
    }
}
