//! The functions of OpenXR 1.0 that hand tracking without a picture needs; the others exist, as they
//! must, and refuse.
//!
//! Pointers are the caller's: each function relies on what the specification promises of them
//! (valid, or null where null means something), and checks the rest.

use crate::hand::{JOINTS, LOCAL_HEIGHT, joint};
use crate::script::{Script, log};
use crate::session::{Instance, Session, Told, known, violation};
use openxr_sys as xr;
use std::ffi::{CStr, c_char};
use xr::{Result as XrResult, SessionState, pfn};

/// The runtime's clock is so far ahead of the system's \[ns\].
const EPOCH_NS: i64 = 3_600_000_000_000;
/// Told of hands this far from now is an error of the caller's \[ns\].
const NEAR_NS: i64 = 1_000_000_000;
/// The one system.
const SYSTEM: u64 = 7;

const EXTENSIONS: [&str; 3] =
    ["XR_EXT_hand_tracking", "XR_MND_headless", "XR_KHR_convert_timespec_time"];

type Done = Result<(), XrResult>;

/// Runs a function's body, unless the script lets it fail.
fn call(name: &str, body: impl FnOnce(&Script) -> Done) -> XrResult {
    let script = Script::read();
    if let Some((_, code)) = script.fails.iter().find(|(failing, _)| failing == name) {
        return XrResult::from_raw(*code);
    }
    match body(&script) {
        Ok(()) => XrResult::SUCCESS,
        Err(error) => error,
    }
}

/// What the caller points at, with the type that it must say.
///
/// # Safety
/// `pointer` is null or points at a valid structure of type `T`.
unsafe fn given<'a, T>(
    pointer: *const T,
    ty: impl Fn(&T) -> bool,
    what: &str,
) -> Result<&'a T, XrResult> {
    // SAFETY: promised by the caller.
    let value = unsafe { pointer.as_ref() };
    value.filter(|value| ty(value)).ok_or_else(|| violation(&format!("{what} is none")))
}

/// Copies a text into an array of C, ended by zero.
fn put<const N: usize>(place: &mut [c_char; N], text: &str) {
    place.fill(0);
    for (place, byte) in place.iter_mut().zip(text.bytes().take(N - 1)) {
        *place = byte as c_char;
    }
}

/// The loader's first question.
///
/// # Safety
/// As the loader's specification says.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn xrNegotiateLoaderRuntimeInterface(
    info: *const xr::NegotiateLoaderInfo,
    request: *mut xr::NegotiateRuntimeRequest,
) -> XrResult {
    // SAFETY: the loader gives valid pointers.
    let (Some(info), Some(request)) = (unsafe { info.as_ref() }, unsafe { request.as_mut() })
    else {
        return XrResult::ERROR_INITIALIZATION_FAILED;
    };
    let known = info.struct_type == xr::NegotiateLoaderInfo::TYPE
        && info.struct_version == xr::NegotiateLoaderInfo::VERSION
        && info.struct_size == size_of::<xr::NegotiateLoaderInfo>()
        && request.struct_type == xr::NegotiateRuntimeRequest::TYPE
        && request.struct_version == xr::NegotiateRuntimeRequest::VERSION
        && request.struct_size == size_of::<xr::NegotiateRuntimeRequest>()
        && (info.min_interface_version..=info.max_interface_version).contains(&1);
    if !known {
        violation("the loader speaks another language");
        return XrResult::ERROR_INITIALIZATION_FAILED;
    }
    request.runtime_interface_version = 1;
    request.runtime_api_version = xr::Version::new(1, 0, 20);
    request.get_instance_proc_addr = Some(get_instance_proc_addr);
    XrResult::SUCCESS
}

/// What every function that is not one of ours does.
unsafe extern "system" fn unsupported() -> XrResult {
    violation("a function was called that a program without a picture does not need");
    XrResult::ERROR_FUNCTION_UNSUPPORTED
}

/// Functions of OpenXR 1.0 that exist and refuse.
const REFUSED: &str = "xrResultToString xrStructureTypeToString xrEnumerateSwapchainFormats \
    xrCreateSwapchain xrDestroySwapchain xrEnumerateSwapchainImages xrAcquireSwapchainImage \
    xrWaitSwapchainImage xrReleaseSwapchainImage xrRequestExitSession xrEnumerateReferenceSpaces \
    xrCreateActionSpace xrLocateSpace xrEnumerateViewConfigurations \
    xrEnumerateEnvironmentBlendModes xrGetViewConfigurationProperties \
    xrEnumerateViewConfigurationViews xrBeginFrame xrLocateViews xrEndFrame xrWaitFrame \
    xrApplyHapticFeedback xrStopHapticFeedback xrStringToPath xrPathToString \
    xrGetReferenceSpaceBoundsRect xrGetActionStateBoolean xrGetActionStateFloat \
    xrGetActionStateVector2f xrGetActionStatePose xrCreateActionSet xrDestroyActionSet \
    xrCreateAction xrDestroyAction xrSuggestInteractionProfileBindings \
    xrAttachSessionActionSets xrGetCurrentInteractionProfile xrSyncActions \
    xrEnumerateBoundSourcesForAction xrGetInputSourceLocalizedName";

/// A function's address as one of no particular type.
macro_rules! address {
    ($function:ident as $type:ty) => {{
        let function: $type = $function;
        // SAFETY: pointers to functions are of one size; whoever calls it gives it its type back.
        Some(unsafe { std::mem::transmute::<$type, pfn::VoidFunction>(function) })
    }};
}

unsafe extern "system" fn get_instance_proc_addr(
    instance: xr::Instance,
    name: *const c_char,
    function: *mut Option<pfn::VoidFunction>,
) -> XrResult {
    // SAFETY: a valid text, and a place to write to.
    let (name, function) = unsafe { (CStr::from_ptr(name), &mut *function) };
    let name = name.to_str().unwrap_or("");
    *function = None;
    let raw = xr::Handle::into_raw(instance);
    let enabled = |extension: &str| {
        let mut known = known();
        let instance = known.instance(raw).ok();
        instance.is_some_and(|instance| instance.extensions.iter().any(|e| e == extension))
    };
    let of_hands = || enabled("XR_EXT_hand_tracking");
    let found = match name {
        "xrEnumerateInstanceExtensionProperties" => {
            address!(enumerate_extensions as pfn::EnumerateInstanceExtensionProperties)
        }
        "xrCreateInstance" => address!(create_instance as pfn::CreateInstance),
        _ if raw == 0 => return XrResult::ERROR_HANDLE_INVALID,
        "xrGetInstanceProcAddr" => address!(get_instance_proc_addr as pfn::GetInstanceProcAddr),
        "xrDestroyInstance" => address!(destroy_instance as pfn::DestroyInstance),
        "xrGetInstanceProperties" => {
            address!(get_instance_properties as pfn::GetInstanceProperties)
        }
        "xrPollEvent" => address!(poll_event as pfn::PollEvent),
        "xrGetSystem" => address!(get_system as pfn::GetSystem),
        "xrGetSystemProperties" => address!(get_system_properties as pfn::GetSystemProperties),
        "xrCreateSession" => address!(create_session as pfn::CreateSession),
        "xrDestroySession" => address!(destroy_session as pfn::DestroySession),
        "xrBeginSession" => address!(begin_session as pfn::BeginSession),
        "xrEndSession" => address!(end_session as pfn::EndSession),
        "xrCreateReferenceSpace" => address!(create_space as pfn::CreateReferenceSpace),
        "xrDestroySpace" => address!(destroy_space as pfn::DestroySpace),
        "xrCreateHandTrackerEXT" if of_hands() => {
            address!(create_tracker as pfn::CreateHandTrackerEXT)
        }
        "xrDestroyHandTrackerEXT" if of_hands() => {
            address!(destroy_tracker as pfn::DestroyHandTrackerEXT)
        }
        "xrLocateHandJointsEXT" if of_hands() => {
            address!(locate_joints as pfn::LocateHandJointsEXT)
        }
        "xrConvertTimespecTimeToTimeKHR" if enabled("XR_KHR_convert_timespec_time") => {
            address!(convert_time as pfn::ConvertTimespecTimeToTimeKHR)
        }
        "xrConvertTimeToTimespecTimeKHR" if enabled("XR_KHR_convert_timespec_time") => {
            Some(unsupported_function())
        }
        _ if REFUSED.split_whitespace().any(|refused| refused == name) => {
            Some(unsupported_function())
        }
        _ => return XrResult::ERROR_FUNCTION_UNSUPPORTED,
    };
    *function = found;
    XrResult::SUCCESS
}

fn unsupported_function() -> pfn::VoidFunction {
    let function: unsafe extern "system" fn() -> XrResult = unsupported;
    // SAFETY: pointers to functions are of one size; it looks at no argument.
    unsafe {
        std::mem::transmute::<unsafe extern "system" fn() -> XrResult, pfn::VoidFunction>(function)
    }
}

unsafe extern "system" fn enumerate_extensions(
    layer: *const c_char,
    capacity: u32,
    count: *mut u32,
    properties: *mut xr::ExtensionProperties,
) -> XrResult {
    call("xrEnumerateInstanceExtensionProperties", |script| {
        if !layer.is_null() {
            return Err(XrResult::ERROR_API_LAYER_NOT_PRESENT);
        }
        let names: Vec<_> =
            EXTENSIONS.iter().filter(|e| script.without.iter().all(|w| w != *e)).collect();
        // SAFETY: a place to write to.
        unsafe { *count = names.len() as u32 };
        if capacity == 0 {
            return Ok(());
        }
        if (capacity as usize) < names.len() {
            return Err(XrResult::ERROR_SIZE_INSUFFICIENT);
        }
        for (k, name) in names.into_iter().enumerate() {
            // SAFETY: the caller has room for `capacity` of them.
            let place = unsafe { &mut *properties.add(k) };
            if place.ty != xr::ExtensionProperties::TYPE {
                return Err(violation("XrExtensionProperties is none"));
            }
            put(&mut place.extension_name, name);
            place.extension_version = 1;
        }
        Ok(())
    })
}

unsafe extern "system" fn create_instance(
    info: *const xr::InstanceCreateInfo,
    out: *mut xr::Instance,
) -> XrResult {
    call("xrCreateInstance", |script| {
        // SAFETY: the loader hands the program's structure on.
        let info = unsafe {
            given(info, |i| i.ty == xr::InstanceCreateInfo::TYPE, "XrInstanceCreateInfo")?
        };
        let version = info.application_info.api_version;
        if version.major() != 1 || version.minor() > 0 {
            return Err(XrResult::ERROR_API_VERSION_UNSUPPORTED);
        }
        let mut extensions = Vec::new();
        for k in 0..info.enabled_extension_count as usize {
            // SAFETY: as many texts as the caller says.
            let name = unsafe { CStr::from_ptr(*info.enabled_extension_names.add(k)) };
            let name = name.to_string_lossy().into_owned();
            if !EXTENSIONS.contains(&name.as_str()) || script.without.contains(&name) {
                return Err(XrResult::ERROR_EXTENSION_NOT_PRESENT);
            }
            extensions.push(name);
        }
        let mut known = known();
        if known.instance.is_some() {
            return Err(XrResult::ERROR_LIMIT_REACHED);
        }
        let handle = known.handle();
        log(&format!("instance {}", extensions.join(" ")));
        known.instance = Some(Instance { handle, extensions, ..Default::default() });
        // SAFETY: a place to write to.
        unsafe { *out = xr::Handle::from_raw(handle) };
        Ok(())
    })
}

unsafe extern "system" fn destroy_instance(instance: xr::Instance) -> XrResult {
    let mut known = known();
    let done = known.instance(xr::Handle::into_raw(instance)).map(|instance| {
        if instance.session.is_some() {
            violation("an instance ended before its session");
        }
    });
    if let Err(error) = done {
        return error;
    }
    known.instance = None;
    log("instance ended");
    XrResult::SUCCESS
}

unsafe extern "system" fn get_instance_properties(
    instance: xr::Instance,
    properties: *mut xr::InstanceProperties,
) -> XrResult {
    call("xrGetInstanceProperties", |_| {
        known().instance(xr::Handle::into_raw(instance))?;
        // SAFETY: a place to write to.
        let properties = unsafe { &mut *properties };
        properties.runtime_version = xr::Version::new(0, 1, 0);
        put(&mut properties.runtime_name, "Thenar's trial runtime");
        Ok(())
    })
}

unsafe extern "system" fn poll_event(
    instance: xr::Instance,
    event: *mut xr::EventDataBuffer,
) -> XrResult {
    let mut none = false;
    let result = call("xrPollEvent", |script| {
        let mut known = known();
        let instance = known.instance(xr::Handle::into_raw(instance))?;
        instance.follow(script);
        // SAFETY: a buffer of this type.
        unsafe { given(event, |e| e.ty == xr::EventDataBuffer::TYPE, "XrEventDataBuffer")? };
        let session = instance.session.as_ref().map_or(0, |session| session.handle);
        let next = std::ptr::null();
        match instance.told.pop_front() {
            Some(Told::State(state)) => {
                let told = xr::EventDataSessionStateChanged {
                    ty: xr::EventDataSessionStateChanged::TYPE,
                    next,
                    session: xr::Handle::from_raw(session),
                    state,
                    time: xr::Time::from_nanos(now_ns()),
                };
                // SAFETY: the buffer is larger than any event, and as much aligned.
                unsafe { event.cast::<xr::EventDataSessionStateChanged>().write(told) };
            }
            Some(Told::InstanceLoss) => {
                let told = xr::EventDataInstanceLossPending {
                    ty: xr::EventDataInstanceLossPending::TYPE,
                    next,
                    loss_time: xr::Time::from_nanos(now_ns()),
                };
                // SAFETY: as above.
                unsafe { event.cast::<xr::EventDataInstanceLossPending>().write(told) };
            }
            None => none = true,
        }
        Ok(())
    });
    if none && result == XrResult::SUCCESS { XrResult::EVENT_UNAVAILABLE } else { result }
}

unsafe extern "system" fn get_system(
    instance: xr::Instance,
    info: *const xr::SystemGetInfo,
    out: *mut xr::SystemId,
) -> XrResult {
    call("xrGetSystem", |_| {
        known().instance(xr::Handle::into_raw(instance))?;
        // SAFETY: the program's structure.
        let info = unsafe { given(info, |i| i.ty == xr::SystemGetInfo::TYPE, "XrSystemGetInfo")? };
        if info.form_factor != xr::FormFactor::HEAD_MOUNTED_DISPLAY {
            return Err(XrResult::ERROR_FORM_FACTOR_UNSUPPORTED);
        }
        // SAFETY: a place to write to.
        unsafe { *out = xr::SystemId::from_raw(SYSTEM) };
        Ok(())
    })
}

unsafe extern "system" fn get_system_properties(
    instance: xr::Instance,
    system: xr::SystemId,
    properties: *mut xr::SystemProperties,
) -> XrResult {
    call("xrGetSystemProperties", |script| {
        known().instance(xr::Handle::into_raw(instance))?;
        if system.into_raw() != SYSTEM {
            return Err(XrResult::ERROR_SYSTEM_INVALID);
        }
        // SAFETY: a place to write to.
        let properties = unsafe { &mut *properties };
        put(&mut properties.system_name, "no headset");
        // SAFETY: null or another structure, which begins with its type.
        let next =
            unsafe { properties.next.cast::<xr::SystemHandTrackingPropertiesEXT>().as_mut() };
        if let Some(hands) = next
            && hands.ty == xr::SystemHandTrackingPropertiesEXT::TYPE
        {
            hands.supports_hand_tracking = script.tracks.into();
        }
        Ok(())
    })
}

unsafe extern "system" fn create_session(
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

unsafe extern "system" fn destroy_session(session: xr::Session) -> XrResult {
    let mut known = known();
    match known.session(xr::Handle::into_raw(session)) {
        Err(error) => error,
        Ok(session) => {
            if !session.spaces.is_empty() || !session.trackers.is_empty() {
                violation("a session ended before what is its own");
            }
            if let Some(instance) = &mut known.instance {
                instance.session = None;
                instance.told.retain(|told| !matches!(told, Told::State(_)));
            }
            log("session ended");
            XrResult::SUCCESS
        }
    }
}

unsafe extern "system" fn begin_session(
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

unsafe extern "system" fn end_session(session: xr::Session) -> XrResult {
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

unsafe extern "system" fn create_space(
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

unsafe extern "system" fn destroy_space(space: xr::Space) -> XrResult {
    let space = xr::Handle::into_raw(space);
    let mut known = known();
    let Some(session) = known.any_session() else { return XrResult::ERROR_HANDLE_INVALID };
    session.spaces.retain(|(handle, _)| *handle != space);
    XrResult::SUCCESS
}

unsafe extern "system" fn create_tracker(
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

unsafe extern "system" fn destroy_tracker(tracker: xr::HandTrackerEXT) -> XrResult {
    let tracker = xr::Handle::into_raw(tracker);
    let mut known = known();
    let Some(session) = known.any_session() else { return XrResult::ERROR_HANDLE_INVALID };
    session.trackers.retain(|(handle, ..)| *handle != tracker);
    XrResult::SUCCESS
}

unsafe extern "system" fn locate_joints(
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

/// The runtime's clock.
fn now_ns() -> i64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: a place to write to.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &mut now) };
    of_timespec(&now)
}

fn of_timespec(time: &libc::timespec) -> i64 {
    time.tv_sec * 1_000_000_000 + time.tv_nsec + EPOCH_NS
}

unsafe extern "system" fn convert_time(
    instance: xr::Instance,
    from: *const libc::timespec,
    to: *mut xr::Time,
) -> XrResult {
    call("xrConvertTimespecTimeToTimeKHR", |_| {
        known().instance(xr::Handle::into_raw(instance))?;
        // SAFETY: a time of the program's, and a place to write to.
        unsafe { *to = xr::Time::from_nanos(of_timespec(&*from)) };
        Ok(())
    })
}
