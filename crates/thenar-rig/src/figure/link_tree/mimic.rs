//! Joints that follow others, once links have become bones.

use super::super::mimic::{MIMIC_TERMS, Mimic, has_axis, polynomial, tangled};
use super::merge::Bone;
use crate::RigError;
use std::collections::BTreeMap;
use thenar_input::quoted;

/// A joint that follows another, as a file says it: by the joints' names and for the file's angles.
#[derive(Clone, Debug)]
pub(in super::super) struct Follows {
    /// Joint that follows.
    pub follower: String,
    /// Joint that leads.
    pub leader: String,
    /// Coefficients of the powers of the leader's angle \[rad\].
    pub law: [f64; MIMIC_TERMS],
}

/// A hinge of the file among the joints of the figure.
struct Hinge {
    joint: u32,
    axis: u8,
    /// Angle of the rest pose in the file \[rad\].
    rest: f64,
}

/// The mimics between joints of the figure; tells of those that are lost.
///
/// # Errors
/// A joint follows itself, through others or not, or two others.
pub(super) fn resolve(
    follows: &[Follows],
    bones: &[Bone],
    notes: &mut Vec<String>,
) -> Result<Vec<Mimic>, RigError> {
    let hinges = hinges(bones);
    let mut mimics = Vec::new();
    for Follows { follower, leader, law } in follows {
        let (Some(own), Some(other)) = (hinges.get(&follower[..]), hinges.get(&leader[..])) else {
            notes.push(format!(
                "joint {} does not follow {}: both must be hinges that move, alone or in a universal joint",
                quoted(follower),
                quoted(leader)
            ));
            continue;
        };
        let mut law = shifted(law, other.rest);
        law[0] -= own.rest;
        let (joint, axis) = (own.joint, own.axis);
        mimics.push(Mimic { joint, axis, leader: other.joint, leader_axis: other.axis, law });
    }
    if let Some(mimic) = tangled(&mimics) {
        let name = |joint: u32| {
            let bone = &bones[joint as usize + 1];
            bone.joint.as_ref().map_or("", |joint| &joint.name)
        };
        return Err(RigError::invalid(format!(
            "joint {} follows itself through others, or follows two joints, one of them {}",
            quoted(name(mimic.joint)),
            quoted(name(mimic.leader))
        )));
    }
    Ok(mimics)
}

fn hinges(bones: &[Bone]) -> BTreeMap<&str, Hinge> {
    let mut hinges = BTreeMap::new();
    // Joint i carries bone i + 1.
    for (joint, bone) in (0..).zip(bones.iter().skip(1)) {
        let Some(kind) = bone.joint.as_ref().map(|joint| joint.kind) else { continue };
        for (axis, (name, rest)) in (0..).zip(&bone.hinges) {
            if has_axis(kind, axis) {
                hinges.insert(&name[..], Hinge { joint, axis, rest: *rest });
            }
        }
    }
    hinges
}

/// The coefficients of `P(x + by)`, by Taylor's formula.
fn shifted(law: &[f64; MIMIC_TERMS], by: f64) -> [f64; MIMIC_TERMS] {
    let mut derivative = *law;
    let mut factorial = 1.0;
    std::array::from_fn(|i| {
        if i > 0 {
            factorial *= i as f64;
            derivative = std::array::from_fn(|k| {
                derivative.get(k + 1).map_or(0.0, |next| (k + 1) as f64 * next)
            });
        }
        polynomial(&derivative, by).0 / factorial
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_is_shifted_along_its_curve() {
        let law = [0.3, -1.2, 0.7, 2.0, -0.4];
        let moved = shifted(&law, 0.6);
        for x in [-1.0, 0.0, 0.25, 1.5] {
            let expected = polynomial(&law, x + 0.6).0;
            assert!((polynomial(&moved, x).0 - expected).abs() < 1e-12, "{x}");
        }
    }
}
