//! Report on a built hand.

use super::digits::DigitRig;
use super::fist::{Inversions, fist};
use super::in_bone;
use super::passive::JointStiffness;
use super::solids::Covered;
use crate::glb::SkinnedPart;
use crate::lattice::{Quality, tet};
use crate::mesh::{Hole, Topology};
use crate::{RigError, TriMesh};
use thenar_core::model::{Digit, HandModel};

/// Reading of a rig: units, axes, and what had to be mended.
#[derive(Clone, Debug, serde::Serialize)]
pub struct RigReading {
    /// Factor on the file's coordinates.
    pub scale: f64,
    /// The unit that the file's coordinates were taken for, where that was to be guessed and is not
    /// metres.
    pub unit: Option<&'static str>,
    /// True if the joints have WebXR's axes; else axes come from their places.
    pub own_axes: bool,
    /// WebXR's names of joints that the rig lacks and that were made.
    pub made: Vec<String>,
    /// True if the skin's triangles faced inward and were turned over.
    pub inside_out: bool,
    /// Holes of the skin that were closed, the largest first.
    pub holes: Vec<Hole>,
    /// The skinned meshes of the file, with those that are the hand marked.
    pub meshes: Vec<SkinnedPart>,
    /// Way in which several meshes became one surface; `None` where there is one, or they fit
    /// together.
    pub joined: Option<JoinedMeshes>,
}

/// One surface of what several meshes enclose together.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct JoinedMeshes {
    /// Edge of the cells of the grid that it was found on \[m\].
    pub cell: f64,
    /// Separate pieces that were left out.
    pub left_out: usize,
}

/// Figures of a built hand.
#[derive(Clone, Debug, serde::Serialize)]
pub struct HandReport {
    /// Reading of the rig.
    pub rig: RigReading,
    /// The skin as read, welded.
    pub skin: Topology,
    /// Volume inside the skin as read \[m³\].
    pub skin_volume: f64,
    /// Volume of the body, inside the smooth surface through the skin's vertices \[m³\].
    pub volume: f64,
    /// Mass of the flesh \[kg\].
    pub flesh_mass: f64,
    /// Mass of the bones \[kg\].
    pub bone_mass: f64,
    /// Wrist to middle fingertip \[m\].
    pub length: f64,
    /// Number of tetrahedra.
    pub tets: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Worst shapes.
    pub quality: Quality,
    /// Smallest barycentric weight of any surface vertex; negative: outside its element.
    pub barycentric_min: f64,
    /// Triangles that touch.
    pub collision_triangles: usize,
    /// Triangles that are drawn.
    pub render_triangles: usize,
    /// Elements inside out in a fist made by skinning.
    pub fist: Inversions,
    /// The uniform scale at which the bone lengths fit the radiographs best (weighted by their
    /// spread); lengths are compared with the mean times this.
    pub anatomy_scale: f64,
    /// Bone lengths against radiographs.
    pub bone_lengths: Vec<BoneLength>,
    /// Solids of the bones and the flesh over them.
    pub bone_covers: Vec<BoneCover>,
    /// Resistance of joints to being turned, axis by axis, where their springs are what flesh
    /// leaves. For other hands, see [`joint_stiffness`](super::joint_stiffness).
    pub joints: Vec<JointStiffness>,
}

/// Thickness of a bone's solid, and of the flesh that covers it in the rest pose.
#[derive(Clone, Debug, serde::Serialize)]
pub struct BoneCover {
    /// Name of the bone.
    pub bone: String,
    /// Diameter of a capsule, least edge of a box \[m\].
    pub thickness: f64,
    /// Least distance from the solid to the skin \[m\].
    pub flesh: f64,
    /// Mean thickness of the flesh between the solid and the skin of the back \[m\].
    pub dorsal: f64,
    /// Flesh over the bone on the palm's side \[m\].
    pub palmar: f64,
    /// Nodes that stand for this bone, alone or with another.
    pub nodes: usize,
    /// Volume of the solid \[m³\].
    pub volume: f64,
    /// Volume of bone that its nodes stand for; less than that of the solid by what lies at nodes
    /// that follow other bones \[m³\].
    pub bound: f64,
}

/// A bone's length beside that of 66 radiographed hands (Buryanov & Kotiuk 2010).
#[derive(Clone, Debug, serde::Serialize)]
pub struct BoneLength {
    /// Name of the bone.
    pub bone: String,
    /// Length here \[m\].
    pub length: f64,
    /// Mean at this hand's scale \[m\].
    pub expected: f64,
    /// (here - expected) in standard deviations at this scale.
    pub deviation_sd: f64,
}

/// Bone, mean and standard deviation \[mm\].
type ReferenceLength = (&'static str, f64, f64);

/// Mean and standard deviation \[mm\] of thumb, index and middle, from the metacarpal on.
const RADIOGRAPHS: [(Digit, &[ReferenceLength]); 3] = [
    (Digit::Thumb, &[("metacarpal", 46.2, 3.9), ("proximal", 31.6, 3.1), ("distal", 21.7, 1.6)]),
    (
        Digit::Index,
        &[
            ("metacarpal", 68.1, 6.3),
            ("proximal", 39.8, 4.9),
            ("intermediate", 22.4, 2.5),
            ("distal", 15.8, 2.3),
        ],
    ),
    (
        Digit::Middle,
        &[
            ("metacarpal", 64.6, 5.4),
            ("proximal", 44.6, 3.8),
            ("intermediate", 26.3, 3.0),
            ("distal", 17.4, 1.9),
        ],
    ),
];

impl HandReport {
    pub(super) fn new(
        hand: &HandModel,
        rig: RigReading,
        skin: &TriMesh,
        digits: &[DigitRig],
        covered: &[Covered],
        joints: Vec<JointStiffness>,
    ) -> Result<Self, RigError> {
        let flesh = &hand.flesh;
        let corners = |t: &[u32; 4]| t.map(|n| flesh.nodes[n as usize]);
        let flesh_mass = (flesh.tets.iter().zip(&flesh.materials))
            .map(|(t, m)| tet::volume(&corners(t)) * m.density)
            .sum();
        let vertices = flesh.collision.vertices.iter().chain(&hand.render.vertices);
        let (anatomy_scale, bone_lengths) = bone_lengths(digits);
        let bone_covers = covered.iter().enumerate().map(|(b, c)| cover(hand, b, c)).collect();
        Ok(Self {
            rig,
            skin: Topology::of(skin),
            skin_volume: skin.volume(),
            volume: hand.node_volumes.iter().sum(),
            flesh_mass,
            bone_mass: hand.bones.iter().map(|b| b.mass).sum(),
            length: hand.length,
            tets: flesh.tets.len(),
            nodes: flesh.nodes.len(),
            quality: Quality::of(flesh.tets.iter().map(corners)),
            barycentric_min: vertices.flat_map(|v| v.weights).fold(f64::INFINITY, f64::min),
            collision_triangles: flesh.collision.triangles.len(),
            render_triangles: hand.render.triangles.len(),
            fist: fist(hand, 1.0)?,
            anatomy_scale,
            bone_lengths,
            bone_covers,
            joints,
        })
    }
}

/// The flesh over bone `b`, and the nodes that hold it.
fn cover(hand: &HandModel, b: usize, covered: &Covered) -> BoneCover {
    let shares = hand.bone_nodes.iter().map(|node| {
        let of_bone = (0..2).filter(|&k| node.binding.bones[k] as usize == b);
        of_bone.map(|k| node.binding.weights[k] * node.volume).sum::<f64>()
    });
    let shares: Vec<f64> = shares.filter(|share| *share > 0.0).collect();
    let [dorsal, palmar] = covered.sides;
    BoneCover {
        bone: hand.bones[b].name.clone(),
        thickness: covered.thickness,
        flesh: covered.flesh,
        dorsal,
        palmar,
        nodes: shares.len(),
        volume: in_bone::volume(&covered.solid.shape),
        bound: shares.iter().sum(),
    }
}

/// Scale of best fit and all comparisons at it.
fn bone_lengths(digits: &[DigitRig]) -> (f64, Vec<BoneLength>) {
    let mut rows = Vec::new();
    for (digit, bones) in &RADIOGRAPHS {
        let Some(rig) = digits.iter().find(|rig| rig.digit == *digit) else { continue };
        let mut lengths: Vec<f64> =
            (0..3).map(|k| (rig.bone(k)[1] - rig.bone(k)[0]).norm()).collect();
        if bones.len() > 3 {
            lengths.insert(0, (rig.joints[0].position - rig.base).norm());
        }
        for ((name, mean, sd), length) in bones.iter().zip(lengths) {
            rows.push((format!("{}-{name}", digit.name()), length, mean * 1e-3, sd * 1e-3));
        }
    }
    // Least squares of (length - s mean) / sd over s.
    let sum = |f: &dyn Fn(f64, f64, f64) -> f64| rows.iter().map(|r| f(r.1, r.2, r.3)).sum::<f64>();
    let scale = sum(&|l, m, s| l * m / (s * s)) / sum(&|_, m, s| m * m / (s * s));
    let lengths = rows
        .into_iter()
        .map(|(bone, length, mean, sd)| BoneLength {
            bone,
            length,
            expected: mean * scale,
            deviation_sd: (length - mean * scale) / (sd * scale),
        })
        .collect();
    (scale, lengths)
}
