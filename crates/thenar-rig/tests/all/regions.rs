//! Goal: pads, nails, palm and back of a hand lie where they should. Method: the directions and
//! areas of their skin in the frames of their bones, in both hands and at another size.

use thenar_core::Vec3;
use thenar_core::model::{CouplingKind, Digit, HandModel, HandRegion, Side};
use thenar_rig::hand::{HandOptions, Size, asset, build_hand};

fn hand(side: Side, length: f64) -> HandModel {
    let options = HandOptions { size: Size::Length(length), ..HandOptions::touch() };
    build_hand(asset(side), &options).unwrap()
}

/// Area [m²] and mean unit normal of the triangles of a region, of one digit.
fn skin(hand: &HandModel, region: HandRegion, digit: Digit) -> (f64, Vec3) {
    let surface = &hand.flesh.collision;
    let mut x = vec![Vec3::zeros(); surface.vertices.len()];
    surface.positions(&hand.flesh.tets, &hand.flesh.nodes, &mut x);
    let mut sum = (0.0, Vec3::zeros());
    for (t, own) in surface.triangles.iter().zip(&hand.regions) {
        let [a, b, c] = t.map(|v| x[v as usize]);
        if *own == region && hand.collision_digits[t[0] as usize] == digit {
            let area = (b - a).cross(&(c - a)) * 0.5;
            sum = (sum.0 + area.norm(), sum.1 + area);
        }
    }
    (sum.0, sum.1 / sum.0)
}

#[test]
fn regions_lie_on_their_sides() {
    for (side, length) in [(Side::Right, 0.19), (Side::Left, 0.165)] {
        let hand = hand(side, length);
        let unit = (length / 0.19).powi(2);
        assert_eq!(hand.regions.len(), hand.flesh.collision.triangles.len());
        for digit in Digit::FINGERS {
            let last = hand.bones.iter().rposition(|bone| bone.digit == digit).unwrap();
            let back = hand.bones[last].pose_MB.vector(&Vec3::y());
            // A nail of 9 to 13 mm each way lies on the back.
            let (area, normal) = skin(&hand, HandRegion::Nail, digit);
            assert!((50e-6..260e-6).contains(&(area / unit)), "{digit:?}: {area} m² of nail");
            assert!(normal.dot(&back) > 0.5, "{digit:?}: nails face {normal:?}");
            let (area, normal) = skin(&hand, HandRegion::Pad, digit);
            assert!((200e-6..1200e-6).contains(&(area / unit)), "{digit:?}: {area} m² of pad");
            assert!(normal.dot(&back) < -0.4, "{digit:?}: pads face {normal:?}");
        }
        for (region, sign) in [(HandRegion::Back, 1.0), (HandRegion::Palm, -1.0)] {
            let (area, normal) = skin(&hand, region, Digit::Palm);
            assert!((4e-3..20e-3).contains(&(area / unit)), "{area} m² of {region:?}");
            assert!(sign * normal.y > 0.4, "{region:?} faces {normal:?}");
        }
    }
}

/// Nails have one node at least, move with the last bones alone, and stiffen what holds the flesh.
#[test]
fn nails_hang_on_the_last_bones() {
    let hand = hand(Side::Right, 0.19);
    for digit in Digit::FINGERS {
        let last = hand.bones.iter().rposition(|bone| bone.digit == digit).unwrap() as u32;
        let own = hand.nail_nodes.iter().filter(|n| n.binding.bones == [last; 2]);
        let volume: f64 = own.map(|n| n.volume).sum();
        let (area, _) = skin(&hand, HandRegion::Nail, digit);
        // 2.5 mm thick at most, and more than the plate itself.
        assert!(volume < 2.6e-3 * area && volume > 0.5e-3 * area, "{digit:?}: {volume} m³");
    }
    let [without, with] = [false, true].map(|nails| hand.held(CouplingKind::Bone, nails).1);
    let sum = |v: &[f64]| v.iter().sum::<f64>();
    let nails: f64 = hand.nail_nodes.iter().map(|n| n.volume).sum();
    assert!((sum(&with) - sum(&without) - nails).abs() < 1e-15);
    assert_eq!(hand.held(CouplingKind::Uniform, true).1, hand.held(CouplingKind::Uniform, false).1);
}
