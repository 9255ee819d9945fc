//! The figures that come with the program.

use super::{Plan, read_glb_plan, read_mjcf, read_urdf};
use crate::RigError;
use std::path::Path;

const GRIPPER: &str = include_str!("../../assets/figures/gripper.urdf");
const FOREARM: &str = include_str!("../../assets/figures/forearm.xml");
const BODY: &[u8] = include_bytes!("../../assets/figures/body.glb");

/// Names of the figures that come with the program.
pub const SHIPPED: [&str; 3] = ["gripper", "forearm", "body"];

/// The plan of a shipped figure; `None` of any other name. "gripper" (URDF, for 5 mm of flesh) and
/// "forearm" (MJCF, for 4 mm) are bones; "body" is a skinned mesh.
///
/// # Errors
/// None that a caller could cause: the files are a part of the program.
pub fn shipped_plan(name: &str) -> Option<Result<Plan, RigError>> {
    let here = Path::new("");
    match name {
        "gripper" => Some(read_urdf(GRIPPER, here)),
        "forearm" => Some(read_mjcf(FOREARM, here)),
        "body" => Some(read_glb_plan(BODY)),
        _ => None,
    }
}
