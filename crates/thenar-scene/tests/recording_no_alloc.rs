//! Goal: a step that is recorded allocates nothing on its thread, poses, settings and keyframes
//! included. Method: a global allocator that counts by thread.

use std::path::Path;
use thenar_core::{Pose, Vec3};
use thenar_record::{Field, Header, Recorder};
use thenar_scene::live::LivePose;
use thenar_scene::recording::{SessionWriter, TimeOf};
use thenar_scene::session::Session;
use thenar_testing::allocations;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

const SCENE: &str = r#"
version = 1
time_step = 0.005
[[rigid]]
name = "floor"
motion = "fixed"
shape = { kind = "plane" }
[[hand]]
preset = "paper"
name = "right"
flesh = false
tets = 300
position = [0.0, 0.3, 0.0]
[[soft]]
name = "cube"
position = [0.0, 0.03, 0.0]
material = { young = 20e3, poisson = 0.3, density = 500.0 }
shape = { kind = "lattice", size = [0.05, 0.05, 0.05], cells = [3, 3, 3] }
"#;

#[test]
fn a_recorded_step_and_a_record_allocate_nothing() {
    let file = std::env::temp_dir().join(format!("thenar-no-alloc-{}.rec", std::process::id()));
    let _ = std::fs::remove_file(&file);
    let mut recorder = Recorder::create(&file, &Header::default()).unwrap();
    let mut session = Session::from_text(SCENE, Path::new("test.toml"), &[]).unwrap();
    let writer = SessionWriter::new(recorder.session(), recorder.clock(), TimeOf::Clock, 0.05);
    session.set_witness(Box::new(writer));
    let mut channel = recorder.channel("ticks", &[Field::new("force", "N")], 1000);
    let radii = [0.01; 25];
    let mut pose = LivePose::Joints { joints: [Pose::identity(); 25], radii };
    for k in 0..60 {
        let t = 0.005 * f64::from(k);
        let before = allocations::so_far();
        if let LivePose::Joints { joints, .. } = &mut pose {
            joints.iter_mut().enumerate().for_each(|(j, joint)| {
                joint.position = Vec3::new(1e-3 * j as f64, 0.3, -4e-3 * j as f64 + 0.1 * t);
            });
        }
        session.live_pose(0, t, &pose).unwrap();
        session.step(&mut ());
        assert!(channel.record(k as u64, &[t]));
        // The first contact between bodies may still find its memory.
        assert!(
            k < 20 || allocations::so_far() == before,
            "step {k}: {} allocations",
            allocations::so_far() - before
        );
    }
    drop(session);
    recorder.finish().unwrap();
    std::fs::remove_file(file).unwrap();
}
