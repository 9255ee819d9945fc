//! Recordings that are whole or not by their own word,
//! with frames put in as a program could have written them.

use crate::stage::{Folder, err, out};
use std::path::Path;
use thenar_record::{FrameKind, Recorder};

/// Copies a recording, with a frame of this kind and body before the tenth step.
fn with_frame(from: &Path, to: &Path, kind: FrameKind, body: &[u8]) {
    let _ = std::fs::remove_file(to);
    let (header, mut frames) = thenar_record::open(from).unwrap();
    let recorder = Recorder::create(to, &header).unwrap();
    let mut writer = recorder.session();
    let mut steps = 0;
    while let Some(frame) = frames.next().unwrap() {
        let own = frame.kind.unwrap();
        steps += u32::from(own == FrameKind::Step);
        if own == FrameKind::Step && steps == 10 {
            // Of the time of the frame before, as what entered after nine steps.
            writer.big_frame(kind, frame.time_ns - 2_000_000, |out| out.extend(body));
        }
        if own != FrameKind::End {
            writer.big_frame(own, frame.time_ns, |out| out.extend(frame.body));
        }
    }
    drop(writer);
    recorder.finish().unwrap();
}

fn recorded(name: &str) -> Folder {
    let folder = Folder::new(name);
    let args = ["record", "falling-box", "--seconds", "0.2", "--out", "whole.rec", "-q"];
    let output = folder.thenar(&args);
    assert!(output.status.success(), "{}", err(&output));
    folder
}

/// A gap as the recorder writes it: source, frames, and how many of them are inputs or records.
fn gap(source: u32, frames: u64, heavy: u64) -> Vec<u8> {
    [&source.to_le_bytes()[..], &frames.to_le_bytes(), &heavy.to_le_bytes()].concat()
}

#[test]
fn what_a_recording_lacks_by_its_own_word_fails_verification() {
    let folder = recorded("lacks");
    let of_channel = [&77_u32.to_le_bytes()[..], &1.0_f64.to_le_bytes()].concat();
    // Postcard: nine steps, variant, hand (200 takes two bytes).
    let [lost, script, let_go] = [2, 3, 8].map(|variant| vec![9, variant, 0xc8, 0x01]);
    let no_hand = "there is no hand 200: the scene has 0";
    for (kind, body, why) in [
        (FrameKind::Gap, gap(0, 5, 0), "5 frames of the session were dropped, 0 of them inputs"),
        (FrameKind::Gap, gap(0, 5, 5), "5 frames of the session were dropped, 5 of them inputs"),
        (
            FrameKind::Gap,
            gap(3, u64::MAX, 1),
            "18446744073709551615 frames of a channel were dropped, 1",
        ),
        (FrameKind::Record, of_channel, "records that fit no channel as it was announced: 1"),
        (FrameKind::Input, lost, no_hand),
        (FrameKind::Input, script, no_hand),
        (FrameKind::Input, let_go, no_hand),
    ] {
        let file = folder.0.join("lacks.rec");
        with_frame(&folder.0.join("whole.rec"), &file, kind, &body);
        let replayed = folder.thenar(&["replay", "lacks.rec"]);
        assert!(replayed.status.success(), "{why}: {}", err(&replayed));
        assert!(out(&replayed).contains(why), "{why}: {}", out(&replayed));
        let verified = folder.thenar(&["replay", "lacks.rec", "--verify", "-q"]);
        let told = err(&verified);
        assert_eq!(verified.status.code(), Some(1), "{why}: {told}");
        assert!(told.starts_with("error: lacks.rec: ") && told.contains(why), "{told}");
    }
    // A channel without records lacks nothing, and the copy itself is sound.
    let file = folder.0.join("same.rec");
    with_frame(&folder.0.join("whole.rec"), &file, FrameKind::Channel, CHANNEL.as_bytes());
    let verified = folder.thenar(&["replay", "same.rec", "--verify"]);
    assert!(verified.status.success(), "{}", err(&verified));
}

const CHANNEL: &str = r#"{"id":1,"name":"c","fields":[]}"#;

#[test]
fn a_replay_begins_within_the_recording_and_verifies_a_step_at_least() {
    let folder = recorded("beyond");
    for (from, ends) in [("0.201", "0.201 s"), ("1e9", "1e9 s"), ("1e308", "1e308 s")] {
        for more in [&["--verify"][..], &["--serve", "--no-open"], &["-q"]] {
            let output = folder.thenar(&[&["replay", "whole.rec", "--from", from], more].concat());
            let told = format!(
                "error: whole.rec: nothing is left to replay from {ends} on: the recording ends at \
                 0.200 s\n"
            );
            assert_eq!((output.status.code(), err(&output)), (Some(2), told), "{more:?}");
        }
    }
    // Its keyframe is the end: there is one at 0.2 s.
    let args = ["record", "falling-box", "--seconds", "0.2", "--keyframes", "0.1", "-o", "k.rec"];
    assert!(folder.thenar(&args).status.success());
    let part = folder.thenar(&["replay", "k.rec", "--from", "0.15", "--verify"]);
    assert!(part.status.success(), "{}", err(&part));
    assert!(out(&part).contains("the same bits in all 50 steps"), "{}", out(&part));
    let none = folder.thenar(&["replay", "k.rec", "--from", "0.2", "--verify"]);
    let told = (none.status.code(), err(&none));
    assert_eq!(told, (Some(1), "error: k.rec: there is no step to compare\n".into()));
}

/// Recorded on 21 November 2026 by the build of d95612b, before contact became continuous.
#[test]
fn a_recording_of_an_older_build_opens_and_tells_from_where_it_differs() {
    let folder = Folder::new("older");
    let older = include_bytes!("data/soft-cube-d95612b.rec");
    std::fs::write(folder.0.join("older.rec"), older).unwrap();
    let replayed = folder.thenar(&["replay", "older.rec"]);
    assert!(replayed.status.success(), "{}", err(&replayed));
    let said = out(&replayed);
    // The cube falls freely for some 40 of its 50 steps: where another processor rounds differently
    // it differs sooner.
    assert!(said.contains("differs from step "), "{said}");
    assert!(said.contains("it was recorded by another build of thenar"), "{said}");
}
