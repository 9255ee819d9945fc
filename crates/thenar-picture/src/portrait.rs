//! A model at rest, to look at it.

use super::colour::hex;
use super::draw::{Pen, wires};
use super::scene3d::{Mesh, Scene3d};
use super::surface;
use super::{
    Backdrop, Camera, Ground, HandActor, Image, Layers, Material, Pattern, Quality, Scales, Soft,
    Stage, render,
};
use thenar_core::model::{CouplingKind, Flesh, HandModel, HandPlacement, Skinning, WorldDesc};
use thenar_core::world::ModelError;
use thenar_core::{Pose, Vec3, World};
use thenar_rig::{Model, TriMesh};

/// Draws a model: a hand or a figure in its rest pose, seen from above its back, or an object.
///
/// # Errors
/// When a hand cannot be simulated.
pub fn portrait(
    model: &Model,
    layers: &Layers,
    size: [u32; 2],
    quality: &Quality,
) -> Result<Image, ModelError> {
    let (skin, flesh) = match model {
        Model::Hand(hand) => return hand_portrait(hand, layers, size, quality),
        Model::Rigid(rigid) => {
            let TriMesh { positions, triangles } = rigid.render.clone();
            (Mesh::new(positions, triangles, Material::paint(hex(0xb3231f))), None)
        }
        Model::Soft(soft) => {
            let positions = surface::embedded(&soft.render, &soft.flesh.tets, &soft.flesh.nodes);
            let mesh = Mesh::new(positions, soft.render.triangles.clone(), Material::rubber());
            (mesh, Some(&soft.flesh))
        }
    };
    Ok(object_portrait(skin, flesh, layers, size, quality))
}

fn hand_portrait(
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
        hands: vec![HandActor { model: hand, bones: handle.bones, joints: handle.joints }],
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

/// Draws an object, seen from above to one side; with the layer `flesh`, a soft one's elements too.
fn object_portrait(
    mut skin: Mesh,
    flesh: Option<&Flesh>,
    layers: &Layers,
    size: [u32; 2],
    quality: &Quality,
) -> Image {
    let flesh = flesh.filter(|_| layers.flesh);
    let aspect = f64::from(size[0]) / f64::from(size[1].max(1));
    let camera = Camera::fitted(&skin.positions, Vec3::new(-0.5, -0.6, -0.75), 0.5, aspect, 0.1);
    let lowest = skin.positions.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let paper = Backdrop::default().horizon;
    let ground = Some(Ground::horizontal(lowest, Pattern::Plain(paper)));
    let mut scene = Scene3d { ground, ..Scene3d::default() };
    if let Some(flesh) = flesh {
        let lines = wires(&flesh.nodes, &flesh.tets);
        let pen = Pen::new(&camera, size[1], 1.3);
        scene.meshes.push(pen.lines(lines, Material::unlit(hex(0x1d4e6b))));
        skin.material = Material { opacity: 0.32, casts_shadow: false, ..skin.material };
    }
    if layers.skin {
        scene.meshes.push(skin);
    }
    render(&scene, &camera, size[0], size[1], quality)
}
