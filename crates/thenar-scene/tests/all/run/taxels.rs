//! Goal: shipped layouts of taxels lie where they say, and in shipped scenes feel all that presses
//! on the hand. Method: the skin at rest seen from its bones; grasps and presses, against sums over
//! contact points worked out here.

use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::{BodyId, Digit, HandModel, Side};
use thenar_core::readout::{TaxelPlace, TaxelReadout};
use thenar_scene::session::{Session, builtin};
use thenar_scene::taxels::{Layout, layout, on_bone};

fn rest(hand: &HandModel) -> Vec<Vec3> {
    let surface = &hand.flesh.collision;
    let mut rest = vec![Vec3::zeros(); surface.vertices.len()];
    surface.positions(&hand.flesh.tets, &hand.flesh.nodes, &mut rest);
    rest
}

#[test]
fn fingertips_are_on_the_pads_in_rows_and_columns() {
    for tets in [600, 3000] {
        let hand = thenar_rig::uniform_hand(Side::Right, tets).unwrap();
        let rest = rest(&hand);
        let patches = layout(&hand, Layout::Fingertips, 4, 3);
        let names: Vec<&str> = patches.iter().map(|patch| &patch.name[..]).collect();
        let tips = ["thumb", "index", "middle", "ring", "little"].map(|f| format!("{f}-distal"));
        assert_eq!(names, tips);
        for patch in &patches {
            assert_eq!((patch.rows, patch.columns, patch.places.len()), (4, 3, 12));
            let bone = hand.bones.iter().find(|bone| bone.name == patch.name).unwrap();
            let at: Vec<Vec3> = patch
                .places
                .iter()
                .map(|place| bone.pose_MB.inverse().point(&place.on(&rest)))
                .collect();
            for (k, p) in at.iter().enumerate() {
                assert!(p.y < 0.0, "{} {k}: on the palm's side: {p}", patch.name);
                // Outwards row by row (-z), and across column by column (x).
                assert!(k < 3 || p.z < at[k - 3].z - 1e-3, "{} {k}: {p}", patch.name);
                assert!(k % 3 == 0 || p.x > at[k - 1].x + 1e-3, "{} {k}: {p}", patch.name);
            }
        }
    }
}

#[test]
fn the_whole_hand_has_a_patch_on_every_bone_and_faces_the_palm() {
    for side in [Side::Left, Side::Right] {
        let hand = thenar_rig::uniform_hand(side, 600).unwrap();
        let rest = rest(&hand);
        let patches = layout(&hand, Layout::Hand, 3, 3);
        assert_eq!(patches.len(), hand.bones.len());
        let palm = &patches[0];
        assert_eq!(palm.name, hand.bones[0].name);
        let at = |place: &TaxelPlace| hand.bones[0].pose_MB.inverse().point(&place.on(&rest));
        let heights: Vec<Vec3> = palm.places.iter().map(at).collect();
        assert!(
            heights.iter().all(|p| p.y < 0.0),
            "{side:?}: {heights:?} {:?}",
            hand.bones[0].ends_B
        );
        for (patch, bone) in patches.iter().zip(&hand.bones) {
            let digit = |v: u32| hand.collision_digits[v as usize];
            let own = |place: &TaxelPlace| place.vertices.iter().all(|v| digit(*v) == bone.digit);
            assert!(patch.places.iter().all(own), "{}", patch.name);
        }
    }
}

#[test]
fn chosen_points_are_laid_on_the_skin_of_their_bone() {
    let hand = thenar_rig::uniform_hand(Side::Right, 600).unwrap();
    let (rest, name) = (rest(&hand), "index-distal");
    let bone = hand.bones.iter().find(|bone| bone.name == name).unwrap();
    let deep = [Vec3::new(0.0, -1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    let patch = on_bone(&hand, name, &deep).unwrap();
    let at = |k: usize| bone.pose_MB.inverse().point(&patch.places[k].on(&rest));
    assert!(at(0).y < -2e-3 && at(1).y > 2e-3, "pad and nail: {} {}", at(0), at(1));
    assert!(on_bone(&hand, "index-distal-2", &deep).is_none());
}

/// Force on these parts of a hand, and the sum of the sizes of its points' forces; and how much of
/// it is on bones.
fn sums(session: &Session, digits: &[Digit]) -> (Vec3, f64, f64) {
    let hand = &session.hands()[0];
    let mut sums = (Vec3::zeros(), 0.0, 0.0);
    for point in session.world().contacts() {
        for side in 0..2 {
            let (digit, on_bone) = match point.bodies[side] {
                BodyId::Soft(soft) if Some(soft) == hand.flesh() => {
                    let vertex = point.vertices[side].expect("a vertex");
                    (hand.model.collision_digits[vertex as usize], 0.0)
                }
                BodyId::Rigid(bone) if hand.handle.bones.contains(&bone) => {
                    let bone = bone - hand.handle.bones.start;
                    (hand.model.bones[bone as usize].digit, 1.0)
                }
                _ => continue,
            };
            if digits.contains(&digit) {
                sums.0 += if side == 0 { point.force_W } else { -point.force_W };
                sums.1 += point.force_W.norm();
                sums.2 += on_bone * point.force_W.norm();
            }
        }
    }
    sums
}

#[test]
fn all_that_presses_on_the_hand_is_felt_in_shipped_scenes() {
    let (mut newtons, mut on_bones) = (0.0_f64, 0.0_f64);
    for name in ["bread-grasp", "car-grasp", "fist", "pinch", "table-press"] {
        let text = builtin(name).expect("a scene").text;
        let mut set = vec!["hand.hand.preset=paper".to_owned()];
        // So soft that the table meets bones.
        if name == "table-press" {
            let soft = ["material.young=1e4", "coupling_stiffness=1e8"];
            set.extend(soft.map(|key| format!("hand.hand.{key}")));
        }
        let session = Session::from_text(text, Path::new("test.toml"), &set);
        let mut session = session.unwrap_or_else(|e| panic!("{e}"));
        let soft = session.hands()[0].flesh().expect("flesh");
        let readout = |session: &Session, which| {
            let patches = layout(&session.hands()[0].model, which, 4, 4);
            let places: Vec<_> = patches.iter().flat_map(|patch| patch.places.clone()).collect();
            TaxelReadout::new(session.world(), soft, &places, f64::INFINITY).unwrap()
        };
        let mut tips = readout(&session, Layout::Fingertips);
        let mut whole = readout(&session, Layout::Hand);
        let every = [&[Digit::Palm][..], &Digit::FINGERS].concat();
        for _ in 0..session.steps_wanted().min(300) {
            session.step(&mut ());
            for (taxels, digits) in [(&mut tips, &Digit::FINGERS[..]), (&mut whole, &every)] {
                taxels.read(session.world());
                let (force_W, size, bones) = sums(&session, digits);
                let felt: Vec3 = taxels.taxels().iter().map(|taxel| taxel.force_W).sum();
                assert!((felt - force_W).norm() <= 1e-12 * size, "{name}: {felt} for {force_W}");
                newtons = newtons.max(size);
                on_bones = on_bones.max(bones);
            }
        }
    }
    assert!(newtons > 5.0 && on_bones > 0.1, "{newtons} N, on bones {on_bones} N");
}
