//! The names and ranges of a hand, in Markdown, from the model and the enums that the program uses.

use super::motion::motion_keys;
use crate::grip::GripKind;
use crate::motion::{
    ANGLES, Anatomy, Articulation, MotionError, Preset, TRACKED_JOINTS, hand_angles,
};
use std::fmt::Write;
use thenar_core::model::{Digit, HandModel};
use thenar_track::reach::PadPlace;

/// Tables of the bones, joints, angles, poses, grips and tracked joints of `hand`, and of motion
/// files, in Markdown; `name` says in prose whose ranges they are.
///
/// # Errors
/// The joints of `hand` do not form a tree.
pub fn hand_tables(hand: &HandModel, name: &str) -> Result<String, MotionError> {
    let mut out = String::new();
    bones(&mut out, hand);
    angles(&mut out, hand, name)?;
    poses(&mut out);
    grips(&mut out);
    tracked(&mut out);
    motions(&mut out);
    Ok(out)
}

fn bones(out: &mut String, hand: &HandModel) {
    out.push_str("### Bones and joints\n\n");
    out.push_str("Each joint connects the bone named beside it to that bone's parent.\n\n");
    out.push_str("| bone | parent | joint | axes |\n|---|---|---|---|\n");
    let anatomy = Anatomy::of(hand);
    for bone in &hand.bones {
        let parent =
            bone.parent.map_or("none".into(), |p| format!("`{}`", hand.bones[p as usize].name));
        let role = anatomy.roles.iter().find(|role| role.bone == bone.name);
        let joint = role.map_or("none".into(), |role| format!("`{}`", role.joint));
        let axes = match role.map(|role| (role.flexion.is_some(), role.spread.is_some())) {
            Some((true, true)) => "flexion and spread",
            Some((true, false)) => "flexion",
            _ => "free: the drive of the palm moves it",
        };
        let _ = writeln!(out, "| `{}` | {parent} | {joint} | {axes} |", bone.name);
    }
    out.push('\n');
}

fn angles(out: &mut String, hand: &HandModel, name: &str) -> Result<(), MotionError> {
    let _ = write!(
        out,
        "### The twenty angles\n\nIn the order of the live protocol and of recordings. Flexion is positive when the hand \
         closes; spread is positive away from the middle finger (the middle finger: towards the thumb; the thumb: \
         out of the palm). Ranges are those of {name}.\n\n\
         | number | joint | angle | smallest [°] | largest [°] | at rest [°] |\n|---:|---|---|---:|---:|---:|\n",
    );
    let found = hand_angles(hand, &Articulation::new(hand)?);
    for k in 0..ANGLES {
        let Some(angle) = &found[k] else { continue };
        let name = if k % 4 == 1 { "spread" } else { "flexion" };
        let [min, max, rest] = [angle.min, angle.max, angle.rest].map(degrees);
        let _ = writeln!(out, "| {k} | `{}` | {name} | {min} | {max} | {rest} |", angle.joint);
    }
    out.push('\n');
    Ok(())
}

fn poses(out: &mut String) {
    out.push_str(
        "### Poses\n\nNames for `pose` in a key. Each cell gives the flexion of the three joints from the palm outwards, \
         then the spread [°]; angles beyond a joint's range are clamped. `pinch`, `fist` and `point` are found for each \
         hand: pads of thumb and index finger press on each other, fingertips on the palm, and the thumb on fingers, on its \
         way aside until these have bent. A fist is squeezed, by up to a sixth beyond the ranges of its joints. The table has \
         what a hand takes that cannot do so.\n\n",
    );
    out.push_str("| pose | thumb | index | middle, ring, little |\n|---|---|---|---|\n");
    for (name, preset) in Preset::NAMED {
        let cell = |digit| {
            preset.angles_deg(digit).map_or("as modelled".into(), |([a, b, c], spread)| {
                format!("{a}, {b}, {c}; {spread}")
            })
        };
        let [thumb, index, other] = [Digit::Thumb, Digit::Index, Digit::Middle].map(cell);
        let _ = writeln!(out, "| `{name}` | {thumb} | {index} | {other} |");
    }
    out.push('\n');
}

fn grips(out: &mut String) {
    out.push_str("### Grips\n\nNames for `kind` in a [grip](scene.md#grips).\n\n");
    out.push_str("| grip | fingers | thumb | where on the fingers |\n|---|---|---|---|\n");
    for kind in GripKind::ALL {
        let fingers: Vec<_> = kind.fingers().iter().map(|digit| digit.name()).collect();
        let thumb = if kind.has_thumb() { "presses" } else { "out of the way" };
        let place = match (kind, kind.place()) {
            (GripKind::Hook, _) => "palm's side of all bones, bent around the object",
            (_, PadPlace::Tip) => "palm's side of the last bone",
            (_, PadPlace::Side) => "thumb's side of the last bone but one",
        };
        let _ = writeln!(out, "| `{}` | {} | {thumb} | {place} |", kind.name(), fingers.join(", "));
    }
    out.push('\n');
}

fn tracked(out: &mut String) {
    out.push_str(
        "### Tracked joints\n\nThe 25 joints that a tracker sends and a recording of tracked hands holds, in this order: \
         those of WebXR Hand Input. In each joint's frame -z points along the bone away from the wrist and +y out of the \
         back of the hand.\n\n| number | joint |\n|---:|---|\n",
    );
    for (k, name) in TRACKED_JOINTS.iter().enumerate() {
        let _ = writeln!(out, "| {k} | `{name}` |");
    }
}

fn motions(out: &mut String) {
    out.push_str(
        "\n### Keys of motion files\n\nWhat stands in [motion files](#motion-files), which `docs/motion.schema.json` describes to \
         editors.\n\n",
    );
    motion_keys(out);
}

/// An angle \[rad\] in whole degrees, without a minus before zero.
fn degrees(angle: f64) -> String {
    format!("{}", angle.to_degrees().round() + 0.0)
}
