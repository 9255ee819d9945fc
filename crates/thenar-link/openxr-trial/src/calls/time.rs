//! The runtime's clock.

use super::call;
use crate::session::known;
use openxr_sys as xr;
use xr::Result as XrResult;

/// The runtime's clock is so far ahead of the system's \[ns\].
const EPOCH_NS: i64 = 3_600_000_000_000;

/// The runtime's clock.
pub(super) fn now_ns() -> i64 {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: a place to write to.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &mut now) };
    of_timespec(&now)
}

fn of_timespec(time: &libc::timespec) -> i64 {
    time.tv_sec * 1_000_000_000 + time.tv_nsec + EPOCH_NS
}

pub(super) unsafe extern "system" fn convert_time(
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
