//! Errors between us and a device.

use thenar_touch::haptic_loop::LoopError;

/// Names the device and the cause; whoever shows it adds nothing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// A device could not be opened.
    #[error("cannot open {device}: {cause}")]
    Open {
        /// Driver and address, as `lucidgloves:/dev/ttyUSB0`.
        device: String,
        /// Cause in words.
        cause: String,
    },
    /// A device was there and is lost; the driver goes on trying.
    #[error("{device} is lost: {cause}")]
    Lost {
        /// Driver and address.
        device: String,
        /// Cause in words.
        cause: String,
    },
    /// A profile, address or setting that cannot be used.
    #[error("{what}: {cause}")]
    Setting {
        /// The file and key, or the argument.
        what: String,
        /// Cause in words.
        cause: String,
    },
}

impl From<LoopError> for LinkError {
    fn from(LoopError { what, cause }: LoopError) -> Self {
        Self::Setting { what, cause }
    }
}
