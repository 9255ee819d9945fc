//! A finger drawn over a soft pad.

use super::{FINGERTIP, H, HAND, MOVES, PRESSED, above_50_hz, run};
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::BodyId;
use thenar_core::world::ContactPoint;
use thenar_scene::session::Session;

/// Force on a soft pad while a finger, palm down, is drawn over it. The finger's underside is 18.5
/// mm below its wrist.
fn finger_on_pad(cells: [u32; 3], way: [f64; 3], depth: f64, friction: f64) -> Vec<Vec3> {
    let way = Vec3::from(way);
    let end = MOVES + way.norm() / 0.02;
    let key = |time: f64, at: Vec3| {
        let at = <[f64; 3]>::from(at);
        format!(
            "[[hand.motion.key]]\ntime = {time:e}\npose = \"rest\"\n\
             wrist = {{ position = {at:?}, fingers = [0, 0, -1], back = [0, 1, 0] }}\n"
        )
    };
    let down = Vec3::y() * -depth;
    let hand = HAND.replace("\"below\"", "\"hand\"").replace("PRESET", "paper");
    let text = format!(
        "version = 1\ngravity = [0, 0, 0]\ntime_step = {H}\nduration = {end}\n{hand}\n[hand.motion]\n\
         kind = \"keyframes\"\n{}{}{}{}\n[[soft]]\nname = \"pad\"\n\
         shape = {{ kind = \"lattice\", size = [0.06, 0.02, 0.04], cells = {cells:?} }}\n\
         material = {{ young = 5e4, density = 1000 }}\nstiffness_damping = 0.005\n\
         position = [{}, {}, {}]\nfixed = [{{ nodes = {{ side = \"y-min\" }} }}]\n\
         [[pair]]\nbodies = [\"hand\", \"pad\"]\nfriction = {friction}\n",
        key(0.0, way * -0.5 + Vec3::y() * 2e-3),
        key(PRESSED, way * -0.5 + down),
        key(MOVES, way * -0.5 + down),
        key(end, way * 0.5 + down),
        FINGERTIP[0],
        FINGERTIP[1] - 0.01,
        FINGERTIP[2],
    );
    let mut session = Session::from_text(&text, Path::new("finger.toml"), &[])
        .unwrap_or_else(|e| panic!("{e}\n{text}"));
    let mut found = Vec::new();
    run(&mut session, end, |time, world| {
        if time > MOVES + 0.15 * way.norm() / 0.02 + 0.5 * H {
            let on_pad = |c: &ContactPoint| match c.bodies[0] {
                BodyId::Soft(1) => c.force_W,
                _ => -c.force_W,
            };
            found.push(world.contacts().iter().map(on_pad).sum());
        }
    });
    found
}

/// Soft on soft: vertices, and edges that the other surface is pressed flat against, hand over to
/// each other.
#[test]
fn a_finger_is_drawn_over_a_soft_pad() {
    let cases = [
        ("across, frictionless", [12, 4, 8], [0.004, 0.0, 0.0], 0.0015, 0.0),
        ("across", [12, 4, 8], [0.004, 0.0, 0.0], 0.0015, 0.6),
        ("along, frictionless", [12, 4, 8], [0.0, 0.0, 0.004], 0.0015, 0.0),
        ("lightly", [12, 4, 8], [0.004, 0.0, 0.0], 0.0006, 0.0),
        ("coarse pad", [6, 2, 4], [0.004, 0.0, 0.0], 0.0015, 0.3),
    ];
    for (name, cells, way, depth, friction) in cases {
        let force = finger_on_pad(cells, way, depth, friction);
        let mean = force.iter().map(Vec3::norm).sum::<f64>() / force.len() as f64;
        let high = above_50_hz(&force);
        println!("{name}: {mean:.2} N, {:.3} % above 50 Hz", 100.0 * high);
        assert!(mean > 1.0, "{name}: {mean} N");
        assert!(high < 5e-3, "{name}: {} % above 50 Hz", 100.0 * high);
    }
}
