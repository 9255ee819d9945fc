//! Hand trackers.

use super::time::now_ns;
use super::{call, given};
use crate::hand::{JOINTS, joint};
use crate::session::{known, violation};
use openxr_sys as xr;
use xr::{Result as XrResult, SessionState};

/// Largest time from now at which a caller may ask for hands \[ns\].
const NEAR_NS: i64 = 1_000_000_000;

pub(super) unsafe extern "system" fn create_tracker(
    session: xr::Session,
    info: *const xr::HandTrackerCreateInfoEXT,
    out: *mut xr::HandTrackerEXT,
) -> XrResult {
    call("xrCreateHandTrackerEXT", |script| {
        if !script.tracks {
            return Err(XrResult::ERROR_FEATURE_UNSUPPORTED);
        }
        let mut known = known();
        let handle = known.handle();
        let session = known.session(xr::Handle::into_raw(session))?;
        let right = |i: &xr::HandTrackerCreateInfoEXT| {
            i.ty == xr::HandTrackerCreateInfoEXT::TYPE
                && i.hand_joint_set == xr::HandJointSetEXT::DEFAULT
        };
        // SAFETY: the program's structure.
        let info = unsafe { given(info, right, "XrHandTrackerCreateInfoEXT")? };
        let hand = match info.hand {
            xr::HandEXT::LEFT => 0,
            xr::HandEXT::RIGHT => 1,
            _ => return Err(violation("XrHandEXT is none")),
        };
        session.trackers.push((handle, hand, 0));
        // SAFETY: a place to write to.
        unsafe { *out = xr::Handle::from_raw(handle) };
        Ok(())
    })
}

pub(super) unsafe extern "system" fn destroy_tracker(tracker: xr::HandTrackerEXT) -> XrResult {
    let tracker = xr::Handle::into_raw(tracker);
    let mut known = known();
    let Some(session) = known.any_session() else { return XrResult::ERROR_HANDLE_INVALID };
    session.trackers.retain(|(handle, ..)| *handle != tracker);
    XrResult::SUCCESS
}

pub(super) unsafe extern "system" fn locate_joints(
    tracker: xr::HandTrackerEXT,
    info: *const xr::HandJointsLocateInfoEXT,
    out: *mut xr::HandJointLocationsEXT,
) -> XrResult {
    call("xrLocateHandJointsEXT", |script| {
        // SAFETY: the program's structures.
        let info = unsafe {
            given(info, |i| i.ty == xr::HandJointsLocateInfoEXT::TYPE, "XrHandJointsLocateInfoEXT")?
        };
        // SAFETY: as above, and the program's to read and write.
        let out = unsafe { &mut *out };
        if out.ty != xr::HandJointLocationsEXT::TYPE || out.joint_count as usize != JOINTS {
            return Err(violation("XrHandJointLocationsEXT is none"));
        }
        let time = info.time.as_nanos();
        if time <= 0 || (time - now_ns()).abs() > NEAR_NS {
            violation("hands were asked for at a time far from now");
            return Err(XrResult::ERROR_TIME_INVALID);
        }
        let mut known = known();
        let session = known.any_session().ok_or(XrResult::ERROR_HANDLE_INVALID)?;
        let space = xr::Handle::into_raw(info.base_space);
        let height = session.spaces.iter().find(|(handle, _)| *handle == space);
        let height = height.ok_or(XrResult::ERROR_HANDLE_INVALID)?.1;
        let tracker = xr::Handle::into_raw(tracker);
        let found = session.trackers.iter_mut().find(|(handle, ..)| *handle == tracker);
        let (_, hand, asked) = found.ok_or(XrResult::ERROR_HANDLE_INVALID)?;
        // Input without focus is none.
        let active = session.state == SessionState::FOCUSED && script.seen[*hand];
        out.is_active = active.into();
        for k in 0..JOINTS {
            let joint = joint(*hand, k, *asked);
            let valid = active && script.blind != Some(k);
            let flags = xr::SpaceLocationFlags::POSITION_VALID
                | xr::SpaceLocationFlags::ORIENTATION_VALID
                | xr::SpaceLocationFlags::POSITION_TRACKED
                | xr::SpaceLocationFlags::ORIENTATION_TRACKED;
            let ([x, y, z], [a, b, c, w]) = (joint.position, joint.rotation);
            let known = xr::HandJointLocationEXT {
                location_flags: flags,
                pose: xr::Posef {
                    orientation: xr::Quaternionf { x: a, y: b, z: c, w },
                    position: xr::Vector3f { x, y: y - height, z },
                },
                radius: joint.radius,
            };
            let nowhere = xr::HandJointLocationEXT {
                location_flags: xr::SpaceLocationFlags::EMPTY,
                pose: xr::Posef {
                    orientation: xr::Quaternionf { w: 0.0, ..Default::default() },
                    position: xr::Vector3f { x: f32::NAN, ..Default::default() },
                },
                radius: f32::NAN,
            };
            // SAFETY: room for as many joints as the program said.
            unsafe { out.joint_locations.add(k).write(if valid { known } else { nowhere }) };
        }
        *asked += u64::from(active);
        Ok(())
    })
}
