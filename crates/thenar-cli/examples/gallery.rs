//! Presses a hand on a table and draws it in every way there is.
//!
//! `cargo run --release -p thenar-cli --example gallery -- OUT_DIR`

#![allow(dead_code, unused_imports)]

#[path = "../src/picture/mod.rs"]
mod picture;

use picture::{
    Camera, EncodeError, Hand, Layers, Movie, Quality, Rigid, Scales, Soft, Stage, render,
    write_png,
};
use std::path::Path;
use std::time::Instant;
use thenar::contact::Shape;
use thenar::model::{
    Drive, HandHandle, HandModel, HandPlacement, Motion, RigidDesc, Side, WorldDesc,
};
use thenar::world::{Input, Target};
use thenar::{Mat3, Pose, Vec3, World};

const SIZE: [u32; 2] = [960, 640];

fn fixed(name: &str, shape: Shape, pose_WB: Pose) -> RigidDesc {
    RigidDesc {
        name: name.into(),
        motion: Motion::Prescribed,
        mass: 0.0,
        inertia: Mat3::zeros(),
        pose_WB,
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
        shape: Some(shape),
        pose_BS: Pose::identity(),
        friction: 0.6,
    }
}

/// A hand above a table and a ball, and where the hand's parts are.
fn world(hand: &HandModel) -> Result<(World, HandHandle), Box<dyn std::error::Error>> {
    let mut desc = WorldDesc { time_step: 1.0 / 240.0, ..WorldDesc::default() };
    desc.add_rigid(fixed("table", Shape::HalfSpace, Pose::identity()));
    let ball = Pose::translation(0.12, 0.03, 0.03);
    desc.add_rigid(fixed("ball", Shape::Sphere { radius: 0.03 }, ball));
    let drive =
        Drive { stiffness: 800.0, damping: 8.0, angular_stiffness: 4.0, angular_damping: 0.04 };
    let placement = HandPlacement {
        name: "hand".into(),
        pose_WM: Pose::translation(0.0, 0.075, 0.1),
        coupling_stiffness: 1e9,
        coupling_damping_time: 1e-3,
        root_drive: Some(drive),
        bone_drive: Some(Drive { stiffness: 150.0, angular_stiffness: 0.6, ..drive }),
    };
    let handle = desc.add_hand(hand, &placement);
    Ok((World::new(desc)?, handle))
}

/// The tracker has the whole hand `depth` metres lower than at the start.
fn lower(world: &World, handle: &HandHandle, depth: f64, input: &mut Input) {
    for bone in handle.bones.clone() {
        let start = world.desc().rigids[bone as usize].pose_WB;
        input.targets[bone as usize] = Some(Target {
            pose_WB: Pose::new(start.position - Vec3::y() * depth, start.rotation),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
    }
}

fn stage<'a>(
    world: &'a World,
    input: &'a Input,
    hand: &'a HandModel,
    handle: &HandHandle,
) -> Stage<'a> {
    Stage {
        world,
        input,
        hands: vec![Hand {
            model: hand,
            bones: handle.bones.clone(),
            joints: handle.joints.clone(),
        }],
        softs: vec![Soft {
            index: handle.soft,
            render: &hand.render,
            material: picture::Material::skin(),
            colours: None,
            hand: Some(hand),
        }],
        rigids: vec![Rigid::default(); world.desc().rigids.len()],
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).unwrap_or_else(|| "out".into());
    let out = Path::new(&out);
    std::fs::create_dir_all(out)?;
    let hand = thenar_rig::default_hand(Side::Right, 600)?;
    let (mut world, handle) = world(&hand)?;
    let mut input = world.input();
    let points = stage(&world, &input, &hand, &handle).points();
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    let camera = Camera::fitted(&points, Vec3::new(0.35, -0.5, -0.8), 0.6, aspect, 0.12);

    let (frames, steps) = (24, 10);
    let mut movie = Movie::create(&out.join("press.png"), SIZE, frames, 24)?;
    for frame in 0..frames {
        for step in 0..steps {
            let t = f64::from(frame * steps + step) / f64::from(frames * steps);
            lower(&world, &handle, 0.045 * t, &mut input);
            world.step(&input, &mut ());
        }
        let scene = stage(&world, &input, &hand, &handle).scene(
            &Layers::skin(),
            &Scales::default(),
            &camera,
            SIZE[1],
        );
        let start = Instant::now();
        let image = render(&scene, &camera, SIZE[0], SIZE[1], &Quality::movie());
        if frame % 8 == 0 {
            println!("frame {frame}: {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
        }
        movie.push(&image)?;
    }
    movie.finish()?;

    for layers in [
        "skin",
        "skin,bones",
        "skin,flesh",
        "pressure,forces",
        "weights",
        "skin,tracked",
        "skin,contacts",
        "targets",
    ] {
        let scene = stage(&world, &input, &hand, &handle).scene(
            &layers.parse::<Layers>()?,
            &Scales::default(),
            &camera,
            SIZE[1],
        );
        let image = render(&scene, &camera, SIZE[0], SIZE[1], &Quality::still());
        write_png(&out.join(format!("{}.png", layers.replace(',', "-"))), &image)?;
    }
    let portrait = picture::hand_portrait(&hand, &"skin,bones".parse()?, SIZE, &Quality::still())?;
    write_png(&out.join("portrait.png"), &portrait)?;
    println!("{} contacts", world.contacts().len());
    Ok(())
}
