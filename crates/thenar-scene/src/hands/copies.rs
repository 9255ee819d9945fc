//! Hands that a scene lacks.

use super::{length_of, mirror};
use crate::format::{
    BonesWord, Hand, HandKey, KeyframesTable, LimitsWord, MotionTable, NamedJoints, Pair, PoseWord,
    Scene, SkinningWord, WristTable,
};
use crate::math::Vec3;
use crate::text::Located;
use thenar_core::model::{Coupling, Side};

/// Gap left free between an added hand and others that point at it \[m\].
const CLEAR: f64 = 0.05;
/// Length of a hand that tells none: that of the built-in hands, rounded up, wrist to middle
/// fingertip \[m\].
const LENGTH: f64 = 0.19;
/// Distance in front of figures at which a hand is added \[m\]: as far as a person of 1.7 m reaches
/// to the side, and the length of a hand.
const BEFORE_FIGURES: f64 = 0.85;
/// Lowest wrist of an added hand \[m\].
const HEIGHT_MIN: f64 = 0.15;

/// A copy of the scene's hand as one of `side`, beside it and still, with room for hands of
/// `lengths`, left and right \[m\]; a hand of its own where the scene has none.
pub fn holding_still(scene: &Scene, side: Side, lengths: [Option<f64>; 2]) -> Hand {
    let Some(template) = template(scene) else { return default_hand(scene, side) };
    let mut hand = template.clone();
    mirror::hand(&mut hand, side);
    hand.name = free_name(scene, side);
    let outwards = outwards(side);
    let reach = |hand: &Hand| length_of(hand, lengths).unwrap_or(LENGTH);
    let first = match hand.motion.as_ref().map(|motion| &motion.value) {
        Some(MotionTable::Keyframes(keys)) => keys.key.first().and_then(|key| key.wrist.clone()),
        _ => None,
    };
    let mut wrist = first.unwrap_or_else(|| resting(outwards));
    let place = wrist.position.get_or_insert_with(Vec3::zeros);
    // As far out as all hands of the other side leave room for, should both point at each other.
    let theirs = scene.hand.iter().map(|other| outwards * start(other).x + reach(other));
    let edge = theirs.fold(f64::NEG_INFINITY, f64::max) + CLEAR + reach(&hand);
    place.x = outwards * (outwards * place.x).max(edge);
    place.y = place.y.max(HEIGHT_MIN);
    hand.motion = Some(still(wrist));
    hand.grip.clear();
    (hand.position, hand.rotation) = (Vec3::zeros(), None);
    hand
}

/// A built-in hand beside the origin.
pub fn default_hand(scene: &Scene, side: Side) -> Hand {
    Hand {
        name: free_name(scene, side),
        model: Some(mirror::model(side)),
        joint_names: None,
        mesh: None,
        preset: None,
        tets: None,
        detail: None,
        length: None,
        position: Vec3::zeros(),
        rotation: None,
        coupling: None,
        coupling_stiffness: None,
        coupling_damping_time: Coupling::DAMPING_TIME,
        skinning: SkinningWord::Lbs,
        pose_offsets: false,
        elements: None,
        material: None,
        springs: None,
        joint: Vec::new(),
        tissue: None,
        layer: Vec::new(),
        skin: None,
        nail: None,
        friction: None,
        flesh: true,
        bones: BonesWord::Solid,
        self_contact: true,
        motion: Some(still(before_figures(resting(outwards(side)), scene))),
        grip: Vec::new(),
        driven: true,
        muscles: None,
        palm_drive: None,
        bone_drive: None,
        colour: None,
    }
}

/// The hand to copy: one that touches the most.
fn template(scene: &Scene) -> Option<&Hand> {
    let untouching = |hand: &Hand| {
        let names = |pair: &&Pair| pair.bodies.iter().any(|body| body.value == hand.name.value);
        scene.pair.iter().filter(|pair| !pair.contact).filter(names).count()
    };
    scene.hand.iter().min_by_key(|hand| (!hand.flesh, !hand.driven, untouching(hand)))
}

/// Start of a hand: the wrist of its first key, or its own place \[m\].
fn start(hand: &Hand) -> Vec3 {
    let wrist = match hand.motion.as_ref().map(|motion| &motion.value) {
        Some(MotionTable::Keyframes(keys)) => keys.key.iter().find_map(|key| key.wrist.as_ref()),
        _ => None,
    };
    wrist.and_then(|wrist| wrist.position).unwrap_or(hand.position)
}

/// Sign of x on the side where a person has this hand.
fn outwards(side: Side) -> f64 {
    if side == Side::Left { -1.0 } else { 1.0 }
}

/// A wrist at ease: palm down, fingers forwards.
fn resting(outwards: f64) -> WristTable {
    WristTable {
        position: Some(Vec3::new(0.2 * outwards, 0.2, 0.1)),
        rotation: None,
        fingers: Some(-Vec3::z()),
        back: Some(Vec3::y()),
    }
}

/// Moves a wrist in front of the scene's figures, if it has any.
fn before_figures(wrist: WristTable, scene: &Scene) -> WristTable {
    let forward = if scene.figure.is_empty() { 0.0 } else { BEFORE_FIGURES };
    WristTable { position: wrist.position.map(|p| p + Vec3::z() * forward), ..wrist }
}

/// A motion that does not move.
fn still(wrist: WristTable) -> Located<MotionTable> {
    let key = HandKey {
        time: 0.0,
        wrist: Some(wrist),
        pose: Some(PoseWord::Rest),
        curl: None,
        joints: NamedJoints::default(),
        tips: None,
    };
    let table = KeyframesTable { limits: LimitsWord::Clamp, key: vec![key] };
    mirror::unwritten(MotionTable::Keyframes(table), "hand.motion")
}

/// A name that the scene does not use yet.
fn free_name(scene: &Scene, side: Side) -> Located<String> {
    let word = if side == Side::Left { "left hand" } else { "right hand" };
    let taken = |name: &str| {
        scene
            .hand
            .iter()
            .map(|hand| &hand.name)
            .chain(scene.rigid.iter().map(|rigid| &rigid.name))
            .chain(scene.soft.iter().map(|soft| &soft.name))
            .any(|known| known.value == name)
    };
    let mut name = word.to_string();
    for n in 2.. {
        if !taken(&name) {
            break;
        }
        name = format!("{word} {n}");
    }
    mirror::unwritten(name, "hand.name")
}
