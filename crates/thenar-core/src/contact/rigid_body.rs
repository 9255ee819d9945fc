//! A rigid body as contact sees it: a shape, and where it is in this step.

use crate::contact::aabb::Aabb;
use crate::contact::sharp::Sharp;
use crate::contact::{RigidPlace, Shape};
use crate::math::{Mat3, Pose, Vec3};
use crate::model::{Motion, RigidDesc};

/// The constant part.
#[derive(Clone, Debug)]
pub(crate) struct RigidBody {
    pub shape: Shape,
    pub pose_BS: Pose,
    pub dynamic: bool,
    pub friction: f64,
    /// Features that soft surfaces meet between their vertices.
    pub sharp: Sharp,
    /// Box around the shape, in S; unbounded for a half-space.
    pub bounds_S: Aabb,
    /// Largest distance of the shape from the centre of mass \[m\]; zero for a half-space.
    pub radius: f64,
    /// Least side of the boxes around its pieces, in their frames, of those that are not flat
    /// \[m\]; unbounded for a half-space.
    pub thickness: f64,
    /// The parts of a compound, or the shape itself.
    pub pieces: Vec<Piece>,
}

/// A shape that is no compound, in the shape frame of its body.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub shape: Shape,
    pub rotation: Mat3,
    pub position: Vec3,
    /// Box around it, in its own frame.
    pub bounds: Aabb,
}

impl Piece {
    fn all_of(shape: &Shape) -> Vec<Self> {
        let piece = |shape: &Shape, pose: &Pose| Self {
            bounds: bounds(shape),
            shape: shape.clone(),
            rotation: pose.rotation.to_rotation_matrix().into_inner(),
            position: pose.position,
        };
        match shape {
            Shape::Compound(parts) => parts.iter().map(|p| piece(&p.shape, &p.pose_SP)).collect(),
            _ => vec![piece(shape, &Pose::identity())],
        }
    }
}

impl RigidBody {
    /// `None` when the body has no shape. Sharp edges are tried at least every `spacing` \[m\].
    pub fn new(desc: &RigidDesc, spacing: f64) -> Option<Self> {
        let shape = desc.shape.clone()?;
        let bounds_S = bounds(&shape);
        let radius = match shape {
            Shape::HalfSpace => 0.0,
            _ => desc.pose_BS.point(&bounds_S.center()).norm() + bounds_S.half().norm(),
        };
        let pieces = Piece::all_of(&shape);
        Some(Self {
            thickness: pieces
                .iter()
                .map(|p| 2.0 * p.bounds.half().min())
                .filter(|thickness| *thickness > 0.0)
                .fold(f64::INFINITY, f64::min),
            sharp: Sharp::of(&shape, spacing),
            pose_BS: desc.pose_BS,
            dynamic: desc.motion == Motion::Dynamic,
            friction: desc.friction,
            pieces,
            bounds_S,
            radius,
            shape,
        })
    }

    /// Places the shape in the world for a step of length `h`.
    pub fn place(&self, at: &RigidPlace, h: f64) -> Placed {
        let pose_WS = at.pose_WB * self.pose_BS;
        let rotation = pose_WS.rotation.to_rotation_matrix().into_inner();
        let travel = h * at.velocity_W;
        let turn = h * at.angular_velocity_W.norm() * self.radius;
        let swept_W = match self.shape {
            Shape::HalfSpace => Aabb::EVERYTHING,
            _ => {
                let now = self.bounds_S.moved(&rotation, &pose_WS.position);
                now.union(&now.translate(&travel)).inflate(turn)
            }
        };
        Placed {
            rotation,
            origin: pose_WS.position,
            center_of_mass: at.pose_WB.position,
            velocity: at.velocity_W,
            angular_velocity: at.angular_velocity_W,
            turn,
            swept_W,
            end_W: swept_W,
        }
    }
}

/// Box around a shape, in its frame.
fn bounds(shape: &Shape) -> Aabb {
    match shape {
        Shape::Sphere { radius } => Aabb::symmetric(Vec3::repeat(*radius)),
        Shape::Capsule { radius, half_length } => {
            Aabb::symmetric(Vec3::new(*radius, radius + half_length, *radius))
        }
        Shape::Cuboid { half } => Aabb::symmetric(*half),
        Shape::HalfSpace => {
            let mut all = Aabb::EVERYTHING;
            all.max.y = 0.0;
            all
        }
        Shape::Mesh(mesh) => Aabb::of_points(&mesh.points).inflate(mesh.index.rounding),
        Shape::Cylinder { radius, half_length } => {
            Aabb::symmetric(Vec3::new(*radius, *half_length, *radius))
        }
        Shape::Ellipsoid { half } => Aabb::symmetric(*half),
        Shape::Cone { radius, height } => Aabb {
            min: Vec3::new(-radius, -0.25 * height, -radius),
            max: Vec3::new(*radius, 0.75 * height, *radius),
        },
        Shape::Compound(parts) => parts.iter().fold(Aabb::EMPTY, |all, part| {
            let rotation = part.pose_SP.rotation.to_rotation_matrix().into_inner();
            all.union(&bounds(&part.shape).moved(&rotation, &part.pose_SP.position))
        }),
    }
}

/// The part that changes each step; all in the world frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed {
    /// From the shape frame to the world.
    pub rotation: Mat3,
    /// Origin of the shape frame.
    pub origin: Vec3,
    pub center_of_mass: Vec3,
    pub velocity: Vec3,
    pub angular_velocity: Vec3,
    /// Upper bound of the distance that rotation carries a point of the shape in this step \[m\].
    pub turn: f64,
    /// Box around the shape during the step.
    pub swept_W: Aabb,
    /// Box around the shape at the end of its way, without the way that led there.
    pub end_W: Aabb,
}

impl Placed {
    pub const NOWHERE: Self = Self {
        rotation: Mat3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        origin: Vec3::new(0.0, 0.0, 0.0),
        center_of_mass: Vec3::new(0.0, 0.0, 0.0),
        velocity: Vec3::new(0.0, 0.0, 0.0),
        angular_velocity: Vec3::new(0.0, 0.0, 0.0),
        turn: 0.0,
        swept_W: Aabb::EMPTY,
        end_W: Aabb::EMPTY,
    };

    /// A point of the shape frame in the world.
    #[inline]
    pub fn world_point(&self, p_S: &Vec3) -> Vec3 {
        self.rotation * p_S + self.origin
    }

    /// A point of the world in the shape frame.
    #[inline]
    pub fn shape_point(&self, p_W: &Vec3) -> Vec3 {
        self.rotation.tr_mul(&(p_W - self.origin))
    }

    /// Velocity of the body at a point of the world.
    #[inline]
    pub fn velocity_at(&self, p_W: &Vec3) -> Vec3 {
        self.velocity + self.angular_velocity.cross(&(p_W - self.center_of_mass))
    }

    /// True when the shape can come within `margin` \[m\] of something inside `swept_W` in a step
    /// of `h` \[s\].
    pub fn may_touch(&self, shape: &Shape, swept_W: &Aabb, margin: f64, h: f64) -> bool {
        if swept_W.is_empty() {
            return false;
        }
        if !matches!(shape, Shape::HalfSpace) {
            return self.swept_W.inflate(margin).overlaps(swept_W);
        }
        // Lowest corner of the box over the plane, less what the plane itself moves.
        let normal = self.rotation.column(1);
        let center = swept_W.center();
        let height = normal.dot(&(center - self.origin)) - normal.abs().dot(&swept_W.half());
        let arm = (center - self.center_of_mass).norm() + swept_W.half().norm();
        let moved = self.velocity.norm() + self.angular_velocity.norm() * arm;
        height <= margin + h * moved
    }
}
