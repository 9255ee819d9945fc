//! Joints.

use super::{Placement, Rotation};
use crate::math::Vec3;
use crate::text::{Located, table, words};

words! {
    /// The relative motion a joint leaves free.
    pub enum JointWord {
        /// No freedom: the child is held.
        "fixed" => Fixed,
        /// A turn about one axis.
        "hinge" => Hinge,
        /// A turn about an axis of the parent, then about an axis of the child.
        "universal" => Universal,
        /// All turns about a point.
        "ball" => Ball,
        /// All; only springs act.
        "free" => Free,
    }
}

table! {
    /// A joint. Its place is given either in the world, for zero angles, with the bodies at
    /// their start poses (`anchor`, `axis`, `axes`), or by a frame in each body
    /// (`parent_frame`, `child_frame`); then a hinge turns about x, a universal joint about the
    /// parent's y and then the child's x, and the child is placed by the joint. Initial angles
    /// and rates move the child and all that hangs on it.
    pub struct Joint {
        /// Name, unique in the scene.
        name: Located<String>;
        /// "hinge", "universal", "ball", "fixed" or "free".
        kind: JointWord;
        /// Parent body. Default: the world.
        parent: Option<Located<String>>;
        /// Child body.
        child: Located<String>;
        /// The joint's point, world [m], at zero angles.
        anchor: Option<Vec3> where PLACE;
        /// Hinge axis, world, at zero angles.
        axis: Option<Located<Vec3>> where PLACE;
        /// Axes of a universal joint, world, at zero angles: first the parent's, then the
        /// child's; at right angles to each other.
        axes: Option<Located<[Vec3; 2]>> where PLACE;
        /// Joint frame in the parent's frame, or in the world.
        parent_frame: Option<Placement>;
        /// Joint frame in the child's frame.
        child_frame: Option<Placement>;
        /// Start angles [rad]: one of a hinge, two of a universal joint. Default zero.
        angles: Located<Vec<f64>> where ANGLE = Located::none();
        /// Start rates of the angles [rad/s]. Default zero.
        rates: Located<Vec<f64>> where RATE = Located::none();
        /// Start rotation of a ball joint.
        rotation: Option<Located<Rotation>>;
        /// Start angular velocity of a ball joint's child against its parent, in the parent's
        /// joint frame [rad/s].
        angular_velocity: Option<Located<Vec3>> where RATE;
        /// Smallest and largest value of each angle [rad].
        limits: Located<Vec<[f64; 2]>> where ANGLE = Located::none();
        /// Spring of each angle [N m/rad]; of a ball joint one value. Default zero.
        stiffness: Located<Vec<f64>> where SPRING = Located::none();
        /// Angles at which the springs are relaxed [rad]. Default zero. An axis without limits is
        /// held by its spring the shorter way round, whole turns apart alike; one with limits as
        /// far as the angle says.
        rest_angles: Located<Vec<f64>> where ANGLE = Located::none();
        /// Damper of each angle [N m s/rad]. Default zero.
        damping: Located<Vec<f64>> where SPRING = Located::none();
        /// Spring past a limit [N m/rad], where limits are springs (`solver.limits`). Default 10.
        limit_stiffness: f64 where SPRING = 10.0;
        /// Damper past a limit [N m s/rad], likewise. Default 0.01.
        limit_damping: f64 where SPRING = 0.01;
    }
}
