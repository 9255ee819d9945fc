//! A grip goes on with the same bits: from a snapshot in the midst of it, and from a recording.

use crate::stage::{Stage, open};
use thenar_record::{Header, Recorder};
use thenar_scene::grip::GripKind;
use thenar_scene::recording::{Replay, SessionWriter, TimeOf, go_on_from, snapshot};
use thenar_scene::session::Session;

fn run(session: &mut Session, until: f64) {
    while session.world().time() < until - 1e-9 {
        session.step(&mut ());
    }
}

#[test]
fn a_snapshot_of_every_phase_goes_on_with_the_same_bits() {
    let stage =
        Stage { more: "open = 1.6".into(), ..Stage::ball("paper", GripKind::Tripod, 2.0, 0.01) };
    let mut session = stage.session();
    let start = session.world().state_hash();
    let mut kept = Vec::new();
    for until in [0.05, 0.2, 0.6, 1.2, 1.8] {
        run(&mut session, until);
        kept.push(snapshot(&session, start));
    }
    run(&mut session, 2.4);
    let mut other = stage.session();
    for bytes in &kept {
        go_on_from(&mut other, start, bytes).expect("a state");
        assert_eq!(snapshot(&other, start), *bytes);
        run(&mut other, 2.4);
        assert_eq!(other.world().state_hash(), session.world().state_hash());
    }
}

/// Grips that were asked for while it ran are in the recording.
#[test]
fn a_recording_of_asked_grips_replays_to_the_same_bits() {
    let file = std::env::temp_dir().join(format!("thenar-grip-{}.thr", std::process::id()));
    let stage = Stage::ball("paper", GripKind::Pinch, 2.0, 0.01);
    let mut session = open(&stage.text_without_grip());
    let header = Header { simulated_time: true, ..Header::default() };
    let recorder = Recorder::create(&file, &header).expect("a file");
    let (frames, clock) = (recorder.session(), recorder.clock());
    session.set_witness(Box::new(SessionWriter::new(frames, clock, TimeOf::Simulation, 0.5)));
    run(&mut session, 0.3);
    session.grip(0, Some("thing"), GripKind::Pinch, Some(1.5)).expect("a grip");
    run(&mut session, 1.5);
    session.release(0).expect("a hand");
    run(&mut session, 2.3);
    drop(session.take_witness());
    recorder.finish().expect("a file");
    let mut replay = Replay::open(&file).expect("a recording");
    while replay.next().expect("an event").is_some() {}
    let verdict = replay.verdict();
    assert!(verdict.first.is_none() && verdict.same == 230, "{verdict}");
    assert!(verdict.refused.is_empty(), "{:?}", verdict.refused);
    assert_eq!(
        replay.session().expect("a session").world().state_hash(),
        session.world().state_hash()
    );
    std::fs::remove_file(&file).expect("the file");
}
