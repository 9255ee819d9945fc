//! Frames of the joints as WebXR has them (-z along the bone, +y out of the back of the hand),
//! whatever axes a rig has.
//!
//! A rig whose own axes are those keeps them. Of any other only the places of joints are used: the
//! palm lies through wrist and knuckles, the index's side is the thumb's, and the side of the hand
//! says which way its back is.

use super::found::RigJoints;
use crate::RigError;
use crate::glb::RigJoint;
use thenar_core::model::Side;
use thenar_core::{Mat3, Pose, Quat, Vec3};

/// A joint's -z may be off the line to the next joint by this (cosine of 45°).
const ALONG_MIN: f64 = 0.707;
/// Least bend towards the palm, of directions' parts along its normal, from which a side is
/// inferred.
const BEND_MIN: f64 = 0.08;
/// Flexion axis of a right hand's thumb in the wrist's frame, where the thumb is too straight to
/// say: the mean of the three joints of the WebXR generic hand.
const THUMB_AXIS: Vec3 = Vec3::new(0.0, -0.878, 0.479);
/// Sines of the angles between a thumb's bones sum to at least this where their plane says about
/// what it bends.
const THUMB_BEND_MIN: f64 = 0.26;

/// Source of the frames of a rig's joints.
#[derive(Clone, Debug)]
pub(in crate::hand) enum Frames {
    /// The rig's own.
    Own,
    /// Places alone: the wrist's frame in the rig's, and the side.
    Places(Quat, Side),
}

impl Frames {
    /// # Errors
    /// The joints do not span a palm, or do not say of which side they are.
    pub fn new(
        found: &RigJoints,
        joints: &[RigJoint],
        side: Option<Side>,
    ) -> Result<Self, RigError> {
        if has_own(found, joints) {
            return Ok(Self::Own);
        }
        let at = |k: usize| joints[k].pose.position;
        let wrist = at(found.wrist);
        let [_, index, middle, ring, _] = found.digits.map(|digit| at(digit.moving[0]));
        let flat = || {
            RigError::invalid("wrist and knuckles of the rig lie in one line: they span no palm")
        };
        let forward = (middle - wrist).try_normalize(0.0).ok_or_else(flat)?;
        // Knuckles lie on an arch with the middle one on top; the little one lies lowest.
        let across = index - ring;
        let width = across.norm();
        let thumbward = (across - forward * forward.dot(&across))
            .try_normalize(1e-3 * width)
            .filter(|t| t.iter().all(|x| x.is_finite()))
            .ok_or_else(flat)?;
        let normal = forward.cross(&thumbward);
        let side = match side.or(found.side) {
            Some(side) => side,
            None => told_by_bend(found, joints, &normal)?,
        };
        let back = if side == Side::Right { normal } else { -normal };
        let axes = Mat3::from_columns(&[back.cross(&-forward), back, -forward]);
        let rotation = Quat::from_matrix(&axes);
        if !thumb_faces_palm(found, joints, &Pose::new(wrist, rotation)) {
            let (by, help) = match found.side {
                Some(_) => ("as the names of its joints say", "is it mirrored?"),
                None => ("as asked for", "ask for the other side (`thenar build --side`)"),
            };
            return Err(RigError::invalid(format!(
                "taken for a {} hand, {by}, the rig has its thumb behind the back of the hand: {help}",
                side.name()
            )));
        }
        Ok(Self::Places(rotation, side))
    }

    /// The wrist's frame in the rig's.
    pub fn wrist(&self, own: &Pose) -> Pose {
        match self {
            Self::Own => *own,
            Self::Places(rotation, _) => Pose::new(own.position, *rotation),
        }
    }

    /// Rotations of the three moving joints of a digit in the wrist's frame M, whose places there
    /// are these, up to the tip.
    pub fn moving(&self, thumb: bool, places: &[Vec3; 4], own: [Quat; 3]) -> [Quat; 3] {
        let Self::Places(_, side) = self else { return own };
        let along: [Vec3; 3] = std::array::from_fn(|k| (places[k + 1] - places[k]).normalize());
        let thumb_x = thumb.then(|| -thumb_axis(&along, *side));
        along.map(|along| {
            let x = thumb_x.unwrap_or_else(|| Vec3::y().cross(&-along));
            let x = (x - along * along.dot(&x)).normalize();
            Quat::from_matrix(&Mat3::from_columns(&[x, (-along).cross(&x), -along]))
        })
    }
}

/// The axis about which a thumb closes: that of its own bend where it has one, if it bends to the
/// palm's side.
fn thumb_axis(along: &[Vec3; 3], side: Side) -> Vec3 {
    // An axis of rotation keeps its part along the normal of a mirror, and turns over the rest.
    let usual = match side {
        Side::Right => THUMB_AXIS,
        Side::Left => Vec3::new(THUMB_AXIS.x, -THUMB_AXIS.y, -THUMB_AXIS.z),
    };
    let bend = along[0].cross(&along[1]) + along[1].cross(&along[2]);
    let clear = bend.norm() > THUMB_BEND_MIN && bend.dot(&usual) > 0.5 * bend.norm();
    if clear { bend.normalize() } else { usual }
}

/// True if each moving joint has its -z along its bone, and the wrist towards the middle knuckle.
fn has_own(found: &RigJoints, joints: &[RigJoint]) -> bool {
    let agrees = |a: usize, b: usize| {
        let along = joints[b].pose.position - joints[a].pose.position;
        joints[a].pose.vector(&-Vec3::z()).dot(&along) >= ALONG_MIN * along.norm()
    };
    let digit = |k: usize| {
        let digit = &found.digits[k];
        let [a, b, c] = digit.moving;
        agrees(a, b) && agrees(b, c) && digit.tip.is_none_or(|tip| agrees(c, tip))
    };
    agrees(found.wrist, found.digits[2].moving[0])
        && (0..5).all(digit)
        && thumb_faces_palm(found, joints, &joints[found.wrist].pose)
}

/// True if by the wrist's frame the thumb lies on the palm's side of the knuckles, or not clearly
/// on any.
fn thumb_faces_palm(found: &RigJoints, joints: &[RigJoint], wrist: &Pose) -> bool {
    let at = |k: usize| wrist.inverse_point(&joints[k].pose.position);
    let thumb = at(found.digits[0].moving[2]);
    let knuckle = at(found.digits[1].moving[0]);
    thumb.y - knuckle.y * thumb.z / knuckle.z <= 0.3 * thumb.norm()
}

/// The side that a bend of the digits towards the palm says. The thumb says most: it stands before
/// the palm.
fn told_by_bend(found: &RigJoints, joints: &[RigJoint], normal: &Vec3) -> Result<Side, RigError> {
    let along = |a: usize, b: usize| {
        let way = joints[b].pose.position - joints[a].pose.position;
        normal.dot(&way) / way.norm()
    };
    let wrist = found.wrist;
    let curl = |k: usize| {
        let [a, b, c] = found.digits[k].moving;
        along(b, c) - along(wrist, a)
    };
    let fingers = (1..5).map(curl).sum::<f64>() / 4.0;
    let thumb = along(wrist, found.digits[0].moving[2]) - along(wrist, found.digits[1].moving[0]);
    let bend = 2.0 * thumb + fingers;
    // The normal of a right hand is its back.
    match bend {
        bend if bend < -BEND_MIN => Ok(Side::Right),
        bend if bend > BEND_MIN => Ok(Side::Left),
        _ => Err(RigError::invalid(
            "neither names nor shape of the rig say whether it is a left or a right hand: say so (`thenar build --side`)",
        )),
    }
}
