//! Taxels on hands: shipped layouts, and places that a user chooses.
//!
//! A layout is made of patches, one on the palm's side of each bone: rows from the wrist outwards,
//! columns along the bone's x axis, which points to the little finger's side of a right hand and to
//! the thumb's of a left one.

use crate::math::Vec3;
use std::f64::consts::PI;
use thenar_core::model::{Bone, Digit, HandModel};
use thenar_core::readout::{TaxelPlace, TaxelSkin};

/// Taxels on one bone, in rows and columns.
#[derive(Clone, Debug, PartialEq)]
pub struct TaxelPatch {
    /// Name of the bone.
    pub name: String,
    /// Rows, from the wrist outwards.
    pub rows: usize,
    /// Columns, along the bone's x axis.
    pub columns: usize,
    /// Places, row after row.
    pub places: Vec<TaxelPlace>,
}

/// Bones on which a layout has patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// On the last bone of each finger.
    Fingertips,
    /// On every bone.
    Hand,
}

impl Layout {
    /// Names of the layouts.
    pub const NAMES: [&'static str; 2] = ["fingertips", "hand"];

    /// The layout of this name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "fingertips" => Some(Self::Fingertips),
            "hand" => Some(Self::Hand),
            _ => None,
        }
    }
}

/// Half the angle around a finger's bone that its columns take in, from the middle of the palm's
/// side \[rad\].
const AROUND: f64 = PI / 3.0;
/// Part of the knuckles' breadth that the palm's columns take in.
const ACROSS: f64 = 0.9;

/// The patches of a layout, each of `rows` and `columns`. Bones without skin on them have none.
pub fn layout(hand: &HandModel, which: Layout, rows: usize, columns: usize) -> Vec<TaxelPatch> {
    let skin = skin(hand);
    let bones = hand.bones.iter().enumerate();
    let wanted = bones.filter(|(i, bone)| which == Layout::Hand || is_tip(hand, *i, bone.digit));
    let patch = |(_, bone): (usize, &Bone)| {
        let side = Side::of(hand, bone, &skin);
        let places = (0..rows * columns).map(|k| {
            let at = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
            side.place(at(k / columns, rows), at(k % columns, columns))
        });
        let places = places.collect::<Option<Vec<_>>>()?;
        Some(TaxelPatch { name: bone.name.clone(), rows, columns, places })
    };
    wanted.filter_map(patch).collect()
}

/// A column of taxels where a bone's skin at rest is nearest to these points of its frame B \[m\];
/// `None` when there is no such bone, or no skin on it.
pub fn on_bone(hand: &HandModel, bone: &str, points_B: &[Vec3]) -> Option<TaxelPatch> {
    let bone = hand.bones.iter().find(|known| known.name == bone)?;
    let skin = skin(hand);
    let side = Side::of(hand, bone, &skin);
    let places = points_B.iter().map(|point| side.nearest(&bone.pose_MB.point(point)));
    let places = places.collect::<Option<Vec<_>>>()?;
    Some(TaxelPatch { name: bone.name.clone(), rows: places.len(), columns: 1, places })
}

fn skin(hand: &HandModel) -> TaxelSkin<'_> {
    TaxelSkin::new(&hand.flesh, hand.collision_digits.iter().map(|digit| digit.part()).collect())
}

/// The last bone of a finger.
fn is_tip(hand: &HandModel, bone: usize, digit: Digit) -> bool {
    digit != Digit::Palm && hand.bones[bone + 1..].iter().all(|later| later.digit != digit)
}

/// The palm's side of a bone.
struct Side<'a> {
    skin: &'a TaxelSkin<'a>,
    bone: &'a Bone,
    /// Along the bone, out of the palm, and across.
    along_B: Vec3,
    palmar_B: Vec3,
    across_B: Vec3,
    /// Bounds of the palm's columns across it; `None` for a finger's bone, which they go around.
    breadth: Option<[f64; 2]>,
}

impl<'a> Side<'a> {
    fn of(hand: &HandModel, bone: &'a Bone, skin: &'a TaxelSkin<'a>) -> Self {
        let [from, to] = bone.ends_B;
        let along_B = (to - from).try_normalize(1e-9).unwrap_or(-Vec3::z());
        let palmar_B = along_B * along_B.y - Vec3::y();
        let palmar_B = palmar_B.try_normalize(1e-9).unwrap_or(-Vec3::y());
        let across_B = along_B.cross(&-palmar_B).normalize();
        let breadth = (bone.digit == Digit::Palm).then(|| breadth(hand, &across_B));
        Self { skin, bone, along_B, palmar_B, across_B, breadth }
    }

    /// The place so far along the bone and across it, both from 0 to 1.
    fn place(&self, along: f64, across: f64) -> Option<TaxelPlace> {
        let [from, to] = self.bone.ends_B;
        let on_axis = from + (to - from) * along;
        let (start, direction) = match self.breadth {
            Some([low, high]) => {
                let wanted = low + (high - low) * across;
                (on_axis + self.across_B * (wanted - on_axis.dot(&self.across_B)), self.palmar_B)
            }
            None => {
                let (sin, cos) = (AROUND * (2.0 * across - 1.0)).sin_cos();
                (on_axis, self.palmar_B * cos + self.across_B * sin)
            }
        };
        // Out through the skin; where that is of another part, the nearest place of this one's.
        let (start_M, direction_M) =
            (self.bone.pose_MB.point(&start), self.bone.pose_MB.vector(&direction));
        let way = self.skin.way(&start_M, &direction_M).unwrap_or(0.0);
        self.nearest(&(start_M + direction_M * way))
    }

    fn nearest(&self, point_M: &Vec3) -> Option<TaxelPlace> {
        let along_M = self.bone.pose_MB.vector(&self.along_B);
        self.skin.nearest(self.bone.digit.part(), point_M, &along_M)
    }
}

/// From the outermost knuckle to the outermost on the other side, in the palm's frame \[m\].
fn breadth(hand: &HandModel, across_B: &Vec3) -> [f64; 2] {
    let knuckles = hand.joints.iter().filter(|joint| joint.parent == Some(0)).filter(|joint| {
        hand.bones.get(joint.child as usize).is_some_and(|bone| bone.digit != Digit::Thumb)
    });
    let places = knuckles.map(|joint| joint.pose_PJ.position.dot(across_B));
    let ends =
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    let [low, high] = if ends[0] < ends[1] { ends } else { [-0.02, 0.02] };
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0 * ACROSS);
    [middle - half, middle + half]
}
