//! Figures: flesh on any tree of bones.

use super::{
    BonesWord, ElementsWord, HandMaterial, InterpolationWord, JointWord, MeshNames, Rotation,
    SkinningWord,
};
use crate::math::Vec3;
use crate::text::{Cx, Defs, Fault, Located, Node, Read, Value, table, words};
use serde_json::json;
use std::collections::BTreeMap;
use thenar_core::model::Coupling;

words! {
    /// Source of the motion of a figure's root.
    pub enum RootWord {
        /// Physics alone.
        "free" => Free,
        /// Nothing: it stays where it starts.
        "fixed" => Fixed,
        /// The figure's keys: it is where they say.
        "scripted" => Scripted,
    }
}

/// Angles of a joint [degrees]: a number, or an array of as many as it has.
#[derive(Clone, Debug, PartialEq)]
pub struct AnglesDeg(pub Vec<f64>);

impl Read for AnglesDeg {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        match &node.value {
            Value::Array(_) => Vec::read(node, cx).map(Self),
            _ => f64::read(node, cx).map(|angle| Self(vec![angle])),
        }
    }

    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> serde_json::Value {
        json!({ "oneOf": [f64::schema(defs, cx), Vec::<f64>::schema(defs, cx)] })
    }
}

table! {
    /// One instant of a figure's motion. Joints that it does not name are interpolated from the
    /// keys around.
    pub struct FigureKey {
        /// Time [s]; later than the key before.
        time: f64 where DURATION;
        /// Position of the model's frame, world [m], where the root is scripted; left out, that of
        /// the key before.
        position: Option<Vec3> where PLACE;
        /// Rotation of the model's frame, where the root is scripted; left out, that of the key
        /// before.
        rotation: Option<Located<Rotation>>;
        /// Angles of joints [degrees] by name; a `*` at its end stands for any ending, and whole
        /// names count more. 0 is the rest pose. A hinge has one angle, a universal joint two, a
        /// ball the three components of its rotation vector in the parent's joint frame.
        joints: BTreeMap<String, Located<AnglesDeg>> where ANGLE;
    }
}

table! {
    /// Changes to joints of a figure, and their motors. Of several that fit a joint, the last one
    /// that gives a value gives it.
    pub struct FigureJoint {
        /// Name of the joint, or of the bone that it carries, without the figure's; a `*` at its
        /// end stands for any ending.
        name: Located<String>;
        /// Another kind: "hinge" with one of `axes`, "universal" with two, "ball" or "fixed". All
        /// joints of a skinned mesh are balls. Only for figures that are built here.
        kind: Option<Located<JointWord>>;
        /// Axes in the model's frame: of a hinge one; of a universal joint the parent's and the
        /// child's, at right angles.
        axes: Vec<Vec3> where PLACE;
        /// Smallest and largest value of each angle [degrees]; 0, the rest pose, lies between.
        range_deg: Vec<[f64; 2]> where HALF_TURN_DEG;
        /// Spring of each angle [N m/rad], of a ball one, relaxed in the rest pose: the stiffness
        /// of the joint's motor.
        stiffness: Vec<f64> where SPRING;
        /// Damper of each angle [N m s/rad], of a ball one.
        damping: Vec<f64> where SPRING;
        /// Largest torque of the motor, spring and damper, about an axis [N m]. Default: any.
        torque_max: Option<f64> where POSITIVE;
    }
}

table! {
    /// A file of changes to the joints of a figure, for building models.
    pub struct FigureJointsFile {
        /// Changes, one after the other.
        joint: Vec<FigureJoint>;
    }
}

table! {
    /// Flesh on any tree of bones: a gripper, an arm, a whole body. Its bones are rigid bodies
    /// named `figure/bone`, its joints `figure/joint`, where `figure` is its name, which stands for
    /// its flesh.
    pub struct Figure {
        /// Name, unique in the scene.
        name: Located<String>;
        /// "gripper", "forearm" or "body", which come with the program, or a path, relative to the
        /// scene file: a skinned mesh (GLB, VRM), a robot's description (URDF; MJCF in `.xml` or
        /// `.mjcf`), or a figure that was built (`.thenar`).
        model: Located<String>;
        /// Name of the skinned mesh of a `.glb` or `.vrm` file that is the body, or names of
        /// several, such as body, shoes and gloves: what they enclose together is the body then.
        /// Default: the mesh that encloses most.
        mesh: Option<Located<MeshNames>>;
        /// Thickness of the flesh around the bones [m], of URDF and MJCF: 5 mm is meant for
        /// "gripper", 4 mm for "forearm". A skinned mesh has a skin of its own.
        flesh: Option<Located<f64>> where THICKNESS;
        /// Factor on all lengths of the file. Default 1.
        scale: Option<Located<f64>> where SCALE;
        /// Tetrahedra wanted. Default 1000.
        tets: Option<Located<u32>> where TETS;
        /// Start position of the model's frame, world [m]. Default [0, 0, 0].
        position: Vec3 where PLACE = Vec3::zeros();
        /// Start rotation. Default none.
        rotation: Option<Located<Rotation>>;
        /// "free", "fixed", or "scripted": where the keys say. Default "free".
        root: RootWord = RootWord::Free;
        /// Changes to joints, and motors.
        joint: Vec<Located<FigureJoint>>;
        /// The motion that the motors of the joints follow, and a scripted root. Joints that no key
        /// names are held in the rest pose by their springs. The figure starts as at time 0.
        key: Vec<Located<FigureKey>>;
        /// Between keys: "smooth" (minimum jerk) or "linear". Default "smooth".
        interpolation: InterpolationWord = InterpolationWord::Smooth;
        /// Changes to the flesh.
        material: Option<HandMaterial>;
        /// Spring between flesh and bones, per volume of bone [N/m⁴]. Default 140 E/r², E the
        /// largest Young's modulus of the flesh and r the radius of the slimmest bone.
        coupling_stiffness: Option<f64> where SPRING;
        /// Damping time of these springs [s]. Default 0.001.
        coupling_damping_time: f64 where SPRING = Coupling::DAMPING_TIME;
        /// Placement of the flesh between two bones: "joint", rotations blended about the joint, or
        /// "lbs", linear blend skinning. Default "joint".
        skinning: SkinningWord = SkinningWord::Joint;
        /// "patches": tetrahedra around one long edge share one evaluation of their law;
        /// "tetrahedra": each by itself. Default "patches".
        elements: ElementsWord = ElementsWord::Patches;
        /// Coulomb friction coefficient of the skin; left out, the model's.
        friction: Option<f64> where FRICTION;
        /// "solid": where flesh is crushed, other bodies touch the bones; "none": only flesh
        /// touches. Default "solid".
        bones: BonesWord = BonesWord::Solid;
        /// True: its surface touches itself, where bones that are not joined carry it. Default
        /// false.
        self_contact: bool = false;
        /// Colour in pictures: red, green, blue from 0 to 1.
        colour: Option<[f64; 3]> where FRACTION;
    }
}
