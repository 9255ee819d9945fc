//! One line of the streamer.

use crate::joints::{POINTS, in_reach, rotation};
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};

/// A line, in WebXR's axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Number of the frame on the headset.
    pub frame: Option<i64>,
    /// The headset's clock \[ns\].
    pub time: Option<i64>,
    /// Content of the line.
    pub body: Body,
}

/// Content of a line.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // one at a time, by value
pub enum Body {
    /// A wrist, in the world.
    Wrist(Side, Pose),
    /// Points of a hand.
    Points(Side, [Vec3; POINTS]),
    /// The head, which no hand follows.
    Head,
}

impl Line {
    /// Reads `LABEL[ | f=<int> | t=<int>]: v1, v2, …`. Metadata that are not known are left out,
    /// as are empty values; everything else must fit.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(bytes).map_err(|_| "a line that is not UTF-8")?;
        let (head, values) = text.split_once(':').ok_or("a line without `:`")?;
        let mut parts = head.split('|').map(str::trim);
        let label = parts.next().unwrap_or_default();
        let (mut frame, mut time) = (None, None);
        for part in parts {
            let Some((key, value)) = part.split_once('=') else { continue };
            let place = match key.trim().to_ascii_lowercase().as_str() {
                "f" | "frame" | "frame_id" => &mut frame,
                "t" | "ts" | "timestamp" => &mut time,
                _ => continue,
            };
            let value = value.trim().parse();
            *place = Some(value.map_err(|_| format!("`{}` is not a whole number", short(part)))?);
        }
        let mut words = label.split_ascii_whitespace().map(str::to_ascii_lowercase);
        let (who, what) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        let side = match who.as_str() {
            "left" => Some(Side::Left),
            "right" => Some(Side::Right),
            _ => None,
        };
        let body = match (side, who.as_str(), what.as_str(), words.next()) {
            (Some(side), _, "wrist", None) => Body::Wrist(side, pose(&numbers::<7>(values)?)?),
            (Some(side), _, "landmarks", None) => {
                Body::Points(side, points(&numbers::<{ 3 * POINTS }>(values)?)?)
            }
            (None, "head", "pose", None) => {
                numbers::<7>(values)?;
                Body::Head
            }
            _ => return Err(format!("`{}` is not a known label", short(label))),
        };
        Ok(Self { frame, time, body })
    }
}

/// The beginning of what a stranger sent.
fn short(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Exactly `N` finite numbers.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let mut numbers = [0.0; N];
    let mut count = 0;
    for word in text.split(',').map(str::trim).filter(|word| !word.is_empty()) {
        if let Some(number) = numbers.get_mut(count) {
            let value = word.parse().ok().filter(|value: &f64| value.is_finite());
            *number = value.ok_or_else(|| format!("`{}` is not a number", short(word)))?;
        }
        count += 1;
    }
    if count != N { Err(format!("{count} numbers; expected {N}")) } else { Ok(numbers) }
}

/// From Unity's axes (left-handed: x right, y up, z forward).
fn place([x, y, z]: [f64; 3]) -> Result<Vec3, String> {
    let place = Vec3::new(x, y, -z);
    if in_reach(&place) { Ok(place) } else { Err(format!("{x}, {y}, {z} is out of reach")) }
}

fn pose([x, y, z, a, b, c, w]: &[f64; 7]) -> Result<Pose, String> {
    let turn = rotation([-a, -b, *c, *w])
        .map_err(|norm| format!("a quaternion of length {norm}; expected 1"))?;
    Ok(Pose::new(place([*x, *y, *z])?, turn))
}

fn points(numbers: &[f64; 3 * POINTS]) -> Result<[Vec3; POINTS], String> {
    let mut points = [Vec3::zeros(); POINTS];
    for (point, chunk) in points.iter_mut().zip(numbers.chunks_exact(3)) {
        *point = place([chunk[0], chunk[1], chunk[2]])?;
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Line, String> {
        Line::read(text.as_bytes())
    }

    #[test]
    fn a_wrist_is_read_with_whatever_metadata() {
        let plain = read("Right wrist: 1, 2, 3, 0, 0, 0, 1").unwrap();
        assert_eq!((plain.frame, plain.time), (None, None));
        let Body::Wrist(Side::Right, pose) = plain.body else { panic!("{plain:?}") };
        assert_eq!(pose.position, Vec3::new(1.0, 2.0, -3.0));

        for head in [
            "Right wrist | f=7 | t=123456789012",
            "Right  WRIST|frame=7|ts = 123456789012|battery=9%|odd",
            "right wrist | timestamp=123456789012 | Frame_ID=7 ",
        ] {
            let line = read(&format!("{head}: 1,2,3,0,0,0,1,\r")).unwrap();
            assert_eq!((line.frame, line.time), (Some(7), Some(123_456_789_012)), "{head}");
            assert_eq!(line.body, plain.body);
        }
    }

    /// A quarter turn about y from z to x, seen in a mirror, goes from -z to x.
    #[test]
    fn rotations_follow_the_mirror() {
        let h = std::f64::consts::FRAC_1_SQRT_2;
        let line = read(&format!("Left wrist: 0,0,0,0,{h},0,{h}")).unwrap();
        let Body::Wrist(Side::Left, pose) = line.body else { panic!() };
        // Unity: Quaternion.Euler(0, 90, 0) * forward (0,0,1) = right (1,0,0).
        assert!((pose.vector(&-Vec3::z()) - Vec3::x()).norm() < 1e-12);
        let line = read(&format!("Left wrist: 0,0,0,{h},0,0,{h}")).unwrap();
        let Body::Wrist(Side::Left, pose) = line.body else { panic!() };
        // Unity: Quaternion.Euler(90, 0, 0) * forward = down.
        assert!((pose.vector(&-Vec3::z()) + Vec3::y()).norm() < 1e-12);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let cases = [
            ("", "without `:`"),
            ("hello", "without `:`"),
            ("Right elbow: 1,2,3", "not a known label"),
            ("Right: 1", "not a known label"),
            ("Head wrist: 1,2,3,0,0,0,1", "not a known label"),
            ("Right wrist extra: 1,2,3,0,0,0,1", "not a known label"),
            ("Right wrist: 1,2,3,0,0,0", "6 numbers; expected 7"),
            ("Right wrist: 1,2,3,0,0,0,1,1", "8 numbers; expected 7"),
            ("Right landmarks: 1,2,3", "3 numbers; expected 63"),
            ("Right wrist: 1,2,x,0,0,0,1", "`x` is not a number"),
            ("Right wrist: 1,2,nan,0,0,0,1", "`nan` is not a number"),
            ("Right wrist: 1,2,1e999,0,0,0,1", "not a number"),
            ("Right wrist: 1,2,300,0,0,0,1", "out of reach"),
            ("Right wrist: 1,2,3,0,0,0,2", "length 2"),
            ("Right wrist | f=1.5: 1,2,3,0,0,0,1", "`f=1.5` is not a whole number"),
        ];
        for (text, cause) in cases {
            let error = read(text).unwrap_err();
            assert!(error.contains(cause), "{text}: {error}");
        }
        assert!(Line::read(b"\xff: 1").unwrap_err().contains("UTF-8"));
        assert_eq!(read("Head pose: 1,2,3,0,0,0,1").unwrap().body, Body::Head);
    }
}
