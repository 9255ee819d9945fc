//! The tables of a scene file. Each is declared once; reader, schema and the reference in
//! `docs/scene.md` follow from the declaration.

#![allow(rustdoc::broken_intra_doc_links)] // units stand in brackets, as in the schema

mod camera;
mod figure;
mod files;
mod friction;
mod grip;
mod hand;
mod joint;
mod joint_names;
mod load;
mod mesh_names;
mod motion;
mod pose;
mod probe;
mod profile;
mod rigid;
mod scene;
mod selector;
mod soft;
mod solver;
mod tissue;

pub use camera::Camera;
pub use figure::{AnglesDeg, Figure, FigureJoint, FigureJointsFile, FigureKey, RootWord};
pub use friction::{PairFriction, SkinOnWord};
pub use grip::{GripTable, GripWord};
pub use hand::{
    BonesWord, CouplingWord, Hand, HandAxis, HandJoint, HandJointsFile, HandMaterial, PresetWord,
    SkinningWord, SpringsWord,
};
pub use joint::{Joint, JointWord};
pub use joint_names::{JointName, NamedJoints};
pub use load::{
    ForceLoad, JointTorqueLoad, Load, NodeForceLoad, PressureLoad, TorqueLoad, TractionLoad,
    TwistLoad,
};
pub use mesh_names::MeshNames;
pub use motion::{
    CurlTable, HandKey, JointAngles, KeyframesTable, LimitsWord, MotionFileTable, MotionTable,
    PoseWord, RecordedTable, SideOfHandWord, TipsTable, WristTable,
};
pub use pose::{DriveTable, InterpolationWord, Keyframe, Placement, Rotation};
pub use probe::{
    ContactProbe, DigitWord, FingerProbe, JointProbe, NodesProbe, PointProbe, Probe, ProbeBody,
    ProbeHand, ProbeMomentum, ProbeName, QuantityWord, RadiusProbe, StressProbe, StressWord,
    VertexWord, VerticesProbe,
};
pub use profile::{Constant, KeyframeProfile, Profile, RampProfile, RandomProfile, SineProfile};
pub use rigid::{
    BoxShape, CapsuleShape, CarShape, CompoundPart, CompoundShape, ConeShape, CylinderShape,
    EllipsoidShape, MeshShape, MotionWord, PlaneShape, Rigid, Shape, SphereShape,
};
pub use scene::{Pair, Scene};
pub use selector::{Selector, Shell, SideWord};
pub use soft::{
    BallShape, Bind, BreadShape, Deform, ElementsWord, ExplicitShape, FileShape, FixedSet,
    LatticeShape, LawWord, MaterialTable, MeshSoftShape, Region, Soft, SoftShape, SplitWord, Terms,
};
pub use solver::{ConeWord, FleshWord, JointLimitsWord, MONOLITHIC_ONCE, SolverTable, SolverWord};
pub use tissue::{HandLayer, HandRegionWord, HandTissueWord, NailTable, SkinTable, TissueWord};
