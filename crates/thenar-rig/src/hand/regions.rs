//! Regions of the body that belong to each digit.
//!
//! Near its root a finger is one body with its neighbours (the web); only beyond that is it a
//! finger of its own. Inside points are first given to the digit whose bone is nearest; then, along
//! each finger, everything up to the last place where it touches another finger is the palm's.

use super::digits::DigitRig;
use crate::lattice::Lattice;
use thenar_core::Vec3;
use thenar_core::model::Digit;

/// Digit of every inside point of the lattice. No two linked points belong to different fingers.
pub(super) fn digits_of_samples(lattice: &Lattice, digits: &[DigitRig]) -> Vec<Digit> {
    let nearest: Vec<Digit> =
        (0..lattice.sample_count()).map(|i| nearest(&lattice.sample_position(i), digits)).collect();

    let along = |i: u32| {
        let rig = rig_of(digits, nearest[i as usize])?;
        Some(rig.direction(0).dot(&(lattice.sample_position(i as usize) - rig.joints[0].position)))
    };
    let mut web = [f64::NEG_INFINITY; 5];
    lattice.for_each_link(|i, j| {
        let (a, b) = (nearest[i as usize], nearest[j as usize]);
        if a == b || a == Digit::Palm || b == Digit::Palm {
            return;
        }
        for (i, digit) in [(i, a), (j, b)] {
            let (at, place) = (along(i), slot(digit));
            web[place] = web[place].max(at.unwrap_or(f64::NEG_INFINITY));
        }
    });

    let beyond = |i: usize| along(i as u32).is_some_and(|at| at > web[slot(nearest[i])].max(0.0));
    (0..nearest.len()).map(|i| if beyond(i) { nearest[i] } else { Digit::Palm }).collect()
}

/// Digit of every tetrahedron: a finger if all its points are that finger's, else the palm.
pub(super) fn digits_of_tets(lattice: &Lattice, samples: &[Digit]) -> Vec<Digit> {
    let mut digits: Vec<Option<Digit>> = vec![None; lattice.tets.len()];
    for (i, &digit) in samples.iter().enumerate() {
        let of_tet = &mut digits[lattice.sample_tet(i) as usize];
        *of_tet = match *of_tet {
            None => Some(digit),
            Some(other) if other == digit => Some(digit),
            Some(_) => Some(Digit::Palm),
        };
    }
    digits.into_iter().map(|d| d.unwrap_or(Digit::Palm)).collect()
}

/// The digit whose bones are nearest to a point.
pub(super) fn nearest(p: &Vec3, digits: &[DigitRig]) -> Digit {
    let (digit, distance) = digits
        .iter()
        .map(|rig| (rig.digit, digit_distance(p, rig)))
        .fold((Digit::Palm, f64::INFINITY), |best, d| if d.1 < best.1 { d } else { best });
    if palm_distance(p, digits) <= distance { Digit::Palm } else { digit }
}

/// Distance to the moving bones of a digit \[m\].
pub(super) fn digit_distance(p: &Vec3, rig: &DigitRig) -> f64 {
    (0..3).map(|k| segment_distance(p, &rig.bone(k))).fold(f64::INFINITY, f64::min)
}

/// Distance to moving bone `k` of a digit \[m\].
pub(super) fn bone_distance(p: &Vec3, rig: &DigitRig, k: usize) -> f64 {
    segment_distance(p, &rig.bone(k))
}

/// Distance to the metacarpals of the four fingers and the carpus between wrist and metacarpals.
pub(super) fn palm_distance(p: &Vec3, digits: &[DigitRig]) -> f64 {
    palm_rays(digits).map(|segment| segment_distance(p, &segment)).fold(f64::INFINITY, f64::min)
}

/// The metacarpals of the four fingers, and lines from the wrist to them.
pub(super) fn palm_rays(digits: &[DigitRig]) -> impl Iterator<Item = [Vec3; 2]> + '_ {
    digits[1..]
        .iter()
        .flat_map(|rig| [[rig.base, rig.joints[0].position], [Vec3::zeros(), rig.base]])
}

fn segment_distance(p: &Vec3, [a, b]: &[Vec3; 2]) -> f64 {
    let d = b - a;
    let t = ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
    (p - a - d * t).norm()
}

/// The point of a line nearest to a place.
pub(super) fn segment_point(p: &Vec3, [a, b]: &[Vec3; 2]) -> Vec3 {
    let d = b - a;
    a + d * ((p - a).dot(&d) / d.norm_squared()).clamp(0.0, 1.0)
}

fn rig_of(digits: &[DigitRig], digit: Digit) -> Option<&DigitRig> {
    digits.iter().find(|rig| rig.digit == digit)
}

/// Place of a finger in an array of five.
fn slot(digit: Digit) -> usize {
    Digit::FINGERS.iter().position(|&f| f == digit).unwrap_or(0)
}
