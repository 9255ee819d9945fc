//! What goes wrong between us and a device.

/// Names the device and the cause; whoever shows it adds nothing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// It could not be opened.
    #[error("cannot open {device}: {cause}")]
    Open {
        /// Driver and address, as `lucidgloves:/dev/ttyUSB0`.
        device: String,
        /// Why.
        cause: String,
    },
    /// It was there and is lost; the driver goes on trying.
    #[error("{device} is lost: {cause}")]
    Lost {
        /// Driver and address.
        device: String,
        /// Why.
        cause: String,
    },
    /// A profile, address or setting that cannot be used.
    #[error("{what}: {cause}")]
    Setting {
        /// The file and key, or the argument.
        what: String,
        /// Why.
        cause: String,
    },
}
