//! Samples that trackers report.

use crate::live::LivePose;
use thenar_core::model::Side;

/// One hand at an instant.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HandSample {
    /// Side of the hand.
    pub side: Side,
    /// Time of measurement, or of reception where the device gives no time \[ns\].
    pub time_ns: u64,
    /// The hand in the world; `None` when the device says that it does not see it. A glove without
    /// a tracker of its own has its wrist where the profile puts it.
    pub pose: Option<LivePose>,
}
