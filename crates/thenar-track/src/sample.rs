//! What trackers tell.

use crate::live::LivePose;
use thenar_core::model::Side;

/// One hand at an instant.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct HandSample {
    /// Side of the hand.
    pub side: Side,
    /// When it was measured, or received where the device tells no time \[ns\].
    pub time_ns: u64,
    /// The hand in the world; `None` when the device says that it does not see it. A glove without
    /// a tracker of its own has its wrist where the profile puts it.
    pub pose: Option<LivePose>,
}
