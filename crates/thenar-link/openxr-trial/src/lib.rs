//! An OpenXR runtime without a headset, for trials of `thenar-link` through the real loader.
//!
//! It is what the manifest in `XR_RUNTIME_JSON` names, and does what the file in `THENAR_XR_SCRIPT`
//! says, which may change at any time ([`script`]). It holds its user to the specification of
//! OpenXR 1.0: what is called wrongly or at the wrong time fails as it must, and is written down
//! beside the script, in a file that also tells which instances and sessions began and ended
//! ([`script::log`]).
//!
//! Two hands of 26 joints are where [`hand::joint`] says.
//!
//! This is the only crate here with `unsafe` calls of C: it is not published, and empty without its
//! feature `trial`.

#![cfg(all(feature = "trial", target_os = "linux"))]

mod calls;
pub mod hand;
pub mod script;
mod session;
