//! Contacts in a snapshot.

use super::snapshot::Bytes;
use thenar::model::BodyId;
use thenar::world::ContactPoint;

/// Contacts in one snapshot; the flag [`super::flags::CONTACTS_LEFT_OUT`] says that there were more.
pub const CONTACTS_MAX: usize = 512;
/// Stands for a body without a surface of vertices.
const NO_VERTEX: u16 = u16::MAX;
/// Added to the index of a deformable body.
const SOFT: u16 = 1 << 15;

/// Smaller forces are left out \[N\].
const FORCE_MIN: f64 = 1e-6;

/// True for a contact that is sent: near ones that carry no force would fill half of a snapshot.
pub fn presses(contact: &ContactPoint) -> bool {
    contact.force_W.norm() > FORCE_MIN
}

/// Appends one contact.
pub fn put(contact: &ContactPoint, out: &mut Bytes) {
    contact.bodies.iter().for_each(|id| out.u16(body(*id)));
    let vertex = |v: &Option<u32>| v.and_then(|v| u16::try_from(v).ok()).unwrap_or(NO_VERTEX);
    contact.vertices.iter().for_each(|v| out.u16(vertex(v)));
    out.vector(&contact.position_W);
    out.vector(&contact.force_W);
    out.f32(contact.force_W.dot(&contact.normal_W));
    out.f32(contact.area);
    out.f32(contact.slip_W.norm());
    out.f32(contact.gap);
}

/// A body's number; a model message is only made of scenes whose bodies have one.
fn body(id: BodyId) -> u16 {
    match id {
        BodyId::Rigid(i) => i as u16,
        BodyId::Soft(i) => i as u16 | SOFT,
    }
}
