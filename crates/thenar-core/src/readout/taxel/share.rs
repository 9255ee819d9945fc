//! Shares of a contact: the nearest taxels get some that sum to one and are continuous in the
//! contact's place.
//!
//! With the distances d₀ ≤ d₁ ≤ … and R that of the first taxel which gets nothing, the weights are
//! `((R - d) / (R d))²` (Franke and Little's form of Shepard's interpolation), divided by their
//! sum. A taxel that comes to be among the nearest, or leaves them, has weight zero then.

use crate::math::Vec3;

/// Most taxels that share one contact.
pub const SHARED: usize = 4;

/// Shares a contact at `place` among `taxels`; returns how many entries of `out` hold a taxel and
/// its share. `None` when there is no taxel within `reach`.
pub fn share(
    place: &Vec3,
    taxels: &[(u32, Vec3)],
    reach: f64,
    out: &mut [(u32, f64); SHARED],
) -> Option<usize> {
    let mut nearest = [(0, f64::INFINITY); SHARED + 1];
    for (taxel, at) in taxels {
        insert(&mut nearest, (*taxel, (at - place).norm()));
    }
    let (first, radius) = (nearest[0].1, nearest[SHARED].1);
    if first > reach || first.is_infinite() {
        return None;
    }
    let count = taxels.len().min(SHARED);
    // Divided by d₀, so that nothing overflows where a taxel is met; of two at one place the first
    // has all.
    let weight = |k: usize, d: f64| match (k, d > 0.0) {
        (0, false) => 1.0,
        (_, false) => 0.0,
        (_, true) => (first / d - first / radius).powi(2),
    };
    for (k, (taxel, d)) in nearest[..count].iter().enumerate() {
        out[k] = (*taxel, weight(k, *d));
    }
    let sum: f64 = out[..count].iter().map(|(_, w)| w).sum();
    // All are as far as the one that gets nothing: the first has all.
    if sum <= 0.0 {
        out[0].1 = 1.0;
        return Some(1);
    }
    out[..count].iter_mut().for_each(|(_, w)| *w /= sum);
    Some(count)
}

/// Keeps a list of the nearest sorted; of two at the same distance the one that came first stays
/// ahead.
fn insert(nearest: &mut [(u32, f64)], new: (u32, f64)) {
    let Some(at) = nearest.iter().position(|known| new.1 < known.1) else { return };
    nearest[at..].rotate_right(1);
    nearest[at] = new;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn weights(place: &Vec3, taxels: &[(u32, Vec3)]) -> Vec<f64> {
        let mut out = [(0, 0.0); SHARED];
        let count = share(place, taxels, f64::INFINITY, &mut out).expect("a taxel");
        let mut all = vec![0.0; taxels.len()];
        out[..count].iter().for_each(|(taxel, w)| all[*taxel as usize] += w);
        all
    }

    #[test]
    fn shares_sum_to_one_wherever_taxels_are() {
        let mut noise = Random::new(11);
        for count in 1..40_u32 {
            let taxels: Vec<_> = (0..count).map(|k| (k, noise.vector(1.0))).collect();
            for _ in 0..50 {
                let shares = weights(&noise.vector(1.0), &taxels);
                assert!(
                    (shares.iter().sum::<f64>() - 1.0).abs() < 1e-15
                        && shares.iter().all(|w| *w >= 0.0)
                );
                assert!(shares.iter().filter(|w| **w > 0.0).count() <= SHARED);
            }
            // On a taxel, and hardly beside it.
            for (k, at) in &taxels {
                assert_eq!(weights(at, &taxels)[*k as usize], 1.0);
                let beside = at + Vec3::x() * 1e-12;
                assert!(weights(&beside, &taxels)[*k as usize] > 1.0 - 1e-9);
            }
        }
    }

    #[test]
    fn taxels_at_one_place_and_at_one_distance_share_too() {
        let same: Vec<_> = (0..9).map(|k| (k, Vec3::y())).collect();
        assert_eq!(weights(&Vec3::y(), &same)[0], 1.0);
        assert_eq!(weights(&Vec3::zeros(), &same).iter().sum::<f64>(), 1.0);
        let two = [(0, -Vec3::x()), (1, Vec3::x())];
        assert_eq!(weights(&Vec3::zeros(), &two), [0.5, 0.5]);
    }

    /// By the formula of the head, worked out by hand for five taxels on a line.
    #[test]
    fn shares_are_those_of_the_formula() {
        let line: Vec<_> = (0..5).map(|k| (k, Vec3::x() * f64::from(k))).collect();
        // From 0.5 short of the first: d = 0.5, 1.5, 2.5, 3.5, and R = 4.5.
        let d = [0.5, 1.5, 2.5, 3.5].map(|d: f64| ((4.5 - d) / (4.5 * d)).powi(2));
        let sum: f64 = d.iter().sum();
        let shares = weights(&(Vec3::x() * -0.5), &line);
        for (got, want) in shares.iter().zip(d) {
            assert!((got - want / sum).abs() < 1e-15);
        }
        assert_eq!(shares[4], 0.0);
    }

    #[test]
    fn shares_are_continuous_where_neighbours_change() {
        let mut noise = Random::new(5);
        let taxels: Vec<_> = (0..30).map(|k| (k, noise.vector(1.0))).collect();
        let step = Vec3::new(1e-7, 0.5e-7, -1e-7);
        let mut place = noise.vector(1.0);
        let mut before = weights(&place, &taxels);
        for k in 0..20_000 {
            // In strides, and a small step after each.
            place += step * if k % 2 == 0 { 500.0 } else { 1.0 };
            let now = weights(&place, &taxels);
            if k % 2 == 1 {
                let most = before.iter().zip(&now).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(most < 1e-4, "{most} at {place}");
            }
            before = now;
        }
    }

    #[test]
    fn nothing_is_shared_beyond_reach() {
        let taxels = [(0, Vec3::zeros())];
        let mut out = [(0, 0.0); SHARED];
        assert_eq!(share(&Vec3::x(), &taxels, 0.99, &mut out), None);
        assert_eq!(share(&Vec3::x(), &taxels, 1.0, &mut out), Some(1));
        assert_eq!(share(&Vec3::x(), &[], f64::INFINITY, &mut out), None);
    }
}
