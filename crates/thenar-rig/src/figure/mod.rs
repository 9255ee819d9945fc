//! Figures: flesh on any tree of bones, from skinned meshes (glTF, VRM) and from descriptions of
//! robots (URDF, MJCF).

mod around;
mod bind;
mod build;
mod file;
mod glb;
mod in_solid;
mod joints;
mod link_tree;
pub(crate) mod mimic;
mod mjcf;
mod options;
mod plan;
mod report;
mod shipped;
mod skin;
mod skin_bones;
mod solid;
mod urdf;
mod xml;

pub use build::{build_figure, usual_coupling_stiffness};
pub use file::{build_figure_file, is_figure, read_plan, read_plan_of};
pub use glb::{read_glb_plan, read_glb_plan_of};
pub use joints::{change_joints, change_plan};
pub use mimic::{MIMIC_TERMS, Mimic};
pub use mjcf::read_mjcf;
pub use options::{FigureOptions, JointChange};
pub use plan::{Plan, PlanBone, PlanJoint, PlanMass, PlanSkin, PlanSolid};
pub use report::FigureReport;
pub use shipped::{SHIPPED, shipped_plan};
pub use urdf::read_urdf;
