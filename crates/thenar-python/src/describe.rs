//! The constant part of a world: names and numbers of bodies, bones and joints.

use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::{Value, json};
use thenar_core::model::Side;
use thenar_scene::build::BuiltHand;
use thenar_scene::session::Session;

/// Names of bodies, and the numbers and names of each hand, as JSON.
pub fn json(session: &Session) -> String {
    let desc = session.world().desc();
    let rigids: Vec<&str> = desc.rigids.iter().map(|rigid| &rigid.name[..]).collect();
    let soft = |(i, soft): (u32, &thenar_core::model::SoftDesc)| {
        json!({
            "name": soft.name,
            "nodes": session.world().node_range(i).len(),
            "vertices": session.world().collision_vertices(i).len(),
        })
    };
    let softs: Vec<Value> = (0..).zip(&desc.softs).map(soft).collect();
    let hands: Vec<Value> = session.hands().iter().map(hand).collect();
    let overlaps: Vec<String> = session.start_overlaps().iter().map(ToString::to_string).collect();
    json!({
        "name": session.name(),
        "rigids": rigids,
        "softs": softs,
        "hands": hands,
        "overlaps": overlaps,
    })
    .to_string()
}

fn hand(hand: &BuiltHand) -> Value {
    let model = &hand.model;
    let bones: Vec<&str> = model.bones.iter().map(|bone| &bone.name[..]).collect();
    let digits: Vec<&str> = model.bones.iter().map(|bone| bone.digit.name()).collect();
    let joints: Vec<&str> = model.joints.iter().map(|joint| &joint.name[..]).collect();
    let angles = hand.angles().map(|angle| {
        angle.map(|a| json!({ "joint": a.joint, "rest": a.rest, "min": a.min, "max": a.max }))
    });
    let side = model.side.map(|side| match side {
        Side::Left => "left",
        Side::Right => "right",
    });
    json!({
        "name": hand.name,
        "side": side,
        "soft": hand.flesh(),
        "first_bone": hand.handle.bones.start,
        "bones": bones,
        "digits": digits,
        "joints": joints,
        "angles": angles,
        "length": model.length,
        "driven": hand.driven,
    })
}

/// Corners of the triangles of a deformable body's surface, rows of three `u32`.
///
/// # Errors
/// There is no such body.
pub fn triangles<'py>(
    py: Python<'py>,
    session: &Session,
    soft: usize,
) -> PyResult<Bound<'py, PyBytes>> {
    let softs = &session.world().desc().softs;
    let soft = softs
        .get(soft)
        .ok_or_else(|| PyIndexError::new_err(format!("there is no deformable body {soft}")))?;
    Ok(PyBytes::new(py, bytemuck::cast_slice(&soft.flesh.collision.triangles)))
}
