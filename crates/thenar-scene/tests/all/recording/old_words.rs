//! Recordings of programs that spelled words differently.

use super::stage::*;
use thenar_record::{FrameKind, Header, Recorder};
use thenar_scene::recording::{Index, Replay};
use thenar_scene::session::Session;
use thenar_scene::tuning::SettingValue;

const STEPS: usize = 40;

/// The body with each text `monolithic`, its length before it, as `exact`; and how many there were.
fn as_once(body: &[u8]) -> (Vec<u8>, usize) {
    let now = b"\x0amonolithic";
    let (mut old, mut rest, mut count) = (Vec::new(), body, 0);
    while let Some((first, behind)) = rest.split_first() {
        if let Some(behind) = rest.strip_prefix(now) {
            old.extend(b"\x05exact");
            rest = behind;
            count += 1;
        } else {
            old.push(*first);
            rest = behind;
        }
    }
    (old, count)
}

#[test]
fn recordings_may_call_the_monolithic_solver_exact() {
    let folder = Folder::new("exact");
    let text = GLOVE.replacen("[[rigid]]", "[solver]\nkind = \"exact\"\n[[rigid]]", 1);
    let choose = |session: &mut Session, word: &str| {
        session.set("solver", &SettingValue::Choice(word.into())).unwrap();
    };
    let (file, recorded) = folder.record(&text, STEPS, |k, session| match k {
        5 => choose(session, "two-step"),
        // Written by its present name.
        15 => choose(session, "exact"),
        _ => {}
    });
    let old = folder.file("old.rec");
    let recorder = Recorder::create(&old, &Header::default()).unwrap();
    let mut writer = recorder.session();
    let (_, mut frames) = thenar_record::open(&file).unwrap();
    let mut respelled = [0, 0];
    while let Some(frame) = frames.next().unwrap() {
        let kind = frame.kind.unwrap();
        let (body, count) = as_once(frame.body);
        match kind {
            FrameKind::End => continue,
            FrameKind::Input => respelled[0] += count,
            FrameKind::Keyframe => respelled[1] += count,
            _ => assert_eq!(count, 0),
        }
        writer.big_frame(kind, frame.time_ns, |out| out.extend(body));
    }
    drop(writer);
    recorder.finish().unwrap();
    // Keyframes after 20 and 30 steps at least have the setting.
    assert!(respelled[0] == 1 && respelled[1] >= 2, "{respelled:?}");
    let index = Index::of(&old).unwrap();
    for seconds in [0.0, 0.2, 0.3] {
        let mut replay = Replay::open(&old).unwrap();
        replay.go_to(&index, seconds).unwrap();
        let hashes = replayed(&mut replay);
        assert_eq!(hashes, recorded[STEPS - hashes.len()..], "{seconds}");
        let verdict = replay.verdict();
        assert!(verdict.is_same() && verdict.ended, "{seconds}: {verdict:?}");
        assert_eq!(verdict.put_right.0, 0, "{seconds}: keyframes agree in memory");
    }
}
