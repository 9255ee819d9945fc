//! Contact per part of a deformable body: the fingers of a hand.

use crate::World;
use crate::math::Vec3;
use crate::model::BodyId;
use crate::readout::ContactReadout;
use crate::readout::patch::{PatchContact, PatchSum};
use crate::world::ContactPoint;

/// Contact that a finger feels, and load that reaches its bones through the flesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartContact {
    /// On the skin, and on bones where flesh is crushed.
    pub contact: PatchContact,
    /// Position of the fingertip: the centre of mass of the part's last bone, world \[m\]; without
    /// bones the centre of pressure.
    pub tip_W: Vec3,
    /// Torque of the contact about the fingertip, world \[N m\].
    pub torque_W: Vec3,
    /// Force that flesh puts on the part's bones through the coupling (Eq. 8), world \[N\]. It
    /// differs from the contact's by weight, inertia, and what the flesh hands on to other parts.
    pub bone_force_W: Vec3,
    /// Torque that flesh puts on the part's bones through the coupling, about the fingertip, world
    /// \[N m\].
    pub bone_torque_W: Vec3,
}

pub(super) fn read(readout: &mut ContactReadout, world: &World) {
    let ContactReadout { surfaces, parts, part_ranges, part_of_bone, tips, shares } = readout;
    for (part, tip) in parts.iter_mut().zip(tips.iter()) {
        *part = PartContact::default();
        part.tip_W = tip.map_or(Vec3::zeros(), |bone| world.rigid_pose(bone).position);
    }
    for (range, soft) in part_ranges.iter().zip(0..) {
        // Points are few; they are gone through once for each part.
        for (index, part) in parts[range.clone()].iter_mut().enumerate() {
            let mut sum = PatchSum::default();
            for point in world.contacts() {
                for side in 0..2 {
                    if part_touched(world, point, side) == Some((soft, index as u32)) {
                        sum.add(point, side);
                    }
                }
            }
            part.contact = sum.finish(0.0);
        }
        for (vertex, v) in (0..).zip(surfaces.vertices(soft)) {
            let part = world.model().part_of(soft, vertex) as usize;
            let peak = &mut parts[range.start + part].contact.pressure_max;
            *peak = peak.max(v.pressure);
        }
    }
    for (part, tip) in parts.iter_mut().zip(tips.iter()) {
        if tip.is_none() {
            part.tip_W = part.contact.centre_W;
        }
        part.torque_W = part.contact.torque_about(&part.tip_W);
    }
    world.for_each_bone_load(shares, |bone, force_W, torque_W| {
        if let Some(index) = part_of_bone[bone as usize] {
            let part = &mut parts[index as usize];
            let arm_W = world.rigid_pose(bone).position - part.tip_W;
            part.bone_force_W += force_W;
            part.bone_torque_W += torque_W + arm_W.cross(&force_W);
        }
    });
}

/// The deformable body and its part that a point touches on this side, on the skin or on a bone.
pub(super) fn part_touched(world: &World, point: &ContactPoint, side: usize) -> Option<(u32, u32)> {
    match point.bodies[side] {
        BodyId::Soft(soft) => Some((soft, world.model().part_of(soft, point.vertices[side]?))),
        BodyId::Rigid(bone) => {
            let (soft, part) = world.model().flesh_of_bone[bone as usize]?;
            Some((soft, u32::from(part)))
        }
    }
}
