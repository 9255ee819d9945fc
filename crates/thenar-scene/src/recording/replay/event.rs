//! Events of a replay.

use thenar_record::{ChannelInfo, Gap};

/// Event of a replay. Times are those of the recording \[ns\].
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A session has begun.
    Scene {
        /// Time of the event \[ns\].
        time_ns: u64,
    },
    /// Something entered, named as for a person.
    Entered {
        /// Time of the event \[ns\].
        time_ns: u64,
        /// Words of the event.
        what: String,
        /// True for kinds that come many times a second: a pose, or targets.
        often: bool,
    },
    /// A step was made.
    Stepped {
        /// Time at which it was over \[ns\].
        time_ns: u64,
        /// Duration when it was recorded \[ns\]; `None` where no mark was kept.
        cost_ns: Option<u32>,
    },
    /// A channel is announced.
    Channel(ChannelInfo),
    /// A record of a channel.
    Record {
        /// Time of the event \[ns\].
        time_ns: u64,
        /// Number of the channel.
        channel: u32,
        /// Values of the channel.
        values: Vec<f64>,
    },
    /// Frames are missing.
    Gap {
        /// Time of the event \[ns\].
        time_ns: u64,
        /// Gap in the recording.
        gap: Gap,
    },
}
