//! Masses of links.

use super::super::plan::PlanMass;
use std::f64::consts::PI;
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3};

/// Mass, centre and inertia about the centre, in some frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::figure) struct Body {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub centre: Vec3,
    /// Inertia about the centre \[kg m²\], where it is known.
    pub inertia: Option<Mat3>,
}

impl Body {
    /// Takes the body from frame B to frame A.
    pub fn moved(self, pose_AB: &Pose) -> Self {
        let turn = pose_AB.rotation.to_rotation_matrix().into_inner();
        let inertia = self.inertia.map(|inertia| turn * inertia * turn.transpose());
        Self { centre: pose_AB.point(&self.centre), inertia, ..self }
    }

    /// Scales mass and inertia to another mass.
    pub fn with_mass(self, mass: f64) -> Self {
        let inertia = self.inertia.map(|inertia| inertia * (mass / self.mass));
        Self { mass, inertia, ..self }
    }

    /// Both bodies as one, by Steiner's theorem.
    pub fn plus(self, other: Self) -> Self {
        let mass = self.mass + other.mass;
        let centre = (self.centre * self.mass + other.centre * other.mass) / mass;
        let about = |body: &Self| {
            let d = body.centre - centre;
            let shifted = (Mat3::identity() * d.norm_squared() - d * d.transpose()) * body.mass;
            body.inertia.map(|inertia| inertia + shifted)
        };
        let inertia = about(&self).zip(about(&other)).map(|(a, b)| a + b);
        Self { mass, centre, inertia }
    }
}

/// True for a tensor that is finite and positive definite.
pub(in crate::figure) fn is_inertia(tensor: &Mat3) -> bool {
    let size = tensor.amax();
    // Brought to size 1, so that no product of small numbers vanishes.
    let unit = tensor / size;
    size.is_finite() && size > 0.0 && unit.cholesky().is_some()
}

/// The mass of a link and whether the file states it.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::figure) struct LinkMass {
    /// The mass; none is zero.
    pub body: Option<Body>,
    /// True where the file states a mass or a density: otherwise only what is merged with such a
    /// link counts.
    pub stated: bool,
}

impl LinkMass {
    /// The mass in frame A, from frame B.
    pub fn moved(self, pose_AB: &Pose) -> Self {
        Self { body: self.body.map(|body| body.moved(pose_AB)), ..self }
    }

    /// Both masses as one.
    pub fn plus(self, other: Self) -> Self {
        let body = match (self.body, other.body) {
            (Some(a), Some(b)) => Some(a.plus(b)),
            (a, b) => a.or(b),
        };
        Self { body, stated: self.stated || other.stated }
    }

    /// Mass as a plan states it.
    pub fn told(self) -> Option<PlanMass> {
        let body = self.body.filter(|_| self.stated)?;
        // Turning leaves rounding errors.
        let inertia_M = body.inertia.map(|inertia| (inertia + inertia.transpose()) * 0.5);
        Some(PlanMass { mass: body.mass, centre_M: body.centre, inertia_M })
    }
}

/// The body of density 1 that fills a sphere, capsule, box, cylinder or ellipsoid, in the shape's
/// frame; none for another shape.
pub(in crate::figure) fn of_shape(shape: &Shape) -> Option<Body> {
    let (mass, moments) = match *shape {
        Shape::Sphere { radius } => ball(&Vec3::repeat(radius)),
        Shape::Ellipsoid { half } => ball(&half),
        Shape::Cuboid { half } => {
            let mass = 8.0 * half.product();
            (mass, across(&half) * (mass / 3.0))
        }
        Shape::Cylinder { radius, half_length } => rod(radius, half_length),
        Shape::Capsule { radius: r, half_length: h } => {
            // The caps are half balls, whose centres lie 3/8 r beyond the ends.
            let ((rod, by_rod), (caps, by_caps)) = (rod(r, h), ball(&Vec3::repeat(r)));
            let apart = caps * (h * h + 0.75 * r * h);
            (rod + caps, by_rod + by_caps + Vec3::new(apart, 0.0, apart))
        }
        _ => return None,
    };
    Some(Body { mass, centre: Vec3::zeros(), inertia: Some(Mat3::from_diagonal(&moments)) })
}

/// Per axis, the sum of the other two squares.
fn across(half: &Vec3) -> Vec3 {
    let square = half.component_mul(half);
    Vec3::repeat(square.sum()) - square
}

/// Mass and moments of an ellipsoid.
fn ball(half: &Vec3) -> (f64, Vec3) {
    let mass = 4.0 / 3.0 * PI * half.product();
    (mass, across(half) * (mass / 5.0))
}

/// Mass and moments of a cylinder along y.
fn rod(radius: f64, half_length: f64) -> (f64, Vec3) {
    let mass = 2.0 * PI * radius * radius * half_length;
    let along = mass * radius * radius / 2.0;
    let across = along / 2.0 + mass * half_length * half_length / 3.0;
    (mass, Vec3::new(across, along, across))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::{Weight, rigid_box, rigid_capsule, rigid_sphere};
    use thenar_core::Quat;

    #[test]
    fn masses_are_those_of_objects_of_the_same_shape() {
        let weight = Weight::Density(1.0);
        for model in [
            rigid_box(&Vec3::new(0.1, 0.2, 0.3), weight),
            rigid_sphere(0.2, weight),
            rigid_capsule(0.1, 0.4, weight),
        ] {
            let model = model.unwrap();
            let body = of_shape(&model.shape).unwrap();
            assert!((body.mass / model.mass - 1.0).abs() < 1e-12);
            assert!((body.inertia.unwrap() - model.inertia).norm() < 1e-12 * model.inertia.norm());
        }
        assert!(of_shape(&Shape::HalfSpace).is_none());
    }

    /// Two halves of a box make the box, wherever and however they lie.
    #[test]
    fn halves_make_the_whole() {
        let half = |x: f64| {
            let body = of_shape(&Shape::Cuboid { half: Vec3::new(0.1, 0.2, 0.3) }).unwrap();
            body.moved(&Pose::translation(x, 0.0, 0.0))
        };
        let whole = of_shape(&Shape::Cuboid { half: Vec3::new(0.2, 0.2, 0.3) }).unwrap();
        let pose = Pose::new(Vec3::new(1.0, 2.0, 3.0), Quat::from_euler_angles(0.3, 0.4, 0.5));
        let sum = half(-0.1).moved(&pose).plus(half(0.1).moved(&pose));
        let whole = whole.moved(&pose);
        assert!(
            (sum.mass - whole.mass).abs() < 1e-12 && (sum.centre - whole.centre).norm() < 1e-12
        );
        assert!((sum.inertia.unwrap() - whole.inertia.unwrap()).norm() < 1e-12);
    }

    /// Cylinder m (3 r² + h²)/12 and m r²/2, ellipsoid m (b² + c²)/5, by hand for r = 1, h = 2.
    #[test]
    fn round_shapes_have_the_textbook_inertia() {
        let rod = of_shape(&Shape::Cylinder { radius: 1.0, half_length: 1.0 }).unwrap();
        assert!((rod.mass - 2.0 * PI).abs() < 1e-12);
        let expected = Vec3::new(7.0 / 6.0, 1.0, 7.0 / 6.0) * PI;
        assert!((rod.inertia.unwrap().diagonal() - expected).norm() < 1e-12);
        let egg = of_shape(&Shape::Ellipsoid { half: Vec3::new(1.0, 2.0, 3.0) }).unwrap();
        assert!((egg.mass - 8.0 * PI).abs() < 1e-12);
        let expected = Vec3::new(13.0, 10.0, 5.0) * (8.0 * PI / 5.0);
        assert!((egg.inertia.unwrap().diagonal() - expected).norm() < 1e-12);
    }

    #[test]
    fn an_unknown_inertia_stays_unknown_and_an_unstated_mass_untold() {
        let point = Body { mass: 1.0, centre: Vec3::x(), inertia: None };
        let ball = of_shape(&Shape::Sphere { radius: 1.0 }).unwrap();
        assert_eq!(point.plus(ball).inertia, None);
        let unstated = LinkMass { body: Some(ball), stated: false };
        assert!(unstated.told().is_none());
        let stated = LinkMass { body: Some(point), stated: true };
        assert!((unstated.plus(stated).told().unwrap().mass - ball.mass - 1.0).abs() < 1e-12);
    }
}
