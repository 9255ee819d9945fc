//! The surface of a figure's body: its file's skin made whole, what several skins enclose together,
//! or flesh laid around its bones.

use super::around::around;
use super::plan::Plan;
use crate::RigError;
use crate::TriMesh;
use crate::embed::check_closed;
use crate::mesh::{Hole, Topology, close_holes, components, weld_near};
use crate::united::{United, largest_piece, united};

/// A body's surface, and what was done to have it.
pub struct Skin {
    /// Closed surface of one piece, its outside out.
    pub mesh: TriMesh,
    /// Holes that were closed.
    pub holes: Vec<Hole>,
    /// Separate pieces that were left out: eyes, clothes, hair.
    pub left_out: usize,
}

/// The skin of a plan, or flesh of `thickness` \[m\] around its bones where it has none.
///
/// # Errors
/// When there is neither skin nor thickness, both, or no closed surface comes of it.
pub fn skin(plan: &Plan, thickness: Option<f64>) -> Result<Skin, RigError> {
    match (&plan.skin, thickness) {
        (Some(skin), None) if skin.joined => {
            let United { mesh, left_out, .. } = united(&skin.mesh)?;
            Ok(Skin { mesh, holes: Vec::new(), left_out })
        }
        (Some(skin), None) => whole(&skin.mesh),
        (None, Some(thickness)) => laid(plan, thickness),
        (None, None) => Err(RigError::invalid(
            "the file has bones and no skin: say how thick the flesh around them is [m] \
             (`--flesh`, in scenes `flesh`)",
        )),
        (Some(_), Some(_)) => Err(RigError::invalid(
            "the file has a skin of its own: leave the thickness of flesh around bones out",
        )),
    }
}

fn laid(plan: &Plan, thickness: f64) -> Result<Skin, RigError> {
    let solids: Vec<_> = plan.bones.iter().flat_map(|bone| bone.solids.iter().cloned()).collect();
    let mesh = around(&solids, thickness)?;
    let parts = Topology::of(&mesh).components;
    if parts != 1 {
        return Err(RigError::invalid(format!(
            "flesh of {thickness} m around the bones falls into {parts} pieces: ask for thicker flesh, or \
             give bones geometry up to their joints"
        )));
    }
    check_closed("the flesh around the bones", &mesh)?;
    Ok(Skin { mesh, holes: Vec::new(), left_out: 0 })
}

fn whole(mesh: &TriMesh) -> Result<Skin, RigError> {
    mesh.check()?;
    let welded = weld_near(mesh);
    let (of_vertex, count) = components(&welded);
    let mut body = largest_piece(&welded, &of_vertex, count);
    if body.triangles.is_empty() {
        return Err(RigError::invalid("all triangles of the skin are without extent"));
    }
    body.orient()?;
    let (mut body, holes) = close_holes(&body);
    body.orient()?;
    check_closed("the skin", &body)?;
    Ok(Skin { mesh: body, holes, left_out: count.saturating_sub(1) })
}
