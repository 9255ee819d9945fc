//! Goal: what is written is read back bit for bit; what is damaged or makes no sense is refused.
//! Method: the shipped hand, and a hand of two bones and one tetrahedron cut from it, damaged in
//! every place.

use super::*;
use crate::hand::{HandOptions, asset, build_hand};
use crate::object::{Bread, Car, bread, toy_car};
use thenar_core::model::{
    Binding, BoneNode, CouplingKind, EmbeddedSurface, HandRegion, Law, Relaxation, Side,
    SurfaceVertex,
};

fn small_hand() -> HandModel {
    let options = HandOptions { tets: 60, render_triangles: 200, ..HandOptions::paper() };
    build_hand(asset(Side::Right), &options).unwrap()
}

/// Two bones, one tetrahedron, one triangle.
fn tiny_hand() -> HandModel {
    let mut hand = small_hand();
    hand.bones.truncate(2);
    hand.joints.truncate(1);
    hand.solids.truncate(2);
    let tet = hand.flesh.tets[0];
    hand.flesh.nodes = tet.map(|n| hand.flesh.nodes[n as usize]).to_vec();
    hand.node_volumes.truncate(4);
    hand.bindings.truncate(4);
    let binding = Binding { bones: [0, 1], weights: [0.5, 0.5] };
    hand.bone_nodes = vec![BoneNode { node: 2, binding, volume: 1e-7 }];
    hand.nail_nodes = vec![BoneNode { node: 1, binding, volume: 2e-8 }];
    hand.regions = vec![HandRegion::Nail];
    for binding in &mut hand.bindings {
        (binding.bones, binding.weights) = ([0, 1], [0.25, 0.75]);
    }
    hand.flesh.tets = vec![[0, 1, 2, 3]];
    hand.flesh.materials.truncate(1);
    let vertex = SurfaceVertex { tet: 0, weights: [0.25; 4] };
    let surface = EmbeddedSurface { vertices: vec![vertex; 3], triangles: vec![[0, 1, 2]] };
    hand.collision_digits.truncate(3);
    (hand.flesh.collision, hand.render) = (surface.clone(), surface);
    hand
}

fn bytes_of(hand: &HandModel) -> Vec<u8> {
    Model::Hand(hand.clone()).to_bytes().unwrap()
}

/// The bytes of a model, under a header that agrees with the body.
fn resealed(bytes: &[u8]) -> Vec<u8> {
    /// Serialises as the bytes themselves, without a length before them.
    struct Raw<'a>(&'a [u8]);
    impl serde::Serialize for Raw<'_> {
        fn serialize<S: serde::Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
            use serde::ser::SerializeTuple;
            let mut tuple = s.serialize_tuple(self.0.len())?;
            self.0.iter().try_for_each(|b| tuple.serialize_element(b))?;
            tuple.end()
        }
    }
    container::encode(Kind::Hand, &Raw(bytes.get(32..).unwrap_or_default())).unwrap()
}

#[test]
fn a_hand_comes_back_as_it_was() {
    let hand = small_hand();
    let bytes = bytes_of(&hand);
    let Model::Hand(back) = Model::from_bytes(&bytes).unwrap() else { panic!("not a hand") };
    assert_eq!(bytes_of(&back), bytes);
    assert_eq!(back.flesh.nodes, hand.flesh.nodes);
    assert_eq!(back.bindings, hand.bindings);
}

#[test]
fn files_are_written_whole_and_name_themselves_in_errors() {
    let folder = std::env::temp_dir().join(format!("thenar-model-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("hand.thenar");
    write_model(&path, &Model::Hand(tiny_hand())).unwrap();
    assert!(read_model(&path).is_ok());
    // Nothing else is left in the folder.
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);

    let mut bytes = std::fs::read(&path).unwrap();
    bytes[100] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let error = read_model(&path).unwrap_err().to_string();
    assert!(error.contains("hand.thenar") && error.contains("damaged"), "{error}");

    // A model that makes no sense leaves the old file alone.
    let before = std::fs::read(&path).unwrap();
    let mut hand = tiny_hand();
    hand.bones[1].mass = f64::NAN;
    assert!(write_model(&path, &Model::Hand(hand)).is_err());
    assert_eq!(std::fs::read(&path).unwrap(), before);
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Mimics are kept in a kind of file of its own, which other readers take for the same figure
/// without them.
#[test]
fn a_figure_keeps_its_mimics() {
    use crate::figure::Mimic;
    let hand = small_hand();
    let mimic =
        Mimic { joint: 3, axis: 0, leader: 4, leader_axis: 0, law: [0.1, -1.0, 0.0, 0.0, 2.0] };
    let folder = std::env::temp_dir().join(format!("thenar-mimics-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("figure.thenar");
    let bytes = figure_bytes(&hand, &[mimic]).unwrap();
    std::fs::write(&path, &bytes).unwrap();
    let (back, mimics) = read_figure(&path).unwrap();
    assert_eq!((mimics, bytes_of(&back)), (vec![mimic], bytes_of(&hand)));
    assert!(
        matches!(Model::from_bytes(&bytes), Ok(Model::Hand(same)) if bytes_of(&same) == bytes_of(&hand))
    );
    assert_eq!(figure_bytes(&hand, &[]).unwrap(), bytes_of(&hand));
    for wrong in [
        Mimic { joint: 99, ..mimic },
        Mimic { axis: 2, ..mimic },
        Mimic { leader: 3, ..mimic },
        Mimic { law: [f64::NAN; 5], ..mimic },
    ] {
        let error = figure_bytes(&hand, &[wrong]).unwrap_err().to_string();
        assert!(error.contains("follow"), "{error}");
    }
    std::fs::write(&path, Model::Rigid(toy_car(&Car::default()).unwrap().0).to_bytes().unwrap())
        .unwrap();
    let error = read_figure(&path).unwrap_err().to_string();
    assert!(error.contains("figure.thenar") && error.contains("holds no figure"), "{error}");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = bytes_of(&tiny_hand());
    assert!(Model::from_bytes(&resealed(&bytes)).is_ok());
    for n in 0..bytes.len() {
        assert!(Model::from_bytes(&bytes[..n]).is_err(), "{n} bytes were accepted");
        assert!(Model::from_bytes(&resealed(&bytes[..n])).is_err(), "{n} resealed bytes were");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(Model::from_bytes(&longer).is_err());
    assert!(Model::from_bytes(&resealed(&longer)).is_err());
}

#[test]
fn every_flipped_bit_is_seen() {
    let bytes = bytes_of(&tiny_hand());
    for i in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[i] ^= 1 << (i % 8);
        assert!(Model::from_bytes(&damaged).is_err(), "byte {i} may change unseen");
        // With a header made to agree it may pass, but whatever passes makes sense.
        if let Ok(model) = Model::from_bytes(&resealed(&damaged)) {
            assert!(model.to_bytes().is_ok());
        }
    }
}

#[test]
fn models_that_make_no_sense_are_refused_by_name() {
    type Spoil = fn(&mut HandModel);
    let cases: [(Spoil, &str); 17] = [
        (|h| h.bones[1].parent = Some(1), "parent"),
        (|h| h.bones[1].mass = 0.0, "bone mass"),
        (|h| h.bones[0].inertia[(0, 1)] += 1.0, "inertia"),
        (|h| h.joints[0].child = 0, "joint 0"),
        (|h| h.flesh.nodes[2].x = f64::INFINITY, "node position"),
        (|h| h.flesh.tets[0].swap(0, 1), "tetrahedron 0"),
        (|h| h.flesh.materials[0].poisson = 0.5, "Poisson"),
        (|h| h.bindings[3].weights = [0.5, 0.6], "node 3"),
        (|h| h.render.triangles[0][2] = 3, "render surface"),
        (|h| h.solids.truncate(1), "1 solids"),
        (|h| h.bone_nodes[0].node = 4, "nodes in bone"),
        (|h| h.bone_nodes[0].volume = 0.0, "volume of bone"),
        (|h| h.bone_nodes[0].binding.weights = [0.5, 0.6], "node 2"),
        (|h| h.nail_nodes[0].node = 4, "nodes in bone"),
        (|h| h.nail_nodes[0].binding.bones = [2, 2], "node 1 is bound to a bone"),
        (|h| h.regions.push(HandRegion::Pad), "2 regions for 1 triangles"),
        (|h| (h.coupling, h.bone_nodes) = (CouplingKind::Bone, Vec::new()), "held in bone"),
    ];
    for (spoil, named) in cases {
        let mut hand = tiny_hand();
        spoil(&mut hand);
        let error = Model::Hand(hand).to_bytes().unwrap_err().to_string();
        assert!(error.contains(named), "{error} does not name {named}");
    }
}

#[test]
fn objects_come_back_as_they_were() {
    let (car, loaf) = (toy_car(&Car::default()).unwrap(), bread(&Bread::loaf()).unwrap());
    for model in [Model::Rigid(car.0), Model::Soft(loaf.0)] {
        let bytes = model.to_bytes().unwrap();
        assert_eq!(Model::from_bytes(&bytes).unwrap().to_bytes().unwrap(), bytes);
    }
}

/// The bytes of a hand without memory, held uniformly, as version 2 had them: without the list of
/// relaxations, the kind of coupling and the lists of nodes in bone, of regions, of nodes under
/// nails and of the flesh's stiffnesses, a zero each.
fn of_version_2(hand: &HandModel) -> Vec<u8> {
    let flesh = &hand.flesh;
    let before = (&hand.name, hand.side, &hand.bones, &hand.joints);
    let before = postcard::to_stdvec(&(before, &flesh.nodes, &flesh.tets, &flesh.materials));
    let mut bytes = bytes_of(hand);
    assert_eq!(bytes.remove(32 + before.unwrap().len()), 0);
    assert_eq!(bytes[bytes.len() - 5..], [0; 5]);
    let mut old = resealed(&bytes[..bytes.len() - 5]);
    old[8] = 2;
    old
}

/// Version 1 ended before the solids, version 2 after them; neither had memory, nor nodes in bone.
#[test]
fn hands_of_earlier_versions_lack_what_came_later() {
    for (version, solids) in [(1, 0), (2, 2)] {
        let solids = tiny_hand().solids[..solids].to_vec();
        let (bone_nodes, nail_nodes, regions) = (Vec::new(), Vec::new(), Vec::new());
        let bending = Vec::new();
        let hand = HandModel { solids, bone_nodes, nail_nodes, regions, bending, ..tiny_hand() };
        let mut old = of_version_2(&hand);
        if version == 1 {
            old = resealed(&old[..old.len() - 1]);
        }
        old[8] = version;
        let Model::Hand(back) = Model::from_bytes(&old).unwrap() else { panic!("not a hand") };
        assert_eq!(back.solids, hand.solids);
        assert!(back.bone_nodes.is_empty() && back.coupling == CouplingKind::Uniform);
        assert!(back.flesh.relaxation.is_empty());
        assert_eq!(bytes_of(&back), bytes_of(&hand));
        old[8] = 6;
        let error = Model::from_bytes(&old).unwrap_err().to_string();
        assert!(error.contains("version 6"), "{error}");
    }
}

/// Version 3 ended before the regions.
#[test]
fn hands_of_version_3_have_no_nails() {
    let (nail_nodes, regions, bending) = (Vec::new(), Vec::new(), Vec::new());
    let hand = HandModel { nail_nodes, regions, bending, ..tiny_hand() };
    let bytes = bytes_of(&hand);
    let mut old = resealed(&bytes[..bytes.len() - 3]);
    old[8] = 3;
    let Model::Hand(back) = Model::from_bytes(&old).unwrap() else { panic!("not a hand") };
    assert!(back.nail_nodes.is_empty() && back.regions.is_empty());
    assert_eq!(back.bone_nodes, hand.bone_nodes);
    assert_eq!(bytes_of(&back), bytes);
}

/// Version 4 ended before what the flesh resists.
#[test]
fn hands_of_version_4_do_not_know_what_their_flesh_resists() {
    let hand = HandModel { bending: Vec::new(), ..tiny_hand() };
    let bytes = bytes_of(&hand);
    let mut old = resealed(&bytes[..bytes.len() - 1]);
    old[8] = 4;
    let Model::Hand(back) = Model::from_bytes(&old).unwrap() else { panic!("not a hand") };
    assert!(back.bending.is_empty());
    assert_eq!(bytes_of(&back), bytes);
}

#[test]
fn laws_and_memory_come_back_and_are_checked() {
    let mut hand = tiny_hand();
    hand.flesh.materials[0].law = Law::Ogden { alpha: 8.5 };
    hand.flesh.relaxation = vec![Relaxation::new(&[[0.3, 0.01], [0.2, 1.4]]).unwrap()];
    let Model::Hand(back) = Model::from_bytes(&bytes_of(&hand)).unwrap() else {
        panic!("not a hand")
    };
    assert_eq!(back.flesh.relaxation, hand.flesh.relaxation);
    assert_eq!(back.flesh.materials, hand.flesh.materials);
    hand.flesh.relaxation.push(Relaxation::NONE);
    let error = Model::Hand(hand.clone()).to_bytes().unwrap_err().to_string();
    assert!(error.contains("2 relaxations for 1 tetrahedra"), "{error}");
    hand.flesh.relaxation.pop();
    hand.flesh.materials[0].law = Law::Ogden { alpha: 2.0 };
    let error = Model::Hand(hand).to_bytes().unwrap_err().to_string();
    assert!(error.contains("Ogden's exponent 2 is not valid"), "{error}");
}
