//! From a plan to bones in flesh.

use super::bind::{Bound, bind};
use super::in_solid::bone_nodes;
use super::mimic::Mimic;
use super::options::FigureOptions;
use super::plan::{Plan, PlanBone};
use super::report::FigureReport;
use super::skin::skin;
use super::skin_bones::give_solids;
use super::{joints, solid};
use crate::hand::bones::{BONE_DENSITY, nearest};
use crate::lattice::{Lattice, LatticeOptions};
use crate::mesh::{Bvh, decimate, subdivide_to};
use crate::size::sensible_size;
use crate::work::phase;
use crate::{RigError, model_file};
use thenar_core::model::{
    Bone, BoneSolid, CouplingKind, Digit, Flesh, HandModel, JointDesc, JointKind, Material,
};
use thenar_core::{Mat3, Pose, Quat, Vec3};
use thenar_input::quoted;

/// More bones are refused: each node is held against each bone.
const BONES_MAX: usize = 1000;
/// Least part of a figure's mass that is flesh, where its bones alone weigh more.
const FLESH_MIN: f64 = 0.2;

/// Builds a figure: bones and joints of the plan in flesh, as a model without a side.
///
/// # Errors
/// When the plan has no closed skin, bones have no extent, or an option is out of range.
pub fn build_figure(
    mut plan: Plan,
    options: &FigureOptions,
) -> Result<(HandModel, FigureReport), RigError> {
    options.check()?;
    phase("reading the figure")?;
    if plan.bones.len() > BONES_MAX {
        return Err(RigError::invalid(format!(
            "the figure has {} bones; {BONES_MAX} are allowed",
            plan.bones.len()
        )));
    }
    plan.scale(options.scale);
    joints::change_plan(&mut plan, &options.joints)?;
    let thickness = options.thickness;
    let skin = skin(&plan, thickness)?;
    sensible_size(skin.mesh.bounds())?;
    let surface = Bvh::new(&skin.mesh);
    let ends = ends(&plan);
    give_solids(&mut plan, &ends, &surface)?;

    let wanted = options.render_triangles;
    let fine = match skin.mesh.triangles.len() < wanted && plan.skin.is_some() {
        true => subdivide_to(&skin.mesh, wanted)?.mesh,
        false => decimate(&skin.mesh, wanted)?,
    };
    let rotation = Quat::identity();
    let lattice = Lattice::new(&fine, &LatticeOptions { tets: options.tets, rotation })?;
    phase("binding the flesh to the bones")?;
    let bones = bones(&plan, &ends)?;
    let solids = contact_solids(&plan, &bones)?;
    let Bound { bindings, lost } = bind(&plan, &lattice.nodes, thickness.unwrap_or_default());
    phase("weighing the flesh")?;
    let collision = decimate(&fine, options.collision_triangles)?;
    let material = material(&lattice, &bones, options);
    let [low, high] = skin.mesh.bounds();
    let near = |p: &Vec3| nearest(&bones, p);
    let [touching, drawn] =
        [lattice.embed_near(&collision, near)?, lattice.embed_near(&fine, near)?];
    let figure = HandModel {
        name: options.name.clone(),
        side: None,
        joints: joint_descs(&plan, &bones),
        flesh: Flesh {
            materials: lattice.materials(|_| material),
            nodes: lattice.nodes.clone(),
            tets: lattice.tets.clone(),
            relaxation: Vec::new(),
            mass_damping: options.mass_damping,
            stiffness_damping: options.stiffness_damping,
            fixed: Vec::new(),
            collision: touching,
            friction: options.friction,
        },
        bindings,
        node_volumes: lattice.node_volumes(),
        render: drawn,
        collision_digits: vec![Digit::Palm; collision.positions.len()],
        length: (high - low).norm(),
        bone_nodes: bone_nodes(&lattice, &plan, &bones)?,
        bones,
        solids,
        coupling: CouplingKind::Bone,
        regions: Vec::new(),
        nail_nodes: Vec::new(),
        bending: Vec::new(),
    };
    model_file::check_hand(&figure)?;
    let mimics = kept_mimics(&mut plan, &figure);
    let report = FigureReport { mimics, ..FigureReport::new(&plan, &figure, &skin, lost) };
    Ok((figure, report))
}

/// The mimics whose axes are left by changes to joints; tells of the others.
fn kept_mimics(plan: &mut Plan, figure: &HandModel) -> Vec<Mimic> {
    let (kept, lost): (Vec<Mimic>, Vec<Mimic>) =
        plan.mimics.iter().partition(|mimic| mimic.fits(figure));
    let name = |joint: u32| quoted(&figure.joints[joint as usize].name);
    plan.notes.extend(lost.iter().map(|mimic| {
        let [follower, leader] = [mimic.joint, mimic.leader].map(name);
        format!("joint {follower} does not follow {leader}: their kinds were changed")
    }));
    kept
}

/// Springs between flesh and bones, per volume of bone \[N/m⁴\], when a scene gives none.
///
/// Bones may yield a twentieth of what flesh around them does. A rod of radius r in a tube of
/// flesh, without slip at either and R = 2.5 r wide, is moved across it with 65 μ a unit of length
/// at most (rubber bush, Adkins and Gent 1954: 4πμ over ln(R/r) - (R² - r²)/(R² + r²)), 22 E where
/// volume is kept. From `κ π r² ≥ 20 · 22 E` for the slimmest bone follows `κ ≥ 140 E/r²`.
pub fn usual_coupling_stiffness(figure: &HandModel) -> f64 {
    let young = figure.flesh.materials.iter().map(|m| m.young).fold(0.0, f64::max);
    let slim = figure.bones.iter().map(|bone| bone.radius).filter(|r| *r > 0.0);
    let radius = slim.fold(figure.length, f64::min);
    140.0 * young / (radius * radius)
}

impl Plan {
    /// Multiplies all lengths; masses with their cube, so that densities stay.
    fn scale(&mut self, by: f64) {
        if by == 1.0 {
            return;
        }
        for bone in &mut self.bones {
            bone.pose_ML.position *= by;
            bone.joint.iter_mut().for_each(|joint| joint.pose_MJ.position *= by);
            if let Some(mass) = &mut bone.mass {
                mass.mass *= by.powi(3);
                mass.centre_M *= by;
                mass.inertia_M.iter_mut().for_each(|inertia| *inertia *= by.powi(5));
            }
            for solid in &mut bone.solids {
                solid.pose_MS.position *= by;
                solid::scale(&mut solid.shape, by);
            }
        }
        self.skin.iter_mut().flat_map(|s| &mut s.mesh.positions).for_each(|p| *p *= by);
    }
}

/// Ends of each bone in M: from its joint to the middle of its children's, or past the middle of
/// what it carries.
fn ends(plan: &Plan) -> Vec<[Vec3; 2]> {
    let begins: Vec<Vec3> = plan.bones.iter().map(begin).collect();
    let of = |b: usize| {
        let children = || {
            let joined = plan.bones.iter().filter(|bone| bone.parent == Some(b as u32));
            joined.filter_map(|bone| bone.joint.as_ref()).map(|joint| joint.pose_MJ.position)
        };
        let count = children().count();
        let end = match count {
            0 => past(&begins[b], &carried(plan, b)),
            _ => children().sum::<Vec3>() / count as f64,
        };
        [begins[b], end]
    };
    (0..plan.bones.len()).map(of).collect()
}

pub(super) fn begin(bone: &PlanBone) -> Vec3 {
    bone.joint.as_ref().map_or(bone.pose_ML.position, |joint| joint.pose_MJ.position)
}

/// The point as far behind the middle as half the way from the beginning to it.
fn past(begin: &Vec3, middle: &Option<Vec3>) -> Vec3 {
    middle.map_or(*begin, |middle| middle + (middle - begin) * 0.5)
}

/// Middle of what a bone carries: its solids, or its part of the skin.
fn carried(plan: &Plan, b: usize) -> Option<Vec3> {
    let solids = &plan.bones[b].solids;
    if !solids.is_empty() {
        let sum: Vec3 = solids.iter().map(|s| s.pose_MS.position).sum();
        return Some(sum / solids.len() as f64);
    }
    let skin = plan.skin.as_ref()?;
    let (mut sum, mut weight) = (Vec3::zeros(), 0.0);
    for (p, four) in skin.mesh.positions.iter().zip(&skin.influences) {
        for (_, w) in four.iter().filter(|(bone, _)| *bone as usize == b) {
            (sum, weight) = (sum + p * *w, weight + w);
        }
    }
    (weight > 0.0).then(|| sum / weight)
}

fn bones(plan: &Plan, ends: &[[Vec3; 2]]) -> Result<Vec<Bone>, RigError> {
    let each = plan.bones.iter().zip(ends).map(|(bone, ends)| {
        let in_bone = |e: RigError| RigError::invalid(format!("bone \"{}\": {e}", bone.name));
        let (mass, centre, inertia_M) = weighed(bone).map_err(in_bone)?;
        let pose_MB = Pose::new(centre, bone.pose_ML.rotation);
        let turn = pose_MB.rotation.inverse().to_rotation_matrix();
        let inertia = turn * inertia_M * turn.transpose();
        let radii = bone.solids.iter().map(|s| super::in_solid::radius(&s.shape));
        Ok(Bone {
            name: bone.name.clone(),
            parent: bone.parent,
            pose_MB,
            mass,
            inertia: (inertia + inertia.transpose()) / 2.0,
            digit: Digit::Palm,
            ends_B: ends.map(|p| pose_MB.inverse_point(&p)),
            radius: radii.fold(0.0, f64::max),
            tracked_joint: None,
            pose_BT: pose_MB.inverse() * Pose::new(begin(bone), bone.pose_ML.rotation),
        })
    });
    each.collect()
}

/// Mass, centre and inertia of a bone: as the file says, else as its solids are of bone.
fn weighed(bone: &PlanBone) -> Result<(f64, Vec3, Mat3), RigError> {
    let solid = || solid::mass(&bone.solids, BONE_DENSITY);
    match &bone.mass {
        None => solid(),
        Some(given) => match given.inertia_M {
            Some(inertia) => Ok((given.mass, given.centre_M, inertia)),
            None => {
                let (mass, _, inertia) = solid()?;
                Ok((given.mass, given.centre_M, inertia * (given.mass / mass)))
            }
        },
    }
}

fn contact_solids(plan: &Plan, bones: &[Bone]) -> Result<Vec<BoneSolid>, RigError> {
    let each = plan.bones.iter().zip(bones).map(|(bone, built)| {
        let (shape, pose_MS) = solid::joined(&bone.solids)
            .ok_or_else(|| RigError::invalid(format!("bone \"{}\" has no solid", bone.name)))?;
        Ok(BoneSolid { shape, pose_BS: built.pose_MB.inverse() * pose_MS })
    });
    each.collect()
}

/// Joints with the frames of bones; joint i carries bone i + 1.
fn joint_descs(plan: &Plan, bones: &[Bone]) -> Vec<JointDesc> {
    let joined = (0..)
        .zip(&plan.bones)
        .filter_map(|(child, bone)| Some((child, bone.parent?, bone.joint.as_ref()?)));
    let each = joined.map(|(child, parent, joint): (u32, u32, _)| {
        let frame = |b: u32| bones[b as usize].pose_MB.inverse() * joint.pose_MJ;
        // Springs past a limit act in the two-step scheme alone: as strong as those of the joint,
        // or of a hand's.
        let strongest = joint.axes.iter().map(|a| a.stiffness).fold(0.0, f64::max);
        JointDesc {
            name: joint.name.clone(),
            kind: joint.kind,
            parent: Some(parent),
            child,
            pose_PJ: frame(parent),
            pose_CK: frame(child),
            axes: if joint.kind == JointKind::Fixed { Default::default() } else { joint.axes },
            limit_stiffness: strongest.max(3.0),
            limit_damping: 0.01 * strongest.max(1.0),
        }
    });
    each.collect()
}

/// Flesh whose density makes the figure, bones included, as heavy as its volume should be.
fn material(lattice: &Lattice, bones: &[Bone], options: &FigureOptions) -> Material {
    let volume: f64 = lattice.filled.iter().sum();
    let whole = options.material.density * volume;
    let bone_mass: f64 = bones.iter().map(|b| b.mass).sum();
    Material { density: (whole - bone_mass).max(FLESH_MIN * whole) / volume, ..options.material }
}
