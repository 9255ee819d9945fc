//! Goal: what a mesh costs is bounded, and told before and while it is spent, whatever the mesh.
//! Method: meshes that are made to cost much; what is counted is the work that stages announce, in
//! comparisons of a point with a triangle (`STAGE_MAX` of a stage takes about half a minute), not
//! time.

use std::cell::RefCell;
use std::rc::Rc;
use thenar_core::Vec3;
use thenar_core::model::{Law, Material, Side};
use thenar_core::random::Random;
use thenar_rig::embed::{EmbedOptions, embed};
use thenar_rig::export::{GlbMesh, Skeleton, VertexSkin, glb};
use thenar_rig::hand::asset;
use thenar_rig::mesh::{read_obj, shapes};
use thenar_rig::object::{ImportOptions, Weight, rigid_from_mesh};
use thenar_rig::work::{Progress, STAGE_MAX, watched};
use thenar_rig::{HandOptions, TriMesh, build_hand};

/// The result of `build`, and the work of all its stages together.
fn cost<T>(build: impl FnOnce() -> T) -> (T, f64) {
    let stages: Rc<RefCell<Vec<Progress>>> = Rc::default();
    let heard = Rc::clone(&stages);
    let watch = move |progress: Progress| {
        heard.borrow_mut().push(progress);
        true
    };
    let made = watched(watch, build);
    let begun = stages.borrow().iter().filter(|p| p.done == 0.0).map(|p| p.work).sum();
    (made, begun)
}

fn rigid(mesh: &TriMesh) -> (Result<(), String>, f64) {
    let options = ImportOptions::default();
    let build = || rigid_from_mesh("x", mesh, Weight::Mass(1.0), &options).map(|_| ());
    let (made, work) = cost(build);
    (made.map_err(|e| e.to_string()), work)
}

fn soft(mesh: &TriMesh) -> (Result<(), String>, f64) {
    let gel = Material { law: Law::Corotational, young: 1e5, poisson: 0.3, density: 1000.0 };
    let (made, work) = cost(|| embed(mesh, &EmbedOptions::default(), |_| gel).map(|_| ()));
    (made.map_err(|e| e.to_string()), work)
}

/// The shipped hand's joints in another skin.
fn hand(skin: &TriMesh) -> (Result<(), String>, f64) {
    let rig = thenar_rig::glb::read_skinned_glb(asset(Side::Right)).unwrap();
    let skeleton = Skeleton {
        names: rig.joints.iter().map(|joint| joint.name.as_str()).collect(),
        parents: rig.joints.iter().map(|_| None).collect(),
        poses: rig.joints.iter().map(|joint| joint.pose).collect(),
    };
    let wrist = VertexSkin { bones: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    let surface = GlbMesh {
        name: "skin",
        positions: &skin.positions,
        triangles: &skin.triangles,
        colour: [0.5; 3],
        skin: Some(&vec![wrist; skin.positions.len()]),
    };
    let bytes = glb(&[surface], Some(&skeleton)).unwrap();
    let (made, work) = cost(|| build_hand(&bytes, &HandOptions::paper()).map(|_| ()));
    (made.map_err(|e| e.to_string()), work)
}

/// A sphere whose corners lie anywhere in the box around the shipped hand: closed, in one part, and
/// all of its triangles lie in each other's way.
fn crumpled(fineness: usize) -> TriMesh {
    let rig = thenar_rig::glb::read_skinned_glb(asset(Side::Right)).unwrap();
    let [low, high] = rig.mesh.bounds();
    let mut random = Random::new(0x5eed_0000_0000_0008);
    let mut mesh = shapes::sphere(0.1, fineness as u32);
    for p in &mut mesh.positions {
        *p = Vec3::from_fn(|k, _| low[k] + (high[k] - low[k]) * random.unit());
    }
    mesh
}

#[test]
fn a_hand_of_overlapping_triangles_costs_no_more_than_a_stage() {
    for (fineness, bound) in [(8, 0.1 * STAGE_MAX), (16, 0.2 * STAGE_MAX)] {
        let mesh = crumpled(fineness);
        let (made, work) = hand(&mesh);
        assert!(made.is_err(), "{made:?}");
        assert!(work < bound, "{} triangles: {work:e}", mesh.triangles.len());
    }
}

/// A hundred thousand triangles of 5 mm that hang together nowhere.
#[test]
fn a_thicket_is_refused_or_costs_no_more_than_a_stage() {
    let mut random = Random::new(0x5eed_0000_0000_0009);
    let mut below = |size: f64| Vec3::from_fn(|_, _| size * random.unit());
    let mut mesh = TriMesh::default();
    for t in 0..100_000 {
        let place = below(0.5);
        mesh.positions.extend([place + below(5e-3), place + below(5e-3), place + below(5e-3)]);
        mesh.triangles.push([3 * t, 3 * t + 1, 3 * t + 2]);
    }
    let (made, work) = soft(&mesh);
    assert!(made.unwrap_err().contains("not closed"));
    assert_eq!(work, 0.0);
    let (made, work) = rigid(&mesh);
    assert!(work < STAGE_MAX && (made.is_ok() || work == 0.0), "{work:e} {made:?}");
}

/// A disc of two polygons of 4000 corners each; cut into triangles they are long and thin.
#[test]
fn a_polygon_of_four_thousand_corners_costs_little() {
    let (n, mut text) = (4000, String::new());
    for y in [0.0, 0.02] {
        for k in 0..n {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(n)).sin_cos();
            text += &format!("v {} {y} {}\n", 0.1 * cos, 0.1 * sin);
        }
    }
    let corners = |numbers: &mut dyn Iterator<Item = u32>| {
        numbers.map(|k| k.to_string()).collect::<Vec<_>>().join(" ")
    };
    let n = n as u32;
    text += &format!("f {}\nf {}\n", corners(&mut (1..=n)), corners(&mut (n + 1..=2 * n).rev()));
    for k in 0..n {
        let (a, b) = (k + 1, (k + 1) % n + 1);
        text += &format!("f {b} {a} {} {}\n", a + n, b + n);
    }
    let mesh = read_obj(text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles.len(), 2 * (4000 - 2) + 2 * 4000);
    for (made, work) in [rigid(&mesh), soft(&mesh)] {
        made.unwrap();
        assert!(work < 0.1 * STAGE_MAX, "{work:e}");
    }
}
