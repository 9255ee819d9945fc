//! Soft bodies.

use super::solver::set;
use super::{Built, Files, Mesh, assets, lattice, place, pose_offsets, tissue};
use crate::format::{
    Bind, ElementsWord, FixedSet, LawWord, MaterialTable, Scene, SkinningWord, Soft, SoftShape,
    SplitWord, Terms,
};
use crate::math::{Mat3, Pose, Vec3};
use crate::text::{Fault, Located};
use std::collections::BTreeMap;
use thenar_core::model::{
    Binding, Coupling, EmbeddedSurface, FixedNode, Flesh, Law, Material, Relaxation, Skinning,
    SoftDesc, Springs, WorldDesc,
};
use thenar_rig::object::SoftModel;

/// A soft body that is no hand.
#[derive(Clone, Debug)]
pub struct SoftBuild {
    /// Index among the deformable bodies.
    pub soft: u32,
    /// Surface to draw.
    pub render: EmbeddedSurface,
    /// Red, green, blue from 0 to 1, if the scene says.
    pub colour: Option<[f64; 3]>,
}

/// Adds all soft bodies.
pub fn add_all(built: &mut Built, scene: &Scene, files: &Files) -> Result<(), Fault> {
    for soft in &scene.soft {
        add(built, soft, files)?;
    }
    Ok(())
}

fn add(built: &mut Built, soft: &Soft, files: &Files) -> Result<(), Fault> {
    let at = |problem| soft.shape.fault(problem);
    let known = tets_wanted(&soft.shape.value);
    if let Some(tets) = known {
        built.memory.take_tets(tets, at)?;
    }
    let SoftModel { mut flesh, render, .. } = rest_shape(&soft.shape, files)?;
    if known.is_none() {
        built.memory.take_tets(flesh.tets.len() as u64, at)?;
    }
    let mesh = Mesh::new(&flesh.nodes, &flesh.tets);
    let pose_WM = Pose::new(soft.position, place::rotation(soft.rotation.as_ref())?);
    let start = start(soft, &mesh, &pose_WM)?;
    let index = built.world.softs.len() as u32;
    let skin = soft.skin.as_ref();
    let skin =
        skin.map(|skin| tissue::skin_of_soft(skin, &flesh, &flesh.collision, index)).transpose()?;
    if !soft.contact {
        flesh.collision = EmbeddedSurface::default();
    }
    let usual = usual(&soft.shape.value, &flesh);
    colour_in(&mut flesh.materials, soft, &usual.material, is_built(&soft.shape.value), &mesh)?;
    remember(&mut flesh, soft, &mesh)?;
    built.memory.take_relaxation(&flesh.relaxation, at)?;
    flesh.mass_damping = soft.mass_damping.unwrap_or(usual.mass_damping);
    flesh.stiffness_damping = soft.stiffness_damping.unwrap_or(usual.stiffness_damping);
    flesh.friction = soft.friction;
    flesh.fixed = fixed(&soft.fixed, &mesh)?;
    let coupling = coupling(built, soft, &mesh)?;
    pose_offsets::of_binds(built, soft, &mesh, index)?;
    built.world.skins.extend(skin);
    built.world.add_soft(SoftDesc {
        name: soft.name.value.clone(),
        flesh,
        pose_WM,
        velocity_W: soft.velocity,
        coupling,
    });
    group_elements(&mut built.world, index, soft.elements);
    if soft.self_contact {
        built.world.self_contact.push(index);
    }
    built.names.add_soft(&soft.name, index)?;
    built.softs.push(SoftBuild { soft: index, render, colour: soft.colour });
    built.meshes.push(mesh);
    built.node_starts.push(start);
    Ok(())
}

/// Groups the elements of a deformable body as the scene asks.
pub(super) fn group_elements(world: &mut WorldDesc, soft: u32, elements: ElementsWord) {
    if elements == ElementsWord::Patches {
        world.group_into_patches(soft);
    }
}

/// Number of tetrahedra that a shape will have; `None` where only its file says.
pub(super) fn tets_wanted(shape: &SoftShape) -> Option<u64> {
    let product = |cells: &[u32; 3]| cells.iter().map(|&n| u64::from(n)).product::<u64>();
    Some(match shape {
        SoftShape::Lattice(s) => {
            let planes = s.coordinates.as_ref().map(|p| [0, 1, 2].map(|k| p[k].len() as u32));
            let per_cell = if s.split == SplitWord::Kuhn { 6 } else { 5 };
            per_cell * s.cells.or(planes).as_ref().map_or(0, product)
        }
        // An icosahedron's 20 triangles, each cut into frequency² prisms of three tetrahedra a
        // layer, and tetrahedra about the centre.
        SoftShape::Ball(s) => 20 * u64::from(s.frequency).pow(2) * (3 * u64::from(s.layers) + 1),
        SoftShape::Bread(s) => 5 * product(&assets::loaf(s).cells),
        SoftShape::Explicit(s) => s.tets.value.len() as u64,
        SoftShape::Mesh(s) if !s.file.value.ends_with(".thenar") => u64::from(s.tets),
        SoftShape::Mesh(_) | SoftShape::File(_) => return None,
    })
}

fn rest_shape(shape: &Located<SoftShape>, files: &Files) -> Result<SoftModel, Fault> {
    match &shape.value {
        SoftShape::Lattice(s) => lattice::build(s, shape),
        SoftShape::Ball(s) => assets::ball(s, shape),
        SoftShape::Explicit(s) => assets::explicit(s, 1.0),
        SoftShape::File(s) => assets::tet_file(s, files),
        SoftShape::Mesh(s) => assets::soft_mesh(s, files),
        SoftShape::Bread(s) => assets::bread(s, shape),
    }
}

/// Defaults where a scene does not say.
struct Defaults {
    material: Material,
    mass_damping: f64,
    stiffness_damping: f64,
}

fn usual(shape: &SoftShape, flesh: &Flesh) -> Defaults {
    match shape {
        // A built model has its own materials: the scene changes them, as a whole.
        _ if is_built(shape) => Defaults {
            material: stiffest(&flesh.materials),
            mass_damping: flesh.mass_damping,
            stiffness_damping: flesh.stiffness_damping,
        },
        SoftShape::Bread(s) => {
            let loaf = assets::loaf(s);
            Defaults {
                material: loaf.crumb,
                mass_damping: loaf.options.mass_damping,
                stiffness_damping: loaf.options.stiffness_damping,
            }
        }
        _ => Defaults {
            material: Material {
                law: Law::Corotational,
                young: 5e4,
                poisson: 0.4,
                density: 1000.0,
            },
            mass_damping: 0.0,
            stiffness_damping: 0.0,
        },
    }
}

/// A model file, whose elements have materials already.
fn is_built(shape: &SoftShape) -> bool {
    matches!(shape, SoftShape::Mesh(s) if s.file.value.ends_with(".thenar"))
}

fn stiffest(materials: &[Material]) -> Material {
    let stiffer = |a: Material, b: &Material| if b.young > a.young { *b } else { a };
    materials.iter().fold(assets::unit(), stiffer)
}

/// Gives every element its material. `materials` holds what the shape makes of a unit material
/// (elements filled in part, crusts) and scales what the scene says.
fn colour_in(
    materials: &mut [Material],
    soft: &Soft,
    usual: &Material,
    built: bool,
    mesh: &Mesh,
) -> Result<(), Fault> {
    let base = material(soft.material.as_ref(), *usual)?;
    let mut scales = materials.to_vec();
    if built {
        scales.iter_mut().for_each(|m| {
            m.young /= usual.young;
            m.density /= usual.density;
        });
    }
    let scaled = |own: &Material, scale: &Material| Material {
        young: own.young * scale.young,
        density: own.density * scale.density,
        ..*own
    };
    for (m, scale) in materials.iter_mut().zip(&scales) {
        *m = scaled(&base, scale);
    }
    for region in &soft.region {
        let own = material(Some(&region.material), base)?;
        for t in mesh.select_tets(Some(&region.elements))? {
            materials[t as usize] = scaled(&own, &scales[t as usize]);
        }
    }
    Ok(())
}

/// The material of a table, on top of `base`.
pub fn material(table: Option<&MaterialTable>, base: Material) -> Result<Material, Fault> {
    let mut m = base;
    let Some(t) = table else { return Ok(m) };
    m = tissue::changed(
        m,
        t.tissue.as_ref(),
        t.law.as_ref(),
        t.alpha.as_ref(),
        t.young,
        t.poisson,
    )?;
    set(&mut m.density, t.density);
    if let Some(mu) = &t.mu {
        if t.young.is_some() {
            return Err(mu.fault("expected `young` or `mu`, not both"));
        }
        m.young = 2.0 * (1.0 + m.poisson) * mu.value;
    }
    Ok(m)
}

/// The law that a table asks for, in the place of `own`.
pub fn law(
    word: Option<&Located<LawWord>>,
    alpha: Option<&Located<f64>>,
    own: Law,
) -> Result<Law, Fault> {
    let asked = match word.map(|word| word.value) {
        None => own,
        Some(LawWord::Corotational) => Law::Corotational,
        Some(LawWord::NeoHookean) => Law::NeoHookean,
        Some(LawWord::StableNeoHookean) => Law::StableNeoHookean,
        Some(LawWord::Ogden) => match (own, alpha) {
            (_, Some(alpha)) => Law::Ogden { alpha: alpha.value },
            (Law::Ogden { .. }, None) => own,
            (_, None) => {
                let needs = "Ogden's law needs its exponent, `alpha`, from 4 to 20";
                return word.map_or(Ok(own), |word| Err(word.fault(needs)));
            }
        },
    };
    match (asked, alpha) {
        (Law::Ogden { .. }, Some(alpha)) => Ok(Law::Ogden { alpha: alpha.value }),
        (_, Some(alpha)) => Err(alpha.fault("only `law = \"ogden\"` has an exponent")),
        (_, None) => Ok(asked),
    }
}

/// Gives every element its relaxation; a body that is built already may have some.
fn remember(flesh: &mut Flesh, soft: &Soft, mesh: &Mesh) -> Result<(), Fault> {
    let mut all = std::mem::take(&mut flesh.relaxation);
    all.resize(flesh.tets.len(), Relaxation::NONE);
    let own = soft.material.as_ref().and_then(|m| m.relaxation.as_ref());
    if let Some(terms) = own {
        all.fill(relaxation(terms)?);
    }
    for region in &soft.region {
        if let Some(terms) = &region.material.relaxation {
            let own = relaxation(terms)?;
            for t in mesh.select_tets(Some(&region.elements))? {
                all[t as usize] = own;
            }
        }
    }
    if all.iter().any(|r| !r.is_none()) {
        flesh.relaxation = all;
        let everywhere = flesh.relaxation.iter().all(|r| !r.is_none());
        if let Some(terms) = own.filter(|_| everywhere) {
            damped_once(terms, soft.stiffness_damping)?;
        }
    }
    Ok(())
}

/// The relaxation of a list of terms.
pub fn relaxation(terms: &Located<Terms>) -> Result<Relaxation, Fault> {
    Relaxation::new(&terms.value.0).map_err(|error| terms.fault(error.to_string()))
}

/// Refuses Rayleigh damping that would act on nothing.
pub fn damped_once(terms: &Located<Terms>, stiffness_damping: Option<f64>) -> Result<(), Fault> {
    match stiffness_damping {
        Some(damping) if damping > 0.0 => Err(terms.fault(
            "expected `relaxation` or `stiffness_damping`, not both: tissue with memory is damped by it, \
             and nothing is damped twice",
        )),
        _ => Ok(()),
    }
}

fn fixed(sets: &[FixedSet], mesh: &Mesh) -> Result<Vec<FixedNode>, Fault> {
    let mut held: BTreeMap<u32, [bool; 3]> = BTreeMap::new();
    for set in sets {
        let axes = axes(set)?;
        for node in mesh.select_nodes(Some(&set.nodes))? {
            let entry = held.entry(node).or_insert([false; 3]);
            (0..3).for_each(|k| entry[k] |= axes[k]);
        }
    }
    Ok(held.into_iter().map(|(node, axes)| FixedNode { node, axes }).collect())
}

fn axes(set: &FixedSet) -> Result<[bool; 3], Fault> {
    let Some(at) = &set.axes else { return Ok([true; 3]) };
    match at.value.chars().all(|c| "xyz".contains(c)) {
        true => Ok(['x', 'y', 'z'].map(|c| at.value.contains(c))),
        false => Err(at.fault(format!("expected letters out of \"xyz\", got \"{}\"", at.value))),
    }
}

/// Node positions in the world after the start deformations, when there are any.
fn start(soft: &Soft, mesh: &Mesh, pose_WM: &Pose) -> Result<Option<Vec<Vec3>>, Fault> {
    if soft.deform.is_empty() {
        return Ok(None);
    }
    let mut nodes = mesh.nodes.clone();
    for at in &soft.deform {
        let rows = at.value.matrix.map(|row| row.transpose());
        let matrix = Mat3::from_rows(&rows);
        for n in mesh.select_nodes(at.value.nodes.as_ref())? {
            let node = &mut nodes[n as usize];
            *node = matrix * *node + at.value.offset;
        }
    }
    Ok(Some(nodes.iter().map(|x| pose_WM.point(x)).collect()))
}

fn coupling(built: &Built, soft: &Soft, mesh: &Mesh) -> Result<Option<Coupling>, Fault> {
    let Some(first) = soft.bind.first() else { return Ok(None) };
    let volumes = node_volumes(mesh);
    let anchor = bones(built, first)?.0[0];
    let loose = Binding { bones: [anchor; 2], weights: [1.0, 0.0] };
    let mut bindings = vec![loose; mesh.nodes.len()];
    let mut stiffness = vec![0.0; mesh.nodes.len()];
    for bind in &soft.bind {
        let (bones, weights) = bones(built, bind)?;
        if bind.stiffness.is_some() && bind.node_stiffness.is_some() {
            return Err(bind.bones.fault("give `stiffness` or `node_stiffness`, not both"));
        }
        for n in mesh.select_nodes(Some(&bind.nodes))? {
            let per_volume = bind.stiffness.unwrap_or(1e9) * volumes[n as usize];
            bindings[n as usize] = Binding { bones, weights };
            stiffness[n as usize] = bind.node_stiffness.unwrap_or(per_volume);
        }
    }
    Ok(Some(Coupling {
        bindings,
        springs: Springs::PerNode(stiffness),
        damping_time: soft.bind_damping_time,
        skinning: skinning(soft.skinning),
    }))
}

/// Returns the rule by which two bones place a node.
pub fn skinning(word: SkinningWord) -> Skinning {
    match word {
        SkinningWord::Lbs => Skinning::Linear,
        SkinningWord::Joint => Skinning::Joint,
    }
}

fn bones(built: &Built, bind: &Bind) -> Result<([u32; 2], [f64; 2]), Fault> {
    let names = &bind.bones;
    let find = |name: &String| {
        built.names.rigid(&Located {
            value: name.clone(),
            place: names.place.clone(),
            key: names.key.clone(),
        })
    };
    match (names.value.as_slice(), bind.weights.value.as_slice()) {
        ([bone], [] | [1.0]) => Ok(([find(bone)?; 2], [1.0, 0.0])),
        ([a, b], []) => Ok(([find(a)?, find(b)?], [0.5, 0.5])),
        ([a, b], [u, v]) if (u + v - 1.0).abs() < 1e-9 => Ok(([find(a)?, find(b)?], [*u, 1.0 - u])),
        ([_] | [_, _], weights) => Err(bind
            .weights
            .fault(format!("expected a weight for each bone, of sum 1, got {weights:?}"))),
        (other, _) => Err(names.fault(format!("expected one or two bones, got {}", other.len()))),
    }
}

/// A quarter of the volume of every element around a node.
fn node_volumes(mesh: &Mesh) -> Vec<f64> {
    let mut volumes = vec![0.0; mesh.nodes.len()];
    for tet in &mesh.tets {
        let [a, b, c, d] = tet.map(|n| mesh.nodes[n as usize]);
        let volume = (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
        tet.iter().for_each(|n| volumes[*n as usize] += volume / 4.0);
    }
    volumes
}
