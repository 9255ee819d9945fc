//! Where driven and scripted bodies should be at the end of a step.

use crate::build::{Built, Follow};
use thenar::World;
use thenar::math::Vec3;
use thenar::skeleton::velocity_between;
use thenar::world::{Input, Target};

/// Fills targets and prescribed velocities for a step that ends at time `t` \[s\].
pub fn fill(input: &mut Input, built: &mut Built, world: &World, t: f64) {
    for driver in &built.drivers {
        let (pose_WB, [velocity_W, angular_velocity_W]) = driver.track.at(t);
        let i = driver.rigid as usize;
        match driver.follow {
            Follow::BySpring => {
                input.targets[i] = Some(Target { pose_WB, velocity_W, angular_velocity_W });
            }
            // The velocity that takes the body exactly there, so that errors never add up.
            Follow::Exactly => {
                let now = world.rigid_pose(driver.rigid);
                input.prescribed[i] = velocity_between(&now, &pose_WB, world.time_step());
            }
        }
    }
    for hand in &mut built.hands {
        let bones = hand.handle.bones.start as usize..hand.handle.bones.end as usize;
        match &mut hand.motion {
            Some(motion) => motion.sample(t, &mut input.targets[bones]),
            None if hand.driven => {
                for i in bones {
                    input.targets[i] = Some(Target {
                        pose_WB: built.world.rigids[i].pose_WB,
                        velocity_W: Vec3::zeros(),
                        angular_velocity_W: Vec3::zeros(),
                    });
                }
            }
            None => {}
        }
    }
}
