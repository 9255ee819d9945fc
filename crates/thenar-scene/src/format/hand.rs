//! Hands.

use super::{
    DriveTable, ElementsWord, GripTable, HandLayer, HandTissueWord, JointName, LawWord, MeshNames,
    MotionTable, NailTable, Rotation, SkinTable, Terms, TissueWord,
};
use crate::math::Vec3;
use crate::text::{Located, table, words};
use std::collections::BTreeMap;
use thenar_core::model::Coupling;

table! {
    /// Changes to the flesh of a hand; what is left out stays as the model has it.
    pub struct HandMaterial {
        /// "epidermis", "dermis", "subcutis", "pulp" or "tendon": law, modulus and Poisson's ratio,
        /// on which the keys below act.
        tissue: Option<Located<TissueWord>>;
        /// "corotational", "neo-hookean", "stable-neo-hookean" or "ogden".
        law: Option<Located<LawWord>>;
        /// Exponent of Ogden's law, which it needs; pulp and skin have 6 to 11.
        alpha: Option<Located<f64>> where OGDEN;
        /// Young's modulus [Pa].
        young: Option<f64> where YOUNG;
        /// Poisson's ratio.
        poisson: Option<f64> where POISSON;
        /// Density [kg/m³].
        density: Option<f64> where DENSITY;
        /// Rayleigh damping: part of the mass matrix [1/s].
        mass_damping: Option<f64> where SPRING;
        /// Memory: [part, time in s] of up to 4 exponentials by which the stress of a held strain
        /// fades; parts sum to less than 1. Moduli are those at once. It stands in the place of
        /// `stiffness_damping`.
        relaxation: Option<Located<Terms>> where POSITIVE;
        /// Rayleigh damping: part of the stiffness matrix [s].
        stiffness_damping: Option<f64> where SPRING;
    }
}

words! {
    /// Response of bones when the flesh around them is crushed.
    pub enum BonesWord {
        /// Bones stop other bodies, as solids inside the flesh.
        "solid" => Solid,
        /// Nothing: only flesh touches.
        "none" => None,
    }
}

words! {
    /// Meshes and couplings that go together.
    pub enum PresetWord {
        /// The paper's: 600 tetrahedra of one size, 1441 triangles that touch, springs on all
        /// flesh.
        "paper" => Paper,
        /// For touch, the usual one: `detail` 0.6, flesh that hangs on bone and is loose at the
        /// roots of the digits, joints as stiff as people's.
        "touch" => Touch,
    }
}

words! {
    /// Flesh that the springs to the bones hold.
    pub enum CouplingWord {
        /// All flesh, skin and pads included.
        "uniform" => Uniform,
        /// Flesh in the place of bone.
        "bone" => Bone,
    }
}

words! {
    /// Placement of the flesh that two bones both carry.
    pub enum SkinningWord {
        /// Linear blend skinning (Eq. 6): places are blended by weight.
        "lbs" => Lbs,
        /// Rotations are blended by weight, about the joint between the bones.
        "joint" => Joint,
    }
}

words! {
    /// Source of the springs of a hand's joints.
    pub enum SpringsWord {
        /// From a table, whatever the bent flesh adds.
        "fixed" => Fixed,
        /// Stiffness of people's joints, less that of the bent flesh.
        "rest" => Rest,
    }
}

table! {
    /// Settings of one axis of a hand's joint; what is left out stays as the model has it.
    pub struct HandAxis {
        /// Smallest and largest angle [degrees]; the angle of the model's rest pose lies between.
        /// No more than half a turn to either side.
        range_deg: Option<Located<[f64; 2]>> where HALF_TURN_DEG;
        /// Spring [N m/rad], beside the bent flesh, which has a stiffness of its own.
        stiffness: Option<f64> where SPRING;
        /// Damper [N m s/rad], beside the bent flesh.
        damping: Option<f64> where SPRING;
        /// Angle at which the spring is relaxed [degrees]; flesh is relaxed in the model's rest
        /// pose.
        rest_deg: Option<f64> where HALF_TURN_DEG;
    }
}

table! {
    /// Changes to joints of a hand. Of several that fit a joint, the last one that gives a value
    /// gives it.
    pub struct HandJoint {
        /// Name of the joint, or of the bone that it carries, without the hand's; a `*` at the end
        /// stands for any ending.
        name: Located<JointName>;
        /// Flexion: 0 is the straight digit, more closes the hand.
        flexion: Option<HandAxis>;
        /// Abduction, of knuckles and the thumb's carpal joint: 0 is the model's rest pose, more
        /// leads to the thumb's side.
        abduction: Option<Located<HandAxis>>;
    }
}

table! {
    /// A file of changes to the joints of a hand, for building models.
    pub struct HandJointsFile {
        /// Changes, one after the other.
        joint: Vec<HandJoint>;
    }
}

table! {
    /// A hand: 16 bones in soft flesh, following a motion. Its bones are rigid bodies named
    /// `hand/bone` and its joints `hand/joint`, where `hand` is its name.
    pub struct Hand {
        /// Name, unique in the scene.
        name: Located<String>;
        /// "right" or "left" for the built-in hands, or the path of a `.thenar` or `.glb` file,
        /// relative to the scene file. Default "right".
        model: Option<Located<String>>;
        /// Names of a rig's joints by those of the 25 tracked joints, such as
        /// `index-finger-phalanx-proximal = "bone_12"`, where the names of a `.glb` file do not say
        /// which joint is which; `thenar hand --list FILE.glb` prints such a table.
        joint_names: Option<Located<BTreeMap<String, String>>>;
        /// Name of the skinned mesh of a `.glb` file that is the hand, or names of several, such as
        /// a glove and the skin beside it: what they enclose together is the hand then. Default:
        /// the mesh that encloses most.
        mesh: Option<Located<MeshNames>>;
        /// Source of those values of `tets`, `detail`, `coupling` and `springs` that are not given,
        /// when the model is built from a mesh. Default "touch"; "paper" where the scene says what
        /// is about the paper's hand: `tets`, `coupling = "uniform"`, `coupling_stiffness` without
        /// `coupling`, or a `solver.kind` other than "monolithic".
        preset: Option<PresetWord>;
        /// Tetrahedra wanted, all of one size, when the model is built from a mesh; the springs
        /// hold what `coupling` or `preset` say, else all flesh.
        tets: Option<u32> where TETS;
        /// In the place of `tets`, how fine a graded mesh is. At 1, on a hand of 190 mm, its cubes
        /// measure 4 mm at the pads of the fingers, 8 mm along fingers and knuckles, 16 mm in palm
        /// and back; all are proportional to the hand's length and to 1/detail. The skin that
        /// touches is at least as fine.
        detail: Option<Located<f64>> where DETAIL;
        /// Wrist to middle fingertip [m]; left out, as the mesh has it.
        length: Option<f64> where HAND_LENGTH;
        /// Start position of the model frame, world [m]. Default [0, 0, 0].
        position: Vec3 where PLACE = Vec3::zeros();
        /// Start rotation. Default none.
        rotation: Option<Located<Rotation>>;
        /// "uniform": springs hold all flesh to the bones, skin and pads included, as in the paper;
        /// "bone": they hold the flesh in the place of bone, and what lies between bone and skin is
        /// free. Default: the model's own; the preset's for hands built here.
        coupling: Option<Located<CouplingWord>>;
        /// Spring between flesh and bones [N/m⁴]: per volume of flesh if `coupling` is "uniform",
        /// per volume of bone if it is "bone". Default 2e9 and 2.2e5 E/L², E the largest Young's
        /// modulus of the flesh and L the length of the hand: 3e11 for 50 kPa and 190 mm. Given
        /// without `coupling` and `preset` it is that of "uniform".
        coupling_stiffness: Option<f64> where SPRING;
        /// Damping time of these springs [s]. Default 0.001.
        coupling_damping_time: f64 where SPRING = Coupling::DAMPING_TIME;
        /// Placement of the flesh between two bones: "lbs", linear blend skinning as in the paper,
        /// which narrows in a twist and thins in a bend; "joint", rotations blended about the
        /// joint, which does neither. Default "lbs".
        skinning: SkinningWord = SkinningWord::Lbs;
        /// True adds offsets by the pose of each joint to the places that `skinning` gives,
        /// measured on the hand's own flesh, bent around bones that hold it at the bone alone.
        /// Needs `coupling = "uniform"`; takes a second or more when the scene is opened first.
        /// Default false.
        pose_offsets: bool = false;
        /// "tetrahedra": each by itself, as in the paper; "patches": those around one long edge
        /// share one evaluation of their law, so that flesh bends and bulges as refined meshes do.
        /// Default: patches where flesh hangs on bone, tetrahedra where the coupling is uniform.
        elements: Option<ElementsWord>;
        /// Changes to the flesh; below layers, the flesh that they leave.
        material: Option<HandMaterial>;
        /// Source of the springs of its joints when the model is built from a mesh: "fixed", a
        /// table, whatever the bent flesh adds; "rest": the stiffness that is measured at people's
        /// joints, less that of the model's flesh. Default: the preset's, "fixed" of "paper" and
        /// "rest" of "touch".
        springs: Option<SpringsWord>;
        /// Changes to its joints.
        joint: Vec<HandJoint>;
        /// "uniform" or "layered": where `layer`, `skin` and `nail` come from that are not given.
        /// Default "uniform": none.
        tissue: Option<Located<HandTissueWord>>;
        /// Layers of flesh by depth under the skin, when the model is built from a mesh.
        layer: Vec<Located<HandLayer>>;
        /// Skin of the hand.
        skin: Option<Located<SkinTable>>;
        /// Nails of the hand.
        nail: Option<Located<NailTable>>;
        /// Coulomb friction coefficient of the skin; left out, the model's.
        friction: Option<f64> where FRICTION;
        /// False leaves the flesh out: a skeleton that touches nothing. Default true.
        flesh: bool = true;
        /// "solid": where flesh is crushed, other bodies touch the bones, which have the friction
        /// of the skin; "none": only flesh touches. Default "solid".
        bones: BonesWord = BonesWord::Solid;
        /// True: fingers and palm touch each other, with their bones where the flesh between is
        /// crushed. Skin on skin has the hand's `friction`, or that of a pair of the hand with
        /// itself. Default true.
        self_contact: bool = true;
        /// The motion to follow. Without one the hand holds its start pose.
        motion: Option<Located<MotionTable>>;
        /// Grips, one after the other; fingers that take part leave the motion meanwhile.
        grip: Vec<Located<GripTable>>;
        /// False lets the hand go: no drives, whatever the motion. Default true.
        driven: bool = true;
        /// False leaves the hand to its drives alone. True adds torques about the joints that
        /// balance flesh and springs at the targets, as a person's muscles do. Default true; of the
        /// preset "paper", and of a hand with `grip`, false. None where no drive pulls its bones,
        /// and none while the haptic loop leads it.
        muscles: Option<bool>;
        /// Drive of the palm. Default: 1000 N/m, 10 N s/m, 10 N m/rad, 0.1 N m s/rad.
        palm_drive: Option<DriveTable>;
        /// Drive of every other bone. Default: 200 N/m, 1 N s/m, 0.3 N m/rad, 0.003 N m s/rad.
        bone_drive: Option<DriveTable>;
        /// Colour in pictures: red, green, blue from 0 to 1.
        colour: Option<[f64; 3]> where FRACTION;
    }
}
