//! What is to be seen of a session.

use super::message::{
    Arrow, Colour, Cylinder, Deletion, Entity, FrameTransform, FrameTransforms, SceneUpdate, Sized,
    Time, Triangles, Xyz,
};
use thenar::contact::Shape;
use thenar::model::RigidDesc;
use thenar::{Pose, Quat, Vec3};
use thenar_scene::session::Session;

/// The frame of simulations, +y up, and one around it with +z up, as Foxglove has it.
const WORLD: &str = "world";
const MAP: &str = "map";
/// Length of an arrow per force \[m/N\].
const ARROW: f64 = 0.02;
/// Forces below are not drawn \[N\].
const FORCE_MIN: f64 = 1e-3;
/// Half the width of the piece of a half space that is drawn \[m\].
const GROUND: f64 = 0.5;

const SKIN: [f64; 3] = [0.85, 0.65, 0.55];
const BONE: [f64; 3] = [0.93, 0.91, 0.84];
const BREAD: [f64; 3] = [0.82, 0.62, 0.36];
const THING: [f64; 3] = [0.55, 0.6, 0.66];
const FORCE: [f64; 3] = [0.85, 0.1, 0.1];

/// Where all bodies are, and where driven ones should be (`NAME/wanted`).
pub fn transforms(session: &Session, time: Time) -> FrameTransforms {
    let world = session.world();
    let upright = Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
    let upright = Pose::new(Vec3::zeros(), upright);
    let mut transforms = vec![FrameTransform::new(time, MAP, WORLD, &upright)];
    for (b, rigid) in world.desc().rigids.iter().enumerate() {
        let pose = world.rigid_pose(b as u32);
        transforms.push(FrameTransform::new(time, WORLD, &rigid.name, &pose));
        if let Some(target) = session.input().target(b) {
            let name = format!("{}/wanted", rigid.name);
            transforms.push(FrameTransform::new(time, WORLD, &name, &target.pose_WB));
        }
    }
    FrameTransforms { transforms }
}

/// Rigid bodies and bones, each in its own frame: sent once per scene.
pub fn objects(session: &Session, time: Time) -> SceneUpdate {
    let desc = session.world().desc();
    let mut entities = Vec::new();
    for (b, rigid) in desc.rigids.iter().enumerate() {
        let look = session.looks().get(b);
        let colour = look.and_then(|look| look.colour).unwrap_or(THING).into();
        let mut entity = Entity::new(time, &rigid.name, &rigid.name);
        match look.and_then(|look| look.mesh.as_ref()) {
            Some((mesh, _)) => {
                entity.triangles.push(surface(&mesh.positions, &mesh.triangles, colour));
            }
            None => shape(rigid, colour, &mut entity),
        }
        entities.push(entity);
    }
    for hand in session.hands() {
        for (bone, b) in hand.model.bones.iter().zip(hand.handle.bones.clone()) {
            let [from, to] = bone.ends_B;
            let axis = to - from;
            let turn = Quat::rotation_between(&Vec3::z(), &axis).unwrap_or_else(Quat::identity);
            let entity = &mut entities[b as usize];
            entity.cylinders.push(Cylinder {
                pose: Pose::new((from + to) / 2.0, turn).into(),
                size: Vec3::new(2.0 * bone.radius, 2.0 * bone.radius, axis.norm()).into(),
                bottom_scale: 1.0,
                top_scale: 1.0,
                color: BONE.into(),
            });
        }
    }
    SceneUpdate { deletions: vec![Deletion::all(time)], entities }
}

fn shape(rigid: &RigidDesc, color: Colour, entity: &mut Entity) {
    let pose = rigid.pose_BS;
    match &rigid.shape {
        None => {}
        Some(Shape::Sphere { radius }) => {
            let size = Vec3::repeat(2.0 * radius).into();
            entity.spheres.push(Sized { pose: pose.into(), size, color });
        }
        Some(Shape::Capsule { radius, half_length }) => {
            // Cylinders stand on z, capsules on y.
            let turn = Quat::rotation_between(&Vec3::z(), &Vec3::y());
            let turn = Pose::new(Vec3::zeros(), turn.unwrap_or_else(Quat::identity));
            entity.cylinders.push(Cylinder {
                pose: (pose * turn).into(),
                size: Vec3::new(2.0 * radius, 2.0 * radius, 2.0 * half_length).into(),
                bottom_scale: 1.0,
                top_scale: 1.0,
                color,
            });
            for end in [-half_length, *half_length] {
                let end = Pose::new(Vec3::y() * end, Quat::identity());
                let size = Vec3::repeat(2.0 * radius).into();
                entity.spheres.push(Sized { pose: (pose * end).into(), size, color });
            }
        }
        Some(Shape::Cuboid { half }) => {
            entity.cubes.push(Sized { pose: pose.into(), size: (half * 2.0).into(), color });
        }
        Some(Shape::HalfSpace) => {
            let below = Pose::new(Vec3::y() * -5e-4, Quat::identity());
            let size = Vec3::new(2.0 * GROUND, 1e-3, 2.0 * GROUND).into();
            entity.cubes.push(Sized { pose: (pose * below).into(), size, color });
        }
        Some(Shape::Mesh(mesh)) => {
            let points: Vec<Vec3> = mesh.points.iter().map(|p| pose.point(p)).collect();
            entity.triangles.push(surface(&points, &mesh.triangles, color));
        }
    }
}

fn surface(points: &[Vec3], triangles: &[[u32; 3]], color: Colour) -> Triangles {
    Triangles {
        pose: Pose::identity().into(),
        points: points.iter().map(Xyz::seen).collect(),
        color,
        colors: [],
        indices: triangles.iter().flatten().copied().collect(),
    }
}

/// The surfaces of all deformable bodies, as they touch.
pub fn flesh(session: &Session, time: Time) -> SceneUpdate {
    let world = session.world();
    let hands: Vec<u32> = session.hands().iter().filter_map(|hand| hand.flesh()).collect();
    let softs = world.desc().softs.iter().enumerate();
    let entities = softs.map(|(s, soft)| {
        let mut entity = Entity::new(time, WORLD, &soft.name);
        let colour = if hands.contains(&(s as u32)) { SKIN } else { BREAD };
        let points = world.collision_vertices(s as u32);
        entity.triangles.push(surface(points, &soft.flesh.collision.triangles, colour.into()));
        entity
    });
    SceneUpdate { deletions: Vec::new(), entities: entities.collect() }
}

/// An arrow for the force of each contact on its first body.
pub fn forces(session: &Session, time: Time) -> SceneUpdate {
    let mut entity = Entity::new(time, WORLD, "contacts");
    for contact in session.world().contacts() {
        let force = contact.force_W.norm();
        if force < FORCE_MIN {
            continue;
        }
        let length = ARROW * force;
        let turn = Quat::rotation_between(&Vec3::x(), &contact.force_W);
        // Straight back: any half turn does.
        let turn =
            turn.unwrap_or_else(|| Quat::from_axis_angle(&Vec3::y_axis(), std::f64::consts::PI));
        entity.arrows.push(Arrow {
            pose: Pose::new(contact.position_W, turn).into(),
            shaft_length: 0.75 * length,
            shaft_diameter: 1e-3,
            head_length: 0.25 * length,
            head_diameter: 2.5e-3,
            color: FORCE.into(),
        });
    }
    SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
}
