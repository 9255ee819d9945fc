//! Contacts in a snapshot.

use super::snapshot::Bytes;
use thenar_core::Vec3;
use thenar_core::model::BodyId;
use thenar_core::world::ContactPoint;

/// Contacts in one snapshot; the flag [`super::flags::CONTACTS_LEFT_OUT`] says that there were
/// more.
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
    octahedral(&contact.normal_W).iter().for_each(|x| out.i16(*x));
    out.f32(contact.area);
    out.f32(contact.slip_W.norm());
    out.f32(contact.gap);
}

/// A unit vector as two numbers, good to 1e-4 rad: projected onto the octahedron
/// `|x| + |y| + |z| = 1`, whose lower half is folded over the upper one (Cigolle et al. 2014); 1
/// becomes 32767.
fn octahedral(n: &Vec3) -> [i16; 2] {
    let size = n.x.abs() + n.y.abs() + n.z.abs();
    let [x, y] = [n.x / size, n.y / size];
    let folded = match n.z < 0.0 {
        true => [(1.0 - y.abs()) * 1.0_f64.copysign(x), (1.0 - x.abs()) * 1.0_f64.copysign(y)],
        false => [x, y],
    };
    folded.map(|part| (part * f64::from(i16::MAX)).round() as i16)
}

/// A body's number; a model message is only made of scenes whose bodies have one.
fn body(id: BodyId) -> u16 {
    match id {
        BodyId::Rigid(i) => i as u16,
        BodyId::Soft(i) => i as u16 | SOFT,
    }
}
