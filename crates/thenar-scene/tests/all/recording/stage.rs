//! What the tests share: scenes, a hand of few elements that is made once, and how sessions are
//! recorded and made again.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use thenar_core::Pose;
use thenar_core::model::{HandModel, Side};
use thenar_core::world::Target;
use thenar_record::{Header, Recorder};
use thenar_rig::hand::{HandOptions, asset, build_hand};
use thenar_rig::{Model, write_model};
use thenar_scene::live::LivePose;
use thenar_scene::recording::{Event, Replay, SessionWriter, TimeOf};
use thenar_scene::session::{Session, Witness};

/// Time step of the scenes \[s\].
pub const H: f64 = 0.01;
/// Steps between keyframes.
pub const KEYFRAME: usize = 10;

/// To make a hand takes a second, to read it nearly nothing.
static HAND: LazyLock<HandModel> = LazyLock::new(|| {
    let options = HandOptions {
        name: "hand".into(),
        side: Some(Side::Right),
        tets: 60,
        collision_triangles: 300,
        ..HandOptions::paper()
    };
    build_hand(asset(Side::Right), &options).unwrap()
});

/// A ball that rolls away, and nothing else.
pub const BALL: &str = r#"
version = 1
time_step = 0.01
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "ball"
mass = 0.2
position = [0.3, 0.06, 0.0]
velocity = [0.5, 0.0, 0.1]
shape = { kind = "sphere", radius = 0.05 }
"#;

/// A bare glove, rigid bodies.
pub const GLOVE: &str = r#"
version = 1
time_step = 0.01
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "box"
mass = 0.2
position = [0.3, 0.06, 0.0]
velocity = [0.5, 0.0, 0.1]
angular_velocity = [3.0, 1.0, 0.0]
shape = { kind = "box", size = [0.1, 0.06, 0.08] }
[[hand]]
preset = "paper"
name = "right"
model = "hand.thenar"
flesh = false
position = [0.0, 0.1, 0.0]
"#;

/// A hand of flesh over a table and a soft cube.
pub const FLESH: &str = r#"
version = 1
time_step = 0.01
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[hand]]
preset = "paper"
name = "right"
model = "hand.thenar"
position = [0.0, 0.1, 0.0]
[[soft]]
name = "cube"
position = [0.2, 0.03, 0.0]
velocity = [0.3, -0.5, 0.0]
material = { young = 20e3, poisson = 0.3, density = 500.0 }
shape = { kind = "lattice", size = [0.05, 0.05, 0.05], cells = [2, 2, 2] }
"#;

/// The same of tissue that remembers.
pub const TISSUE: &str = r#"
version = 1
time_step = 0.01
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[hand]]
preset = "paper"
name = "right"
model = "hand.thenar"
position = [0.0, 0.1, 0.0]
material = { relaxation = [[0.7, 4e-3], [0.15, 0.07], [0.08, 1.4]] }
[[soft]]
name = "cube"
position = [0.2, 0.03, 0.0]
velocity = [0.3, -0.5, 0.0]
material = { young = 20e3, poisson = 0.3, density = 500.0, relaxation = [[0.5, 0.1]] }
shape = { kind = "lattice", size = [0.05, 0.05, 0.05], cells = [2, 2, 2] }
"#;

/// A folder of its own for each test, with the hand in it.
pub struct Folder(pub PathBuf);

impl Folder {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("thenar-rec-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// A session of a scene.
    pub fn open(&self, text: &str) -> Session {
        let hand = self.file("hand.thenar");
        if text.contains("hand.thenar") && !hand.exists() {
            write_model(&hand, &Model::Hand(HAND.clone())).unwrap();
        }
        Session::from_text(text, &self.file("scene.toml"), &[]).unwrap()
    }

    /// Records what `drive` does in each of `steps` steps of a scene, before it is made; returns
    /// the file and the hash after every step.
    pub fn record(
        &self,
        text: &str,
        steps: usize,
        drive: impl FnMut(usize, &mut Session),
    ) -> (PathBuf, Vec<u64>) {
        self.record_all(&[(text, steps)], drive)
    }

    /// The same of several scenes, one after another.
    pub fn record_all(
        &self,
        scenes: &[(&str, usize)],
        drive: impl FnMut(usize, &mut Session),
    ) -> (PathBuf, Vec<u64>) {
        let sessions = scenes.iter().map(|(text, steps)| (self.open(text), *steps));
        self.record_sessions(sessions, drive)
    }

    /// Comparison of sessions that are open already.
    pub fn record_sessions(
        &self,
        sessions: impl Iterator<Item = (Session, usize)>,
        mut drive: impl FnMut(usize, &mut Session),
    ) -> (PathBuf, Vec<u64>) {
        let file = self.file("test.rec");
        let header = Header { simulated_time: true, ..Header::default() };
        let recorder = Recorder::create(&file, &header).unwrap();
        let every = H * KEYFRAME as f64;
        let writer =
            SessionWriter::new(recorder.session(), recorder.clock(), TimeOf::Simulation, every);
        let mut witness: Box<dyn Witness> = Box::new(writer);
        let mut hashes = Vec::new();
        for (mut session, steps) in sessions {
            session.set_witness(witness);
            for k in 0..steps {
                drive(k, &mut session);
                session.step(&mut ());
                hashes.push(session.world().state_hash());
            }
            witness = session.take_witness().unwrap();
        }
        drop(witness);
        recorder.finish().unwrap();
        (file, hashes)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Hashes after the steps that a replay tells of.
pub fn replayed(replay: &mut Replay) -> Vec<u64> {
    steps(replay).into_iter().map(|(_, hash)| hash).collect()
}

/// The same with the number of each step: for scenes without restarts or another time step.
pub fn steps(replay: &mut Replay) -> Vec<(usize, u64)> {
    let mut steps = Vec::new();
    while let Some(event) = replay.next().unwrap() {
        if let Event::Stepped { time_ns, .. } = event {
            let number = (time_ns as f64 * 1e-9 / H).round() as usize;
            steps.push((number, replay.session().unwrap().world().state_hash()));
        }
    }
    steps
}

/// Where bones are to be, moved by `x` \[m\]: what the haptic loop would say.
pub fn moved_targets(session: &Session, x: f64) -> Vec<Target> {
    let bones = session.hands()[0].handle.bones.clone();
    let target = |bone: u32| {
        let mut target = session.input().targets[bone as usize].unwrap();
        target.pose_WB.position.x += x;
        target
    };
    bones.map(target).collect()
}

/// A pose by angles: the wrist here, all fingers bent.
pub fn bent(wrist: [f64; 3], angle: f64) -> LivePose {
    let [x, y, z] = wrist;
    LivePose::Angles { wrist: Pose::translation(x, y, z), angles: [angle; 20] }
}

/// A pose of a headset: joints in a plane, good enough to be carried over.
pub fn tracked(wrist: [f64; 3]) -> LivePose {
    let [x, y, z] = wrist;
    let joints = std::array::from_fn(|j| {
        let (finger, place) = (j.saturating_sub(1) / 5, j.saturating_sub(1) % 5);
        Pose::translation(x + 0.02 * (finger as f64 - 2.0), y, z - 0.03 * place as f64)
    });
    LivePose::Joints { joints, radii: [0.01; 25] }
}

/// Bytes of a file.
pub fn bytes(file: &Path) -> Vec<u8> {
    std::fs::read(file).unwrap()
}
