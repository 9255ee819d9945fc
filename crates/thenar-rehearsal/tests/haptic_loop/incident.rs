//! Goal: what was felt before forces stopped can be made again, to the same bits, and not with
//! anything else. Method: the loop on a made-up clock, its incident through a file, and the chain
//! run over it; then with one thing changed.

use crate::rig::{MS, PRESS, Rig, SCENE};
use std::path::PathBuf;
use thenar_link::Rendering;
use thenar_link::haptic_loop::incident::{Incident, IncidentError, Input, VERSION, replay};
use thenar_link::haptic_loop::{LoopMode, Settings, TickRecord};
use thenar_touch::safety::Status;
use thenar_track::live::LivePose;

/// A hand with flesh, so that frames respond.
const FLESH: &str = "version = 1\ntime_step = 0.01\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\n\
                     tets = 200\n[solver]\nkind = \"monolithic\"\n";

/// What pulls at the finger and at the palm, to and fro; the wearer feels that, and not the hand's
/// own flesh.
const LOADS: &str = r#"
[[load]]
kind = "force"
body = "hand/index-distal"
force = [0, 1, 0]
profile = { kind = "sine", frequency = 0.7 }
[[load]]
kind = "force"
body = "hand/palm"
force = [0, 1, 0]
profile = { kind = "sine", frequency = 0.7 }
"#;

fn settings(mode: LoopMode) -> Settings {
    Settings { mode, grip: None, trip_folder: Some(std::env::temp_dir()), ..Settings::default() }
}

/// Runs for some milliseconds, a frame every tenth and a sample every fifth of them, and keeps what
/// was recorded.
fn run(rig: &mut Rig, ms: u64, kept: &mut Vec<TickRecord>, flexion: impl Fn(u64) -> f64) {
    for k in 0..ms {
        if k % 10 == 0 {
            rig.simulated_frame();
        }
        if k % 5 == 0 {
            let pose = rig.pose(flexion(k));
            rig.wearer.say(rig.now_ns, Some(pose));
        }
        rig.now_ns += MS;
        rig.wearer.alive(rig.now_ns);
        assert!(rig.clock.tick(rig.now_ns));
        while let Ok(record) = rig.clock.records.pop() {
            kept.push(record);
        }
        rig.clock.incident_reader.as_mut().unwrap().drain();
    }
}

/// Armed, pressing to and fro against a hand that follows slowly, then stopped; the incident.
fn incident(scene: &str, mode: LoopMode, rendering: Rendering) -> (Incident, Vec<TickRecord>) {
    let mut rig = Rig::of(&format!("{scene}{LOADS}"), &settings(mode), rendering);
    let mut kept = Vec::new();
    run(&mut rig, 1000, &mut kept, |_| 0.0);
    rig.clock.remote().arm();
    let to_and_fro = |ms: u64| PRESS * (0.02 * ms as f64).sin();
    run(&mut rig, 3700, &mut kept, to_and_fro);
    rig.clock.remote().stop();
    run(&mut rig, 20, &mut kept, |_| 0.0);
    let incident = rig.clock.incident("a test", &kept).expect("something was kept");
    (incident, kept)
}

struct File(PathBuf);

impl File {
    fn of(incident: &Incident, name: &str) -> Self {
        let file =
            Self(std::env::temp_dir().join(format!("thenar-{name}-{}.touch", std::process::id())));
        let _ = std::fs::remove_file(&file.0);
        incident.write(&file.0).unwrap();
        file
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Up to three seconds and a bit, whatever stands between hand and simulation and whatever is felt
/// with.
#[test]
fn incidents_are_made_again_bit_for_bit() {
    let all = [
        (SCENE, LoopMode::Multirate, Rendering::Tendons),
        (FLESH, LoopMode::Shared, Rendering::Tendons),
        (SCENE, LoopMode::Shared, Rendering::Wrench),
    ];
    for (k, (scene, mode, rendering)) in all.into_iter().enumerate() {
        let (incident, kept) = incident(scene, mode, rendering);
        let file = File::of(&incident, &format!("again-{k}"));
        let read = Incident::read(&file.0).unwrap();
        let made = replay(&read).unwrap();
        assert_eq!(made.different, 0, "{mode:?} {rendering:?}: {:?}", made.first);
        // Frames that respond are large: those of one second at least are there.
        let least = if mode == LoopMode::Shared { 1000 } else { 2000 };
        assert!((least..=3100).contains(&made.compared), "{}", made.compared);
        let last = kept.last().unwrap();
        assert_eq!(made.records.last().unwrap().time_ns, last.time_ns);
        assert!(matches!(last.status, Status::Tripped(_)));
        // There was something to feel, and guards that let it through.
        let forces = made.records.iter().flat_map(|r| r.axes).map(|axis| axis.output.abs());
        assert!(forces.fold(0.0, f64::max) > 0.01, "{mode:?} {rendering:?}");
        assert!(made.records.iter().any(|r| matches!(r.status, Status::Live)));
    }
}

/// One bit of one sample, one frame that is another, one tick a nanosecond later: that is noticed
/// where it acts.
#[test]
fn what_is_not_the_same_is_noticed() {
    let (incident, _) = incident(SCENE, LoopMode::Multirate, Rendering::Tendons);
    let differs = |change: &dyn Fn(&mut Incident)| {
        let mut changed = incident.clone();
        change(&mut changed);
        replay(&changed).unwrap().different
    };
    assert_eq!(differs(&|_| {}), 0);
    let sample = differs(&|incident| {
        let LivePose::Angles { angles, .. } = incident.samples[50].pose.as_mut().unwrap() else {
            panic!("angles")
        };
        angles[4] = f64::from_bits(angles[4].to_bits() ^ (1 << 30));
    });
    assert!(sample > 100, "{sample}");
    let late = differs(&|incident| {
        for input in &mut incident.inputs {
            if let Input::Sample(_, stated) = input {
                *stated = Some(thenar_touch::TrackerTiming::HEADSET);
            }
        }
    });
    assert!(late > 100, "{late}");
    let armed = differs(&|incident| {
        let tick = incident.inputs.iter().position(|i| matches!(i, Input::Tick(..))).unwrap();
        incident.inputs.insert(tick, Input::Arm);
    });
    assert!(armed > 100, "{armed}");
}

/// Two seconds at least and no more than three and a tick, however long it ran; and nothing at all
/// in single-rate.
#[test]
fn what_is_kept_is_bounded() {
    let (incident, _) = incident(SCENE, LoopMode::Multirate, Rendering::Tendons);
    let ticks = incident.inputs.iter().filter(|i| matches!(i, Input::Tick(..))).count();
    assert!((2000..=3001).contains(&ticks), "{ticks}");
    assert!(incident.samples.len() <= ticks / 5 + 1 && incident.samples.len() >= ticks / 5 - 1);
    let rig = Rig::of(SCENE, &settings(LoopMode::SingleRate), Rendering::Tendons);
    assert!(rig.clock.incident_reader.is_none());
}

/// A monitor that looks too rarely lets samples overflow: what is kept begins anew with the next
/// state, and is whole.
#[test]
fn a_ring_that_overflows_begins_anew() {
    let mut rig = Rig::of(SCENE, &settings(LoopMode::Multirate), Rendering::Tendons);
    let mut kept = Vec::new();
    run(&mut rig, 1200, &mut kept, |_| 0.0);
    // Nobody looks while 600 samples come, each of another hand position.
    for k in 0..600 {
        let pose = rig.pose(1e-4 * f64::from(k));
        rig.wearer.say(rig.now_ns, Some(pose));
        rig.tick();
    }
    run(&mut rig, 1500, &mut kept, |ms| 1e-4 * ms as f64);
    let incident = rig.clock.incident("a test", &kept).expect("a state after the overflow");
    let made = replay(&incident).unwrap();
    assert_eq!(made.different, 0, "{:?}", made.first);
    assert!(made.compared > 400 && made.compared <= 1500, "{}", made.compared);
}

/// What is no incident, is damaged, of another version or made up is refused by its cause.
#[test]
fn files_are_read_strictly() {
    let (incident, _) = incident(SCENE, LoopMode::Multirate, Rendering::Tendons);
    let file = File::of(&incident, "strict");
    let bytes = std::fs::read(&file.0).unwrap();
    let told = |bytes: &[u8]| Incident::parse(bytes).unwrap_err().to_string();
    assert!(told(b"no").contains("no incident"));
    assert!(told(&[0; 100]).contains("no incident"));
    for at in [16, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 4;
        assert!(told(&damaged).contains("checksum"), "{at}");
    }
    assert!(told(&bytes[..bytes.len() - 1]).contains("checksum"));
    let mut newer = bytes.clone();
    newer[8..12].copy_from_slice(&(VERSION + 1).to_le_bytes());
    assert!(
        matches!(Incident::parse(&newer), Err(IncidentError::Version { found }) if found == VERSION + 1)
    );
    // Sound to the eye, and nonsense: a state, frames or samples of something else.
    let refused = |change: &dyn Fn(&mut Incident)| {
        let mut changed = incident.clone();
        change(&mut changed);
        assert!(replay(&changed).is_err());
    };
    refused(&|incident| incident.state.truncate(100));
    refused(&|incident| incident.samples.clear());
    refused(&|incident| incident.frames.clear());
    refused(&|incident| incident.displays.clear());
    refused(&|incident| incident.inputs.insert(0, Input::Heard(7, 1)));
    refused(&|incident| incident.inputs.insert(0, Input::Frame(3, 1)));
}
