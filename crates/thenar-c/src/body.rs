//! Bodies: names, poses, nodes, surfaces, and what presses on these.
#![allow(unsafe_code)] // exported by name, and handed pointers

use crate::boundary::{Refusal, Status, guard};
use crate::pointer;
use crate::running::{Running, World};
use std::borrow::Cow;
use std::ffi::c_char;
use thenar_scene::flat::flat_pose;

/// Numbers of rigid bodies (hands' bones are some), deformable bodies (hands' flesh is some) and
/// hands. Pass NULL for what is not wanted.
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

/// The name of a rigid body; of a bone `hand/bone`. It stays until the world is freed. Contacts
/// tell bodies by their place in the rigid bodies, then the deformable ones.
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

/// Fills in what is read of a rigid body.
///
/// # Safety
/// As of [`pointer::world`] and [`pointer::fill`].
unsafe fn of_rigid<const N: usize>(
    world: *const World,
    rigid: usize,
    (name, out, room): (&str, *mut f64, usize),
    read: impl FnOnce(&thenar_core::World, u32) -> [f64; N],
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let world = running.session.world();
            let rigid = Running::index("rigid body", rigid, world.desc().rigids.len())?;
            // SAFETY: the caller's word.
            unsafe { pointer::fill(name, out, room, &read(world, rigid)) }
        })
    })
}

/// Pose of a rigid body's frame, whose origin is the centre of mass, in the world: position [m],
/// quaternion x, y, z, w. `room` is 7.
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
    // SAFETY: the caller's word.
    unsafe {
        of_rigid(world, rigid, ("pose", pose, room), |world, i| flat_pose(&world.rigid_pose(i)))
    }
}

/// Velocity of a rigid body's centre of mass [m/s], then its angular velocity [rad/s], world.
/// `room` is 6.
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
    // SAFETY: the caller's word.
    unsafe {
        of_rigid(world, rigid, ("velocity", velocity, room), |world, i| {
            let [linear, angular] = world.rigid_velocity(i);
            [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
        })
    }
}

/// Lists what is read of a deformable body.
///
/// # Safety
/// As of [`pointer::world`] and [`pointer::list`].
unsafe fn of_soft<T: Copy>(
    world: *const World,
    soft: usize,
    (out, room, count): (*mut T, usize, *mut usize),
    read: impl for<'a> FnOnce(&'a mut Running, u32) -> Cow<'a, [T]>,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let softs = running.session.world().desc().softs.len();
            let soft = Running::index("deformable body", soft, softs)?;
            // SAFETY: the caller's word.
            unsafe { pointer::list("out", out, room, count, &read(running, soft)) }
        })
    })
}

/// Nodes of a deformable body's tetrahedra, world, three numbers each [m]. `*count` gets how many
/// numbers there are; `out`, unless it is NULL, gets them, and `room` says how many it can take.
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
    unsafe {
        of_soft(world, soft, (out, room, count), |running, i| {
            Cow::Borrowed(bytemuck::cast_slice(running.session.world().nodes(i)))
        })
    }
}

/// Vertices of a deformable body's surface that touches, world, three numbers each [m]. `out`,
/// `room` and `count` are as of `thenar_soft_nodes`.
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
    unsafe {
        of_soft(world, soft, (out, room, count), |running, i| {
            Cow::Borrowed(bytemuck::cast_slice(running.session.world().collision_vertices(i)))
        })
    }
}

/// Contact force on each vertex of a deformable body's surface in the last step, world, three
/// numbers each [N]. `out`, `room` and `count` are as of `thenar_soft_nodes`.
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
    unsafe {
        of_soft(world, soft, (out, room, count), |running, i| {
            let vertices = running.contact().vertices(i).iter();
            vertices.flat_map(|vertex| <[f64; 3]>::from(vertex.force_W)).collect()
        })
    }
}

/// Corners of the triangles of a deformable body's surface, three places in its vertices each,
/// counter-clockwise from outside. They never change. `out`, `room` and `count` are as of
/// `thenar_soft_nodes`.
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
    // SAFETY: the caller's word.
    unsafe {
        of_soft(world, soft, (out, room, count), |running, i| {
            let body = &running.session.world().desc().softs[i as usize];
            Cow::Borrowed(bytemuck::cast_slice(&body.flesh.collision.triangles))
        })
    }
}
