//! Hands: where their bones are.
#![allow(unsafe_code)] // exported by name, and handed pointers

use crate::boundary::{Status, guard};
use crate::pointer;
use crate::running::World;
use thenar_scene::flat::flat_pose;

/// Pose of a hand's wrist in the world: position [m], quaternion x, y, z, w; -z towards the
/// fingers, +y out of the back. `room` is 7.
///
/// # Safety
/// `world` is NULL or a live handle; `wrist` is NULL or has room for `room` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_wrist(
    world: *const World,
    hand: usize,
    wrist: *mut f64,
    room: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let pose = flat_pose(&running.session.hand_wrist(running.hand(hand)?));
            // SAFETY: the caller's word.
            unsafe { pointer::fill("wrist", wrist, room, &pose) }
        })
    })
}

/// The twenty angles of a hand [rad]; NaN for a joint that it lacks. For each finger, thumb first:
/// flexion and spread of its base joint, then flexion of its second and third. `room` is 20.
///
/// # Safety
/// `world` is NULL or a live handle; `angles` is NULL or has room for `room` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_angles(
    world: *const World,
    hand: usize,
    angles: *mut f64,
    room: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let all = running.session.hand_angles(running.hand(hand)?);
            // SAFETY: the caller's word.
            unsafe { pointer::fill("angles", angles, room, &all) }
        })
    })
}

/// Poses of a hand's bones in the world, the palm first, seven numbers each: position [m],
/// quaternion x, y, z, w; -z along the bone away from the wrist, +y out of the back. `*count` gets
/// how many numbers there are; `poses`, unless it is NULL, gets them, and `room` says how many it
/// can take.
///
/// # Safety
/// `world` is NULL or a live handle; `poses` is NULL or has room for `room` numbers, `count` for
/// one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_bone_poses(
    world: *const World,
    hand: usize,
    poses: *mut f64,
    room: usize,
    count: *mut usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let bones = running.session.hands()[running.hand(hand)?].handle.bones.clone();
            let world = running.session.world();
            let all: Vec<[f64; 7]> = bones.map(|bone| flat_pose(&world.rigid_pose(bone))).collect();
            // SAFETY: the caller's word.
            unsafe { pointer::list("poses", poses, room, count, all.as_flattened()) }
        })
    })
}
