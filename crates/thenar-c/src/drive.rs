//! Hands follow poses.
#![allow(unsafe_code)] // exported by name, and handed pointers

use crate::boundary::{Refusal, Status, guard};
use crate::pointer;
use crate::running::{Running, World};
use thenar_scene::flat::pose;
use thenar_scene::live::LivePose;

/// Numbers of a hand's 25 joints.
const JOINTS: usize = 25 * 7;

fn follow(running: &mut Running, hand: usize, time: f64, pose: &LivePose) -> Result<(), Refusal> {
    let refused =
        |e: thenar_scene::live::LiveError| Refusal { status: Status::Pose, words: e.to_string() };
    running.session.live_pose(hand, time, pose).map_err(refused)
}

/// Follows a wrist (7 numbers, as of `thenar_hand_wrist`) and twenty angles (as of
/// `thenar_hand_angles`) from the next step on, as `thenar serve` follows a headset: smoothed,
/// followed at limited speed, and lost when nothing comes for 0.1 s. `time`: when the pose was
/// taken, by any clock [s]. Angles out of range are brought to its end.
///
/// # Safety
/// `world` is NULL or a live handle; `wrist` and `angles` are NULL or of as many numbers as their
/// counts say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_follow_angles(
    world: *const World,
    hand: usize,
    time: f64,
    wrist: *const f64,
    wrist_count: usize,
    angles: *const f64,
    angles_count: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        let (world, wrist, mut angles) = unsafe {
            (
                pointer::world(world)?,
                pointer::array::<f64, 7>("wrist", wrist, wrist_count)?,
                pointer::array::<f64, 20>("angles", angles, angles_count)?,
            )
        };
        world.with(|running| {
            let hand = running.hand(hand)?;
            // Angles of joints that the hand lacks may be what `thenar_hand_angles` says of them.
            let lacks = running.session.hands()[hand].angles().map(|range| range.is_none());
            angles.iter_mut().zip(lacks).filter(|(_, lacks)| *lacks).for_each(|(a, _)| *a = 0.0);
            follow(running, hand, time, &LivePose::Angles { wrist: pose(&wrist), angles })
        })
    })
}

/// Follows the 25 joints of WebXR Hand Input from the next step on, seven numbers each, as
/// `thenar_hand_follow_angles` follows angles. `radii`: 25 of them [m], or NULL and 0.
///
/// # Safety
/// `world` is NULL or a live handle; `joints` and `radii` are NULL or of as many numbers as their
/// counts say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_follow_joints(
    world: *const World,
    hand: usize,
    time: f64,
    joints: *const f64,
    joints_count: usize,
    radii: *const f64,
    radii_count: usize,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        let (world, joints, radii) = unsafe {
            let radii = match radii.is_null() && radii_count == 0 {
                true => [0.0; 25],
                false => pointer::array::<f64, 25>("radii", radii, radii_count)?,
            };
            let joints = pointer::array::<f64, JOINTS>("joints", joints, joints_count)?;
            (pointer::world(world)?, joints, radii)
        };
        let (rows, _) = joints.as_chunks::<7>();
        let joints = std::array::from_fn(|k| pose(&rows[k]));
        world.with(|running| {
            let hand = running.hand(hand)?;
            follow(running, hand, time, &LivePose::Joints { joints, radii })
        })
    })
}

/// The hand is not tracked any more: it holds still until the next pose.
///
/// # Safety
/// `world` is NULL or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_lose(world: *const World, hand: usize) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let hand = running.hand(hand)?;
            running.session.live_lost(hand);
            Ok(())
        })
    })
}

/// The hand goes back to its scene's script.
///
/// # Safety
/// `world` is NULL or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_hand_follow_script(world: *const World, hand: usize) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::world(world) }?.with(|running| {
            let hand = running.hand(hand)?;
            running.session.follow_script(hand);
            Ok(())
        })
    })
}
