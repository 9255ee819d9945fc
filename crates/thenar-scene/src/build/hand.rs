//! Hands.

use super::soft::{damped_once, group_elements, law, relaxation, skinning};
use super::solver::set;
use super::{
    Built, Files, Mesh, RigidAppearance, assets, drivers, hand_joints, motion, place, pose_offsets,
    preset, tissue,
};
use crate::format::{BonesWord, CouplingWord, ElementsWord, Hand, HandMaterial, PresetWord, Scene};
use crate::math::{Pose, Vec3};
use crate::motion::{ANGLES, AngleRange, Articulation, HandMotion, hand_angles};
use crate::text::Fault;
use std::ops::Range;
use thenar_core::World;
use thenar_core::model::{CouplingKind, Drive, Flesh, HandModel, HandPlacement};
use thenar_track::Muscles;

/// Indices of a hand's parts in the world.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HandParts {
    /// Bones of the hand among the rigid bodies.
    pub bones: Range<u32>,
    /// Joints of the hand among the world's joints.
    pub joints: Range<u32>,
    /// Flesh of the hand among the deformable bodies, if it has any.
    pub soft: Option<u32>,
}

/// A hand of a scene, built: its model, where it is in the world, and what it follows.
#[derive(Clone, Debug)]
pub struct BuiltHand {
    /// Name in the scene.
    pub name: String,
    /// The model it was made from.
    pub model: HandModel,
    /// Indices of its parts in the world.
    pub handle: HandParts,
    /// Motion that it follows; `None` lets it hold its start pose, or go.
    pub motion: Option<HandMotion>,
    /// True if the bones have drives.
    pub driven: bool,
    /// The flesh that the springs to the bones hold.
    pub coupling: CouplingKind,
    /// Springs between flesh and bones, per volume of what they hold \[N/m⁴\].
    pub coupling_stiffness: f64,
    /// Torques that hold its joints at their targets; `None` for a hand that nothing drives, or
    /// that the scene leaves to its drives.
    pub muscles: Option<Muscles>,
    /// Red, green, blue from 0 to 1, if the scene says.
    pub colour: Option<[f64; 3]>,
}

impl BuiltHand {
    /// The twenty angles of the hand (see [`hand_angles`]); `None` for a joint it lacks, and for
    /// all when its joints are no tree.
    pub fn angles(&self) -> [Option<AngleRange>; ANGLES] {
        match Articulation::new(&self.model) {
            Ok(articulation) => hand_angles(&self.model, &articulation),
            Err(_) => std::array::from_fn(|_| None),
        }
    }

    /// The wrist's frame in the palm bone: -z towards the fingers, +y out of the back.
    pub fn wrist_B(&self) -> Pose {
        self.model.bones.first().map_or(Pose::identity(), |palm| palm.pose_BT)
    }

    /// Places of all nodes of its flesh, bound or free, by linear blend skinning (Eq. 6), world
    /// \[m\].
    pub fn skinned(&self, world: &World) -> Vec<Vec3> {
        let bones = &self.model.bones;
        let moves: Vec<Pose> = self
            .handle
            .bones
            .clone()
            .zip(bones)
            .map(|(rigid, bone)| world.rigid_pose(rigid) * bone.pose_MB.inverse())
            .collect();
        let nodes = self.model.flesh.nodes.iter().zip(&self.model.bindings);
        nodes
            .map(|(x, binding)| {
                let by = |k: usize| moves[binding.bones[k] as usize].point(x) * binding.weights[k];
                by(0) + by(1)
            })
            .collect()
    }

    /// True when it has flesh, and springs that hold only what lies in the place of bone.
    pub fn hangs_on_bone(&self) -> bool {
        self.flesh().is_some() && self.coupling == CouplingKind::Bone
    }

    /// The index of its flesh among the deformable bodies, if it has any.
    pub fn flesh(&self) -> Option<u32> {
        self.handle.soft
    }
}

/// Adds all hands.
pub fn add_all(built: &mut Built, scene: &Scene, files: &Files) -> Result<(), Fault> {
    for hand in &scene.hand {
        add(built, hand, preset(scene, hand), files)?;
    }
    Ok(())
}

fn add(built: &mut Built, hand: &Hand, preset: PresetWord, files: &Files) -> Result<(), Fault> {
    let at = |problem| hand.name.fault(problem);
    // That of a model file is known when it is read.
    let built_here = hand.model.as_ref().is_none_or(|file| !file.value.ends_with(".thenar"));
    if built_here {
        if let (Some(_), Some(detail)) = (hand.tets, &hand.detail) {
            return Err(
                detail.fault("`tets` and `detail` are both given: one of them says how fine")
            );
        }
        built.memory.take_tets(assets::tets_wanted(hand, preset), at)?;
    }
    let mut model = assets::hand(hand, preset, files)?;
    if !built_here {
        built.memory.take_tets(model.flesh.tets.len() as u64, at)?;
    }
    let modulus = |flesh: &Flesh| flesh.materials.iter().map(|m| m.young).fold(0.0, f64::max);
    let before = modulus(&model.flesh);
    apply_material(&mut model.flesh, hand.material.as_ref(), tissue::is_layered(hand))?;
    let softer = modulus(&model.flesh) / before.max(f64::MIN_POSITIVE);
    model.bending.iter_mut().for_each(|f| *f *= softer);
    built.memory.take_relaxation(&model.flesh.relaxation, at)?;
    set(&mut model.flesh.friction, hand.friction);
    hand_joints::change(&mut model, &hand.joint)?;
    let own = Pose::new(hand.position, place::rotation(hand.rotation.as_ref())?);
    let coupling = coupling(hand, &model)?;
    let coupling_stiffness =
        hand.coupling_stiffness.unwrap_or_else(|| model.usual_coupling_stiffness(coupling));
    let motion = match &hand.motion {
        Some(table) => Some(motion::load(table, &model, &own, files)?),
        None => None,
    };
    let pose_WM = motion.as_ref().map_or(own, HandMotion::start_placement);
    let drive = |table: Option<&crate::format::DriveTable>, default| {
        hand.driven.then(|| table.map_or(default, drivers::settings))
    };
    let placement = HandPlacement {
        name: hand.name.value.clone(),
        pose_WM,
        coupling,
        coupling_stiffness,
        coupling_damping_time: hand.coupling_damping_time,
        skinning: skinning(hand.skinning),
        root_drive: drive(hand.palm_drive.as_ref(), Drive::palm()),
        bone_drive: drive(hand.bone_drive.as_ref(), Drive::bone()),
        // A skeleton touches nothing.
        solid_bones: hand.flesh && hand.bones == BonesWord::Solid,
        nails: tissue::has_nails(hand),
    };
    let handle = built.world.add_hand(&model, &placement);
    if !hand.self_contact {
        built.world.self_contact.retain(|&soft| soft != handle.soft);
    }
    built.names.add_hand(&hand.name, built.hands.len() as u32)?;
    if hand.flesh {
        built.names.add_flesh(&hand.name.value, handle.soft);
        let usual = match coupling {
            CouplingKind::Uniform => ElementsWord::Tetrahedra,
            CouplingKind::Bone => ElementsWord::Patches,
        };
        group_elements(&mut built.world, handle.soft, hand.elements.unwrap_or(usual));
        built.world.skins.extend(tissue::skin_of_hand(hand, &model, handle.soft)?);
        pose_offsets::of_hand(built, hand, &model, &handle, coupling, placement.skinning)?;
        built.meshes.push(Mesh::new(&model.flesh.nodes, &model.flesh.tets));
        built.node_starts.push(None);
    } else {
        if hand.pose_offsets {
            return Err(at("`pose_offsets` move flesh, and `flesh = false` leaves it out".into()));
        }
        built.world.softs.pop();
        built.world.parts.pop();
        built.world.self_contact.retain(|&soft| soft != handle.soft);
    }
    for i in handle.bones.clone() {
        let name = built.world.rigids[i as usize].name.clone();
        built.names.add_bone(&name, i);
        built.looks.push(RigidAppearance {
            colour: hand.colour,
            mesh: None,
            pose_MB: Pose::identity(),
        });
    }
    for j in handle.joints.clone() {
        let name = built.world.joints[j as usize].name.clone();
        built.names.add_joint_of(&name, j);
    }
    // The flesh's stiffness was measured as the model holds its flesh.
    if coupling != model.coupling {
        model.bending.clear();
    }
    // Joints that no drive pulls are limp, and fingers that are to grip find their own way, by
    // force.
    let usual = preset != PresetWord::Paper && hand.grip.is_empty();
    let pulls = |drive: Drive| drive.stiffness > 0.0 || drive.angular_stiffness > 0.0;
    let has_muscles = placement.bone_drive.is_some_and(pulls) && hand.muscles.unwrap_or(usual);
    let muscles = has_muscles.then(|| Muscles::new(&model, hand.flesh).ok()).flatten();
    built.hands.push(BuiltHand {
        name: hand.name.value.clone(),
        model,
        handle: HandParts {
            bones: handle.bones,
            joints: handle.joints,
            soft: hand.flesh.then_some(handle.soft),
        },
        motion: motion.filter(|_| hand.driven),
        driven: hand.driven,
        coupling,
        coupling_stiffness,
        muscles,
        colour: hand.colour,
    });
    Ok(())
}

/// The flesh that the springs hold: as the scene says, else as the model has it.
fn coupling(hand: &Hand, model: &HandModel) -> Result<CouplingKind, Fault> {
    let Some(word) = &hand.coupling else { return Ok(model.coupling) };
    match word.value {
        CouplingWord::Uniform => Ok(CouplingKind::Uniform),
        CouplingWord::Bone if model.bone_nodes.is_empty() => Err(word.fault(
            "the model does not know which of its nodes lie in bone: it was built by an earlier \
             version; build it again",
        )),
        CouplingWord::Bone => Ok(CouplingKind::Bone),
    }
}

/// Changes the flesh as the scene says. A model's elements differ in modulus and density by how
/// much of the body they hold: a change of the largest scales them all. What lies under layers was
/// given its modulus, ratio and law when it was built.
pub(super) fn apply_material(
    flesh: &mut Flesh,
    table: Option<&HandMaterial>,
    layered: bool,
) -> Result<(), Fault> {
    let Some(t) = table else { return Ok(()) };
    let largest = |f: fn(&thenar_core::model::Material) -> f64| {
        flesh.materials.iter().map(f).fold(f64::MIN_POSITIVE, f64::max)
    };
    let named = t.tissue.as_ref().map(|tissue| tissue::named(tissue.value));
    let asked = t.young.or(named.map(|(_, young, _)| young)).filter(|_| !layered);
    let young = asked.map(|e| e / largest(|m| m.young));
    let density = t.density.map(|d| d / largest(|m| m.density));
    for material in &mut flesh.materials {
        material.young *= young.unwrap_or(1.0);
        material.density *= density.unwrap_or(1.0);
        if !layered {
            let own = named.map_or(material.law, |(law, ..)| law);
            material.law = law(t.law.as_ref(), t.alpha.as_ref(), own)?;
            set(&mut material.poisson, t.poisson.or(named.map(|(.., poisson)| poisson)));
        }
    }
    set(&mut flesh.mass_damping, t.mass_damping);
    set(&mut flesh.stiffness_damping, t.stiffness_damping);
    if let Some(terms) = &t.relaxation {
        let own = relaxation(terms)?;
        flesh.relaxation.clear();
        if !own.is_none() {
            damped_once(terms, t.stiffness_damping)?;
            flesh.relaxation.resize(flesh.tets.len(), own);
        }
    }
    Ok(())
}
