//! The functions of OpenXR 1.0 that hand tracking without a picture needs; the others exist, as
//! they must, and refuse.
//!
//! Pointers are the caller's: each function relies on what the specification promises of them
//! (valid, or null where null means something), and checks the rest.

mod sessions;
mod time;
mod trackers;

use crate::script::{Script, log};
use crate::session::{Instance, RuntimeEvent, known, violation};
use openxr_sys as xr;
use sessions::{
    begin_session, create_session, create_space, destroy_session, destroy_space, end_session,
};
use std::ffi::{CStr, c_char};
use time::{convert_time, now_ns};
use trackers::{create_tracker, destroy_tracker, locate_joints};
use xr::{Result as XrResult, pfn};

/// The one system.
const SYSTEM: u64 = 7;

const EXTENSIONS: [&str; 3] =
    ["XR_EXT_hand_tracking", "XR_MND_headless", "XR_KHR_convert_timespec_time"];

type CallResult = Result<(), XrResult>;

/// Runs a function's body, unless the script lets it fail.
fn call(name: &str, body: impl FnOnce(&Script) -> CallResult) -> XrResult {
    let script = Script::read();
    if let Some((_, code)) = script.fails.iter().find(|(failing, _)| failing == name) {
        return XrResult::from_raw(*code);
    }
    match body(&script) {
        Ok(()) => XrResult::SUCCESS,
        Err(error) => error,
    }
}

/// Structure behind the caller's pointer, checked for the type that it must state.
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

/// Stands in for every function that is not one of ours.
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
            Some(RuntimeEvent::State(state)) => {
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
            Some(RuntimeEvent::InstanceLoss) => {
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
