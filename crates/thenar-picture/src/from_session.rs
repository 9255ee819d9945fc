//! Looks of the bodies of a scene file.

use super::actors::{HandActor, Rigid, Soft};
use super::colour::{Rgb, from_srgb_triple};
use super::{Camera, Image, Layers, Material, Quality, Scales, Stage, render};
use thenar_core::Vec3;
use thenar_rig::object::crust;
use thenar_scene::build::{BuiltHand, SoftBuild};
use thenar_scene::format::SoftShape;
use thenar_scene::session::Session;

/// Direction of view when the scene says nothing: from above the wrist, to one side.
const DIRECTION: Vec3 = Vec3::new(-0.5, -0.6, -0.75);
const FOV_Y: f64 = 0.6;

/// Draws a session as it is, `size` pixels wide and high.
pub fn draw(
    session: &Session,
    layers: &Layers,
    camera: &Camera,
    size: [u32; 2],
    quality: &Quality,
) -> Image {
    let scene = stage(session).scene(layers, &Scales::default(), camera, size[1]);
    render(&scene, camera, size[0], size[1], quality)
}

/// A moment of a session.
pub fn stage(session: &Session) -> Stage<'_> {
    let hands = session.hands();
    Stage {
        world: session.world(),
        input: session.input(),
        hands: hands
            .iter()
            .map(|h| HandActor {
                model: &h.model,
                bones: h.handle.bones.clone(),
                joints: h.handle.joints.clone(),
            })
            .collect(),
        softs: hands
            .iter()
            .filter_map(hand_flesh)
            .chain(session.softs().iter().enumerate().map(|(i, s)| soft(session, i, s)))
            .collect(),
        rigids: session
            .looks()
            .iter()
            .map(|look| Rigid {
                colour: look.colour.map(from_srgb_triple),
                mesh: look.mesh.as_ref().map(|(mesh, paint)| (mesh, &paint[..])),
            })
            .collect(),
    }
}

/// The scene's camera, or one that shows everything for a picture of this width by height.
pub fn camera(session: &Session, aspect: f64) -> Camera {
    match session.camera() {
        Some(c) => Camera {
            position: c.position,
            target: c.target,
            up: c.up,
            fov_y: c.fov_deg.to_radians(),
        },
        None => Camera::fitted(&stage(session).points(), DIRECTION, FOV_Y, aspect, 0.2),
    }
}

fn tinted(material: Material, colour: Option<[f64; 3]>) -> Material {
    match colour.map(from_srgb_triple) {
        Some(colour) => Material { colour, ..material },
        None => material,
    }
}

fn hand_flesh(hand: &BuiltHand) -> Option<Soft<'_>> {
    Some(Soft {
        index: hand.flesh()?,
        render: &hand.model.render,
        material: tinted(Material::skin(), hand.colour),
        colours: None,
        hand: Some(&hand.model),
    })
}

fn soft<'a>(session: &'a Session, i: usize, built: &'a SoftBuild) -> Soft<'a> {
    let shape = session.scene().soft.get(i).map(|s| &s.shape.value);
    let bread = matches!(shape, Some(SoftShape::Bread(_)));
    let flesh = &session.world().desc().softs[built.soft as usize].flesh;
    let colours: Option<Vec<Rgb>> = bread.then(|| crust(&built.render, &flesh.tets, &flesh.nodes));
    let material = if bread { Material::crust() } else { Material::rubber() };
    Soft {
        index: built.soft,
        render: &built.render,
        material: tinted(material, built.colour),
        colours,
        hand: None,
    }
}
