//! Checks of offsets by pose.

use super::{EXTENT_MAX, count, index, number};
use crate::model::{PoseOffsets, WorldDesc};
use crate::world::ModelError;

/// Most poses of a joint, a grid of ten by ten: each takes 72 bytes of every node.
const POSES_MAX: f64 = 100.0;

/// Returns the first fault found.
pub fn check(given: &PoseOffsets, desc: &WorldDesc) -> Result<(), ModelError> {
    index("pose offsets", "deformable body", u64::from(given.soft), desc.softs.len())?;
    let soft = &desc.softs[given.soft as usize];
    let name = &soft.name;
    index(name, "joint of pose offsets", u64::from(given.joint), desc.joints.len())?;
    let poses = given.poses.len();
    number(name, "number of poses", "from 1 to 100", poses as f64, |n| {
        (1.0..=POSES_MAX).contains(&n)
    })?;
    count(name, "pose offsets", given.nodes.len() * poses, given.offsets.len())?;
    for node in &given.nodes {
        index(name, "node of pose offsets", u64::from(*node), soft.flesh.nodes.len())?;
    }
    let mut nodes: Vec<u32> = all_nodes(given, desc).collect();
    let times = nodes.len();
    nodes.sort_unstable();
    nodes.dedup();
    count(name, "nodes with pose offsets, each named once,", nodes.len(), times)?;
    for pose in &given.poses {
        number(name, "length of a pose's quaternion", "1", pose.norm(), |n| {
            (n - 1.0).abs() < 1e-6
        })?;
    }
    for x in given.offsets.iter().flat_map(|offset| offset.iter()) {
        number(name, "pose offset", "within 1e4 m", *x, |x| x.abs() <= EXTENT_MAX)?;
    }
    Ok(())
}

/// Nodes of all offsets of the same body.
fn all_nodes<'a>(given: &PoseOffsets, desc: &'a WorldDesc) -> impl Iterator<Item = u32> + 'a {
    let soft = given.soft;
    let of_body = desc.pose_offsets.iter().filter(move |other| other.soft == soft);
    of_body.flat_map(|other| other.nodes.iter().copied())
}
