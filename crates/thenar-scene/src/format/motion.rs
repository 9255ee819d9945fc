//! Motions of hands.

use super::NamedJoints;
use crate::math::Vec3;
use crate::text::{Located, choice, table, words};

words! {
    /// Treatment of joint angles out of range.
    pub enum LimitsWord {
        /// Refuse the motion.
        "error" => Error,
        /// Take the nearest admissible angle.
        "clamp" => Clamp,
    }
}

words! {
    /// A hand.
    pub enum SideOfHandWord {
        /// Left hand.
        "left" => Left,
        /// Right hand.
        "right" => Right,
    }
}

words! {
    /// A shape of the whole hand.
    pub enum PoseWord {
        /// Shape in which the hand's mesh was modelled.
        "rest" => Rest,
        /// Flat, fingers a little apart.
        "open" => Open,
        /// Hanging loose.
        "relaxed" => Relaxed,
        /// Closed on itself.
        "fist" => Fist,
        /// Index straight, the others closed.
        "point" => Point,
        /// Thumb and index pads against each other.
        "pinch" => Pinch,
        /// All fingers and the thumb around something of 5 to 8 cm.
        "power-grasp" => PowerGrasp,
    }
}

table! {
    /// Pose of the wrist, world. Its -z axis points to the fingers, +y out of the back of the hand.
    /// Give `rotation`, or the two directions.
    pub struct WristTable {
        /// Position [m].
        position: Option<Vec3> where PLACE;
        /// Unit quaternion x, y, z, w.
        rotation: Option<[f64; 4]> where UNIT;
        /// Direction of the fingers.
        fingers: Option<Vec3> where PLACE;
        /// Direction out of the back of the hand; its part along `fingers` is ignored.
        back: Option<Vec3> where PLACE;
    }
}

table! {
    /// Curl of each finger, from 0 (open) to 1 (fist).
    pub struct CurlTable {
        /// The thumb.
        thumb: Option<f64> where FRACTION;
        /// Index finger.
        index: Option<f64> where FRACTION;
        /// Middle finger.
        middle: Option<f64> where FRACTION;
        /// Ring finger.
        ring: Option<f64> where FRACTION;
        /// Little finger.
        little: Option<f64> where FRACTION;
    }
}

table! {
    /// Places of fingertips, world: the middle of each pad's skin.
    pub struct TipsTable {
        /// Place of the thumb's pad [m].
        thumb: Option<Vec3> where PLACE;
        /// Place of the index finger's pad [m].
        index: Option<Vec3> where PLACE;
        /// Place of the middle finger's pad [m].
        middle: Option<Vec3> where PLACE;
        /// Place of the ring finger's pad [m].
        ring: Option<Vec3> where PLACE;
        /// Place of the little finger's pad [m].
        little: Option<Vec3> where PLACE;
    }
}

table! {
    /// Angles of one joint.
    pub struct JointAngles {
        /// Flexion [degrees], positive when the hand closes.
        flexion_deg: Option<f64> where ANGLE;
        /// Spread [degrees], positive away from the middle finger (the thumb: out of the palm).
        spread_deg: Option<f64> where ANGLE;
    }
}

table! {
    /// One instant of a keyframed motion. What is left out is interpolated from the keys around.
    pub struct HandKey {
        /// Time [s]; later than the key before.
        time: f64 where DURATION;
        /// The wrist.
        wrist: Option<WristTable>;
        /// Shape of the whole hand.
        pose: Option<PoseWord>;
        /// Curl of each finger.
        curl: Option<CurlTable>;
        /// Single joints, by the name of the joint or of the bone it carries.
        joints: NamedJoints;
        /// Places of fingertips at that time, with the wrist where it is then: digits bend, near to
        /// the shape that the keys above give them, until the middle of each pad is there. Between
        /// keys their joints turn evenly. A place that is out of reach is an angle out of range:
        /// see `limits`.
        tips: Option<TipsTable>;
    }
}

table! {
    /// Keyframes of wrist and fingers; also what a motion file in TOML holds.
    pub struct KeyframesTable {
        /// Angles out of a joint's range: "error" (default) or "clamp".
        limits: LimitsWord = LimitsWord::Error;
        /// The keys, in order of time.
        key: Vec<HandKey>;
    }
}

table! {
    /// A motion file: `.toml` with keyframes, or `.jsonl` with a recording.
    pub struct MotionFileTable {
        /// Path, relative to the scene file.
        file: Located<String>;
    }
}

table! {
    /// Tracked hand joints from a JSON Lines file, resampled and filtered.
    pub struct RecordedTable {
        /// Path, relative to the scene file.
        file: Located<String>;
        /// Side of the recorded hand; left out, the side of this hand. The other side is mirrored.
        hand: Option<SideOfHandWord>;
        /// Part of the recording to skip [s]. Default 0.
        start_s: Option<f64> where DURATION;
        /// Position of the recording's origin, world [m]. Default [0, 0, 0].
        position: Option<Vec3> where PLACE;
        /// Turn of the recording about +y [degrees]. Default 0.
        heading_deg: Option<f64> where ANGLE;
        /// Natural frequency of the filter [Hz]; lower is smoother and later. Default 8.
        filter_hz: Option<f64> where SPRING;
        /// A longer gap between samples is a loss of tracking [s]. Default 0.1.
        loss_s: Option<f64> where DURATION;
        /// Time in which the hand gets back its full speed after a loss [s]. Default 0.5.
        reacquire_s: Option<f64> where DURATION;
        /// Fastest wrist [m/s]. Default 3.
        speed_max: Option<f64> where SPRING;
        /// Fastest turn of the wrist [degrees/s]. Default 1000.
        spin_max_deg: Option<f64> where SPRING;
        /// Fastest joint [degrees/s]. Default 1500.
        joint_rate_max_deg: Option<f64> where SPRING;
    }
}

choice! {
    /// Motion that a hand follows.
    pub enum MotionTable by "kind" {
        /// Keyframes, here.
        "keyframes" => Keyframes(KeyframesTable),
        /// A recording.
        "recorded" => Recorded(RecordedTable),
        /// A motion file.
        "file" => File(MotionFileTable),
    }
}
