//! Description of a scene as plain data: bodies, joints, flesh, bindings, surfaces.
//!
//! These descriptions are checked and compiled into a `Model` before a simulation runs.

mod flesh;
mod friction;
mod hand;
mod joint;
mod patches;
mod pose_offsets;
mod relaxation;
mod rigid;
mod skin;
mod surface;

pub use flesh::{Binding, FixedNode, Flesh, Law, Material, OGDEN_ALPHA, Skinning};
pub use friction::{BodyParts, FrictionTable};
pub use hand::{Bone, BoneNode, BoneSolid, CouplingKind, Digit, HandModel, HandRegion, Side};
pub use joint::{AngleLimit, Axis, JointDesc, JointKind};
pub use patches::{ElementPatches, PATCH_TETS_MAX, patches};
pub use pose_offsets::PoseOffsets;
pub use relaxation::{Relaxation, RelaxationError, TERMS_MAX, Term};
pub use rigid::{Motion, RigidDesc};
pub use skin::{Facet, Sheet, Skin, facets};
pub use surface::{EmbeddedSurface, SurfaceVertex};
mod world;

pub use world::{
    BodyId, Cone, Coupling, Drive, FleshInStep1, HandHandle, HandPlacement, JointLimits, PairRule,
    SoftDesc, SolverKind, SolverSettings, Springs, WorldDesc,
};
