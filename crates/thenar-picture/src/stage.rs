//! A moment of a simulation as a scene of meshes.

use super::actors::{HandActor, Rigid, Soft};
use super::bodies::{bone_meshes, cuff_mesh, rigid_mesh};
use super::colour::{Rgb, hex, pressure_colour};
use super::draw::{Pen, arrow, points, wires};
use super::scene3d::{Ground, Material, Mesh, Pattern, Scene3d};
use super::shapes::Solid;
use super::skin;
use super::surface::{self, Nodes};
use super::{Camera, Layers};
use thenar_core::model::BodyId;
use thenar_core::shape::Shape;
use thenar_core::world::{ContactPoint, Input};
use thenar_core::{Vec3, World};

/// A world, and how its bodies look.
pub struct Stage<'a> {
    /// The world.
    pub world: &'a World,
    /// Input that acts on the world: where trackers have the bones.
    pub input: &'a Input,
    /// Hands on the stage.
    pub hands: Vec<HandActor<'a>>,
    /// Deformable bodies, in any order; those of hands too.
    pub softs: Vec<Soft<'a>>,
    /// One per rigid body of the world.
    pub rigids: Vec<Rigid<'a>>,
}

/// Pressed flesh sinks into what presses it; its pressure shows in front of as much \[m\].
const LIFT: f64 = 5e-3;

/// Skin that bears less than this part of the scale is not marked.
const LOAD_SHOWN: f64 = 0.04;

/// Scales that turn quantities into lengths and colours.
#[derive(Clone, Copy, Debug)]
pub struct Scales {
    /// Length of a force's arrow \[m/N\].
    pub force: f64,
    /// Longest arrow \[m\].
    pub arrow_max: f64,
    /// Pressure of the last colour \[Pa\].
    pub pressure: f64,
}

impl Default for Scales {
    fn default() -> Self {
        Self { force: 0.1, arrow_max: 0.08, pressure: 12e3 }
    }
}

impl Stage<'_> {
    /// The meshes to draw for `camera` and a picture of this height \[px\].
    pub fn scene(
        &self,
        layers: &Layers,
        scales: &Scales,
        camera: &Camera,
        height: u32,
    ) -> Scene3d<'static> {
        let mut scene = Scene3d { ground: self.ground(), ..Scene3d::default() };
        for (i, rigid) in self.objects() {
            let desc = &self.world.desc().rigids[i];
            scene.meshes.extend(rigid_mesh(desc, &self.world.rigid_pose(i as u32), rigid));
        }
        let pen = Pen::new(camera, height, 1.3);
        for soft in &self.softs {
            self.add_soft(soft, layers, scales, &pen, &mut scene);
        }
        for hand in &self.hands {
            let through = layers.targets || layers.pressure || layers.see_through();
            let has_flesh = self
                .softs
                .iter()
                .any(|soft| soft.hand.is_some_and(|of| std::ptr::eq(of, hand.model)));
            if layers.skin && has_flesh && !through {
                scene.meshes.extend(cuff_mesh(self.world, hand));
            }
            if layers.bones {
                scene.meshes.extend(bone_meshes(self.world, hand));
            }
            if layers.tracked {
                scene.meshes.extend(self.tracked(hand));
            }
        }
        self.add_contacts(layers, scales, &mut scene);
        scene
    }

    /// Rigid bodies that are no bones inside flesh.
    fn objects(&self) -> impl Iterator<Item = (usize, &Rigid<'_>)> {
        let all = self.rigids.iter().enumerate();
        all.filter(|(i, _)| self.world.desc().flesh_of_bone(*i as u32).is_none())
    }

    /// Points that a picture should show.
    pub fn points(&self) -> Vec<Vec3> {
        let mut points: Vec<Vec3> = Vec::new();
        for (i, rigid) in self.objects() {
            let desc = &self.world.desc().rigids[i];
            if let Some(mesh) = rigid_mesh(desc, &self.world.rigid_pose(i as u32), rigid) {
                let reach = mesh.positions.iter().map(|p| (p - mesh.positions[0]).norm());
                // Tables and walls need not be seen whole.
                if reach.fold(0.0, f64::max) < 0.5 {
                    points.extend_from_slice(&mesh.positions);
                }
            }
        }
        (0..self.world.desc().softs.len()).for_each(|s| points.extend(self.world.nodes(s as u32)));
        for hand in &self.hands {
            points.extend(hand.bones.clone().map(|b| self.world.rigid_pose(b).position));
        }
        if points.is_empty() {
            let rigids = 0..self.rigids.len() as u32;
            points.extend(rigids.map(|i| self.world.rigid_pose(i).position));
        }
        points
    }

    /// The first plane of the scene.
    fn ground(&self) -> Option<Ground> {
        let desc = self.world.desc();
        let i = desc.rigids.iter().position(|r| matches!(r.shape, Some(Shape::HalfSpace)))?;
        let pose = self.world.rigid_pose(i as u32) * desc.rigids[i].pose_BS;
        let pattern = match self.rigids.get(i).and_then(|r| r.colour) {
            Some(c) => Pattern::Checker([c, c.map(|x| 0.6 * x)], 0.05),
            None => Pattern::Wood(0.09),
        };
        Some(Ground { point: pose.position, normal: pose.vector(&Vec3::y()), pattern })
    }

    fn add_soft(
        &self,
        soft: &Soft,
        layers: &Layers,
        scales: &Scales,
        pen: &Pen,
        scene: &mut Scene3d<'static>,
    ) {
        let desc = &self.world.desc().softs[soft.index as usize];
        let nodes = self.world.nodes(soft.index);
        let tets = &desc.flesh.tets;
        let shows_pressure = layers.pressure && soft.hand.is_some();
        let mut material = soft.material;
        if layers.see_through() || shows_pressure {
            material = Material { opacity: 0.32, casts_shadow: false, ..material };
        }
        if layers.skin && !layers.targets {
            let positions = surface::embedded(soft.render, tets, nodes);
            if shows_pressure {
                let eye = pen.eye();
                scene.meshes.extend(self.loaded_skin(soft, &positions, scales.pressure, eye));
            }
            let mut mesh = Mesh::new(positions, soft.render.triangles.clone(), material);
            if !layers.pressure && !layers.weights {
                mesh.sites = soft.hand.and_then(|hand| skin::sites(hand, soft.render));
            }
            scene.meshes.push(tinted(mesh, soft, layers));
        }
        if layers.targets {
            let mut targets = nodes.to_vec();
            self.world.skin_targets(soft.index, &mut targets);
            let positions = surface::embedded(soft.render, tets, &targets);
            scene.meshes.push(Mesh::new(positions, soft.render.triangles.clone(), material));
        }
        if layers.flesh {
            let colour = Material::unlit(hex(0x1d4e6b));
            scene.meshes.push(pen.lines(wires(nodes, tets), colour));
        }
    }

    /// The part of the skin that something presses on, in the colours of the pressure up to `most`
    /// \[Pa\]: seen from both sides, and in front of what it has sunk into. Nothing without
    /// pressure.
    fn loaded_skin(
        &self,
        soft: &Soft,
        positions: &[Vec3],
        most: f64,
        eye: Vec3,
    ) -> Option<Mesh<'static>> {
        let loads: Vec<f64> =
            self.pressure(soft.index, positions).iter().map(|p| p / most).collect();
        let load = |i: u32| loads.get(i as usize).copied().unwrap_or_default();
        let loaded = |t: &&[u32; 3]| t.iter().any(|&i| load(i) > LOAD_SHOWN);
        let triangles: Vec<[u32; 3]> =
            soft.render.triangles.iter().filter(loaded).copied().collect();
        if triangles.is_empty() {
            return None;
        }
        // Along the line of sight, so that nothing moves in the picture.
        let lifted = |p: &Vec3| p + (eye - p).try_normalize(1e-9).unwrap_or_default() * LIFT;
        let places: Vec<Vec3> = positions.iter().map(lifted).collect();
        let colours: Vec<Rgb> = loads.iter().map(|p| pressure_colour(*p)).collect();
        let mesh = Mesh::new(places, triangles, Material::unlit([1.0; 3])).coloured(colours);
        Some(Mesh { two_sided: true, ..mesh })
    }

    /// Contact pressure \[Pa\] at places on a deformable body: each contact's normal force is
    /// spread over a bell whose height is force by area.
    pub fn pressure(&self, soft: u32, places: &[Vec3]) -> Vec<f64> {
        let body = BodyId::Soft(soft);
        let own = |c: &&ContactPoint| c.bodies.contains(&body) && c.area > 0.0;
        let contacts: Vec<&ContactPoint> = self.world.contacts().iter().filter(own).collect();
        let spread = |p: &Vec3| -> f64 {
            contacts
                .iter()
                .map(|c| {
                    let square = (p - c.position_W).norm_squared();
                    let peak = c.force_W.dot(&c.normal_W).max(0.0) / c.area;
                    peak * (-std::f64::consts::PI * square / c.area).exp()
                })
                .fold(0.0, |sum, p| sum + p)
        };
        places.iter().map(spread).collect()
    }

    /// The skin of a hand as its tracker has it.
    fn tracked(&self, hand: &HandActor) -> Option<Mesh<'static>> {
        let known = hand.bones.clone().any(|b| self.input.targets[b as usize].is_some());
        if !known {
            return None;
        }
        let pose = |b: u32| match &self.input.targets[b as usize] {
            Some(target) => target.pose_WB,
            None => self.world.rigid_pose(b),
        };
        let poses: Vec<_> = hand.bones.clone().map(pose).collect();
        let nodes: Nodes = surface::skinned(hand.model, &poses);
        let positions = surface::embedded(&hand.model.render, &hand.model.flesh.tets, &nodes);
        let yellow = Material::ghost(hex(0xf5c518), 0.42);
        Some(Mesh::new(positions, hand.model.render.triangles.clone(), yellow))
    }

    fn add_contacts(&self, layers: &Layers, scales: &Scales, scene: &mut Scene3d<'static>) {
        let contacts = self.world.contacts();
        let loaded = |c: &&ContactPoint| c.force_W.norm() > 1e-6;
        if layers.contacts {
            let (active, near): (Vec<&ContactPoint>, Vec<&ContactPoint>) =
                contacts.iter().partition(loaded);
            for (list, colour) in [(active, hex(0xd6261c)), (near, hex(0x3a76d8))] {
                let mut solid = points(list.iter().map(|c| c.position_W), 0.0012);
                for c in list {
                    solid.join(&arrow(c.position_W, c.normal_W * 0.009, 0.0004));
                }
                push_over(solid, colour, scene);
            }
        }
        if layers.forces {
            let mut solid = Solid::default();
            for c in contacts.iter().filter(loaded) {
                let length = (c.force_W.norm() * scales.force).min(scales.arrow_max);
                // The force on the deformable side, drawn so that its tip touches.
                let sign = if matches!(c.bodies[0], BodyId::Soft(_)) { 1.0 } else { -1.0 };
                let vector = c.force_W.normalize() * (sign * length);
                solid.join(&arrow(c.position_W - vector, vector, 0.0009));
            }
            push_over(solid, hex(0x1a9641), scene);
        }
    }
}

/// The skin in the colours that the layers ask for.
fn tinted(mut mesh: Mesh<'static>, soft: &Soft, layers: &Layers) -> Mesh<'static> {
    if layers.weights
        && !layers.pressure
        && let Some(colours) = surface::bone_colours(soft)
    {
        mesh.material = Material { colour: [1.0; 3], ..Material::skin() };
        mesh.coloured(colours)
    } else if let Some(colours) = &soft.colours {
        mesh.coloured(colours.clone())
    } else {
        mesh
    }
}

fn push_over(solid: Solid, colour: Rgb, scene: &mut Scene3d<'static>) {
    if !solid.triangles.is_empty() {
        scene.meshes.push(solid.mesh(Material::matte(colour).over_everything()));
    }
}
