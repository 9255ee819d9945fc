//! Targets of driven and scripted bodies at the end of a step.

use crate::build::{Built, BuiltHand, Follow};
use crate::live::{LiveError, LiveHand};
use std::ops::Range;
use thenar_core::World;
use thenar_core::condensed::BoneFrame;
use thenar_core::kinematics::velocity_between;
use thenar_core::math::Vec3;
use thenar_core::model::{Flesh, RigidDesc};
use thenar_core::world::{Input, Target};

/// Fills targets and prescribed velocities for a step that ends at time `t` \[s\].
pub fn fill(
    input: &mut Input,
    built: &mut Built,
    live: &mut [Result<Box<LiveHand>, LiveError>],
    world: &World,
    t: f64,
) {
    bodies(input, built, world, t);
    let Built { hands, world: start, .. } = built;
    for (hand, live) in hands.iter_mut().zip(live) {
        let bones = bones(hand);
        let targets = &mut input.targets[bones.clone()];
        match live {
            Ok(live) => {
                if live.wants_script() {
                    script(hand, &start.rigids[bones], t, targets);
                }
                live.step(world.time_step(), targets);
            }
            Err(_) => script(hand, &start.rigids[bones], t, targets),
        }
    }
}

/// Hands that are led go where they are led, whatever script and poses say.
pub fn follow_leaders(input: &mut Input, built: &Built, led: &[Option<Vec<Target>>]) {
    for (hand, led) in built.hands.iter().zip(led) {
        let Some(led) = led else { continue };
        for (target, led) in input.targets[bones(hand)].iter_mut().zip(led) {
            *target = Some(*led);
        }
    }
}

/// A hand that is led is weightless: its wearer's own carries its weight, and would feel it twice.
pub fn carry(input: &mut Input, built: &Built, led: &[Option<Vec<Target>>], world: &World) {
    let (model, gravity) = (world.model(), input.gravity);
    for (hand, _) in built.hands.iter().zip(led).filter(|(_, led)| led.is_some()) {
        for bone in bones(hand) {
            input.wrenches[bone][0] -= gravity * model.rigids[bone].mass;
        }
        if let Some(soft) = hand.flesh() {
            for node in model.soft_nodes[soft as usize].clone() {
                input.node_forces[node] -= gravity * model.flesh.mass[node];
            }
        }
    }
}

/// Adds a led hand's weight to the loads in the frame of the hand that begins with rigid body
/// `first`: what carries that weight is no load on it.
pub fn weigh(
    input: &Input,
    built: &Built,
    led: &[Option<Vec<Target>>],
    world: &World,
    first: u32,
    frame: &mut BoneFrame,
) {
    let carried =
        |(hand, led): (&BuiltHand, &Option<_>)| hand.handle.bones.start == first && led.is_some();
    if !built.hands.iter().zip(led).any(carried) {
        return;
    }
    let rigids = &world.model().rigids[first as usize..];
    for (load, rigid) in frame.response.loads.chunks_exact_mut(6).zip(rigids) {
        let weight = input.gravity * rigid.mass;
        load[..3].iter_mut().zip(&weight).for_each(|(load, weight)| *load += weight);
    }
}

/// Torques that hold the joints of hands at the targets of scripts and poses, after the loads of
/// the step. Fingers that grip find their own way, by the force that they feel. A hand that is led
/// has none: its targets answer to contact, and the hand in empty air beside it has other targets,
/// so that the difference would be felt.
pub fn hold(input: &mut Input, built: &mut Built, led: &[Option<Vec<Target>>], world: &World) {
    for (hand, _) in built.hands.iter_mut().zip(led).filter(|(_, led)| led.is_none()) {
        let joints = hand.handle.joints.start as usize..hand.handle.joints.end as usize;
        let bones = bones(hand);
        // Settings change all moduli by one factor.
        let young = |flesh: &Flesh| flesh.materials.first().map_or(1.0, |m| m.young);
        let stiffer = hand.flesh().map_or(1.0, |soft| {
            young(&world.desc().softs[soft as usize].flesh) / young(&hand.model.flesh)
        });
        if let Some(muscles) = &mut hand.muscles {
            muscles.hold(&input.targets[bones], stiffer, &mut input.joint_torques[joints]);
        }
    }
}

/// Fills all targets with those of the scripts at time `t` \[s\].
pub fn fill_scripts(input: &mut Input, built: &mut Built, world: &World, t: f64) {
    bodies(input, built, world, t);
    let Built { hands, world: start, .. } = built;
    for hand in hands {
        let bones = bones(hand);
        script(hand, &start.rigids[bones.clone()], t, &mut input.targets[bones]);
    }
}

/// The bones of a hand among the rigid bodies.
pub fn bones(hand: &BuiltHand) -> Range<usize> {
    hand.handle.bones.start as usize..hand.handle.bones.end as usize
}

/// Sets the targets that the scene gives a hand: its motion, or its start pose.
fn script(hand: &mut BuiltHand, start: &[RigidDesc], t: f64, targets: &mut [Option<Target>]) {
    match &mut hand.motion {
        Some(motion) => motion.sample(t, targets),
        None if hand.driven => {
            for (target, bone) in targets.iter_mut().zip(start) {
                *target = Some(Target {
                    pose_WB: bone.pose_WB,
                    velocity_W: Vec3::zeros(),
                    angular_velocity_W: Vec3::zeros(),
                });
            }
        }
        None => {}
    }
}

/// Motors of joints, after the loads of the step.
pub fn motors(input: &mut Input, built: &Built, world: &World, t: f64) {
    built.motors.iter().for_each(|motor| motor.lead(input, world, t));
    built.trains.iter().for_each(|train| train.lead(input, world, t));
}

/// Scripted and driven rigid bodies.
fn bodies(input: &mut Input, built: &Built, world: &World, t: f64) {
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
}
