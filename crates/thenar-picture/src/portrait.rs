//! A model at rest, to look at it.

use super::{
    Backdrop, Camera, Ground, Hand, Image, Layers, Material, Pattern, Quality, Scales, Soft, Stage,
    render,
};
use thenar::model::{CouplingKind, HandModel, HandPlacement, Skinning, WorldDesc};
use thenar::world::ModelError;
use thenar::{Pose, Vec3, World};

/// Draws a hand in its rest pose, seen from above its back.
///
/// # Errors
/// When the model cannot be simulated.
pub fn hand_portrait(
    hand: &HandModel,
    layers: &Layers,
    size: [u32; 2],
    quality: &Quality,
) -> Result<Image, ModelError> {
    let mut desc = WorldDesc::default();
    let handle = desc.add_hand(
        hand,
        &HandPlacement {
            name: hand.name.clone(),
            pose_WM: Pose::identity(),
            coupling: CouplingKind::Uniform,
            coupling_stiffness: 1.0,
            coupling_damping_time: 0.0,
            skinning: Skinning::Linear,
            root_drive: None,
            bone_drive: None,
            solid_bones: true,
            nails: false,
        },
    );
    let world = World::new(desc)?;
    let input = world.input();
    let stage = Stage {
        world: &world,
        input: &input,
        hands: vec![Hand { model: hand, bones: handle.bones, joints: handle.joints }],
        softs: vec![Soft {
            index: handle.soft,
            render: &hand.render,
            material: Material::skin(),
            colours: None,
            hand: Some(hand),
        }],
        rigids: (0..world.desc().rigids.len()).map(|_| Default::default()).collect(),
    };
    let points = stage.points();
    let lowest = points.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let aspect = f64::from(size[0]) / f64::from(size[1].max(1));
    let camera = Camera::fitted(&points, Vec3::new(0.25, -0.9, -0.6), 0.5, aspect, 0.08);
    let mut scene = stage.scene(layers, &Scales::default(), &camera, size[1]);
    let paper = Backdrop::default().horizon;
    scene.ground = Some(Ground::horizontal(lowest - 0.01, Pattern::Plain(paper)));
    Ok(render(&scene, &camera, size[0], size[1], quality))
}
