//! A list of what names tell of a rig, for whoever writes a name map.

use super::found::{sides_said, told};
use crate::RigError;
use crate::glb::read_skinned_glb_of;
use crate::hand::names::{self, NameMap};
use thenar_core::model::{Digit, Side};

/// A tracked joint, and the joint of a file that it was found to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedJoint {
    /// WebXR's name.
    pub name: String,
    /// Name in the file.
    pub own: Option<String>,
    /// True if no hand is built without it.
    pub needed: bool,
    /// Joints that may be a needed one that was not found: those that say that they are of its
    /// digit.
    pub like: Vec<String>,
}

/// The joints of a file as those of a hand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RigListing {
    /// Side that was looked for, else the one that names say.
    pub side: Option<Side>,
    /// True if names say both sides; without a side asked for, the right hand is listed.
    pub both_sides: bool,
    /// The 25 tracked joints.
    pub joints: Vec<ListedJoint>,
    /// Joints of the file that are none of them.
    pub others: Vec<String>,
}

/// Lists the joints of a skinned mesh (GLB) as those of a hand, whether they make one or not.
///
/// # Errors
/// When the file is damaged or holds no skinned mesh, the map names what is not there, or names
/// contradict the side.
pub fn rig_listing(
    bytes: &[u8],
    map: &NameMap,
    meshes: &[String],
    side: Option<Side>,
) -> Result<RigListing, RigError> {
    let rig = read_skinned_glb_of(bytes, meshes)?;
    let both_sides = sides_said(&rig.joints) == [true, true];
    let found = told(&rig.joints, map, side.or(both_sides.then_some(Side::Right)))?;
    let mut of_joint: Vec<(String, bool, usize, Option<usize>)> =
        vec![(names::WRIST.to_owned(), true, 0, found.wrist.as_ref().ok().copied())];
    for (d, digit) in Digit::FINGERS.into_iter().enumerate() {
        let chain = found.digits[d].as_ref().ok();
        let all = names::suffixes(digit);
        let before = all.len() - 4;
        for (k, suffix) in all.iter().enumerate() {
            let name = format!("{}-{suffix}", names::prefix(digit));
            let own = match k.checked_sub(before) {
                None => chain.and_then(|chain| chain.metacarpal),
                Some(3) => chain.and_then(|chain| chain.tip),
                Some(moving) => chain.map(|chain| chain.moving[moving]),
            };
            let needed = k >= before && k < before + 3;
            let own = own.or_else(|| by_map(&rig.joints, map, &name));
            of_joint.push((name, needed, d + 1, own));
        }
    }
    let name = |k: usize| rig.joints[k].name.clone();
    let used: Vec<usize> = of_joint.iter().filter_map(|joint| joint.3).collect();
    let listed = of_joint.into_iter().map(|(webxr, needed, digit, own)| ListedJoint {
        name: webxr,
        own: own.map(name),
        needed,
        like: match (needed, own, digit.checked_sub(1)) {
            (true, None, Some(d)) => found.of_digit[d].iter().map(|&k| name(k)).collect(),
            _ => Vec::new(),
        },
    });
    Ok(RigListing {
        side: found.side,
        both_sides,
        joints: listed.collect(),
        others: (0..rig.joints.len()).filter(|k| !used.contains(k)).map(name).collect(),
    })
}

/// The joint of a digit that is not whole, by the map or by WebXR's own name.
fn by_map(joints: &[crate::glb::RigJoint], map: &NameMap, webxr: &str) -> Option<usize> {
    let own = map.get(webxr).map_or(webxr, String::as_str);
    joints.iter().position(|joint| joint.name == own)
}
