//! What is left of a damaged recording.

use super::stage::*;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;
use thenar_record::FrameKind;
use thenar_scene::recording::{Index, Replay, ReplayError};
use thenar_scene::session::Session;
use thenar_scene::tuning::SettingValue;

const STEPS: usize = 60;

/// Poses all the time, as of a tracker; settings and a leader on the way. Keyframes after steps 10,
/// 20, ...
fn tracked_session(k: usize, session: &mut Session) {
    let t = H * k as f64;
    let pose = bent([0.05 * t, 0.1 - 0.25 * t, 0.0], 0.5 * t);
    session.live_pose(0, 7.0 + t, &pose).unwrap();
    match k {
        23 => session.set("friction", &SettingValue::Number(0.1)).unwrap(),
        24 => session.set("gravity", &SettingValue::Number(4.0)).unwrap(),
        34..44 => assert!(session.lead(0, moved_targets(session, 1e-3).into_iter())),
        44 => session.let_go(0),
        _ => {}
    }
}

/// Where the frames of a file lie, and the time of each as a number of steps.
fn frames(file: &Path) -> Vec<(Option<FrameKind>, usize, Range<usize>)> {
    let (_, mut frames) = thenar_record::open(file).unwrap();
    let mut found = Vec::new();
    let mut at = frames.offset() as usize;
    while let Some(frame) = frames.next().unwrap() {
        let (kind, time) = (frame.kind, (frame.time_ns as f64 * 1e-9 / H).round() as usize);
        let end = frames.offset() as usize;
        found.push((kind, time, at..end));
        at = end;
    }
    found
}

/// Replays changed bytes: numbers and hashes of the steps that are told.
fn replay_of(folder: &Folder, bytes: &[u8]) -> (Replay, Vec<(usize, u64)>) {
    let file = folder.file("hurt.rec");
    std::fs::write(&file, bytes).unwrap();
    let mut replay = Replay::open(&file).unwrap();
    let steps = steps(&mut replay);
    (replay, steps)
}

/// Steps that are not told.
fn missing(steps: &[(usize, u64)]) -> Vec<usize> {
    let told: BTreeSet<usize> = steps.iter().map(|step| step.0).collect();
    assert!(told.len() == steps.len() && steps.is_sorted_by_key(|step| step.0), "each once");
    (1..=STEPS).filter(|k| !told.contains(k)).collect()
}

#[track_caller]
fn assert_same(steps: &[(usize, u64)], recorded: &[u64], context: &str) {
    for (number, hash) in steps {
        assert_eq!(*hash, recorded[number - 1], "{context}: step {number}");
    }
}

#[test]
fn a_damaged_session_goes_on_with_the_same_bits() {
    let folder = Folder::new("hurt");
    let mut contacts = 0;
    let (file, recorded) = folder.record(FLESH, STEPS, |k, session| {
        tracked_session(k, session);
        contacts += session.report().contacts;
    });
    assert!(contacts > 100, "the hand presses the table: {contacts}");
    let (whole, frames) = (bytes(&file), frames(&file));
    let of = |kind: FrameKind, time: usize| {
        let it = frames.iter().find(|frame| frame.0 == Some(kind) && frame.1 == time);
        it.map(|frame| frame.2.clone()).unwrap()
    };

    // Marks alone, here and there: all steps are made, those with their marks are told.
    let mut hurt = whole.clone();
    let marks = [3, 14, 15, 28, 41, 59];
    marks.iter().for_each(|k| hurt[of(FrameKind::Step, *k).start + 20] ^= 0x40);
    let (replay, steps) = replay_of(&folder, &hurt);
    assert_same(&steps, &recorded, "marks");
    assert_eq!(missing(&steps), marks);
    let verdict = replay.verdict();
    assert!(verdict.is_same() && verdict.losses.len() == marks.len(), "{verdict:?}");
    assert_eq!((verdict.steps, verdict.unmarked, verdict.lost), (60, 6, 0));

    // A piece in the middle is overwritten: with poses and both settings, while the hand is led,
    // when it is let go of.
    for (from, to) in [(21, 26), (35, 38), (42, 46), (12, 33)] {
        let (mut hurt, piece) =
            (whole.clone(), of(FrameKind::Step, from).end..of(FrameKind::Step, to).start);
        hurt[piece.clone()].fill(0x5a);
        let context = format!("{from} to {to}, {} bytes", piece.len());
        let (replay, steps) = replay_of(&folder, &hurt);
        assert_same(&steps, &recorded, &context);
        let verdict = replay.verdict();
        assert!(verdict.is_same() && verdict.ended && verdict.losses.len() == 1, "{verdict:?}");
        // From the keyframe after the piece on, everything is there.
        let keyframe = to.next_multiple_of(KEYFRAME);
        assert_eq!(missing(&steps), (from + 1..=keyframe).collect::<Vec<_>>(), "{context}");
        assert_eq!(verdict.lost as usize, keyframe - from, "{context}");
        let loss = verdict.losses[0];
        assert!((loss.from - H * from as f64).abs() < 1e-9, "{context}: {loss:?}");
        assert!((loss.until.unwrap() - H * keyframe as f64).abs() < 1e-9, "{context}: {loss:?}");
    }

    // Cut off within a keyframe and within a pose.
    for (kind, time) in [(FrameKind::Keyframe, 20), (FrameKind::Input, 47)] {
        let cut = of(kind, time).start + 30;
        let (replay, steps) = replay_of(&folder, &whole[..cut]);
        assert_same(&steps, &recorded, "cut");
        assert_eq!(missing(&steps), (time + 1..=STEPS).collect::<Vec<_>>());
        let verdict = replay.verdict();
        assert!(verdict.is_same() && !verdict.ended, "{verdict:?}");
    }
}

#[test]
fn damage_anywhere_costs_no_more_than_up_to_the_next_keyframe() {
    let folder = Folder::new("hole");
    let (file, recorded) = folder.record(GLOVE, STEPS, tracked_session);
    let (whole, frames) = (bytes(&file), frames(&file));
    // Behind the frame of the scene, with which all would be gone.
    let first = frames.iter().find(|frame| frame.0 == Some(FrameKind::Scene)).unwrap().2.end;
    let (mut caught_up, mut lost) = (0, 0);
    for (k, at) in (first..whole.len()).step_by((whole.len() - first) / 40).enumerate() {
        let mut hurt = whole.clone();
        match k % 2 {
            0 => drop(hurt.drain(at..(at + 30).min(whole.len()))),
            _ => hurt[at] ^= 0x10,
        }
        let (replay, steps) = replay_of(&folder, &hurt);
        let verdict = replay.verdict();
        assert!(!verdict.losses.is_empty(), "{at}");
        assert_same(&steps, &recorded, &format!("at {at}"));
        assert!(verdict.is_same(), "{at}: {verdict:?}");
        let before = (verdict.losses[0].from / H).round() as usize;
        let gone = missing(&steps);
        let next = (before / KEYFRAME + 1) * KEYFRAME;
        // A keyframe that is hit itself leaves the one after it.
        let end = if gone.last().is_some_and(|k| *k > next) { next + KEYFRAME } else { next };
        assert!(gone.iter().all(|k| (before..=end).contains(k)), "{at}: {gone:?}");
        caught_up += usize::from(gone.len() <= 2);
        lost += usize::from(verdict.lost > 0);
    }
    assert!(caught_up > 3 && lost > 10, "{caught_up} {lost}");
}

/// Its steps have the numbers that would follow in the scene before, and its state would fit.
#[test]
fn a_scene_whose_beginning_is_lost_is_not_taken_for_the_one_before() {
    let folder = Folder::new("foreign");
    let heavy = BALL.replace("mass = 0.2", "mass = 0.4").replace("0.06", "0.2");
    let (file, recorded) = folder.record_all(&[(BALL, 5), (&heavy, 25)], |_, _| ());
    let frames = frames(&file);
    let scene = frames.iter().rfind(|frame| frame.0 == Some(FrameKind::Scene)).unwrap();
    let eighth =
        frames.iter().find(|frame| frame.0 == Some(FrameKind::Step) && frame.1 == 13).unwrap();
    let mut hurt = bytes(&file);
    hurt[scene.2.start..eighth.2.end].fill(0x5a);
    let (mut replay, steps) = replay_of(&folder, &hurt);
    let hashes: Vec<u64> = steps.iter().map(|step| step.1).collect();
    assert_eq!(hashes, recorded[..5]);
    let verdict = replay.verdict();
    assert!(verdict.is_same() && verdict.losses[0].until.is_none(), "{verdict:?}");
    let index = Index::of(&folder.file("hurt.rec")).unwrap();
    let error = replay.go_to(&index, 0.2).unwrap_err().to_string();
    assert!(error.contains("a scene that is not in the recording"), "{error}");
    assert_eq!(replay.go_to(&index, 0.03).unwrap(), 0.0);
}

#[test]
fn whatever_is_cut_off_the_rest_is_replayed() {
    let folder = Folder::new("cut");
    let (file, recorded) = folder.record(BALL, 6, |k, session| {
        if k == 3 {
            session.set("gravity", &SettingValue::Number(5.0)).unwrap();
        }
    });
    let whole = bytes(&file);
    let cut = folder.file("cut.rec");
    let (mut lengths, mut damaged) = (Vec::new(), 0);
    for size in (0..whole.len()).step_by(5) {
        std::fs::write(&cut, &whole[..size]).unwrap();
        match Replay::open(&cut) {
            Err(error) => assert!(matches!(error, ReplayError::Open(_)) && size < 300, "{error}"),
            Ok(mut replay) => {
                let hashes = replayed(&mut replay);
                assert_eq!(hashes, recorded[..hashes.len()], "{size}");
                assert!(replay.verdict().is_same() && !replay.verdict().ended);
                damaged += usize::from(!replay.verdict().losses.is_empty());
                lengths.push(hashes.len());
            }
        }
    }
    assert!(lengths.is_sorted() && lengths.first() == Some(&0) && lengths.last() == Some(&6));
    assert!(damaged > lengths.len() / 2, "only cuts between frames leave no damage");
}
