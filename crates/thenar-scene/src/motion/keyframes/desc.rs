//! A keyframed motion as a person writes it.

use crate::motion::error::MotionError;
use crate::motion::preset::Preset;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use thenar_core::model::Digit;

/// A keyframed motion as written in a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyframesDesc {
    /// Treatment of joint angles out of range.
    #[serde(default)]
    pub limits: LimitPolicy,
    /// The keys, in order of time.
    #[serde(default)]
    pub key: Vec<Key>,
}

/// Treatment of a joint angle that `joints` puts out of range. Shapes and curls are clamped, but
/// for a fist, which is squeezed against the ends of its joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LimitPolicy {
    /// Refuse the motion.
    #[default]
    Error,
    /// Take the nearest admissible angle.
    Clamp,
}

/// One instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// Time \[s\]; strictly increasing from key to key.
    pub time: f64,
    /// The wrist.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wrist: Option<WristKey>,
    /// Shape of the whole hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pose: Option<Preset>,
    /// Curl of each finger, from 0 (open) to 1 (fist).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub curl: BTreeMap<Digit, f64>,
    /// Single joints, by the name of the joint or of the bone it carries.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub joints: BTreeMap<String, JointKey>,
    /// Position of the middle of each finger's pad, world \[m\].
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tips: BTreeMap<Digit, [f64; 3]>,
}

/// Pose of the wrist's frame in the world. Its -z axis points to the fingers, +y out of the back of
/// the hand. Give the rotation, or the two directions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WristKey {
    /// Position \[m\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Unit quaternion x, y, z, w.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation: Option<[f64; 4]>,
    /// Direction of the fingers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingers: Option<[f64; 3]>,
    /// Direction out of the back of the hand; its part along `fingers` is ignored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub back: Option<[f64; 3]>,
}

/// The angles of one joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointKey {
    /// Flexion \[degrees\], positive when the hand closes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flexion_deg: Option<f64>,
    /// Spread \[degrees\], positive away from the middle finger (the thumb: out of the palm).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread_deg: Option<f64>,
}

impl KeyframesDesc {
    /// Reads the text of a motion file; `file` is named in errors.
    pub fn parse(text: &str, file: &Path) -> Result<Self, MotionError> {
        toml::from_str(text)
            .map_err(|cause| MotionError::Syntax { file: file.to_path_buf(), cause })
    }
}
