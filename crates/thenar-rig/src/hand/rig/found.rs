//! Search for the hand's joints in a rig: by the name map, by WebXR's names, or by what names say.

use super::words::{self, Place, Said, Thumbs};
use crate::RigError;
use crate::glb::RigJoint;
use crate::hand::names::{self, NameMap};
use thenar_core::model::{Digit, Side};
use thenar_input::quoted;

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
pub(in crate::hand) struct RigJoints {
    pub wrist: usize,
    /// Digits, thumb first.
    pub digits: [Chain; 5],
    /// The side that names say.
    pub side: Option<Side>,
}

/// The first of a finger's four numbered joints is a metacarpal when it lies within this part of
/// the way from the wrist to the last. A metacarpal begins a third of the way to the knuckle, which
/// lies halfway to the tip.
const METACARPAL_REACH: f64 = 0.33;

/// A hand as names tell it, digit by digit.
pub(in crate::hand) struct JointsByName {
    pub wrist: Result<usize, RigError>,
    /// Digits, thumb first.
    pub digits: [Result<Chain, RigError>; 5],
    /// The joints that say that they are of each digit.
    pub of_digit: [Vec<usize>; 5],
    /// The side that names say.
    pub side: Option<Side>,
}

/// Finds the joints of a hand.
///
/// # Errors
/// Names the joint that is missing, lists those of the rig, and says what helps.
pub(in crate::hand) fn find(
    joints: &[RigJoint],
    map: &NameMap,
    side: Option<Side>,
) -> Result<RigJoints, RigError> {
    let JointsByName { wrist, digits, side, .. } = told(joints, map, side)?;
    let wrist = wrist?;
    let [a, b, c, d, e] = digits;
    Ok(RigJoints { wrist, digits: [a?, b?, c?, d?, e?], side })
}

/// Finds what there is of a hand, and says what is not.
///
/// # Errors
/// The map names what is not there, or names contradict the side or say both.
pub(in crate::hand) fn told(
    joints: &[RigJoint],
    map: &NameMap,
    side: Option<Side>,
) -> Result<JointsByName, RigError> {
    check_map(joints, map)?;
    let exact = |webxr: &str| {
        let name = map.get(webxr).map_or(webxr, String::as_str);
        joints.iter().position(|j| j.name == name)
    };
    let names = words::uncounted(joints.iter().map(|j| j.name.as_str()));
    let thumbs = Thumbs::of(&names);
    let side = one_side(joints, &names, &thumbs, side)?;
    let said = said_of(joints, &names, &thumbs, map, side);
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
    });
    // Without a wrist what is found is for reading alone.
    let from = *wrist.as_ref().unwrap_or(&0);
    let chain = |digit: Digit| match by_names(digit, exact) {
        Some(chain) => Ok(chain),
        None => by_words(digit, &said, joints, from),
    };
    let of = |digit: Digit| {
        let is = |k: &usize| matches!(said[*k], Said::Of(own, _) if own == digit);
        (0..joints.len()).filter(is).collect()
    };
    let digits = Digit::FINGERS.map(chain);
    Ok(JointsByName { wrist, digits, of_digit: Digit::FINGERS.map(of), side })
}

/// The sides that the names of a hand's joints say: left, right.
pub(in crate::hand) fn sides_said(joints: &[RigJoint]) -> [bool; 2] {
    let names = words::uncounted(joints.iter().map(|j| j.name.as_str()));
    sides_of(&names, &Thumbs::of(&names))
}

fn sides_of(names: &[&str], thumbs: &Thumbs) -> [bool; 2] {
    let of_hand = names.iter().filter(|name| words::said(name, thumbs) != Said::Nothing);
    let sides: Vec<Side> = of_hand.filter_map(|name| words::side(name)).collect();
    [Side::Left, Side::Right].map(|side| sides.contains(&side))
}

/// Meanings of all joints, by the map or by their names.
fn said_of(
    joints: &[RigJoint],
    names: &[&str],
    thumbs: &Thumbs,
    map: &NameMap,
    side: Option<Side>,
) -> Vec<Said> {
    let of_webxr = |webxr: &String| words::said(webxr, &Thumbs::default());
    let mapped: Vec<Said> = map.keys().map(of_webxr).collect();
    let layer = words::layer(names, thumbs, side);
    let of_name = |name: &str| {
        let other = side.is_some_and(|side| words::side(name).is_some_and(|own| own != side));
        let handle = layer.is_some_and(|layer| !words::is_of_layer(name, layer));
        // What the map gives to one joint, no other has.
        let said = words::said(name, thumbs);
        if other || handle || mapped.contains(&said) { Said::Nothing } else { said }
    };
    let given = |joint: &RigJoint| map.iter().find(|(_, own)| **own == joint.name);
    let joints = joints.iter().zip(names);
    joints
        .map(|(joint, name)| {
            given(joint).map_or_else(|| of_name(name), |(webxr, _)| of_webxr(webxr))
        })
        .collect()
}

/// Errs if a name map names a joint that WebXR or this rig does not have, or one joint twice.
fn check_map(joints: &[RigJoint], map: &NameMap) -> Result<(), RigError> {
    for (webxr, own) in map {
        if !names::all().any(|name| name == *webxr) {
            let all: Vec<String> = names::all().collect();
            return Err(RigError::invalid(format!(
                "the name map names {}, which is none of WebXR's joints: {}",
                quoted(webxr),
                all.join(", ")
            )));
        }
        if !joints.iter().any(|j| j.name == *own) {
            let own = quoted(own);
            let what = format!("the rig has no joint {own} (by the name map), needed as {webxr}");
            return Err(lacking(joints, what));
        }
        if let Some((other, _)) = map.iter().find(|(key, name)| *key != webxr && *name == own) {
            let own = quoted(own);
            return Err(RigError::invalid(format!(
                "the name map names {own} twice: as {webxr} and as {other}"
            )));
        }
    }
    Ok(())
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
    let counted = || {
        let chain = along(digit, &numbers, tip, joints, wrist)?;
        Some(Chain { metacarpal: chain.metacarpal.or_else(|| metacarpal(digit, bone)), ..chain })
    };
    let some_named = named_bones(digit, bone).iter().any(Option::is_some);
    let chain = named(digit, bone, tip).or_else(|| match some_named {
        true => filled(digit, bone, &numbers, tip),
        false => counted(),
    });
    chain.ok_or_else(|| {
        let mine: Vec<usize> = of.iter().map(|(_, k)| *k).collect();
        let has = match mine[..] {
            [] => "no name says that it is one of them".to_string(),
            _ => format!("these say that they are of it: {}", listed(joints, &mine)),
        };
        let what = format!("the rig has no three joints in a row for the {}: {has}", digit.name());
        lacking(joints, what)
    })
}

/// A chain whose names are those of bones. A thumb of proximal, intermediate and distal (VRM 0)
/// begins at the metacarpal, as one of metacarpal, proximal and distal does.
fn named(digit: Digit, bone: impl Fn(u8) -> Option<usize>, tip: Option<usize>) -> Option<Chain> {
    let [a, b, c] = moving_bones(digit, bone(0).is_some()).map(&bone);
    Some(Chain { metacarpal: metacarpal(digit, &bone), moving: [a?, b?, c?], tip })
}

/// The words of the bones that move.
fn moving_bones(digit: Digit, has_metacarpal: bool) -> [u8; 3] {
    if digit == Digit::Thumb && has_metacarpal { [0, 1, 3] } else { [1, 2, 3] }
}

/// The joint before those that move.
fn metacarpal(digit: Digit, bone: impl Fn(u8) -> Option<usize>) -> Option<usize> {
    bone(0).filter(|_| digit != Digit::Thumb)
}

/// The joints of the moving bones that are named.
fn named_bones(digit: Digit, bone: impl Fn(u8) -> Option<usize>) -> [Option<usize>; 3] {
    // A thumb with a metacarpal, or without an intermediate bone, is named as WebXR names it.
    let of_webxr = bone(0).is_some() || bone(2).is_none();
    moving_bones(digit, of_webxr).map(bone)
}

/// A chain of which some joints are named as bones, and as many numbered as are left.
fn filled(
    digit: Digit,
    bone: impl Fn(u8) -> Option<usize>,
    numbers: &[(u32, usize)],
    tip: Option<usize>,
) -> Option<Chain> {
    let named = named_bones(digit, &bone);
    let mut rest = numbers.iter().map(|(_, k)| *k);
    let [a, b, c] = named.map(|own| own.or_else(|| rest.next()));
    let chain = Chain { metacarpal: metacarpal(digit, &bone), moving: [a?, b?, c?], tip };
    rest.next().is_none().then_some(chain)
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
fn one_side(
    joints: &[RigJoint],
    names: &[&str],
    thumbs: &Thumbs,
    asked: Option<Side>,
) -> Result<Option<Side>, RigError> {
    let [left, right] = sides_of(names, thumbs);
    let told = match (left, right) {
        (true, true) if asked.is_none() => {
            let all: Vec<usize> = (0..joints.len()).collect();
            return Err(RigError::invalid(format!(
                "the rig has a left and a right hand: say which by the side (`thenar build --side`); its joints are {}",
                listed(joints, &all)
            )));
        }
        (true, true) => asked,
        (true, false) => Some(Side::Left),
        (false, true) => Some(Side::Right),
        (false, false) => None,
    };
    match (told, asked) {
        (Some(told), Some(asked)) if told != asked => Err(RigError::invalid(format!(
            "the names of the rig's joints are those of a {} hand, not of the {} one asked for",
            told.name(),
            asked.name()
        ))),
        _ => Ok(told),
    }
}

/// Most names of a rig that an error lists.
const LISTED_MAX: usize = 40;

/// Names of some of the rig's joints.
fn listed(joints: &[RigJoint], which: &[usize]) -> String {
    let names = which.iter().take(LISTED_MAX).map(|&k| quoted(&joints[k].name).to_string());
    let more = which.len().saturating_sub(LISTED_MAX);
    let more = (more > 0).then(|| format!("and {more} more"));
    names.chain(more).collect::<Vec<_>>().join(", ")
}

/// An error that lists the rig's joints and says what helps.
fn lacking(joints: &[RigJoint], what: String) -> RigError {
    let all: Vec<usize> = (0..joints.len()).collect();
    RigError::invalid(format!(
        "{what}; its joints are {}; a file of lines `webxr-joint = \"name in the rig\"` says which is which \
         (`thenar build --joint-names`)",
        listed(joints, &all)
    ))
}
