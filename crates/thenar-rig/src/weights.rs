//! Skinning weights of flesh nodes (Eq. 6): at most two adjacent bones per node.
//!
//! Around each joint the weight passes from the parent to the child over a smooth ramp across the
//! joint; ramps of neighbouring joints do not overlap, so no node needs a third bone. Where a node
//! could follow several digits (the webs), the nearest takes it, with a weight that fades towards
//! the place where another takes over.

use thenar_core::Vec3;
use thenar_core::model::Binding;

/// Three moving bones in a row, hanging on a root bone.
#[derive(Clone, Debug)]
pub struct Chain {
    /// The root bone and the three moving bones.
    pub bones: [u32; 4],
    /// Places of the three joints \[m\].
    pub joints: [Vec3; 3],
    /// Unit direction across each joint, from parent to child.
    pub across: [Vec3; 3],
    /// Half width of each joint's ramp \[m\].
    pub half_widths: [f64; 3],
}

/// Position of a point across joint `k`: 0 at the start of its ramp, 1 at the end.
fn across(chain: &Chain, k: usize, p: &Vec3) -> f64 {
    0.5 + 0.5 * chain.across[k].dot(&(p - chain.joints[k])) / chain.half_widths[k]
}

/// From 0 to 1, straight in the middle and rounded at both ends: the slope, which decides how much
/// flesh is crushed inside a bent joint, is little more than a straight ramp's.
fn ramp(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    if t < ROUND {
        SLOPE * t * t / (2.0 * ROUND)
    } else if t > 1.0 - ROUND {
        1.0 - SLOPE * (1.0 - t) * (1.0 - t) / (2.0 * ROUND)
    } else {
        SLOPE * (t - ROUND / 2.0)
    }
}

/// Part of the ramp that is rounded, at either end.
const ROUND: f64 = 0.2;
/// Slope of the straight part.
const SLOPE: f64 = 1.0 / (1.0 - ROUND);

/// The binding of a point that follows `chain`. `hold` in 0..1 says how firmly: from 0 to ½ the
/// first moving bone takes the point over from the root, from ½ to 1 the later bones join. So a
/// point on the way from the chain's flesh to the root's never needs three bones.
pub fn bind(chain: &Chain, p: &Vec3, hold: f64) -> Binding {
    let [root, a, b, c] = chain.bones;
    let first = ramp(across(chain, 0, p)) * (2.0 * hold).min(1.0);
    let later = (2.0 * hold - 1.0).clamp(0.0, 1.0);
    let second = ramp(across(chain, 1, p)) * later;
    let third = ramp(across(chain, 2, p));
    if second <= 0.0 {
        pair(root, a, first)
    } else if second < 1.0 {
        pair(a, b, second)
    } else {
        pair(b, c, third)
    }
}

/// Weight `w` on bone `b`, the rest on bone `a`.
pub fn pair(a: u32, b: u32, w: f64) -> Binding {
    if w <= 0.0 {
        Binding { bones: [a, a], weights: [1.0, 0.0] }
    } else if w >= 1.0 {
        Binding { bones: [b, b], weights: [1.0, 0.0] }
    } else {
        Binding { bones: [a, b], weights: [1.0 - w, w] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_is_smooth_and_symmetric() {
        let n = 997;
        for i in 0..=n {
            let t = f64::from(i) / f64::from(n);
            assert!((ramp(t) + ramp(1.0 - t) - 1.0).abs() < 1e-12);
            let slope = (ramp(t + 1e-4) - ramp(t - 1e-4)) / 2e-4;
            assert!((0.0..SLOPE + 1e-9).contains(&slope), "slope {slope} at {t}");
        }
    }
}
