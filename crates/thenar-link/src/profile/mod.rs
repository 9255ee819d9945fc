//! Profiles of a device and its wearer: rates, limits, stiffness, calibration, pose of the wrist.
//! Shipped for every driver; a user's file changes single keys.

mod address;
mod cameras;
mod load;
mod parts;

pub use address::Address;
pub use cameras::{Cameras, camera_timing, page_timing, states_timing};
pub(crate) use load::read_table;
pub use load::{Check, load, profile_name, save, settings_folder, user_file};
pub use parts::{DigitAngles, Display, Link, Tracking, WearerHand, Wrist};
