//! The solids of bones: what of a bone touches other bodies when flesh is crushed.
//!
//! The solid of a moving bone is the capsule whose mass and inertia it has; that of the palm is a
//! box around its metacarpals. Neither is thicker than the flesh over it anywhere: a capsule's
//! radius is at most half the least distance from its axis to the skin, and the box is made smaller
//! until the skin is nowhere nearer than half its thickness. The last bone of a digit is flat and
//! lies under its nail, with the pad on its other side: two capsules side by side have the section
//! of its one, and where a rig has it in the middle of the fingertip, they are moved towards the
//! back; its mass stays where the rig has it.

use super::digits::DigitRig;
use crate::RigError;
use crate::mesh::Bvh;
use crate::object::length_in_words;
use crate::size::place_in_words;
use crate::work::Stage;
use std::sync::Arc;
use thenar_core::model::{Bone, BoneSolid};
use thenar_core::shape::{PlacedShape, Shape};
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

/// Places along a capsule's axis, and along each edge of a box, where the flesh is measured: at
/// most 3 mm apart on a hand of 190 mm.
const SAMPLES: usize = 16;
/// The box shrinks by this in each attempt.
const SHRINK: f64 = 0.97;

/// Nail and nail bed over the last bone of a digit, of the length of a hand: 2.5 mm of 190. Nail
/// plates are 0.40 to 0.48 mm thick in the mean (Wollina et al. 2001); for the bed 2 mm are
/// assumed.
const NAIL_SIDE: f64 = 2.5 / 190.0;

/// Width of the last bone of a digit over its thickness, shaft and tuft together. Recalled of
/// people's: the shaft is 5 to 6 mm wide and 4 mm thick, the tuft 7 to 9 mm wide and 3.5 mm thick.
const LAST_WIDTH: f64 = 1.7;

/// A solid and the flesh over it.
pub(super) struct Covered {
    pub solid: BoneSolid,
    /// Twice the radius of a capsule, the least edge of a box \[m\].
    pub thickness: f64,
    /// Least distance from its surface to the skin \[m\].
    pub flesh: f64,
    /// Mean thickness of the flesh between its surface and the skin of the back and of the palm's
    /// side, along the y axis of the bone's frame \[m\].
    pub sides: [f64; 2],
}

/// The solids of all bones, in their order: the palm, then three per digit. `length` is that of the
/// hand \[m\].
///
/// # Errors
/// The surface is such a thicket that to measure in it would take too long.
pub(super) fn solids(
    bones: &[Bone],
    digits: &[DigitRig],
    surface: &Bvh,
    length: f64,
) -> Result<Vec<Covered>, RigError> {
    let mut skin = Skin::new(bones, surface)?;
    let (palms, moving) = bones.split_at(1.min(bones.len()));
    let palms = palms.iter().map(|bone| palm(bone, digits, &mut skin));
    let palms = palms.collect::<Result<Vec<_>, _>>()?;
    let is_last = |b: usize| bones.iter().all(|bone| bone.parent != Some(b as u32));
    let moving = moving.iter().enumerate().map(|(k, bone)| match is_last(k + 1) {
        true => flat(bone, NAIL_SIDE * length, &mut skin),
        false => capsule(bone, &mut skin),
    });
    palms.into_iter().map(Ok).chain(moving).collect()
}

/// Places on the surface of a box.
const BOX_PLACES: usize = 6 * SAMPLES * SAMPLES;
/// Most times that a box is made smaller: a hundred attempts leave a twentieth, which lies within
/// any palm that has flesh at all.
const ATTEMPTS: usize = 100;

/// Surface below which flesh is measured, and the work that this may cost.
struct Skin<'a> {
    surface: &'a Bvh,
    stage: Stage,
    asked: usize,
}

impl<'a> Skin<'a> {
    /// Asks for as much as a box that fits at once and all capsules take; what more is needed is
    /// asked for as it comes.
    fn new(bones: &[Bone], surface: &'a Bvh) -> Result<Self, RigError> {
        let ends = || bones.iter().flat_map(|bone| bone.ends_B.map(|end| bone.pose_MB.point(&end)));
        let places = 2 * BOX_PLACES + ATTEMPTS + 2 * SAMPLES * bones.len();
        let each = ends().map(|p| surface.signed_distance_cost(&p)).sum::<f64>()
            / ends().count().max(1) as f64;
        let stage = Stage::new(
            "measuring the flesh over the bones",
            places,
            each * places as f64,
            "its triangles lie in each other's way; simplify the mesh",
        )?;
        Ok(Self { surface, stage, asked: 0 })
    }

    fn ask(&mut self) -> Result<(), RigError> {
        self.asked += 1;
        self.stage.at_most(self.asked)
    }

    /// Depth of a place below the skin \[m\], negative outside.
    fn depth(&mut self, p: &Vec3) -> Result<f64, RigError> {
        self.ask()?;
        Ok(-self.surface.signed_distance(p))
    }

    /// Distance to the skin from a place below it in a direction \[m\].
    fn way(&mut self, p: &Vec3, direction: &Vec3) -> Result<f64, RigError> {
        let mut way = 0.0;
        for _ in 0..RAY_STEPS {
            let depth = self.depth(&(p + direction * way))?;
            if depth <= RAY_TOLERANCE * way {
                break;
            }
            way += depth;
        }
        Ok(way)
    }

    /// True when a place is less far below the skin than `depth` \[m\].
    fn is_shallower(&mut self, p: &Vec3, depth: f64) -> Result<bool, RigError> {
        self.ask()?;
        let distance = self.surface.closest(p).distance;
        // Too near the skin, whichever side it is on.
        Ok(distance < depth || -distance < depth && !self.surface.contains(p))
    }
}

/// A step along a ray that is this part of the way to the skin ends it.
const RAY_TOLERANCE: f64 = 1e-3;
/// Steps along a ray at most; each goes as far as the skin is away, so that a dozen are usual.
const RAY_STEPS: usize = 64;

/// Mean distance from places in a bone to the skin, out of the back of the hand and out of its
/// palm, less what the bone itself takes of the way.
fn sides(
    bone: &Bone,
    places: &[Vec3],
    half_thickness: f64,
    skin: &mut Skin,
) -> Result<[f64; 2], RigError> {
    let back = bone.pose_MB.vector(&Vec3::y());
    let mut sums = [0.0; 2];
    for place in places {
        for (sum, direction) in sums.iter_mut().zip([back, -back]) {
            *sum += skin.way(place, &direction)?;
        }
    }
    Ok(sums.map(|sum| sum / places.len() as f64 - half_thickness))
}

/// Errs unless a bone can be as thick as this \[m\] inside the skin, over whose axis there is at
/// least so much of it \[m\].
fn covered_by_skin(bone: &Bone, radius: f64, least: f64) -> Result<(), RigError> {
    if radius > 0.0 && radius.is_finite() {
        return Ok(());
    }
    let [from, to] = bone.ends_B.map(|end| place_in_words(&bone.pose_MB.point(&end)));
    Err(RigError::invalid(format!(
        "bone {} lies outside the hand's skin, from {from} to {to} m, by {}: joints and mesh do not fit. Is it the mesh of \
         one hand, cut off at the wrist (`--mesh` names another; a whole figure is built by `--figure`), and are these \
         its joints (`thenar hand --list FILE` shows them, `--joint-names` names others)?",
        quoted(&bone.name),
        length_in_words((-least).max(0.0))
    )))
}

/// The capsule between a bone's ends.
fn capsule(bone: &Bone, skin: &mut Skin) -> Result<Covered, RigError> {
    let axis = Axis::of(bone);
    let places = axis.places(bone, &Vec3::zeros());
    let least = least_depth(&places, skin)?;
    let radius = bone.radius.min(0.5 * least);
    covered_by_skin(bone, radius, least)?;
    let shape = Shape::Capsule { radius, half_length: axis.half_length };
    covered(bone, BoneSolid { shape, pose_BS: axis.pose_BS }, &places, radius, skin)
}

/// The two capsules of a last bone, side by side, under `nail` \[m\] of flesh on the back, if there
/// is more.
fn flat(bone: &Bone, nail: f64, skin: &mut Skin) -> Result<Covered, RigError> {
    let axis = Axis::of(bone);
    let radius = bone.radius / flat_section().sqrt();
    let aside = Vec3::x() * (radius * (LAST_WIDTH - 1.0));
    let mut places = axis.places(bone, &aside);
    places.extend(axis.places(bone, &-aside));
    let least = least_depth(&places, skin)?;
    let radius = radius.min(0.5 * least);
    covered_by_skin(bone, radius, least)?;
    let raised = rise(bone, &places, radius + nail.max(radius), skin)?;
    let raised_M = bone.pose_MB.vector(&Vec3::y()) * raised;
    places.iter_mut().for_each(|place| *place += raised_M);
    let part = |aside: Vec3| PlacedShape {
        shape: Shape::Capsule { radius, half_length: axis.half_length },
        pose_SP: Pose::new(aside, Quat::identity()),
    };
    let shape = Shape::Compound(Arc::new(vec![part(aside), part(-aside)]));
    let pose_BS = Pose::new(Vec3::y() * raised, Quat::identity()) * axis.pose_BS;
    covered(bone, BoneSolid { shape, pose_BS }, &places, radius, skin)
}

/// Section of two circles of radius 1 that are together [`LAST_WIDTH`] as wide as thick, over that
/// of one of them.
fn flat_section() -> f64 {
    let half_way = LAST_WIDTH - 1.0;
    let lens = 2.0 * (half_way.acos() - half_way * (1.0 - half_way * half_way).sqrt());
    2.0 - lens / std::f64::consts::PI
}

fn covered(
    bone: &Bone,
    solid: BoneSolid,
    places: &[Vec3],
    radius: f64,
    skin: &mut Skin,
) -> Result<Covered, RigError> {
    Ok(Covered {
        solid,
        thickness: 2.0 * radius,
        flesh: least_depth(places, skin)? - radius,
        sides: sides(bone, places, radius, skin)?,
    })
}

/// The middle line of a bone's solid: y in its frame S, x across the digit.
struct Axis {
    pose_BS: Pose,
    half_length: f64,
}

impl Axis {
    fn of(bone: &Bone) -> Self {
        let [a, b] = bone.ends_B;
        let length = (b - a).norm();
        // The caps lie within the joints, as those of its mass do.
        let inset = bone.radius.min(0.4 * length);
        let turn = Quat::rotation_between(&Vec3::y(), &(b - a)).unwrap_or_else(Quat::identity);
        Self { pose_BS: Pose::new((a + b) / 2.0, turn), half_length: 0.5 * length - inset }
    }

    /// Places along the line, in the model frame M, moved aside by so much in S.
    fn places(&self, bone: &Bone, aside_S: &Vec3) -> Vec<Vec3> {
        let pose_MS = bone.pose_MB * self.pose_BS;
        let along = |k: usize| Vec3::y() * (self.half_length * (2.0 * fraction(k) - 1.0));
        (0..SAMPLES).map(|k| pose_MS.point(&(aside_S + along(k)))).collect()
    }
}

/// Least depth of some places \[m\].
fn least_depth(places: &[Vec3], skin: &mut Skin) -> Result<f64, RigError> {
    places.iter().try_fold(f64::INFINITY, |least, place| Ok(least.min(skin.depth(place)?)))
}

/// Distance by which the axis of a bone can be moved out of the back of the hand \[m\] so that none
/// of it is nearer than `left` to the skin, in any direction; 0 where none will do.
fn rise(bone: &Bone, axis: &[Vec3], left: f64, skin: &mut Skin) -> Result<f64, RigError> {
    let back = bone.pose_MB.vector(&Vec3::y());
    let mut raised = f64::INFINITY;
    for place in axis {
        raised = raised.min(skin.way(place, &back)? - left);
    }
    // A fingertip is narrower towards its back. Depth changes by no more than the way, so that none
    // of what is passed over on the way down is deep enough, but for the tolerance that ends the
    // walk.
    for _ in 0..RAY_STEPS {
        if raised <= 0.0 {
            break;
        }
        let moved: Vec<Vec3> = axis.iter().map(|place| place + back * raised).collect();
        let short = left - least_depth(&moved, skin)?;
        if short <= 0.0 {
            return Ok(raised);
        }
        raised -= short + RAY_TOLERANCE * left;
    }
    Ok(0.0)
}

/// The box around the four metacarpals, in the plane that runs between them.
fn palm(bone: &Bone, digits: &[DigitRig], skin: &mut Skin) -> Result<Covered, RigError> {
    covered_by_skin(bone, bone.radius, bone.radius)?;
    let rays: Vec<[Vec3; 2]> =
        digits[1..].iter().map(|rig| [rig.base, rig.joints[0].position]).collect();
    let center = rays.iter().map(|[a, b]| (a + b) / 2.0).sum::<Vec3>() / rays.len() as f64;
    let along = rays.iter().map(|[a, b]| b - a).sum::<Vec3>();
    let middle = |ray: &[Vec3; 2]| (ray[0] + ray[1]) / 2.0;
    let across = middle(&rays[rays.len() - 1]) - middle(&rays[0]);
    let turn = Quat::face_towards(&along, &along.cross(&across));
    let pose_MS = Pose::new(center, turn);
    let extent = |axis: &Vec3| {
        let reach = rays.iter().flatten().map(|p| pose_MS.inverse_point(p).dot(axis).abs());
        reach.fold(0.0, f64::max)
    };
    let whole = Vec3::new(extent(&Vec3::x()), bone.radius, extent(&Vec3::z()));
    let sizes = std::iter::successors(Some(whole), |half| Some(half * SHRINK));
    let mut found = None;
    for half in sizes.take(ATTEMPTS) {
        if !is_bare(&half, &pose_MS, skin)? {
            found = Some(half);
            break;
        }
    }
    let half = found.unwrap_or(whole * 0.05);
    let mut flesh = f64::INFINITY;
    for p in box_places(&half) {
        flesh = flesh.min(skin.depth(&pose_MS.point(&p))?);
    }
    let middle: Vec<Vec3> = (0..SAMPLES * SAMPLES)
        .map(|k| [k % SAMPLES, k / SAMPLES].map(|k| 2.0 * fraction(k) - 1.0))
        .map(|[s, t]| pose_MS.point(&Vec3::new(s * half.x, 0.0, t * half.z)))
        .collect();
    Ok(Covered {
        solid: BoneSolid {
            shape: Shape::Cuboid { half },
            pose_BS: bone.pose_MB.inverse() * pose_MS,
        },
        thickness: 2.0 * half.min(),
        flesh,
        sides: sides(bone, &middle, half.y, skin)?,
    })
}

/// True when the skin is nearer to a box than half its thickness, somewhere.
fn is_bare(half: &Vec3, pose_MS: &Pose, skin: &mut Skin) -> Result<bool, RigError> {
    for p in box_places(half) {
        if skin.is_shallower(&pose_MS.point(&p), half.y)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Places on the surface of a box.
fn box_places(half: &Vec3) -> impl Iterator<Item = Vec3> + '_ {
    let grid = (0..SAMPLES).flat_map(|i| (0..SAMPLES).map(move |j| (i, j)));
    grid.flat_map(move |(i, j)| {
        let [s, t] = [i, j].map(|k| 2.0 * fraction(k) - 1.0);
        [-1.0, 1.0].into_iter().flat_map(move |side| {
            [Vec3::new(side, s, t), Vec3::new(s, side, t), Vec3::new(s, t, side)]
        })
    })
    .map(|p| half.component_mul(&p))
}

fn fraction(k: usize) -> f64 {
    k as f64 / (SAMPLES - 1) as f64
}
