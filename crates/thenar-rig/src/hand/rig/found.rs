//! Which joints of a rig are the hand's: by the name map, by WebXR's names, or by what names say.

use super::words::{self, Place, Said};
use crate::RigError;
use crate::glb::RigJoint;
use crate::hand::names::{self, NameMap};
use thenar::model::{Digit, Side};

/// The joints of one digit, as indices into the rig's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::hand) struct Chain {
    /// Base of a finger's metacarpal; none of a thumb.
    pub metacarpal: Option<usize>,
    /// Proximal ends of the three moving bones.
    pub moving: [usize; 3],
    /// The tip.
    pub tip: Option<usize>,
}

/// The joints of a hand.
#[derive(Clone, Debug)]
pub(in crate::hand) struct Found {
    pub wrist: usize,
    /// Digits, thumb first.
    pub digits: [Chain; 5],
    /// The side that names say.
    pub side: Option<Side>,
}

/// The first of a finger's four numbered joints is a metacarpal when it lies within this part of the way from the
/// wrist to the last. A metacarpal begins a third of the way to the knuckle, which lies halfway to the tip.
const METACARPAL_REACH: f64 = 0.33;

/// Finds the joints of a hand.
///
/// # Errors
/// Names the joint that is missing, lists those of the rig, and says what helps.
pub(in crate::hand) fn find(
    joints: &[RigJoint],
    map: &NameMap,
    side: Option<Side>,
) -> Result<Found, RigError> {
    for name in map.values() {
        if !joints.iter().any(|j| j.name == *name) {
            let webxr = map.iter().find(|(_, own)| *own == name).map_or("", |(key, _)| key);
            return Err(lacking(
                joints,
                format!("the rig has no joint `{name}` (by the name map), needed as {webxr}"),
            ));
        }
    }
    let exact = |webxr: &str| {
        let name = map.get(webxr).map_or(webxr, String::as_str);
        joints.iter().position(|j| j.name == name)
    };
    let side = one_side(joints, side)?;
    let seen = |j: &RigJoint| {
        let other = side.is_some_and(|side| words::side(&j.name).is_some_and(|own| own != side));
        if other { Said::Nothing } else { words::said(&j.name) }
    };
    let said: Vec<Said> = joints.iter().map(seen).collect();
    let by_word = || {
        let rank = |k: &usize| match said[*k] {
            Said::Wrist(rank) => Some(rank),
            _ => None,
        };
        (0..joints.len()).filter(|k| rank(k).is_some()).min_by_key(|k| rank(k))
    };
    let wrist = exact(names::WRIST).or_else(by_word).ok_or_else(|| {
        lacking(
            joints,
            "the rig has no joint `wrist`, and none whose name says wrist, hand or palm".into(),
        )
    })?;
    let mut digits = [None; 5];
    for (k, &digit) in Digit::FINGERS.iter().enumerate() {
        let chain = match by_names(digit, exact) {
            Some(chain) => chain,
            None => by_words(digit, &said, joints, wrist)?,
        };
        digits[k] = Some(chain);
    }
    let digits =
        digits.map(|chain| chain.unwrap_or(Chain { metacarpal: None, moving: [0; 3], tip: None }));
    Ok(Found { wrist, digits, side })
}

/// A chain whose moving joints have WebXR's names, or those of the map.
fn by_names(digit: Digit, exact: impl Fn(&str) -> Option<usize>) -> Option<Chain> {
    let at = |suffix: &str| exact(&format!("{}-{suffix}", names::prefix(digit)));
    let suffixes = names::suffixes(digit);
    let moving = suffixes.len() - 4;
    let of = |k: usize| at(suffixes[moving + k]);
    Some(Chain {
        metacarpal: if moving == 1 { at(suffixes[0]) } else { None },
        moving: [of(0)?, of(1)?, of(2)?],
        tip: at("tip"),
    })
}

/// A chain by what names say.
fn by_words(
    digit: Digit,
    said: &[Said],
    joints: &[RigJoint],
    wrist: usize,
) -> Result<Chain, RigError> {
    let mut of: Vec<(Place, usize)> = (said.iter().enumerate())
        .filter_map(|(k, said)| match said {
            Said::Of(own, place) if *own == digit => Some((*place, k)),
            _ => None,
        })
        .collect();
    of.sort_unstable();
    let bone = |b: u8| of.iter().find(|(place, _)| *place == Place::Bone(b)).map(|(_, k)| *k);
    let mut ends = of.iter().filter(|(place, _)| matches!(place, Place::End(_)));
    let tip =
        of.iter().find(|(place, _)| *place == Place::Tip).or(ends.next_back()).map(|(_, k)| *k);
    let numbers: Vec<(u32, usize)> = (of.iter())
        .filter_map(|(place, k)| if let Place::Number(n) = place { Some((*n, *k)) } else { None })
        .collect();
    let chain = if bone(1).is_some() {
        named(digit, bone, tip)
    } else {
        along(digit, &numbers, tip, joints, wrist)
    };
    chain.ok_or_else(|| {
        let mine: Vec<&str> = of.iter().map(|(_, k)| joints[*k].name.as_str()).collect();
        let has = match mine[..] {
            [] => "no name says that it is one of them".to_string(),
            _ => format!("these say that they are of it: {}", mine.join(", ")),
        };
        let what = format!("the rig has no three joints in a row for the {}: {has}", digit.name());
        lacking(joints, what)
    })
}

/// A chain whose names are those of bones. A thumb of proximal, intermediate and distal (VRM 0) begins at the
/// metacarpal, as one of metacarpal, proximal and distal does.
fn named(digit: Digit, bone: impl Fn(u8) -> Option<usize>, tip: Option<usize>) -> Option<Chain> {
    let moving = match (digit, bone(0)) {
        (Digit::Thumb, Some(first)) => [first, bone(1)?, bone(3)?],
        _ => [bone(1)?, bone(2)?, bone(3)?],
    };
    Some(Chain { metacarpal: bone(0).filter(|_| digit != Digit::Thumb), moving, tip })
}

/// A chain of numbered joints: three that move, perhaps one before them and one behind.
fn along(
    digit: Digit,
    numbers: &[(u32, usize)],
    tip: Option<usize>,
    joints: &[RigJoint],
    wrist: usize,
) -> Option<Chain> {
    let at: Vec<usize> = numbers.iter().map(|(_, k)| *k).collect();
    let far = |k: usize| (joints[k].pose.position - joints[wrist].pose.position).norm();
    let first_is_before = |first: usize, last: usize| match digit {
        Digit::Thumb => numbers[0].0 == 0,
        _ => far(first) < METACARPAL_REACH * far(last),
    };
    let (before, moving, last) = match at[..] {
        [a, b, c] => (None, [a, b, c], tip),
        [m, a, b, c] if tip.is_some() || first_is_before(m, c) => (Some(m), [a, b, c], tip),
        [a, b, c, end] => (None, [a, b, c], tip.or(Some(end))),
        [m, a, b, c, end] => (Some(m), [a, b, c], tip.or(Some(end))),
        _ => return None,
    };
    Some(Chain { metacarpal: before.filter(|_| digit != Digit::Thumb), moving, tip: last })
}

/// The side that names say; where they say both, the one asked for.
fn one_side(joints: &[RigJoint], asked: Option<Side>) -> Result<Option<Side>, RigError> {
    let of_hand = joints.iter().filter(|j| words::said(&j.name) != Said::Nothing);
    let sides: Vec<Side> = of_hand.filter_map(|j| words::side(&j.name)).collect();
    let has = |side| sides.contains(&side);
    match (has(Side::Left), has(Side::Right), asked) {
        (true, true, None) => Err(lacking(
            joints,
            "the rig has a left and a right hand: say which by the side (`--side`)".into(),
        )),
        (true, true, asked) => Ok(asked),
        (true, false, _) => Ok(Some(Side::Left)),
        (false, true, _) => Ok(Some(Side::Right)),
        _ => Ok(None),
    }
}

/// Most names of a rig that an error lists.
const LISTED_MAX: usize = 40;

/// An error that lists the rig's joints and says what helps.
fn lacking(joints: &[RigJoint], what: String) -> RigError {
    let mut list: Vec<String> =
        joints.iter().take(LISTED_MAX).map(|j| thenar_input::quoted(&j.name).to_string()).collect();
    if joints.len() > LISTED_MAX {
        list.push(format!("and {} more", joints.len() - LISTED_MAX));
    }
    RigError::invalid(format!(
        "{what}; its joints are {}; a file of lines `webxr-joint = \"name in the rig\"` says which is which \
         (`thenar build --joint-names`)",
        list.join(", ")
    ))
}
