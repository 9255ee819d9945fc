//! Messages that draw a session.

use super::message::{clear, colour, entity, placed, point, transform, vector};
use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, CylinderPrimitive, FrameTransforms, SceneEntity,
    SceneUpdate, SpherePrimitive, Timestamp, TriangleListPrimitive,
};
use thenar_core::model::RigidDesc;
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};
use thenar_scene::session::Session;

/// The frame of simulations, +y up, and one around it with +z up, as Foxglove has it.
pub const WORLD: &str = "world";
const MAP: &str = "map";
/// Length of an arrow per force \[m/N\].
pub const ARROW: f64 = 0.02;
/// Forces below are not drawn \[N\].
pub const FORCE_MIN: f64 = 1e-3;
/// Half the width of the piece of a half space that is drawn \[m\].
pub const GROUND: f64 = 0.5;

const SKIN: [f64; 3] = [0.85, 0.65, 0.55];
pub const BONE: [f64; 3] = [0.93, 0.91, 0.84];
const BREAD: [f64; 3] = [0.82, 0.62, 0.36];
const THING: [f64; 3] = [0.55, 0.6, 0.66];
pub const FORCE: [f64; 3] = [0.85, 0.1, 0.1];

/// Poses of all bodies, and those where driven ones should be (`NAME/wanted`).
pub fn transforms(session: &Session, now: Timestamp) -> FrameTransforms {
    let world = session.world();
    let upright = Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
    let upright = Pose::new(Vec3::zeros(), upright);
    let mut transforms = vec![transform(now, MAP, WORLD, &upright)];
    for (b, rigid) in world.desc().rigids.iter().enumerate() {
        let pose = world.rigid_pose(b as u32);
        transforms.push(transform(now, WORLD, &rigid.name, &pose));
        if let Some(target) = session.input().target(b) {
            let name = format!("{}/wanted", rigid.name);
            transforms.push(transform(now, WORLD, &name, &target.pose_WB));
        }
    }
    FrameTransforms { transforms }
}

/// Rigid bodies and bones, each in its own frame: sent once per scene.
pub fn objects(session: &Session, now: Timestamp) -> SceneUpdate {
    let desc = session.world().desc();
    let mut entities = Vec::new();
    for (b, rigid) in desc.rigids.iter().enumerate() {
        let look = session.looks().get(b);
        let colour = colour(colour_of(session, b));
        let mut entity = entity(now, &rigid.name, &rigid.name);
        match look.and_then(|look| look.mesh.as_ref()) {
            Some((mesh, _)) => {
                entity.triangles.push(surface(&mesh.positions, &mesh.triangles, colour));
            }
            None if desc.flesh_of_bone(b as u32).is_some() => {}
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
            let pose = Pose::new((from + to) / 2.0, turn);
            let size = Vec3::new(2.0 * bone.radius, 2.0 * bone.radius, axis.norm());
            entity.cylinders.push(cylinder(&pose, size, colour(BONE)));
        }
    }
    SceneUpdate { deletions: vec![clear(now)], entities }
}

/// The colour of a rigid body.
pub fn colour_of(session: &Session, body: usize) -> [f64; 3] {
    session.looks().get(body).and_then(|look| look.colour).unwrap_or(THING)
}

/// The colour of a deformable body.
pub fn colour_of_soft(session: &Session, soft: usize) -> [f64; 3] {
    let mut hands = session.hands().iter().filter_map(|hand| hand.flesh());
    if hands.any(|flesh| flesh as usize == soft) { SKIN } else { BREAD }
}

/// A cylinder along z.
fn cylinder(pose: &Pose, size: Vec3, color: Color) -> CylinderPrimitive {
    CylinderPrimitive {
        pose: Some(placed(pose)),
        size: Some(vector(size)),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    }
}

fn sphere(pose: &Pose, radius: f64, color: Color) -> SpherePrimitive {
    let size = Some(vector(Vec3::repeat(2.0 * radius)));
    SpherePrimitive { pose: Some(placed(pose)), size, color: Some(color) }
}

fn cube(pose: &Pose, size: Vec3, color: Color) -> CubePrimitive {
    CubePrimitive { pose: Some(placed(pose)), size: Some(vector(size)), color: Some(color) }
}

fn shape(rigid: &RigidDesc, color: Color, entity: &mut SceneEntity) {
    let pose = rigid.pose_BS;
    match &rigid.shape {
        None => {}
        Some(Shape::Sphere { radius }) => entity.spheres.push(sphere(&pose, *radius, color)),
        Some(Shape::Capsule { radius, half_length }) => {
            // Cylinders stand on z, capsules on y.
            let turn = Quat::rotation_between(&Vec3::z(), &Vec3::y());
            let turn = Pose::new(Vec3::zeros(), turn.unwrap_or_else(Quat::identity));
            let size = Vec3::new(2.0 * radius, 2.0 * radius, 2.0 * half_length);
            entity.cylinders.push(cylinder(&(pose * turn), size, color));
            for end in [-half_length, *half_length] {
                let end = Pose::new(Vec3::y() * end, Quat::identity());
                entity.spheres.push(sphere(&(pose * end), *radius, color));
            }
        }
        Some(Shape::Cuboid { half }) => entity.cubes.push(cube(&pose, half * 2.0, color)),
        Some(Shape::HalfSpace) => {
            let below = Pose::new(Vec3::y() * -5e-4, Quat::identity());
            let size = Vec3::new(2.0 * GROUND, 1e-3, 2.0 * GROUND);
            entity.cubes.push(cube(&(pose * below), size, color));
        }
        Some(Shape::Mesh(mesh)) => {
            let points: Vec<Vec3> = mesh.points.iter().map(|p| pose.point(p)).collect();
            entity.triangles.push(surface(&points, &mesh.triangles, color));
        }
        Some(other) => {
            if let Some(solid) = thenar_picture::of_shape(other, 48, 1) {
                let solid = solid.placed(&pose);
                entity.triangles.push(surface(&solid.positions, &solid.triangles, color));
            }
        }
    }
}

fn surface(points: &[Vec3], triangles: &[[u32; 3]], color: Color) -> TriangleListPrimitive {
    TriangleListPrimitive {
        pose: Some(placed(&Pose::identity())),
        points: points.iter().map(point).collect(),
        color: Some(color),
        colors: Vec::new(),
        indices: triangles.iter().flatten().copied().collect(),
    }
}

/// The surfaces of all deformable bodies, as they touch.
pub fn flesh(session: &Session, now: Timestamp) -> SceneUpdate {
    let world = session.world();
    let softs = world.desc().softs.iter().enumerate();
    let entities = softs.map(|(s, soft)| {
        let mut entity = entity(now, WORLD, &soft.name);
        let colour = colour(colour_of_soft(session, s));
        let points = world.collision_vertices(s as u32);
        entity.triangles.push(surface(points, &soft.flesh.collision.triangles, colour));
        entity
    });
    SceneUpdate { deletions: Vec::new(), entities: entities.collect() }
}

/// An arrow for the force of each contact on its first body.
pub fn forces(session: &Session, now: Timestamp) -> SceneUpdate {
    let mut entity = entity(now, WORLD, "contacts");
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
        entity.arrows.push(ArrowPrimitive {
            pose: Some(placed(&Pose::new(contact.position_W, turn))),
            shaft_length: 0.75 * length,
            shaft_diameter: 1e-3,
            head_length: 0.25 * length,
            head_diameter: 2.5e-3,
            color: Some(colour(FORCE)),
        });
    }
    SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
}
