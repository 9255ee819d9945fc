//! A hand comes down on a ball, grips it, and lifts it from its table.
//!
//!     cargo run --release -p thenar --example grip

use std::error::Error;
use thenar::{GripKind, Hand, HandPose, Pose, Quat, Rigid, Scene, Simulation, Vec3};

fn main() -> Result<(), Box<dyn Error>> {
    let (lift, sim) = lift()?;
    println!("the ball is {:.0} mm higher", 1e3 * lift);
    for load in sim.hands().flat_map(|hand| sim.loads(hand)) {
        println!("{:6} {:.2} N", load.digit.name(), load.normal);
    }
    Ok(())
}

/// Lifts the ball by 80 mm; returns how far it went \[m\].
pub fn lift() -> Result<(f64, Simulation), Box<dyn Error>> {
    let mut scene = Scene::new();
    scene.add(Rigid::plane());
    let ball = scene.add(Rigid::sphere(0.02).at([0.0, 0.02, 0.0]).mass(0.05).friction(0.8));
    let hand = scene.add(Hand::right().at([0.0, 0.3, 0.0]).friction(0.8));
    let mut sim = scene.build()?;

    let mut gripped = false;
    while sim.time() < 4.0 {
        // Down to where thumb and index finger reach the ball, and up from second 2.5 on.
        let height = match sim.time() {
            t if t < 0.8 => 0.081 + 0.1 * (0.8 - t),
            t => 0.081 + 0.08 * (t - 2.5).clamp(0.0, 1.0),
        };
        let wrist = Pose::new(Vec3::new(0.029, height, 0.121), Quat::identity());
        sim.hand_mut(hand).follow(&HandPose::flat(wrist))?;
        if sim.time() > 0.9 && !gripped {
            sim.hand_mut(hand).grip(ball, GripKind::Pinch, Some(2.0))?;
            gripped = true;
        }
        sim.step();
    }
    Ok((sim.rigid(ball).pose().position.y - 0.02, sim))
}
