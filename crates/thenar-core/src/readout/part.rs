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
    let ContactReadout { surfaces, parts, sums, part_ranges, part_of_bone, tips, shares } = readout;
    for (part, tip) in parts.iter_mut().zip(tips.iter()) {
        *part = PartContact::default();
        part.tip_W = tip.map_or(Vec3::zeros(), |bone| world.rigid_pose(bone).position);
    }
    for (range, soft) in part_ranges.iter().zip(0..) {
        let sums = &mut sums[range.clone()];
        sum_parts(world, soft, sums);
        for (part, sum) in parts[range.clone()].iter_mut().zip(sums) {
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

/// Sums the contact of each part of a deformable body, on its skin and on bones where flesh is
/// crushed. `sums` has a place for each part.
pub fn sum_parts(world: &World, soft: u32, sums: &mut [PatchSum]) {
    sums.fill(PatchSum::default());
    for point in world.contacts() {
        for side in 0..2 {
            let touched = part_touched(world, point, side).filter(|(found, _)| *found == soft);
            if let Some(sum) = touched.and_then(|(_, part)| sums.get_mut(part as usize)) {
                sum.add(point, side);
            }
        }
    }
}

/// The deformable body and its part that a point touches on this side, on the skin or on a bone.
pub fn part_touched(world: &World, point: &ContactPoint, side: usize) -> Option<(u32, u32)> {
    match point.bodies[side] {
        BodyId::Soft(soft) => Some((soft, world.model().part_of(soft, point.vertices[side]?))),
        BodyId::Rigid(bone) => {
            let (soft, part) = world.model().flesh_of_bone[bone as usize]?;
            Some((soft, u32::from(part)))
        }
    }
}
