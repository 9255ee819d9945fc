//! One line of a pose stream.

use crate::joints::{
    OPENXR_JOINTS, POINTS, in_reach, rebuild, rotation, typical_radii, webxr_of_apple,
    webxr_of_openxr,
};
use serde::Deserialize;
use std::fmt::Write;
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_input::plain;
use thenar_track::TRACKED_JOINTS;
use thenar_track::live::{LivePose, RADIUS_MAX};

/// Times are seconds of any clock within this (31 years) \[s\].
const TIME_MAX: f64 = 1e9;

/// Place in a line of each of our joints.
pub type Order = [usize; 25];

/// Content of a line.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // one at a time, by value
pub enum Line {
    /// The order of joints from now on.
    Header(Order),
    /// A hand.
    Hand {
        /// Side of the hand.
        side: Side,
        /// The sender's clock \[s\].
        time: Option<f64>,
        /// `None` when it is not seen.
        pose: Option<LivePose>,
    },
}

#[derive(Deserialize)]
struct Header {
    format: String,
    version: u64,
    joints: Vec<String>,
    quat: String,
}

#[derive(Deserialize)]
struct Sample {
    t: Option<f64>,
    hand: Side,
    #[serde(default = "seen")]
    tracked: bool,
    #[serde(default)]
    pos: Vec<[f64; 3]>,
    quat: Option<Vec<[f64; 4]>>,
    radius: Option<Vec<f64>>,
}

fn seen() -> bool {
    true
}

impl Line {
    /// Reads a line; 25 joints stand in it in the order of the last header.
    ///
    /// # Errors
    /// It is none: the cause, for a person.
    pub fn read(bytes: &[u8], order: &Order) -> Result<Self, String> {
        const HEADER: &[u8] = br#""format""#;
        if bytes.windows(HEADER.len()).any(|part| part == HEADER) {
            return header(bytes).map(Self::Header);
        }
        let sample: Sample = json(bytes)?;
        if let Some(t) = sample.t.filter(|t| t.is_nan() || t.abs() > TIME_MAX) {
            return Err(format!("t is {}, expected at most {TIME_MAX} s", plain(t)));
        }
        let pose = if sample.tracked { Some(pose(&sample, order)?) } else { None };
        Ok(Self::Hand { side: sample.hand, time: sample.t, pose })
    }
}

/// The order in which joints stand without a header.
pub fn natural_order() -> Order {
    std::array::from_fn(|joint| joint)
}

fn header(bytes: &[u8]) -> Result<Order, String> {
    let header: Header = json(bytes).map_err(|cause| format!("header: {cause}"))?;
    let known = header.format == "hand-joints-jsonl" && header.version == 1;
    if !known || header.quat != "x,y,z,w" || header.joints.len() != 25 {
        let cause = "expected format hand-joints-jsonl, version 1, quat x,y,z,w and 25 joints";
        return Err(format!("header: {cause}"));
    }
    let mut order = natural_order();
    for (place, name) in order.iter_mut().zip(TRACKED_JOINTS) {
        let found = header.joints.iter().position(|joint| joint == name);
        *place = found.ok_or_else(|| format!("header: joint `{name}` is missing"))?;
    }
    Ok(order)
}

fn pose(sample: &Sample, order: &Order) -> Result<LivePose, String> {
    let count = sample.pos.len();
    let mut points = Vec::with_capacity(count);
    for point in &sample.pos {
        let point = Vec3::from(*point);
        if !in_reach(&point) {
            return Err(format!("pos {:?} is out of reach", point.as_slice()));
        }
        points.push(point);
    }
    let Some(quaternions) = &sample.quat else { return of_points(sample, &points) };
    if quaternions.len() != count {
        return Err(format!("quat has {} entries, pos {count}", quaternions.len()));
    }
    let mut frames = Vec::with_capacity(count);
    for (point, quaternion) in points.into_iter().zip(quaternions) {
        let turn = rotation(*quaternion)
            .map_err(|norm| format!("a quaternion of length {norm}, expected 1"))?;
        frames.push(Pose::new(point, turn));
    }
    let joints = ours(&frames, order).ok_or_else(|| {
        format!("pos has {count} entries; expected 25 (WebXR), 26 (OpenXR) or 27 (Apple)")
    })?;
    let radii = match &sample.radius {
        None => typical_radii((joints[11].position - joints[0].position).norm()),
        Some(radii) if radii.len() != count => {
            return Err(format!("radius has {} entries, pos {count}", radii.len()));
        }
        Some(radii) => {
            if let Some(odd) = radii.iter().find(|r| !(0.0..=RADIUS_MAX).contains(*r)) {
                return Err(format!("a radius of {odd} m, expected 0 to {RADIUS_MAX}"));
            }
            match ours(radii, order) {
                Some(radii) => radii,
                None => return Err("a radius for each joint is expected".into()),
            }
        }
    };
    Ok(LivePose::Joints { joints, radii })
}

/// Points without frames.
fn of_points(sample: &Sample, points: &[Vec3]) -> Result<LivePose, String> {
    let Ok(points) = <&[Vec3; POINTS]>::try_from(points) else {
        let count = points.len();
        return Err(format!("pos has {count} entries and no quat; only {POINTS} points need none"));
    };
    rebuild(sample.hand, points).map_err(|error| error.to_string())
}

/// Our joints of another order, told by how many there are.
fn ours<T: Copy>(values: &[T], order: &Order) -> Option<[T; 25]> {
    match values.len() {
        25 => Some(order.map(|place| values[place])),
        OPENXR_JOINTS => values.first_chunk().map(webxr_of_openxr),
        27 => webxr_of_apple(values),
        _ => None,
    }
}

/// The cause without the place of serde_json's that counts lines.
fn json<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, String> {
    serde_json::from_slice(bytes).map_err(|error| {
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = error.to_string();
        let cause = message.strip_suffix(&place).unwrap_or(&message);
        // A cause may quote what a stranger sent.
        format!("column {}: {}", error.column(), cause.chars().take(100).collect::<String>())
    })
}

/// The line of a hand, with its end, to the micrometre; `None` is a hand that is not seen.
/// Angles are no joints: such a pose is written as not seen.
pub fn write(side: Side, time: f64, pose: Option<&LivePose>) -> String {
    let side = match side {
        Side::Left => "left",
        Side::Right => "right",
    };
    let mut text = format!("{{\"t\":{time:.6},\"hand\":\"{side}\"");
    // Writing to a string cannot fail.
    match pose {
        Some(LivePose::Joints { joints, radii }) => {
            let list = |text: &mut String, key: &str, value: &dyn Fn(usize) -> String| {
                let values: Vec<_> = (0..25).map(value).collect();
                let _ = write!(text, ",\"{key}\":[{}]", values.join(","));
            };
            list(&mut text, "pos", &|j| {
                let p = joints[j].position;
                format!("[{:.6},{:.6},{:.6}]", p.x, p.y, p.z)
            });
            list(&mut text, "quat", &|j| {
                let q = joints[j].rotation.coords;
                format!("[{:.6},{:.6},{:.6},{:.6}]", q.x, q.y, q.z, q.w)
            });
            list(&mut text, "radius", &|j| format!("{:.6}", radii[j]));
        }
        Some(LivePose::Angles { .. }) | None => text.push_str(",\"tracked\":false"),
    }
    text.push_str("}\n");
    text
}
