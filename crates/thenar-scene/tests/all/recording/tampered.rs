//! Recordings that somebody has written into, with all checksums mended.

use super::stage::*;
use std::path::Path;
use thenar_scene::build::{Files, USUAL_PRESET};
use thenar_scene::format::PresetWord;
use thenar_scene::recording::{Index, Replay, Verdict};
use thenar_scene::session::{Session, Source};
use thenar_scene::tuning::SettingValue;

const STEPS: usize = 60;

/// The payloads of a recording's frames: kind, time, body. They come after a prologue of 16 bytes.
fn payloads(bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    let mut rest = &bytes[16..];
    while let Some((length, behind)) = rest.split_first_chunk::<4>() {
        let length = u32::from_le_bytes(*length) as usize;
        found.push(behind[4..4 + length].to_vec());
        rest = &behind[4 + length..];
    }
    found
}

/// A recording of these payloads, whose checksums agree.
fn recording(prologue: &[u8], payloads: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = prologue[..16].to_vec();
    let mut sum = u32::from_le_bytes(prologue[12..16].try_into().unwrap());
    for payload in payloads {
        let length = (payload.len() as u32).to_le_bytes();
        let mut hasher = crc32fast::Hasher::new_with_initial(sum);
        hasher.update(&length);
        hasher.update(payload);
        sum = hasher.finalize();
        bytes.extend(length);
        bytes.extend(sum.to_le_bytes());
        bytes.extend(payload);
    }
    bytes
}

const STEP: u8 = 4;

fn number(payload: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(payload[at..at + 8].try_into().unwrap())
}

fn add(payload: &mut [u8], at: usize, more: i64) {
    let new = number(payload, at).wrapping_add_signed(more);
    payload[at..at + 8].copy_from_slice(&new.to_le_bytes());
}

/// Where in a payload its time is, and in a step's its number.
const TIME: usize = 1;
const NUMBER: usize = 9;

/// Replays tampered payloads: what is found, and the steps that are told.
fn tampered(
    folder: &Folder,
    prologue: &[u8],
    payloads: &[Vec<u8>],
) -> (Verdict, Vec<(usize, u64)>) {
    let file = folder.file("tampered.rec");
    std::fs::write(&file, recording(prologue, payloads)).unwrap();
    let mut replay = Replay::open(&file).unwrap();
    let steps = steps(&mut replay);
    (replay.verdict().clone(), steps)
}

/// The frame of the step of this number.
fn step(payloads: &[Vec<u8>], wanted: u64) -> usize {
    payloads.iter().position(|p| p[0] == STEP && number(p, NUMBER) == wanted).unwrap()
}

fn driven(k: usize, session: &mut thenar_scene::session::Session) {
    session.live_pose(0, k as f64, &bent([0.0, 0.1, 0.0], 0.01 * k as f64)).unwrap();
}

#[track_caller]
fn check_told(steps: &[(usize, u64)], recorded: &[u64], context: &str) {
    assert!(steps.len() <= recorded.len(), "{context}: {} steps", steps.len());
    for (number, hash) in steps {
        assert!((1..=recorded.len()).contains(number), "{context}: step {number}");
        assert_eq!(*hash, recorded[number - 1], "{context}: step {number}");
    }
}

#[test]
fn a_mark_beyond_what_its_time_allows_is_damage_and_costs_nothing_else() {
    let folder = Folder::new("tampered-number");
    let (file, recorded) = folder.record(GLOVE, STEPS, driven);
    let (whole, frames) = (bytes(&file), payloads(&bytes(&file)));
    assert!(recording(&whole, &frames) == whole, "the tool of this test is right");
    for wanted in [1, 9, 10, 31, 59, 60] {
        for more in [9_175_398, 1_000_000, 5000, 2, 1, -1, -5000, i64::MAX, i64::MIN] {
            let mut hurt = frames.clone();
            add(&mut hurt[step(&frames, wanted)], NUMBER, more);
            let context = format!("step {wanted} is told as {more} more");
            let (verdict, steps) = tampered(&folder, &whole, &hurt);
            check_told(&steps, &recorded, &context);
            assert_eq!(verdict.losses.len(), 1, "{context}: {verdict:?}");
            assert!(verdict.is_same() && verdict.ended, "{context}: {verdict:?}");
            // Only the mark is missing: its step is made again, unless nothing comes behind it.
            assert_eq!(steps.len(), STEPS - 1, "{context}");
            // Where a keyframe follows at once, that step need not be made.
            assert_eq!(verdict.lost, u64::from(wanted % 10 == 0), "{context}");
        }
    }
}

/// The state after a step has the hash of its mark. The last keyframe counts as the others, where
/// no step behind it would tell.
#[test]
fn a_keyframe_with_another_state_than_its_mark_is_damage_and_costs_nothing_else() {
    const KEYFRAME: u8 = 5;
    let folder = Folder::new("tampered-keyframe");
    let (file, recorded) = folder.record(BALL, STEPS, |_, _| ());
    let (whole, frames) = (bytes(&file), payloads(&bytes(&file)));
    let keyframes: Vec<usize> = (0..frames.len()).filter(|k| frames[*k][0] == KEYFRAME).collect();
    assert_eq!(keyframes.len(), 6);
    for k in keyframes {
        // Behind kind, time and number: the state's time, as an f64, and a coordinate.
        for at in [12, 40] {
            let mut hurt = frames.clone();
            hurt[k][at] ^= 1;
            let (verdict, steps) = tampered(&folder, &whole, &hurt);
            let context = format!("byte {at} of frame {k}");
            check_told(&steps, &recorded, &context);
            assert_eq!((verdict.losses.len(), steps.len()), (1, STEPS), "{context}: {verdict:?}");
            assert!(verdict.is_same() && verdict.ended && verdict.lost == 0, "{verdict:?}");
            assert_eq!(verdict.put_right.0, 0, "{context}: {verdict:?}");
        }
    }
}

/// A mark says that a step was taken back, or the scene begins at another time or with another
/// step.
#[test]
fn what_a_mark_or_a_scene_says_besides_its_hash_is_compared() {
    let folder = Folder::new("tampered-flag");
    let (file, _) = folder.record(BALL, STEPS, |_, _| ());
    let (whole, frames) = (bytes(&file), payloads(&bytes(&file)));
    let flag = frames[step(&frames, 31)].len() - 1;
    let scene = frames.iter().position(|frame| frame[0] == 2).unwrap();
    let end = frames[scene].len();
    for (k, at, number) in
        [(step(&frames, 31), flag, 31), (scene, end - 4, 0), (scene, end - 12, 0)]
    {
        let mut hurt = frames.clone();
        hurt[k][at] ^= 1;
        let first = tampered(&folder, &whole, &hurt).0.first;
        assert_eq!(first.map(|first| first.step), Some(number), "byte {at} of frame {k}");
    }
}

/// So that the time would allow it.
#[test]
fn a_mark_with_its_time_ahead_of_all_behind_it_is_damage() {
    let folder = Folder::new("tampered-both");
    let (file, recorded) = folder.record(GLOVE, STEPS, driven);
    let (whole, frames) = (bytes(&file), payloads(&bytes(&file)));
    for more in [1001, 5000, 900_000, 9_000_000] {
        let mut hurt = frames.clone();
        let mark = &mut hurt[step(&frames, 31)];
        add(mark, NUMBER, more);
        add(mark, TIME, more * 10_000_000);
        let (verdict, steps) = tampered(&folder, &whole, &hurt);
        check_told(&steps, &recorded, &format!("{more} more"));
        assert!(!verdict.losses.is_empty() && steps.len() == STEPS - 1, "{more}: {verdict:?}");
    }
}

#[test]
fn no_time_of_a_run_can_be_changed_unseen() {
    let folder = Folder::new("tampered-time");
    let (file, recorded) = folder.record(GLOVE, STEPS, driven);
    let (whole, frames) = (bytes(&file), payloads(&bytes(&file)));
    let clean = tampered(&folder, &whole, &frames).0;
    assert!(clean.is_same() && clean.losses.is_empty() && clean.steps == 60, "{clean:?}");
    // Scene, inputs, steps and keyframes carry simulated time.
    for k in (0..frames.len()).filter(|k| (2..=5).contains(&frames[*k][0])) {
        let years = 7_926_335_344_188_000_000;
        for more in [1, -1, 2_000_000_000, years, i64::MIN].into_iter().skip(k % 2) {
            let mut hurt = frames.clone();
            add(&mut hurt[k], TIME, more);
            let (verdict, steps) = tampered(&folder, &whole, &hurt);
            let context = format!("{more} ns more in frame {k} of kind {}", frames[k][0]);
            check_told(&steps, &recorded, &context);
            assert!(!verdict.losses.is_empty(), "{context}: {verdict:?}");
            assert!(verdict.seconds < 0.61, "{context}: {verdict:?}");
        }
    }
}

/// By the clock on the wall any time is possible that rises, but none ahead of those behind it.
#[test]
fn times_of_a_live_session_do_not_leap_ahead_of_what_follows() {
    let folder = Folder::new("tampered-live");
    let (file, recorded) = folder.record(BALL, STEPS, |_, _| ());
    let whole = bytes(&file);
    let mut frames = payloads(&whole);
    // As if it had been live.
    let text = String::from_utf8(frames[0][9..].to_vec()).unwrap();
    let live = text.replace("\"simulated_time\":true", "\"simulated_time\":false");
    assert_ne!(text, live);
    frames[0].splice(9.., live.into_bytes());
    let end = frames.len() - 1;
    // The clock on the wall stood at some milliseconds when it was written.
    frames[end][TIME..TIME + 8].copy_from_slice(&700_000_000_u64.to_le_bytes());
    let clean = tampered(&folder, &whole, &frames).0;
    assert!(clean.is_same() && clean.losses.is_empty() && clean.steps == 60, "{clean:?}");
    for wanted in [1, 30, 60] {
        for more in [1_500_000_000, 7_926_335_344_188_000_000] {
            let mut hurt = frames.clone();
            add(&mut hurt[step(&frames, wanted)], TIME, more);
            let context = format!("step {wanted}, {more} ns");
            let (verdict, steps) = tampered(&folder, &whole, &hurt);
            check_told(&steps, &recorded, &context);
            assert_eq!(verdict.losses.len(), 1, "{context}: {verdict:?}");
            assert!(verdict.seconds < 0.61 && steps.len() == STEPS - 1, "{context}");
            let index = Index::of(&folder.file("tampered.rec")).unwrap();
            assert!(index.end() < 0.61, "{context}: {}", index.end());
        }
    }
    // A pause of an hour is none of this.
    let mut paused = frames.clone();
    let from = step(&frames, 31);
    paused[from..].iter_mut().for_each(|frame| add(frame, TIME, 3_600_000_000_000));
    let (verdict, _) = tampered(&folder, &whole, &paused);
    assert!(verdict.is_same() && verdict.losses.is_empty() && verdict.steps == 60, "{verdict:?}");
}

/// Honest recordings pass: other time steps, restarts, scenes, marks that were dropped.
#[test]
fn what_was_written_is_possible() {
    let folder = Folder::new("possible");
    let (file, recorded) = folder.record_all(&[(GLOVE, 40), (BALL, 30)], |k, session| match k {
        7 => session.set("time_step", &SettingValue::Number(0.004)).unwrap(),
        13 => session.restart(),
        19 => session.set("time_step", &SettingValue::Number(1.0 / 60.0)).unwrap(),
        _ => {}
    });
    let whole = bytes(&file);
    assert_clean(&file, 70);
    let index = Index::of(&file).unwrap();
    for seconds in index.beginnings() {
        let mut replay = Replay::open_at(&file, seconds).unwrap();
        while replay.next().unwrap().is_some() {}
        let verdict = replay.verdict();
        assert!(verdict.is_same() && verdict.losses.is_empty(), "{seconds} s: {verdict:?}");
    }
    // Without the marks of twenty steps, and keyframes, as if they had been dropped.
    let mut scenes = 0;
    let mut frames = payloads(&whole);
    frames.retain(|frame| {
        scenes += u32::from(frame[0] == 2);
        let dropped = frame[0] == 5 || (frame[0] == STEP && (3..23).contains(&number(frame, 9)));
        !(dropped && scenes == 1)
    });
    std::fs::write(&file, recording(&whole, &frames)).unwrap();
    let mut replay = Replay::open(&file).unwrap();
    assert_eq!(replayed(&mut replay), recorded);
    let verdict = replay.verdict();
    assert!(verdict.is_same() && verdict.losses.is_empty(), "{verdict:?}");
    assert_eq!((verdict.steps, verdict.unmarked), (70, 20));
}

#[track_caller]
fn assert_clean(file: &Path, steps: u64) {
    let mut replay = Replay::open(file).unwrap();
    while replay.next().unwrap().is_some() {}
    let verdict = replay.verdict();
    assert!(verdict.is_same() && verdict.losses.is_empty() && verdict.ended, "{verdict:?}");
    assert_eq!((verdict.steps, verdict.same), (steps, steps));
}

/// Programs that knew the paper's hand alone wrote nothing behind the parts of a scene frame; a
/// number that is not known is refused.
#[test]
fn a_scene_means_the_hand_that_it_meant_when_it_was_recorded() {
    const SCENE: u8 = 2;
    let folder = Folder::new("meant");
    let text = "version = 1\ntime_step = 0.01\n[[hand]]\nname = \"hand\"\nposition = [0, 0.1, 0]\n";
    for usual_hand in [PresetWord::Paper, USUAL_PRESET] {
        let source = Source { usual_hand, ..Source::new(text, &folder.file("scene.toml"), &[]) };
        let session = Session::open(&source, Files::beside(&source.file)).unwrap();
        let tets = session.hands()[0].model.flesh.tets.len();
        let (file, hashes) = folder.record_sessions([(session, 20)].into_iter(), driven);
        let whole = bytes(&file);
        std::fs::remove_file(&file).unwrap();
        let mut found = payloads(&whole);
        let scene = found.iter().position(|p| p[0] == SCENE).unwrap();
        let meant = [PresetWord::Paper, PresetWord::Touch].iter().position(|h| *h == usual_hand);
        assert_eq!(found[scene].last().copied().map(usize::from), meant);
        let check = |payloads: &[Vec<u8>], tets: usize| {
            let file = folder.file("meant.rec");
            std::fs::write(&file, recording(&whole, payloads)).unwrap();
            let mut replay = Replay::open(&file).unwrap();
            assert_eq!(replayed(&mut replay), hashes);
            assert!(replay.verdict().is_same(), "{}", replay.verdict());
            assert_eq!(replay.session().unwrap().hands()[0].model.flesh.tets.len(), tets);
        };
        check(&found, tets);
        if usual_hand == PresetWord::Paper {
            // 597 in the paper.
            assert!((540..660).contains(&tets));
            found[scene].pop();
            check(&found, tets);
            found[scene].push(200);
            let file = folder.file("unknown.rec");
            std::fs::write(&file, recording(&whole, &found)).unwrap();
            assert!(Replay::open(&file).unwrap().next().is_err());
        }
    }
}
