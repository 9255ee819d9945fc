//! Fitting a device to its wearer: poses that a person takes, and what follows from them.

use crate::{LinkError, Opened};
use thenar_track::ANGLES;

/// A pose to take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Prompt {
    /// Name of the pose.
    pub name: &'static str,
    /// Instruction to the wearer.
    pub text: &'static str,
}

/// Result of a calibration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fitted {
    /// Keys for the user's profile.
    pub keys: toml::Table,
    /// Remarks for a person: sensors that hardly moved.
    pub remarks: Vec<String>,
}

/// Devices that need it.
pub trait Calibrate {
    /// The poses, in their order.
    fn prompts(&self) -> Vec<Prompt>;

    /// Opens the device with its sensors as they are: the tracker's angles are sensor values, a
    /// radian for a full range, in an order that only `fit` knows.
    ///
    /// # Errors
    /// As for opening it.
    fn open_raw(&self, address: &str) -> Result<Opened, LinkError>;

    /// From the mean of those angles in each pose to keys of a profile.
    fn fit(&self, means: &[[f64; ANGLES]]) -> Fitted;
}
