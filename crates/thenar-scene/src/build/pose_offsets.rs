//! Offsets of skinning targets by the pose of joints.

use super::{Built, Mesh, hand_cache, place};
use crate::format::{Bind, Hand, Soft};
use crate::text::{Fault, Located};
use std::collections::BTreeMap;
use thenar_core::Quat;
use thenar_core::model::{CouplingKind, HandHandle, HandModel, PoseOffsets, Skinning};

/// Adds the offsets that the binds of soft body number `soft` name. Of several binds of a node the
/// last counts.
pub fn of_binds(built: &mut Built, table: &Soft, mesh: &Mesh, soft: u32) -> Result<(), Fault> {
    if table.bind.iter().all(|bind| bind.pose_offset.is_empty()) {
        return Ok(());
    }
    let mut bind_of: BTreeMap<u32, usize> = BTreeMap::new();
    for (b, bind) in table.bind.iter().enumerate() {
        bind_of.extend(mesh.select_nodes(Some(&bind.nodes))?.into_iter().map(|node| (node, b)));
    }
    for (b, bind) in table.bind.iter().enumerate().filter(|(_, bind)| !bind.pose_offset.is_empty())
    {
        let nodes = bind_of.iter().filter(|(_, of)| **of == b).map(|(node, _)| *node).collect();
        let given = of_bind(built, bind, soft, nodes)?;
        built.world.pose_offsets.push(given);
    }
    Ok(())
}

fn of_bind(built: &Built, bind: &Bind, soft: u32, nodes: Vec<u32>) -> Result<PoseOffsets, Fault> {
    let names = &bind.bones;
    let [a, b] = &names.value[..] else {
        return Err(names.fault("`pose_offset` acts between two bones; expected two"));
    };
    let find = |name: &String| {
        let at =
            Located { value: name.clone(), place: names.place.clone(), key: names.key.clone() };
        built.names.rigid(&at)
    };
    let both = [find(a)?, find(b)?];
    let joint = built.world.joints.iter().position(|joint| {
        joint
            .parent
            .is_some_and(|parent| [[joint.child, parent], [parent, joint.child]].contains(&both))
    });
    let joint = joint.ok_or_else(|| {
        names.fault(format!(
            "`pose_offset` follows the joint between \"{a}\" and \"{b}\", and there is none"
        ))
    })? as u32;
    let rotations = bind.pose_offset.iter().map(|at| place::rotation(Some(&at.value.rotation)));
    let poses = rotations.collect::<Result<Vec<Quat>, Fault>>()?;
    let shifts = || bind.pose_offset.iter().map(|at| at.value.offset);
    let offsets = nodes.iter().flat_map(|_| shifts()).collect();
    Ok(PoseOffsets { soft, joint, poses, nodes, offsets })
}

/// Adds those that a hand's own flesh gives, where it asks for them.
pub fn of_hand(
    built: &mut Built,
    hand: &Hand,
    model: &HandModel,
    handle: &HandHandle,
    coupling: CouplingKind,
    skinning: Skinning,
) -> Result<(), Fault> {
    if !hand.pose_offsets {
        return Ok(());
    }
    if coupling == CouplingKind::Bone {
        return Err(hand.name.fault(
            "`pose_offsets` act where springs hold all flesh: give `coupling = \"uniform\"`; flesh that hangs on bone \
             finds its shape by itself",
        ));
    }
    let sculpted = hand_cache::offsets_of(model, skinning);
    let sculpted = sculpted.map_err(|error| hand.name.fault(format!("`pose_offsets`: {error}")))?;
    built.world.pose_offsets.extend(sculpted.into_iter().map(|given| PoseOffsets {
        soft: handle.soft,
        joint: handle.joints.start + given.joint,
        ..given
    }));
    Ok(())
}
