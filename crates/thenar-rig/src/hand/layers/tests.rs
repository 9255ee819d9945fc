use super::*;
use crate::hand::build::{Rigged, build_hand, rigged};
use crate::hand::{Springs, asset, grading};
use crate::mesh::subdivide_to;
use thenar_core::model::Side;

fn layer(region: Option<HandRegion>, depth: [f64; 2], young: f64, poisson: f64) -> Layer {
    Layer { region, depth, young: Some(young), poisson: Some(poisson), law: None }
}

/// A coarse hand for touch, as stiff over its joints as elsewhere.
fn options(layers: Vec<Layer>) -> HandOptions {
    HandOptions {
        layers,
        detail: Some(0.4),
        joint_softness: 1.0,
        root_softness: 1.0,
        springs: Springs::Fixed,
        render_triangles: 2000,
        ..HandOptions::touch()
    }
}

/// Each element has the mean of what lies at the inside points in it, found one by one without
/// bounds.
#[test]
fn an_element_has_the_mean_of_its_layers() {
    let layers = vec![
        layer(Some(HandRegion::Pad), [0.0, 1.5e-3], 1.2e5, 0.3),
        layer(Some(HandRegion::Pad), [1.5e-3, 4e-3], 2e4, 0.45),
        layer(Some(HandRegion::Back), [0.0, 3e-3], 8e4, 0.48),
        layer(Some(HandRegion::Palm), [2e-3, f64::INFINITY], 3e4, 0.47),
    ];
    let even = build_hand(asset(Side::Right), &options(Vec::new())).unwrap();
    let options = options(layers);
    let hand = build_hand(asset(Side::Right), &options).unwrap();
    assert_eq!(hand.flesh.tets, even.flesh.tets);

    let rig = crate::glb::read_skinned_glb(asset(Side::Right)).unwrap();
    let Rigged { skin, digits, length, .. } = rigged(&rig, &options).unwrap();
    let grading = grading::grading(length, 0.4).unwrap();
    let triangles = options
        .render_triangles
        .max(options.collision_triangles)
        .max(grading::triangles(skin.area(), &grading));
    let smooth = subdivide_to(&skin, triangles).unwrap().mesh;
    let edge = |p: &thenar_core::Vec3| grading::edge(p, &digits, length, &grading);
    let lattice = Lattice::graded(&smooth, &grading, edge).unwrap();
    assert_eq!(lattice.nodes, hand.flesh.nodes);
    let (body, sides) = (Bvh::new(&smooth), Sides::new(&digits, &Bvh::new(&skin)));
    // Sums of moduli, of their product with Poisson's ratio, and counts; points of each layer.
    let mut sums = vec![[0.0; 3]; lattice.tets.len()];
    let mut points = [0; 5];
    for i in 0..lattice.sample_count() {
        let p = lattice.sample_position(i);
        let (region, depth) = (sides.of(&p).0, body.closest(&p).distance);
        let (own, young, poisson) = match region {
            HandRegion::Pad if depth < 1.5e-3 => (0, 1.2e5, 0.3),
            HandRegion::Pad if depth < 4e-3 => (1, 2e4, 0.45),
            HandRegion::Back if depth < 3e-3 => (2, 8e4, 0.48),
            HandRegion::Palm if depth >= 2e-3 => (3, 3e4, 0.47),
            _ => (4, 5e4, 0.43),
        };
        points[own] += 1;
        let sum = &mut sums[lattice.sample_tet(i) as usize];
        *sum = [sum[0] + young, sum[1] + young * poisson, sum[2] + 1.0];
    }
    assert!(points.iter().all(|&n| n > 200), "{points:?}");
    let mut mixed = 0;
    for (t, (got, even)) in hand.flesh.materials.iter().zip(&even.flesh.materials).enumerate() {
        let [young, product, count] = sums[t];
        // What is filled in part is softer by as much.
        let want = young / count * even.young / 5e4;
        assert!((got.young / want - 1.0).abs() < 1e-12, "{t}: {} Pa, not {want}", got.young);
        assert!((got.poisson - product / young).abs() < 1e-12);
        assert!((got.density - even.density).abs() < 1e-9 * even.density);
        mixed += usize::from(young / count < 1e5 && young / count > 6e4);
    }
    assert!(mixed > 50, "{mixed} elements hold several layers");
}

/// The law is that of the stiffer part.
#[test]
fn an_element_has_the_law_of_the_larger_part() {
    let ogden = Law::Ogden { alpha: 8.0 };
    let pad =
        Layer { law: Some(ogden), ..layer(Some(HandRegion::Pad), [0.0, f64::INFINITY], 5e4, 0.43) };
    let hand = build_hand(asset(Side::Right), &options(vec![pad])).unwrap();
    let count = hand.flesh.materials.iter().filter(|m| m.law == ogden).count();
    let share = count as f64 / hand.flesh.materials.len() as f64;
    // Pads have a few parts in a hundred of the volume, and the finest elements.
    assert!((0.05..0.5).contains(&share), "{share}");
}

#[test]
fn layers_that_make_no_sense_are_refused() {
    let refused = |layers: Vec<Layer>, named: &str| {
        let error = build_hand(asset(Side::Right), &options(layers)).unwrap_err().to_string();
        assert!(error.contains(named), "{error}");
    };
    let any = |depth| layer(None, depth, 2e4, 0.4);
    refused(vec![any([1e-3, 1e-3])], "layer 1: its depth [0.001, 0.001] m must rise");
    refused(vec![any([2e-3, 1e-3])], "must rise");
    refused(vec![any([-1e-3, 1e-3])], "must rise from 0");
    refused(vec![any([f64::NAN, 1e-3])], "must rise");
    refused(vec![layer(None, [0.0, 1e-3], 0.0, 0.4)], "Young's modulus must be positive, not 0 Pa");
    refused(vec![layer(None, [0.0, 1e-3], 1e4, 0.5)], "Poisson's ratio must be above -1 and below");
    let negative =
        Layer { law: Some(Law::Ogden { alpha: 8.0 }), ..layer(None, [0.0, 1e-3], 1e4, -0.1) };
    refused(vec![negative], "from 0 (with Ogden's law)");
    refused(vec![any([0.0, 2e-3]), any([1e-3, 3e-3])], "layer 2: it overlaps layer 1");
    let pad = |depth| layer(Some(HandRegion::Pad), depth, 2e4, 0.4);
    refused(vec![pad([0.0, 2e-3]), any([1e-3, 3e-3])], "layer 2: it overlaps layer 1");
    refused(
        vec![pad([0.0, 0.05])],
        "layer 1: it reaches 50.0 mm under the skin, but the pad is thinner",
    );
    refused(vec![pad([0.02, f64::INFINITY])], "it reaches 20.0 mm under the skin");
    // Layers of different regions may share depths.
    let back = layer(Some(HandRegion::Back), [1e-3, 3e-3], 2e4, 0.4);
    assert!(build_hand(asset(Side::Right), &options(vec![pad([0.0, 2e-3]), back])).is_ok());
}
