//! Report on a built figure.

use super::mimic::Mimic;
use super::plan::Plan;
use super::skin::Skin;
use thenar_core::Vec3;
use thenar_core::model::{HandModel, JointKind};

/// A built figure in numbers.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct FigureReport {
    /// Number of bones.
    pub bones: usize,
    /// Name, kind and parent bone of each joint.
    pub joints: Vec<(String, JointKind, String)>,
    /// Joints that follow others.
    pub mimics: Vec<Mimic>,
    /// Smallest and largest coordinates of its surface in M \[m\].
    pub bounds: [Vec3; 2],
    /// Mass of bones and of flesh \[kg\].
    pub masses: [f64; 2],
    /// Nodes and tetrahedra of the flesh.
    pub elements: [usize; 2],
    /// Holes of the skin that were closed.
    pub holes: usize,
    /// Separate pieces of the skin that were left out.
    pub left_out: usize,
    /// Mean part of a node's weights in the file on bones other than the two that it follows.
    pub lost_weight: f64,
    /// Notes on what was changed or passed over in the file.
    pub notes: Vec<String>,
}

impl FigureReport {
    pub(super) fn new(plan: &Plan, figure: &HandModel, skin: &Skin, lost_weight: f64) -> Self {
        let joint = |j: &thenar_core::model::JointDesc| {
            let parent =
                j.parent.map_or_else(String::new, |p| figure.bones[p as usize].name.clone());
            (j.name.clone(), j.kind, parent)
        };
        let flesh = &figure.flesh;
        let volume =
            |t: &[u32; 4]| crate::lattice::tet::volume(&t.map(|n| flesh.nodes[n as usize]));
        let of_flesh = flesh.tets.iter().zip(&flesh.materials).map(|(t, m)| volume(t) * m.density);
        Self {
            bones: figure.bones.len(),
            joints: figure.joints.iter().map(joint).collect(),
            mimics: Vec::new(),
            bounds: skin.mesh.bounds(),
            masses: [figure.bones.iter().map(|b| b.mass).sum(), of_flesh.sum()],
            elements: [flesh.nodes.len(), flesh.tets.len()],
            holes: skin.holes.len(),
            left_out: skin.left_out,
            lost_weight,
            notes: plan.notes.clone(),
        }
    }
}
