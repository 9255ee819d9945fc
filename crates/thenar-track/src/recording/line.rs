//! One line of a recording.

use super::{TRACKED_JOINTS, TrackedSample};
use crate::live::RADIUS_MAX;
use serde::Deserialize;
use thenar_core::model::Side;
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::{brief, quoted};

/// Position in a line of each joint of [`TRACKED_JOINTS`].
pub type Order = [usize; 25];

/// Furthest a tracked joint may be from the origin \[m\].
const DISTANCE_MAX: f64 = 100.0;
/// Latest time \[s\].
const TIME_MAX: f64 = 1e7;

#[derive(Deserialize)]
struct Header {
    format: String,
    version: u64,
    joints: Vec<String>,
    quat: String,
}

#[derive(Deserialize)]
struct Sample {
    t: f64,
    hand: Side,
    pos: Vec<[f64; 3]>,
    quat: Vec<[f64; 4]>,
    /// Radii of the joints \[m\]: checked, not used.
    #[serde(default)]
    radius: Option<Vec<f64>>,
}

/// Reads the first line.
pub fn header(text: &[u8]) -> Result<Order, String> {
    let header: Header = json(text).map_err(|cause| format!("header: {cause}"))?;
    if header.format != "hand-joints-jsonl" || header.version != 1 {
        return Err(format!(
            "header: expected format \"hand-joints-jsonl\" version 1, got {} version {}",
            quoted(&header.format),
            header.version
        ));
    }
    if header.quat != "x,y,z,w" {
        return Err(format!("header: quat must be \"x,y,z,w\", got {}", quoted(&header.quat)));
    }
    if header.joints.len() != TRACKED_JOINTS.len() {
        return Err(format!("header: expected 25 joints, got {}", header.joints.len()));
    }
    let mut order = [0; 25];
    for (place, name) in order.iter_mut().zip(TRACKED_JOINTS) {
        *place = header
            .joints
            .iter()
            .position(|joint| joint == name)
            .ok_or_else(|| format!("header: joint `{name}` is missing"))?;
    }
    Ok(order)
}

/// Reads any other line.
pub fn sample(text: &[u8], order: &Order) -> Result<(Side, TrackedSample), String> {
    let sample: Sample = json(text)?;
    if sample.t.is_nan() || sample.t.abs() > TIME_MAX {
        return Err(format!("t is {}, expected at most {TIME_MAX} s", sample.t));
    }
    let radii = sample.radius.as_deref();
    let counts = [("pos", sample.pos.len()), ("quat", sample.quat.len())];
    for (what, count) in counts.into_iter().chain(radii.map(|radii| ("radius", radii.len()))) {
        if count != order.len() {
            return Err(format!("{what} has {count} entries, expected {}", order.len()));
        }
    }
    if let Some(odd) = radii.unwrap_or_default().iter().find(|r| !(0.0..=RADIUS_MAX).contains(*r)) {
        return Err(format!("a radius is {odd} m, expected 0 to {RADIUS_MAX}"));
    }
    let mut joints = [Pose::identity(); 25];
    for ((joint, from), name) in joints.iter_mut().zip(order).zip(TRACKED_JOINTS) {
        *joint = pose(sample.pos[*from], sample.quat[*from])
            .map_err(|cause| format!("joint `{name}`: {cause}"))?;
    }
    Ok((sample.hand, TrackedSample { time: sample.t, joints }))
}

fn pose(position: [f64; 3], [x, y, z, w]: [f64; 4]) -> Result<Pose, String> {
    if !position.iter().all(|x| x.abs() <= DISTANCE_MAX) {
        return Err(format!("position {position:?} is further than {DISTANCE_MAX} m"));
    }
    let quaternion = nalgebra::Quaternion::new(w, x, y, z);
    let norm = quaternion.norm();
    if !(0.9..=1.1).contains(&norm) {
        return Err(format!("quaternion of length {norm}, expected 1"));
    }
    Ok(Pose::new(Vec3::from(position), Quat::from_quaternion(quaternion)))
}

/// Parses one line; the column is named, for the line is known to the caller only.
fn json<'a, T: Deserialize<'a>>(text: &'a [u8]) -> Result<T, String> {
    serde_json::from_slice(text.trim_ascii()).map_err(|error| {
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = error.to_string();
        let cause = message.strip_suffix(&place).unwrap_or(&message);
        brief(&format!("column {}: {cause}", error.column()))
    })
}
