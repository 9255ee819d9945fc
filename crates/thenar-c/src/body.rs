//! Bodies: names, poses, nodes, surfaces, and what presses on these.
#![allow(unsafe_code)] // exported by name, and handed pointers

use crate::boundary::{Refusal, Status, guard};
use crate::pointer;
use crate::running::{Running, World};
use std::ffi::c_char;
use thenar::Vec3;
use thenar_scene::flat::flat_pose;

/// How many rigid bodies (hands' bones are some), deformable bodies (hands' flesh is some) and hands there are. What is
/// not wanted is NULL.
///
/// # Safety
/// `world` is NULL or a live handle; the others are NULL or have room for a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_counts(
    world: *const World,
    rigid_bodies: *mut usize,
    soft_bodies: *mut usize,
    hands: *mut usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        let world = unsafe { pointer::world(world) }?;
        let wanted =
            [("rigid_bodies", rigid_bodies), ("soft_bodies", soft_bodies), ("hands", hands)];
        for ((name, place), names) in wanted.into_iter().zip(&world.names) {
            if !place.is_null() {
                // SAFETY: the caller's word.
                unsafe { pointer::put(name, place, names.len()) }?;
            }
        }
        Ok(())
    })
}

/// The name of a rigid body; of a bone `hand/bone`. It stays until the world is freed. Contacts tell bodies by their
/// place in the rigid bodies, then the deformable ones.
///
/// # Safety
/// `world` is NULL or a live handle; `name` has room for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_rigid_name(
    world: *const World,
    rigid: usize,
    name: *mut *const c_char,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe { name_of(world, 0, "rigid body", rigid, name) })
}

/// The name of a deformable body. It stays until the world is freed.
///
/// # Safety
/// `world` is NULL or a live handle; `name` has room for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_soft_name(
    world: *const World,
    soft: usize,
    name: *mut *const c_char,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe { name_of(world, 1, "deformable body", soft, name) })
}

/// The name of a hand. It stays until the world is freed.
///
/// # Safety
/// `world` is NULL or a live handle; `name` has room for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_name(
    world: *const World,
    hand: usize,
    name: *mut *const c_char,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe { name_of(world, 2, "hand", hand, name) })
}

/// A name of one of the three lists.
///
/// # Safety
/// As of [`pointer::world`] and [`pointer::put`].
unsafe fn name_of(
    world: *const World,
    list: usize,
    kind: &str,
    index: usize,
    name: *mut *const c_char,
) -> Result<(), Refusal> {
    // SAFETY: the caller's word.
    let names = unsafe { &pointer::world(world)?.names[list] };
    let index = Running::index(kind, index, names.len())?;
    // SAFETY: the caller's word.
    unsafe { pointer::put("name", name, names[index as usize].as_ptr()) }
}

/// Pose of a rigid body's frame, whose origin is the centre of mass, in the world: position [m], quaternion x, y, z, w.
/// `room` is 7.
///
/// # Safety
/// `world` is NULL or a live handle; `pose` is NULL or has room for `room` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_rigid_pose(
    world: *const World,
    rigid: usize,
    pose: *mut f64,
    room: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let world = running.session.world();
            let rigid = Running::index("rigid body", rigid, world.desc().rigids.len())?;
            // SAFETY: the caller's word.
            unsafe { pointer::fill("pose", pose, room, &flat_pose(&world.rigid_pose(rigid))) }
        })
    })
}

/// Velocity of a rigid body's centre of mass [m/s], then its angular velocity [rad/s], world. `room` is 6.
///
/// # Safety
/// `world` is NULL or a live handle; `velocity` is NULL or has room for `room` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_rigid_velocity(
    world: *const World,
    rigid: usize,
    velocity: *mut f64,
    room: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let world = running.session.world();
            let rigid = Running::index("rigid body", rigid, world.desc().rigids.len())?;
            let both = world.rigid_velocity(rigid);
            // SAFETY: the caller's word.
            unsafe { pointer::fill("velocity", velocity, room, bytemuck::cast_slice(&both)) }
        })
    })
}

/// Reads a list of vectors of a deformable body.
///
/// # Safety
/// As of [`pointer::world`] and [`pointer::list`].
unsafe fn vectors(
    world: *const World,
    soft: usize,
    out: *mut f64,
    room: usize,
    count: *mut usize,
    read: impl FnOnce(&mut Running, u32) -> Vec<Vec3>,
) -> Result<(), Refusal> {
    // SAFETY: the caller's word.
    unsafe { pointer::world(world) }?.with(|running| {
        let softs = running.session.world().desc().softs.len();
        let soft = Running::index("deformable body", soft, softs)?;
        let read = read(running, soft);
        // SAFETY: the caller's word.
        unsafe { pointer::list("out", out, room, count, bytemuck::cast_slice(&read)) }
    })
}

/// Nodes of a deformable body's tetrahedra, world, three numbers each [m]. `*count` gets how many numbers there are;
/// `out`, unless it is NULL, gets them, and `room` says how many it can take.
///
/// # Safety
/// `world` is NULL or a live handle; `out` is NULL or has room for `room` numbers, `count` for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_soft_nodes(
    world: *const World,
    soft: usize,
    out: *mut f64,
    room: usize,
    count: *mut usize,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe {
        vectors(world, soft, out, room, count, |r, i| r.session.world().nodes(i).to_vec())
    })
}

/// Vertices of a deformable body's surface that touches, world, three numbers each [m]. `out`, `room` and `count` are as
/// of `thenar_soft_nodes`.
///
/// # Safety
/// As of `thenar_soft_nodes`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_soft_vertices(
    world: *const World,
    soft: usize,
    out: *mut f64,
    room: usize,
    count: *mut usize,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe {
        vectors(world, soft, out, room, count, |r, i| {
            r.session.world().collision_vertices(i).to_vec()
        })
    })
}

/// Contact force on each vertex of a deformable body's surface in the last step, world, three numbers each [N]. `out`,
/// `room` and `count` are as of `thenar_soft_nodes`.
///
/// # Safety
/// As of `thenar_soft_nodes`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_soft_vertex_forces(
    world: *const World,
    soft: usize,
    out: *mut f64,
    room: usize,
    count: *mut usize,
) -> Status {
    // SAFETY: the caller's word.
    guard(|| unsafe {
        vectors(world, soft, out, room, count, |r, i| {
            r.contact().vertices(i).iter().map(|vertex| vertex.force_W).collect()
        })
    })
}

/// Corners of the triangles of a deformable body's surface, three places in its vertices each, counter-clockwise from
/// outside. They never change. `out`, `room` and `count` are as of `thenar_soft_nodes`.
///
/// # Safety
/// As of `thenar_soft_nodes`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_soft_triangles(
    world: *const World,
    soft: usize,
    out: *mut u32,
    room: usize,
    count: *mut usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let softs = &running.session.world().desc().softs;
            let soft = Running::index("deformable body", soft, softs.len())?;
            let corners = bytemuck::cast_slice(&softs[soft as usize].flesh.collision.triangles);
            // SAFETY: the caller's word.
            unsafe { pointer::list("out", out, room, count, corners) }
        })
    })
}
