//! Contacts, and what presses on a hand.
#![allow(unsafe_code)] // exported by name, and handed pointers

use crate::boundary::{Status, guard};
use crate::pointer;
use crate::running::World;
use thenar_core::model::BodyId;
use thenar_core::readout::PartContact;
use thenar_core::world::ContactPoint;
use thenar_scene::session::HandLoad;

/// A contact point of the last step, near or touching.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Bodies A and B: places in the rigid bodies, then the deformable ones.
    pub bodies: [i32; 2],
    /// The vertex of each one's surface that is nearest; -1 of a rigid body.
    pub vertices: [i32; 2],
    /// Place, world [m].
    pub point: [f64; 3],
    /// Unit vector from B to A, world.
    pub normal: [f64; 3],
    /// Force on A, world; on B the opposite [N].
    pub force: [f64; 3],
    /// Velocity of A along B, world [m/s].
    pub slip: [f64; 3],
    /// Distance, negative inside [m].
    pub gap: f64,
    /// Area that the point stands for; 0 between rigid bodies [m²].
    pub area: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Friction gives all it can.
    pub slips: bool,
}

/// Load that presses on a part of a hand.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Load {
    /// Sum of normal forces [N].
    pub normal: f64,
    /// Size of the summed tangential force [N].
    pub shear: f64,
    /// Area in contact [m²].
    pub area: f64,
    /// Mean on the skin [Pa].
    pub pressure: f64,
    /// Force on the part, world [N].
    pub force: [f64; 3],
    /// Centre of pressure, world [m].
    pub centre: [f64; 3],
}

/// Contact points of the last step. `*count` gets how many there are; `contacts`, unless it is
/// NULL, gets them, and `room` says how many it can take. There are none after a reset or a state,
/// until the next step.
///
/// # Safety
/// `world` is NULL or a live handle; `contacts` is NULL or has room for `room` contacts, `count`
/// for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_contacts(
    world: *const World,
    contacts: *mut Contact,
    room: usize,
    count: *mut usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let world = running.session.world();
            let rigids = world.desc().rigids.len();
            let all: Vec<Contact> = world.contacts().iter().map(|c| contact(rigids, c)).collect();
            // SAFETY: the caller's word.
            unsafe { pointer::list("contacts", contacts, room, count, &all) }
        })
    })
}

fn contact(rigids: usize, point: &ContactPoint) -> Contact {
    let body = |body: BodyId| match body {
        BodyId::Rigid(i) => i as i32,
        BodyId::Soft(i) => rigids as i32 + i as i32,
    };
    Contact {
        bodies: point.bodies.map(body),
        vertices: point.vertices.map(|vertex| vertex.map_or(-1, |vertex| vertex as i32)),
        point: point.position_W.into(),
        normal: point.normal_W.into(),
        force: point.force_W.into(),
        slip: point.slip_W.into(),
        gap: point.gap,
        area: point.area,
        friction: point.friction,
        slips: point.slips,
    }
}

/// Loads on palm, thumb, index, middle, ring and little finger of a hand in the last step. `room`
/// is 6.
///
/// # Safety
/// `world` is NULL or a live handle; `loads` is NULL or has room for `room` loads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_loads(
    world: *const World,
    hand: usize,
    loads: *mut Load,
    room: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let hand = running.hand(hand)?;
            let figures = running.session.hand_loads(hand);
            let flesh = running.session.hands()[hand].flesh();
            let parts = flesh.map_or(&[][..], |soft| running.contact().parts(soft));
            let none = PartContact::default();
            let all: [Load; 6] = std::array::from_fn(|k| {
                let part = parts.get(k).unwrap_or(&none);
                let [normal, shear, area, pressure] = HandLoad::figures(&figures[k]);
                let (force, centre) = (part.contact.force_W.into(), part.contact.centre_W.into());
                Load { normal, shear, area, pressure, force, centre }
            });
            // SAFETY: the caller's word.
            unsafe { pointer::fill("loads", loads, room, &all) }
        })
    })
}
