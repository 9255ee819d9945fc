//! Drivers, which find devices and open them.

use crate::LinkError;
use crate::calibration::Calibrate;
use thenar_touch::{ForceDisplay, Tracker};

/// A kind of device: finds those that are there and opens them.
pub trait Driver: Send + Sync {
    /// Name of the driver in addresses, such as `lucidgloves`.
    fn name(&self) -> &'static str;

    /// One line for a person: what it is, and what an address looks like.
    fn about(&self) -> &'static str;

    /// Devices that seem to be there now. Opens nothing that could move.
    fn enumerate(&self) -> Vec<FoundDevice>;

    /// Opens the device at an address (what follows `name:`), in so far as it can be: a device that
    /// is away for now opens, and is taken up when it comes.
    fn open(&self, address: &str) -> Result<Opened, LinkError>;

    /// Set if its devices are fitted to their wearer.
    fn calibrate(&self) -> Option<&dyn Calibrate> {
        None
    }
}

/// A device that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundDevice {
    /// Address that `open` takes.
    pub address: String,
    /// Description of the device, for a person.
    pub what: String,
}

/// An open device: a tracker, a force display, or both. Dropping the display releases the hand;
/// dropping both closes the device.
pub struct Opened {
    /// Tells where hands are.
    pub tracker: Option<Box<dyn Tracker>>,
    /// Lets a hand feel.
    pub display: Option<Box<dyn ForceDisplay>>,
}
