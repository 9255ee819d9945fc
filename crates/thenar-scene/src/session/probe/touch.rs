//! Columns of the contact read-out.

use crate::format::VertexWord;
use crate::math::Vec3;
use thenar_core::World;
use thenar_core::model::BodyId;
use thenar_core::readout::{ContactReadout, PartContact, PatchContact};

/// All of the contact of two bodies.
pub fn between(patch: &PatchContact, out: &mut Vec<f64>) {
    out.extend(patch.force_W.iter());
    out.extend([patch.push_W().norm(), patch.shear_W.norm(), patch.area]);
    out.extend(patch.centre_W.iter());
    out.extend([patch.penetration, f64::from(patch.points)]);
    slip(patch, out);
    out.extend([patch.normal, patch.shear_sum, patch.pressure_mean()]);
}

/// Largest pressure, slip speed, sliding part of the load, state.
fn slip(patch: &PatchContact, out: &mut Vec<f64>) {
    let state = f64::from(patch.state.number());
    out.extend([patch.pressure_max, patch.slip_W.norm(), patch.slipping, state]);
}

/// Force on a body by all its contacts, and its torque about the centre of mass.
pub fn on_body(world: &World, readout: &mut ContactReadout, body: BodyId, out: &mut Vec<f64>) {
    let centre_W = match body {
        BodyId::Rigid(i) => world.rigid_pose(i).position,
        BodyId::Soft(s) => {
            let masses = world.node_masses(s);
            let moment: Vec3 = world.nodes(s).iter().zip(masses).map(|(x, m)| x * *m).sum();
            moment / masses.iter().sum::<f64>()
        }
    };
    let patch = readout.body(world, body);
    let torque_W = patch.torque_about(&centre_W);
    out.extend(patch.force_W.iter().chain(torque_W.iter()));
}

/// All of a finger.
pub fn finger(part: &PartContact, out: &mut Vec<f64>) {
    let contact = &part.contact;
    out.extend(contact.force_W.iter().copied().chain([contact.normal, contact.shear_W.norm()]));
    out.extend(part.torque_W.iter().chain(contact.centre_W.iter()));
    out.push(contact.area);
    slip(contact, out);
    out.extend(part.bone_force_W.iter().chain(part.bone_torque_W.iter()));
    out.extend([contact.shear_sum, contact.pressure_mean()]);
}

/// One quantity of all vertices.
pub fn vertices(readout: &ContactReadout, soft: u32, what: VertexWord, out: &mut Vec<f64>) {
    for v in readout.vertices(soft) {
        match what {
            VertexWord::Pressure => out.push(v.pressure),
            VertexWord::Force => out.extend(v.force_W.iter()),
            VertexWord::Slip => out.push(v.slip_W.norm()),
            VertexWord::State => out.push(f64::from(v.state.number())),
            VertexWord::Area => out.push(v.area),
        }
    }
}
