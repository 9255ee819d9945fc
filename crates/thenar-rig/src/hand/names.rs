//! Names of the tracked joints and of the bones.

use std::collections::BTreeMap;
use thenar_core::model::Digit;

/// From WebXR joint names to the names a rig uses; what is not listed keeps its WebXR name.
pub type NameMap = BTreeMap<String, String>;

/// The 25 joints of the WebXR Hand Input specification, of which `prefix` names the digit.
pub(super) fn prefix(digit: Digit) -> &'static str {
    match digit {
        Digit::Palm => "wrist",
        Digit::Thumb => "thumb",
        Digit::Index => "index-finger",
        Digit::Middle => "middle-finger",
        Digit::Ring => "ring-finger",
        Digit::Little => "pinky-finger",
    }
}

/// Names of all joints.
pub(super) fn all() -> impl Iterator<Item = String> {
    let of = |digit: &Digit| {
        let (prefix, suffixes) = (prefix(*digit), suffixes(*digit));
        suffixes.iter().map(move |suffix| format!("{prefix}-{suffix}"))
    };
    std::iter::once(WRIST.to_string()).chain(Digit::FINGERS.iter().flat_map(of))
}

/// The wrist.
pub(super) const WRIST: &str = "wrist";

/// Joint suffixes from the base to the tip. The thumb has no intermediate phalanx.
pub(super) fn suffixes(digit: Digit) -> &'static [&'static str] {
    match digit {
        Digit::Palm => &[],
        Digit::Thumb => &["metacarpal", "phalanx-proximal", "phalanx-distal", "tip"],
        _ => &["metacarpal", "phalanx-proximal", "phalanx-intermediate", "phalanx-distal", "tip"],
    }
}

/// The three moving bones of a digit.
pub(super) fn bone_names(digit: Digit) -> [&'static str; 3] {
    match digit {
        Digit::Thumb => ["metacarpal", "proximal", "distal"],
        _ => ["proximal", "intermediate", "distal"],
    }
}

/// The joint at the proximal end of moving bone `k`, from 0 to 2.
pub(super) fn joint_name(digit: Digit, k: usize) -> String {
    let joints = match digit {
        Digit::Thumb => ["cmc", "mcp", "ip"],
        _ => ["mcp", "pip", "dip"],
    };
    format!("{}-{}", digit.name(), joints[k])
}

/// Names of the joints of all hands that are built here, whatever their rig: thumb first, each
/// digit from the palm on.
pub fn joint_names() -> Vec<String> {
    let of = |digit| (0..3).map(move |k| joint_name(digit, k));
    Digit::FINGERS.into_iter().flat_map(of).collect()
}
