//! Goal: steps and live poses allocate nothing. Method: a global allocator that counts, around
//! steps of a hand that a script moves, that poses move, that is lost, and that returns.

use std::path::Path;
use thenar_core::{Pose, Quat, Vec3};
use thenar_scene::live::LivePose;
use thenar_scene::session::{Session, builtin};
use thenar_testing::allocations;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

#[test]
fn live_steps_allocate_nothing() {
    let text = builtin("bread-grasp").expect("a scene").text;
    let paper = ["hand.hand.preset=paper".to_owned()];
    let mut session = Session::from_text(text, Path::new("t.toml"), &paper).expect("a scene");
    session.set("friction", &thenar_scene::tuning::SettingValue::Number(0.7)).expect("a setting");
    let before = allocations::so_far();
    for k in 0..240 {
        let t = f64::from(k) / 60.0;
        let wave = Vec3::new(0.066, 0.15 - 0.05 * (3.0 * t).sin(), 0.07);
        match k {
            40..160 => {
                // Joints in a plane, good enough to be carried over.
                let joints = std::array::from_fn(|j| {
                    let (finger, place) = (j.saturating_sub(1) / 5, j.saturating_sub(1) % 5);
                    let step = Vec3::new(0.02 * (finger as f64 - 2.0), 0.0, -0.03 * place as f64);
                    Pose::new(wave + step, Quat::identity())
                });
                session
                    .live_pose(0, t, &LivePose::Joints { joints, radii: [0.01; 25] })
                    .expect("ok");
            }
            180 => session.live_lost(0),
            200 => session.follow_script(0),
            _ => {}
        }
        session.step(&mut ());
    }
    let after = allocations::so_far();
    assert_eq!(after - before, 0, "allocations in 240 steps");

    // A grip from its beginning to its end; places on the object are searched in its first step.
    let text = builtin("ball-grip").expect("a scene").text;
    let mut session = Session::from_text(text, Path::new("t.toml"), &paper).expect("a scene");
    let steps = session.steps_wanted();
    let (allocated, ()) = allocations::count(|| (0..steps).for_each(|_| _ = session.step(&mut ())));
    assert_eq!(allocated, 0, "allocations in the steps of a grip");
}
