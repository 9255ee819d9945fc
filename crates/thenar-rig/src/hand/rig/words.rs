//! Words in the names of common rigs: which digit, which joint of it, which side.
//!
//! Names are cut into words at signs, digits and capitals; what is no word of the tables says
//! nothing. So are read the joints of WebXR and OpenXR, Oculus hands, VRM 0 and 1, Unity's
//! humanoid, Mixamo, Unreal, MakeHuman's default and game rigs, Rigify, VRoid, Daz and 3ds Max
//! bipeds.

use thenar_core::model::{Digit, Side};

/// Place of a joint in its digit, as a name says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Place {
    /// A bone's word: 0 metacarpal, 1 proximal, 2 intermediate, 3 distal.
    Bone(u8),
    /// A number along the chain.
    Number(u32),
    /// The tip.
    Tip,
    /// An end node behind a joint, which is the tip where there is no other.
    End(u32),
}

/// Meaning of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Said {
    /// The wrist, the better the smaller the number.
    Wrist(u8),
    /// A joint of a digit.
    Of(Digit, Place),
    /// Nothing that is of use.
    Nothing,
}

/// Lower-case words and numbers of a name.
fn words(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut before = ' ';
    for c in name.chars() {
        let begins = c.is_ascii_digit() != before.is_ascii_digit()
            || (c.is_uppercase() && before.is_lowercase())
            || !before.is_alphanumeric();
        if c.is_alphanumeric() {
            match words.last_mut().filter(|_| !begins) {
                Some(word) => word.extend(c.to_lowercase()),
                None => words.push(c.to_lowercase().collect()),
            }
        }
        before = c;
    }
    // Daz writes `lThumb1`, Oculus `b_l_thumb1`: both give `l`.
    words
}

/// Names without the number that exporters of scenes append to each of them (`RightHand_033`):
/// numbers after a `_` at the end, if all of them differ, a hand's worth of names has them, and
/// names differ without.
pub(super) fn uncounted<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let names: Vec<&str> = names.collect();
    let count = |name: &&'a str| -> Option<(&'a str, &'a str)> {
        let (own, number) = name.rsplit_once('_')?;
        let is = !own.is_empty() && !number.is_empty();
        (is && number.bytes().all(|b| b.is_ascii_digit())).then_some((own, number))
    };
    let mut numbers: Vec<&str> = names.iter().filter_map(count).map(|(_, n)| n).collect();
    let counted = numbers.len();
    numbers.sort_unstable();
    numbers.dedup();
    if counted < JOINTS_MIN || numbers.len() < counted {
        return names;
    }
    let own: Vec<&str> =
        names.iter().map(|name| count(name).map_or(*name, |(own, _)| own)).collect();
    // Numbers that tell joints apart are part of their names.
    let mut apart = own.clone();
    apart.sort_unstable();
    apart.dedup();
    if apart.len() == own.len() { own } else { names }
}

/// Joints of a hand: a wrist and three of each digit.
const JOINTS_MIN: usize = 16;

/// First words of names that a control rig has several times, the better first: Rigify's copies of
/// the bones that were drawn, one of each, then those that deform, of which older figures have two
/// for one. Others of such a rig may be handles.
const LAYERS: [&str; 2] = ["org", "def"];

/// The first word of names that make a whole hand of a control rig, of this side if one is given: a
/// wrist, and three joints of each digit.
pub(super) fn layer(names: &[&str], thumbs: &Thumbs, wanted: Option<Side>) -> Option<&'static str> {
    let is_other = |name: &str| wanted.is_some_and(|w| side(name).is_some_and(|own| own != w));
    let is_whole = |layer: &&str| {
        let own = names.iter().filter(|name| is_of_layer(name, layer) && !is_other(name));
        let own: Vec<Said> = own.map(|name| said(name, thumbs)).collect();
        let bones = |digit: Digit| {
            let is = |said: &&Said| match said {
                Said::Of(of, place) => *of == digit && !matches!(place, Place::Tip | Place::End(_)),
                _ => false,
            };
            own.iter().filter(is).count()
        };
        own.iter().any(|said| matches!(said, Said::Wrist(_)))
            && Digit::FINGERS.iter().all(|digit| bones(*digit) >= 3)
    };
    LAYERS.into_iter().find(is_whole)
}

/// True if a name begins with this word.
pub(super) fn is_of_layer(name: &str, layer: &str) -> bool {
    words(name).first().is_some_and(|word| word == layer)
}

/// Digits by their words. The middle one's are last: they also name the middle phalanx of the
/// others.
const DIGITS: [(Digit, &[&str]); 5] = [
    (Digit::Thumb, &["thumb"]),
    (Digit::Index, &["index", "pointer", "forefinger"]),
    (Digit::Ring, &["ring"]),
    (Digit::Little, &["little", "pinky", "pinkie"]),
    (Digit::Middle, MIDDLE),
];
const MIDDLE: &[&str] = &["middle", "mid"];

/// Words of bones of a finger; the thumb's are distinguished where chains are read.
const BONES: [(u8, &[&str]); 4] = [
    (0, &["metacarpal", "meta", "carpal", "cmc"]),
    (1, &["proximal", "mcp"]),
    (2, &["intermediate", "medial", "pip"]),
    (3, &["distal", "dip"]),
];

fn one_of<T: Copy>(table: &[(T, &[&str])], words: &[String]) -> Option<T> {
    table.iter().find(|(_, of)| words.iter().any(|w| of.contains(&w.as_str()))).map(|(t, _)| *t)
}

/// Words that a finger's number follows in the place of its name: `Finger0`, `Finger01` of 3ds Max
/// and `finger1-1` of MakeHuman, Rigify's `palm.01`, MakeHuman's `metacarpal1`.
const NUMBERED: [&str; 3] = ["finger", "palm", "metacarpal"];

/// The thumb's number after each word of [`NUMBERED`]: 0, or 1 in rigs that count five digits to 5.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Thumbs([u32; NUMBERED.len()]);

impl Thumbs {
    /// The numbers of a rig whose joints have these names.
    pub fn of(names: &[&str]) -> Self {
        let mut thumbs = Self::default();
        let unnamed = names.iter().map(|name| words(name));
        for words in unnamed.filter(|words| one_of(&DIGITS, words).is_none()) {
            if let Some((kind, [finger, _])) = numbers(&words, &Self::default())
                && finger as usize == Digit::FINGERS.len()
            {
                thumbs.0[kind] = 1;
            }
        }
        thumbs
    }
}

/// Reads a name of a rig that counts fingers so.
pub(super) fn said(name: &str, thumbs: &Thumbs) -> Said {
    let words = words(name);
    let has = |word: &str| words.iter().any(|w| w == word);
    if is_second_part(&words) {
        return Said::Nothing;
    }
    let number = words.iter().rev().find_map(|w| w.parse::<u32>().ok());
    let number = number_before_side(&words).or(number);
    let (digit, number, by_number) = match (one_of(&DIGITS, &words), numbered(&words, thumbs)) {
        (Some(digit), _) => (Some(digit), number, false),
        (None, Some((digit, number))) => (Some(digit), Some(number), true),
        (None, None) => (None, number, false),
    };
    let Some(digit) = digit else {
        let elsewhere = ["forearm", "end", "ik", "elbow", "arm", "shoulder", "pole", "prop"];
        let at = |word: &str| words.iter().position(|w| w == word);
        let found =
            (0..).zip(["wrist", "hand", "palm"]).find_map(|(rank, word)| Some((rank, at(word)?)));
        // `hand_02` is some other joint of a hand.
        let counted = |at: usize| words[at..].iter().any(|w| w.parse::<u32>().is_ok());
        return match found {
            Some((rank, at)) if !counted(at) && !elsewhere.iter().any(|w| has(w)) => {
                Said::Wrist(rank)
            }
            _ => Said::Nothing,
        };
    };
    // The first of five numbered metacarpals is the thumb's, before joints that may have numbers
    // themselves.
    let counted = by_number && digit == Digit::Thumb;
    let bone = one_of(&BONES, &words).filter(|_| !counted).or_else(|| {
        let last_of_thumb = digit == Digit::Thumb && has("ip");
        // `middle` is a digit before it is a phalanx.
        let middles = words.iter().filter(|w| MIDDLE.contains(&w.as_str())).count();
        let phalanx = middles > usize::from(digit == Digit::Middle);
        if last_of_thumb { Some(3) } else { phalanx.then_some(2) }
    });
    let place = if has("tip") || has("null") || has("nub") {
        Place::Tip
    } else if has("end") {
        Place::End(number.unwrap_or(0))
    } else {
        bone.map_or(Place::Number(number.unwrap_or(0)), Place::Bone)
    };
    Said::Of(digit, place)
}

/// Place of a word for the side among these, if a digit and its number stand before it, as in
/// `f_index.02.L`.
fn side_after_number(words: &[String]) -> Option<usize> {
    let at = words.iter().rposition(|w| ["l", "r", "left", "right"].contains(&w.as_str()))?;
    let (number, before) = words[..at].split_last()?;
    let says =
        one_of(&DIGITS, before).is_some() || before.iter().any(|w| NUMBERED.contains(&&w[..]));
    (says && number.parse::<u32>().is_ok()).then_some(at)
}

/// The number right before the side.
fn number_before_side(words: &[String]) -> Option<u32> {
    words[side_after_number(words)? - 1].parse().ok()
}

/// True of the second part, and others after it, of a bone that older figures of Rigify cut:
/// `DEF-f_index.01.L.02`.
fn is_second_part(words: &[String]) -> bool {
    let part = side_after_number(words).and_then(|at| words.get(at + 1)?.parse::<u32>().ok());
    part.is_some_and(|part| part >= 2)
}

/// The digit that has a number in the place of a name, and the number of its joint.
fn numbered(words: &[String], thumbs: &Thumbs) -> Option<(Digit, u32)> {
    let (kind, [finger, joint]) = numbers(words, thumbs)?;
    let digit = *Digit::FINGERS.get(finger.checked_sub(thumbs.0[kind])? as usize)?;
    // Rigs that count from the index finger have none before it.
    let is = NUMBERED[kind] == "finger" || digit != Digit::Thumb || thumbs.0[kind] > 0;
    is.then_some((digit, joint))
}

/// Index of the word of [`NUMBERED`] that a name has, and the numbers after it: of a finger and of
/// a joint. A metacarpal's, which lies before all that is numbered along the finger, is 0.
fn numbers(words: &[String], thumbs: &Thumbs) -> Option<(usize, [u32; 2])> {
    let number = |at: usize| words.get(at).filter(|w| w.bytes().all(|b| b.is_ascii_digit()));
    let (kind, at, own) = (0..).zip(NUMBERED).find_map(|(kind, word)| {
        let at = 1 + words.iter().position(|w| w == word)?;
        Some((kind, at, number(at)?))
    })?;
    if NUMBERED[kind] != "finger" {
        return Some((kind, [own.parse().ok()?, 0]));
    }
    let (finger, rest) = own.split_at(1);
    // What follows the number of a finger from 0 to 4 is a copy's, or a scene's.
    let joint = number(at + 1).filter(|_| thumbs.0[kind] > 0).map_or(rest, String::as_str);
    Some((kind, [finger.parse().ok()?, joint.parse().unwrap_or(0)]))
}

/// The side that a name says.
pub(super) fn side(name: &str) -> Option<Side> {
    let words = words(name);
    let has = |word: &str| words.iter().any(|w| w == word);
    match (has("l") || has("left"), has("r") || has("right")) {
        (true, false) => Some(Side::Left),
        (false, true) => Some(Side::Right),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_many_tools_are_read() {
        use Digit::{Index, Little, Middle, Ring, Thumb};
        let cases = [
            ("index-finger-phalanx-proximal", Said::Of(Index, Place::Bone(1))),
            ("pinky-finger-tip", Said::Of(Little, Place::Tip)),
            ("XR_HAND_JOINT_LITTLE_METACARPAL_EXT", Said::Of(Little, Place::Bone(0))),
            ("b_r_thumb0", Said::Of(Thumb, Place::Number(0))),
            ("b_r_ring_null", Said::Of(Ring, Place::Tip)),
            ("b_r_ring3_end", Said::Of(Ring, Place::End(3))),
            ("leftThumbMetacarpal", Said::Of(Thumb, Place::Bone(0))),
            ("Left Middle Intermediate", Said::Of(Middle, Place::Bone(2))),
            ("mixamorig:RightHandPinky4", Said::Of(Little, Place::Number(4))),
            ("index_metacarpal_r", Said::Of(Index, Place::Bone(0))),
            ("middle_01_l", Said::Of(Middle, Place::Number(1))),
            ("DEF-f_index.02.R", Said::Of(Index, Place::Number(2))),
            ("DEF-f_index.01.L.01", Said::Of(Index, Place::Number(1))),
            ("DEF-f_index.01.L.02", Said::Nothing),
            ("Bip01 R Thumb2", Said::Of(Thumb, Place::Number(2))),
            ("thumb_l_02", Said::Of(Thumb, Place::Number(2))),
            ("palm.01.R", Said::Of(Index, Place::Number(0))),
            ("palm.04.L", Said::Of(Little, Place::Number(0))),
            ("J_Bip_L_Ring2", Said::Of(Ring, Place::Number(2))),
            ("lMid3", Said::Of(Middle, Place::Number(3))),
            ("Bip01 R Finger0", Said::Of(Thumb, Place::Number(0))),
            ("Bip01 R Finger42", Said::Of(Little, Place::Number(2))),
            ("thumb_cmc", Said::Of(Thumb, Place::Bone(0))),
            ("thumb_ip", Said::Of(Thumb, Place::Bone(3))),
            ("ring_middle", Said::Of(Ring, Place::Bone(2))),
            ("little finger middle phalanx", Said::Of(Little, Place::Bone(2))),
            ("index_mid", Said::Of(Index, Place::Bone(2))),
            ("middle_middle", Said::Of(Middle, Place::Bone(2))),
            ("middle_proximal", Said::Of(Middle, Place::Bone(1))),
            ("wrist", Said::Wrist(0)),
            ("hand.R", Said::Wrist(1)),
            ("mixamorig:LeftHand", Said::Wrist(1)),
            ("Palm", Said::Wrist(2)),
            ("Bip01 R Hand", Said::Wrist(1)),
            ("hand_02", Said::Nothing),
            ("b_r_forearm_stub", Said::Nothing),
            ("RightForeArm", Said::Nothing),
            ("Spine1", Said::Nothing),
        ];
        for (name, expected) in cases {
            assert_eq!(said(name, &Thumbs::default()), expected, "{name}");
        }
    }

    #[test]
    fn fingers_are_counted_from_0_unless_there_is_a_fifth() {
        use Digit::{Index, Little, Middle, Thumb};
        let read = |names: &[&str]| -> Vec<Said> {
            let thumbs = Thumbs::of(names);
            names.iter().map(|name| said(name, &thumbs)).collect()
        };
        assert_eq!(
            read(&["finger5-3.R", "finger1-1.R", "metacarpal1.R", "palm.02.R"]),
            [
                Said::Of(Little, Place::Number(3)),
                Said::Of(Thumb, Place::Number(1)),
                Said::Of(Index, Place::Bone(0)),
                Said::Of(Middle, Place::Number(0)),
            ]
        );
        // A copy of a biped.
        assert_eq!(
            read(&["Bip01 R Finger0.001", "Bip01 R Finger42.001"]),
            [Said::Of(Thumb, Place::Number(0)), Said::Of(Little, Place::Number(2))]
        );
        // The five of anatomy; the thumb's moves.
        assert_eq!(
            read(&["metacarpal_1", "metacarpal_5"]),
            [Said::Of(Thumb, Place::Number(0)), Said::Of(Little, Place::Bone(0))]
        );
        assert_eq!(read(&["metacarpal0", "palm0"]), [Said::Nothing; 2]);
        assert_eq!(read(&["index_metacarpal_5"]), [Said::Of(Index, Place::Bone(0))]);
    }

    #[test]
    fn numbers_that_count_a_scene_s_nodes_are_no_part_of_names() {
        let numbered = |k: usize| format!("RightHandIndex{}_0{}", k + 1, k + 30);
        let mut names: Vec<String> = (0..16).map(numbered).collect();
        names.push("_rootJoint".into());
        let of = |names: &[String]| -> Vec<String> {
            uncounted(names.iter().map(String::as_str)).into_iter().map(String::from).collect()
        };
        assert_eq!(of(&names)[..2], ["RightHandIndex1", "RightHandIndex2"]);
        assert_eq!(of(&names)[16], "_rootJoint");
        // Numbers along the digits come again with each of them.
        let along: Vec<String> = (0..16).map(|k| format!("digit{}_0{}", k / 3, k % 3)).collect();
        assert_eq!(of(&along), along);
        assert_eq!(of(&names[..15]), names[..15]);
        // Numbers through the whole hand say the order along a digit.
        let through: Vec<String> = (0..16).map(|k| format!("digit{}_{k}", k / 3)).collect();
        assert_eq!(of(&through), through);
    }

    #[test]
    fn sides_are_words_and_not_letters_within_words() {
        for name in ["b_r_wrist", "hand.R", "RightHand", "Bip01 R Hand", "rThumb1"] {
            assert_eq!(side(name), Some(Side::Right), "{name}");
        }
        for name in ["lHand", "mixamorig:LeftHandThumb1", "thumb_01_l"] {
            assert_eq!(side(name), Some(Side::Left), "{name}");
        }
        for name in ["ring-finger-tip", "little_distal", "wrist", "root"] {
            assert_eq!(side(name), None, "{name}");
        }
    }
}
