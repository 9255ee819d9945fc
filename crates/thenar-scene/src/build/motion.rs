//! Motions of hands, from tables and files.

use super::Files;
use super::assets;
use crate::format::{
    CurlTable, HandKey, JointAngles, KeyframesTable, LimitsWord, MotionTable, PoseWord,
    RecordedTable, SideOfHandWord, TipsTable, WristTable,
};
use crate::math::Pose;
use crate::motion::{
    FitError, HandMotion, JointKey, Key, Keyframes, KeyframesDesc, LimitPolicy, MotionError,
    Preset, Recorded, RecordedDesc, Recording, WristKey,
};
use crate::text::{Fault, Located, Node, parse};
use std::collections::BTreeMap;
use thenar_core::model::{Digit, HandModel, Side};

/// Largest keyframe file \[bytes\].
const KEYFRAMES_BYTES_MAX: u64 = 4 << 20;

/// Loads a motion for a hand that starts at `pose_WM` where the motion does not say.
pub fn load(
    table: &Located<MotionTable>,
    hand: &HandModel,
    pose_WM: &Pose,
    files: &Files,
) -> Result<HandMotion, Fault> {
    let keyframes = |desc: &KeyframesDesc, at: &dyn Fn(String) -> Fault| {
        Keyframes::new(desc, hand, pose_WM)
            .map(|k| HandMotion::Keyframes(Box::new(k)))
            .map_err(|e| at(e.to_string()))
    };
    match &table.value {
        MotionTable::Keyframes(k) => keyframes(&desc(k), &|p| table.fault(p)),
        MotionTable::Recorded(r) => recorded(&recorded_desc(r), &r.file, hand, files),
        MotionTable::File(f) if f.file.value.ends_with(".jsonl") => {
            recorded(&RecordedDesc::of_file(&f.file.value), &f.file, hand, files)
        }
        MotionTable::File(f) => {
            // By the table of scenes, so that both take the same, and their schema describes it.
            let text = assets::read_text(files, &f.file, KEYFRAMES_BYTES_MAX)?;
            let read = Node::parse(&text).and_then(|root| parse::<KeyframesTable>(&root));
            let table = read.map_err(|fault| {
                let located = fault.locate(&assets::path(files, &f.file), &text, &[]);
                f.file.fault(located.to_string())
            })?;
            keyframes(&desc(&table), &|p| f.file.fault(p))
        }
    }
}

fn recorded(
    desc: &RecordedDesc,
    file: &Located<String>,
    hand: &HandModel,
    files: &Files,
) -> Result<HandMotion, Fault> {
    let recording = Recording::open(&assets::path(files, file))
        .map_err(|e| file.fault(MotionError::from(e).to_string()))?;
    let problem = |e: FitError| match e {
        // The recording's, not the scene's.
        FitError::NoHand { .. } => format!("{}: {e}", assets::path(files, file).display()),
        other => other.to_string(),
    };
    Recorded::new(desc, &recording, hand)
        .map(|motion| HandMotion::Recorded(Box::new(motion)))
        .map_err(|e| file.fault(problem(e)))
}

fn recorded_desc(t: &RecordedTable) -> RecordedDesc {
    let usual = RecordedDesc::of_file(&t.file.value);
    RecordedDesc {
        hand: t.hand.map(|side| match side {
            SideOfHandWord::Left => Side::Left,
            SideOfHandWord::Right => Side::Right,
        }),
        start_s: t.start_s.unwrap_or(usual.start_s),
        position: t.position.map_or(usual.position, Into::into),
        heading_deg: t.heading_deg.unwrap_or(usual.heading_deg),
        filter_hz: t.filter_hz.unwrap_or(usual.filter_hz),
        loss_s: t.loss_s.unwrap_or(usual.loss_s),
        reacquire_s: t.reacquire_s.unwrap_or(usual.reacquire_s),
        speed_max: t.speed_max.unwrap_or(usual.speed_max),
        spin_max_deg: t.spin_max_deg.unwrap_or(usual.spin_max_deg),
        joint_rate_max_deg: t.joint_rate_max_deg.unwrap_or(usual.joint_rate_max_deg),
        ..usual
    }
}

fn desc(t: &KeyframesTable) -> KeyframesDesc {
    let limits = match t.limits {
        LimitsWord::Error => LimitPolicy::Error,
        LimitsWord::Clamp => LimitPolicy::Clamp,
    };
    KeyframesDesc { limits, key: t.key.iter().map(key).collect() }
}

fn key(k: &HandKey) -> Key {
    let joint = |j: &JointAngles| JointKey { flexion_deg: j.flexion_deg, spread_deg: j.spread_deg };
    Key {
        time: k.time,
        wrist: k.wrist.as_ref().map(wrist),
        pose: k.pose.map(preset),
        curl: k.curl.as_ref().map(curl).unwrap_or_default(),
        joints: k.joints.0.iter().map(|(name, j)| (name.clone(), joint(j))).collect(),
        tips: k.tips.as_ref().map(tips).unwrap_or_default(),
    }
}

fn tips(t: &TipsTable) -> BTreeMap<Digit, [f64; 3]> {
    let fingers = [t.thumb, t.index, t.middle, t.ring, t.little];
    let places = Digit::FINGERS.into_iter().zip(fingers);
    places.filter_map(|(digit, place)| place.map(|place| (digit, place.into()))).collect()
}

fn wrist(w: &WristTable) -> WristKey {
    WristKey {
        position: w.position.map(Into::into),
        rotation: w.rotation,
        fingers: w.fingers.map(Into::into),
        back: w.back.map(Into::into),
    }
}

fn curl(c: &CurlTable) -> BTreeMap<Digit, f64> {
    let fingers = [c.thumb, c.index, c.middle, c.ring, c.little];
    Digit::FINGERS.into_iter().zip(fingers).filter_map(|(d, c)| c.map(|c| (d, c))).collect()
}

fn preset(word: PoseWord) -> Preset {
    match word {
        PoseWord::Rest => Preset::Rest,
        PoseWord::Open => Preset::Open,
        PoseWord::Relaxed => Preset::Relaxed,
        PoseWord::Fist => Preset::Fist,
        PoseWord::Point => Preset::Point,
        PoseWord::Pinch => Preset::Pinch,
        PoseWord::PowerGrasp => Preset::PowerGrasp,
    }
}
