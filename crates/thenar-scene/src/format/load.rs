//! Loads.

use super::{Profile, Selector};
use crate::math::Vec3;
use crate::text::{Located, choice, table};

table! {
    /// A force on a rigid body.
    pub struct ForceLoad {
        /// Name of the body; a bone is `hand/bone`.
        body: Located<String>;
        /// Force, world [N].
        force: Vec3 where LOAD;
        /// Point where it acts, in the body's frame [m]. Default: the centre of mass.
        point: Vec3 where PLACE = Vec3::zeros();
        /// Over time. Default constant.
        profile: Option<Profile>;
    }
}

table! {
    /// A torque on a rigid body.
    pub struct TorqueLoad {
        /// Name of the body; a bone is `hand/bone`.
        body: Located<String>;
        /// Torque, world [N m].
        torque: Vec3 where LOAD;
        /// Over time. Default constant.
        profile: Option<Profile>;
    }
}

table! {
    /// A torque about the axes of joints, on the child and opposite on the parent.
    pub struct JointTorqueLoad {
        /// Names of joints; a `*` at the end stands for any ending.
        joints: Located<Vec<String>>;
        /// Torque about each axis [N m].
        torque: f64 where LOAD;
        /// Over time. Default constant.
        profile: Option<Profile>;
    }
}

table! {
    /// One force on each of some nodes.
    pub struct NodeForceLoad {
        /// The soft body or hand.
        body: Located<String>;
        /// Nodes that the force acts on.
        nodes: Located<Selector>;
        /// Force on each node, world [N].
        force: Vec3 where LOAD;
        /// Over time. Default constant.
        profile: Option<Profile>;
    }
}

table! {
    /// A uniform traction on a part of the boundary at rest, a third of each face's share on
    /// each of its nodes. It keeps its direction. Give `total` or `traction`.
    pub struct TractionLoad {
        /// The soft body or hand.
        body: Located<String>;
        /// Boundary faces that are pulled.
        faces: Located<Selector>;
        /// Total force, world [N].
        total: Option<Vec3> where LOAD;
        /// Traction, world [Pa].
        traction: Option<Vec3> where LOAD;
        /// Over time. Default constant.
        profile: Option<Profile>;
    }
}

table! {
    /// A pressure on a part of the boundary; it follows the faces as they turn and stretch.
    pub struct PressureLoad {
        /// The soft body or hand.
        body: Located<String>;
        /// Boundary faces that are pressed.
        faces: Located<Selector>;
        /// Pressure [Pa], positive inwards.
        pressure: f64 where LOAD;
        /// Over time. Default constant.
        profile: Option<Profile>;
    }
}

table! {
    /// Tractions at right angles to an axis and to the distance from it, growing with that
    /// distance, on a part of the boundary at rest: a pure torque. They keep their direction.
    pub struct TwistLoad {
        /// The soft body or hand.
        body: Located<String>;
        /// Boundary faces that are twisted.
        faces: Located<Selector>;
        /// Total torque, world [N m]; its direction is the axis, which goes through the centre
        /// of the faces.
        torque: Vec3 where LOAD;
        /// Over time. Default constant.
        profile: Option<Profile>;
    }
}

choice! {
    /// Load that acts from outside.
    pub enum Load by "kind" {
        /// A force on a rigid body.
        "force" => Force(ForceLoad),
        /// A torque on a rigid body.
        "torque" => Torque(TorqueLoad),
        /// Torques about joint axes.
        "joint-torque" => JointTorque(JointTorqueLoad),
        /// Forces on nodes.
        "node-force" => NodeForce(NodeForceLoad),
        /// A traction on boundary faces.
        "traction" => Traction(TractionLoad),
        /// A pressure on boundary faces.
        "pressure" => Pressure(PressureLoad),
        /// A torque spread over boundary faces.
        "twist" => Twist(TwistLoad),
    }
}
