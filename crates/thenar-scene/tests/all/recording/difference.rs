//! A replay that gives something else says so, and is put right.

use super::stage::*;
use thenar_core::{Pose, Vec3};
use thenar_record::Header;
use thenar_scene::recording::Replay;

#[test]
fn a_difference_is_found_told_and_put_right() {
    let folder = Folder::new("differs");
    let (file, recorded) = folder.record(BALL, 30, |k, session| {
        if k == 13 {
            // Behind the witness's back.
            let pose = Pose::new(Vec3::new(0.3, 0.5, 0.0), Default::default());
            session.world_mut().set_rigid_state(1, pose, [Vec3::zeros(); 2]);
        }
    });
    let mut replay = Replay::open(&file).unwrap();
    let hashes = replayed(&mut replay);
    let verdict = replay.verdict();
    let first = verdict.first.unwrap();
    assert_eq!((first.scene, first.step), (1, 14));
    assert!((first.time - 0.14).abs() < 1e-9);
    assert_eq!(hashes[..13], recorded[..13]);
    assert!((13..20).all(|k| hashes[k] != recorded[k]));
    // The keyframe after step 20 puts it right.
    assert_eq!(hashes[20..], recorded[20..]);
    let (times, moved) = verdict.put_right;
    assert!(times == 1 && moved.rigid > 0.3 && moved.node == 0.0, "{moved:?}");
    let told = verdict.to_string();
    assert!(told.starts_with("differs from step 14 of scene 1 on, at 0.140 s; 23 of"), "{told}");
    let here = Header { vectors: "Other".into(), ..Header::default() };
    let causes = verdict.causes(replay.header(), &here);
    assert!(causes[0].contains("vector instructions"), "{causes:?}");
}
