//! Skinning weights of flesh nodes (Eq. 6): at most two adjacent bones per node.
//!
//! Around each joint the weight passes from the parent to the child over a smooth ramp across the
//! joint; ramps of neighbouring joints do not overlap, so no node needs a third bone. Where a node
//! could follow several digits (the webs), the nearest takes it, with a weight that fades towards
//! the place where another takes over.

use thenar::Vec3;
use thenar::model::Binding;

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

/// How far along a chain a point has got: weight of the child at each joint, 0..1.
fn passed(chain: &Chain, p: &Vec3) -> [f64; 3] {
    std::array::from_fn(|k| {
        let along = chain.across[k].dot(&(p - chain.joints[k]));
        ramp(0.5 + 0.5 * along / chain.half_widths[k])
    })
}

/// From 0 to 1, straight in the middle and rounded at both ends: the slope, which decides how much
/// flesh is crushed inside a bent joint, is only 4/3 of a straight ramp's.
fn ramp(t: f64) -> f64 {
    const ROUND: f64 = 0.25;
    let t = t.clamp(0.0, 1.0);
    let slope = 1.0 / (1.0 - ROUND);
    if t < ROUND {
        slope * t * t / (2.0 * ROUND)
    } else if t > 1.0 - ROUND {
        1.0 - slope * (1.0 - t) * (1.0 - t) / (2.0 * ROUND)
    } else {
        slope * (t - ROUND / 2.0)
    }
}

/// The binding of a point that follows `chain`; `hold` in 0..1 scales how much of it the first
/// moving bone may take from the root.
pub fn bind(chain: &Chain, p: &Vec3, hold: f64) -> Binding {
    let [first, second, third] = passed(chain, p);
    // Beyond the first joint's ramp the root has no part, so the later joints may take over.
    let first = first * if second > 0.0 { hold.max(second.min(1.0)) } else { hold };
    let [root, a, b, c] = chain.bones;
    if first < 1.0 {
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
        let n = 1000;
        for i in 0..=n {
            let t = f64::from(i) / f64::from(n);
            assert!((ramp(t) + ramp(1.0 - t) - 1.0).abs() < 1e-12);
            let slope = (ramp(t + 1e-4) - ramp(t - 1e-4)) / 2e-4;
            assert!((0.0..1.3334).contains(&slope), "slope {slope} at {t}");
        }
    }
}
