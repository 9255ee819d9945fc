//! Measures of an object before it is gripped: its width, the force that holds it, its distance.

use super::kind::GripKind;
use super::surface::{nearest, sample, through};
use crate::math::Vec3;
use thenar_core::model::{BodyId, PairRule, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::{Pose, World};

/// Grip force over the slip limit where a scene does not say. People hold dry things with 1.2 to 2
/// times what they need [Johansson and Westling 1984]; pads that do not face each other straight
/// need the more.
pub const MARGIN: f64 = 2.0;
/// Least force that is held where a scene does not say \[N\]: that with which pads meet what is
/// hard as they close.
const FORCE_MIN: f64 = 0.2;

/// The least width of an object between places that face away from each other \[m\]; infinite where
/// there are none.
pub fn narrowest(world: &World, object: BodyId) -> f64 {
    let mut samples = Vec::new();
    sample(world, object, &middle(world, object), 1e3, &mut samples);
    let width = |from: &super::surface::Sample| {
        let to = through(world, from, &-from.normal)?;
        (to.normal.dot(&from.normal) < -0.7).then(|| (to.point - from.point).norm())
    };
    samples.iter().filter_map(width).fold(f64::INFINITY, f64::min)
}

/// The body's middle, world \[m\].
pub fn middle(world: &World, object: BodyId) -> Vec3 {
    match object {
        BodyId::Rigid(body) => world.rigid_pose(body).position,
        BodyId::Soft(soft) => {
            let nodes = world.nodes(soft);
            nodes.iter().sum::<Vec3>() / nodes.len().max(1) as f64
        }
    }
}

/// From a point, world, to the surface of a body \[m\]; `None` of one that has no surface to grip.
pub fn way_to(world: &World, object: BodyId, point: &Vec3) -> Option<f64> {
    if let BodyId::Rigid(i) = object
        && matches!(world.desc().rigids[i as usize].shape, None | Some(Shape::HalfSpace))
    {
        return None;
    }
    nearest(world, object, point).map(|place| (place.point - point).norm())
}

/// Force that holds an object against its weight with a margin \[N\]; in a hook no friction holds
/// it, and half of the weight is what there is when it hangs. `flesh` is the hand's.
pub fn usual_force(desc: &WorldDesc, flesh: u32, object: BodyId, kind: GripKind) -> f64 {
    let force = match kind.has_thumb() {
        true => MARGIN * slip_limit(desc, flesh, object),
        false => 0.5 * mass(desc, object) * desc.gravity.norm(),
    };
    force.max(FORCE_MIN)
}

/// Least force between two sides that keeps an object from slipping under its weight, `m g / (2 μ)`
/// \[N\]. `flesh` is the hand's.
pub fn slip_limit(desc: &WorldDesc, flesh: u32, object: BodyId) -> f64 {
    mass(desc, object) * desc.gravity.norm() / (2.0 * friction(desc, flesh, object).max(0.05))
}

/// Mass of a body \[kg\].
pub fn mass(desc: &WorldDesc, object: BodyId) -> f64 {
    match object {
        BodyId::Rigid(i) => desc.rigids[i as usize].mass,
        BodyId::Soft(i) => {
            let soft = &desc.softs[i as usize].flesh;
            let of = |(tet, material): (&[u32; 4], &thenar_core::model::Material)| {
                let [a, b, c, d] = tet.map(|n| soft.nodes[n as usize]);
                (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0 * material.density
            };
            soft.tets.iter().zip(&soft.materials).map(of).sum()
        }
    }
}

/// Friction between an object and a hand of this flesh.
pub fn friction(desc: &WorldDesc, flesh: u32, object: BodyId) -> f64 {
    let own = desc.softs.get(flesh as usize).map_or(1.0, |soft| soft.flesh.friction);
    let friction = match object {
        BodyId::Rigid(i) => desc.rigids[i as usize].friction,
        BodyId::Soft(i) => desc.softs[i as usize].flesh.friction,
    };
    let pair = [BodyId::Soft(flesh), object];
    let rule = |rule: &&PairRule| rule.bodies == pair || rule.bodies == [pair[1], pair[0]];
    let ruled = desc.pairs.iter().rfind(rule).and_then(|rule| rule.friction);
    ruled.unwrap_or((own * friction).sqrt())
}

/// The middle of the pads of a hand that is about to close, world \[m\].
pub fn pads_middle(palm: &Pose, opposition: &super::Opposition) -> Vec3 {
    pads_middle_at(palm, opposition, super::choose::READY)
}

/// The middle of the pads of a hand around something of this width, world \[m\].
pub fn pads_middle_at(palm: &Pose, opposition: &super::Opposition, width: f64) -> Vec3 {
    let span = opposition.at(width);
    palm.point(&((span.base + span.fingers) * 0.5))
}
