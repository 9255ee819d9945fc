//! From the text of a scene or a motion to two simulated steps, or to a moved hand.
//!
//! The fuzz target `session` and `crates/thenar-scene/tests/all/text/fuzz_scenes.rs` run this code.

use std::path::Path;
use thenar_core::Pose;
use thenar_core::model::HandModel;
use thenar_scene::SceneError;
use thenar_scene::build::wanted_bytes;
use thenar_scene::motion::{
    HandMotion, Keyframes, KeyframesDesc, MotionError, Recorded, RecordedDesc, Recording,
};
use thenar_scene::session::{Session, read};

/// Scenes that would take more memory are not built: a fuzzer learns nothing from waiting.
const BYTES_MAX: u64 = 20_000_000;

/// A scene, opened and stepped; false where it would be too large, or holds hands, which take a
/// second each. Files that it names are not there.
pub fn steps(text: &str) -> Result<bool, SceneError> {
    let file = Path::new("/nowhere/fuzz.toml");
    let small = |text: &str| {
        read(text, &[]).is_ok_and(|s| s.hand.is_empty() && wanted_bytes(&s) < BYTES_MAX)
    };
    let mut session = match small(text) {
        true => Session::from_text(text, file, &[])?,
        false => return read(text, &[]).map(|_| false).map_err(|f| f.locate(file, text, &[])),
    };
    let sound = session.world().state().is_sound();
    for _ in 0..2 {
        let report = session.step(&mut ());
        assert_eq!(session.world().state().is_sound(), sound, "{report:?}");
        session.probe();
    }
    Ok(true)
}

/// Keyframes of a hand, looked at along their way.
pub fn keyframes(text: &str, hand: &HandModel) -> Result<(), MotionError> {
    let desc = KeyframesDesc::parse(text, Path::new("fuzz.toml"))?;
    let keyframes = Keyframes::new(&desc, hand, &Pose::identity())?;
    moves(HandMotion::Keyframes(Box::new(keyframes)), hand);
    Ok(())
}

/// A recorded motion of a hand, looked at along its way.
pub fn recorded(bytes: &[u8], hand: &HandModel) -> Result<(), MotionError> {
    let recording = Recording::read(bytes, Path::new("fuzz.jsonl"))?;
    let recorded = Recorded::new(&RecordedDesc::of_file("fuzz.jsonl"), &recording, hand)?;
    moves(HandMotion::Recorded(Box::new(recorded)), hand);
    Ok(())
}

fn moves(mut motion: HandMotion, hand: &HandModel) {
    assert!(motion.start_placement().is_finite(), "{motion:?}");
    let mut targets = vec![None; hand.bones.len()];
    for part in [0.0, 0.001, 0.3, 1.0, 2.0] {
        motion.sample(part * motion.duration().min(10.0), &mut targets);
        for target in targets.iter().flatten() {
            assert!(target.pose_WB.is_finite(), "{target:?}");
        }
    }
}
