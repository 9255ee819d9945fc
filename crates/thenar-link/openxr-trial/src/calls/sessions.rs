//! Sessions and reference spaces.

use super::{SYSTEM, call, given};
use crate::hand::LOCAL_HEIGHT;
use crate::script::log;
use crate::session::{RuntimeEvent, Session, known, violation};
use openxr_sys as xr;
use xr::{Result as XrResult, SessionState};

pub(super) unsafe extern "system" fn create_session(
    instance: xr::Instance,
    info: *const xr::SessionCreateInfo,
    out: *mut xr::Session,
) -> XrResult {
    call("xrCreateSession", |_| {
        let mut known = known();
        let handle = known.handle();
        let instance = known.instance(xr::Handle::into_raw(instance))?;
        // SAFETY: the program's structure.
        let info =
            unsafe { given(info, |i| i.ty == xr::SessionCreateInfo::TYPE, "XrSessionCreateInfo")? };
        if info.system_id.into_raw() != SYSTEM {
            return Err(XrResult::ERROR_SYSTEM_INVALID);
        }
        // Without a picture only where that was asked for.
        let headless = instance.extensions.iter().any(|e| e == "XR_MND_headless");
        if !headless || !info.next.is_null() {
            return Err(XrResult::ERROR_GRAPHICS_DEVICE_INVALID);
        }
        if instance.session.is_some() {
            return Err(XrResult::ERROR_LIMIT_REACHED);
        }
        let (state, running) = (SessionState::UNKNOWN, false);
        let (spaces, trackers) = (Vec::new(), Vec::new());
        instance.session = Some(Session { handle, state, running, spaces, trackers });
        instance.enter(&[SessionState::IDLE]);
        log("session");
        // SAFETY: a place to write to.
        unsafe { *out = xr::Handle::from_raw(handle) };
        Ok(())
    })
}

pub(super) unsafe extern "system" fn destroy_session(session: xr::Session) -> XrResult {
    let mut known = known();
    match known.session(xr::Handle::into_raw(session)) {
        Err(error) => error,
        Ok(session) => {
            if !session.spaces.is_empty() || !session.trackers.is_empty() {
                violation("a session ended before what is its own");
            }
            if let Some(instance) = &mut known.instance {
                instance.session = None;
                instance.told.retain(|told| !matches!(told, RuntimeEvent::State(_)));
            }
            log("session ended");
            XrResult::SUCCESS
        }
    }
}

pub(super) unsafe extern "system" fn begin_session(
    session: xr::Session,
    info: *const xr::SessionBeginInfo,
) -> XrResult {
    call("xrBeginSession", |_| {
        let mut known = known();
        // SAFETY: the program's structure.
        unsafe { given(info, |i| i.ty == xr::SessionBeginInfo::TYPE, "XrSessionBeginInfo")? };
        let session = known.session(xr::Handle::into_raw(session))?;
        if session.running {
            return Err(XrResult::ERROR_SESSION_RUNNING);
        }
        if session.state != SessionState::READY {
            violation("a session began that was not ready");
            return Err(XrResult::ERROR_SESSION_NOT_READY);
        }
        session.running = true;
        if let Some(instance) = &mut known.instance {
            use SessionState as S;
            instance.enter(&[S::SYNCHRONIZED, S::VISIBLE, S::FOCUSED]);
        }
        log("session runs");
        Ok(())
    })
}

pub(super) unsafe extern "system" fn end_session(session: xr::Session) -> XrResult {
    call("xrEndSession", |_| {
        let mut known = known();
        let session = known.session(xr::Handle::into_raw(session))?;
        if !session.running {
            return Err(XrResult::ERROR_SESSION_NOT_RUNNING);
        }
        if session.state != SessionState::STOPPING {
            violation("a session was ended that was not stopping");
            return Err(XrResult::ERROR_SESSION_NOT_STOPPING);
        }
        session.running = false;
        if let Some(instance) = &mut known.instance {
            instance.enter(&[SessionState::IDLE]);
        }
        log("session stopped");
        Ok(())
    })
}

pub(super) unsafe extern "system" fn create_space(
    session: xr::Session,
    info: *const xr::ReferenceSpaceCreateInfo,
    out: *mut xr::Space,
) -> XrResult {
    call("xrCreateReferenceSpace", |script| {
        let mut known = known();
        let handle = known.handle();
        let session = known.session(xr::Handle::into_raw(session))?;
        let right = |i: &xr::ReferenceSpaceCreateInfo| {
            let pose = i.pose_in_reference_space;
            i.ty == xr::ReferenceSpaceCreateInfo::TYPE
                && pose.orientation.w == 1.0
                && pose.position == xr::Vector3f::default()
        };
        // SAFETY: the program's structure.
        let info = unsafe { given(info, right, "XrReferenceSpaceCreateInfo")? };
        let height = match info.reference_space_type {
            xr::ReferenceSpaceType::STAGE if script.stage => 0.0,
            xr::ReferenceSpaceType::LOCAL => LOCAL_HEIGHT,
            _ => return Err(XrResult::ERROR_REFERENCE_SPACE_UNSUPPORTED),
        };
        session.spaces.push((handle, height));
        // SAFETY: a place to write to.
        unsafe { *out = xr::Handle::from_raw(handle) };
        Ok(())
    })
}

pub(super) unsafe extern "system" fn destroy_space(space: xr::Space) -> XrResult {
    let space = xr::Handle::into_raw(space);
    let mut known = known();
    let Some(session) = known.any_session() else { return XrResult::ERROR_HANDLE_INVALID };
    session.spaces.retain(|(handle, _)| *handle != space);
    XrResult::SUCCESS
}
