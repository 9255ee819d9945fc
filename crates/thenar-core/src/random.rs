//! Random numbers that are the same everywhere (SplitMix64, Steele et al. 2014).

use crate::math::{Pose, Quat, Vec3};

/// A series of random numbers.
#[derive(Clone, Copy, Debug)]
pub struct Random {
    state: u64,
}

/// The golden ratio's fraction in 64 bits, made odd.
pub(crate) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Spreads 64 bits, one to one.
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Numbers from -1 to 1, evenly.
fn to_symmetric(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

impl Random {
    /// The series of a seed.
    pub fn new(seed: u64) -> Self {
        Self { state: mix(seed.wrapping_add(GOLDEN)) }
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN);
        mix(self.state)
    }

    /// The next number, from -1 to 1.
    pub fn symmetric(&mut self) -> f64 {
        to_symmetric(self.bits())
    }

    /// The next number, from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        0.5 * (self.symmetric() + 1.0)
    }

    /// The next number of a series of mean 0 and deviation 1, nearly normal: the sum of twelve even
    /// numbers, each of variance 1/3, halved.
    pub fn normal(&mut self) -> f64 {
        0.5 * (0..12).map(|_| self.symmetric()).sum::<f64>()
    }

    /// The next whole number below `n`; 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() >> 33) as usize % n.max(1)
    }

    /// The next number from `a` to `b`.
    pub fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// The next vector from the cube with edges of `2 reach` about the origin.
    pub fn vector(&mut self, reach: f64) -> Vec3 {
        Vec3::new(self.symmetric(), self.symmetric(), self.symmetric()) * reach
    }

    /// The next turn, by up to `angle` \[rad\] about any axis.
    pub fn rotation(&mut self, angle: f64) -> Quat {
        let axis = self.vector(1.0).normalize();
        Quat::from_scaled_axis(axis * self.range(-angle, angle))
    }

    /// The next pose: a place in the cube with edges of `2 reach` about the origin, turned anyhow.
    pub fn pose(&mut self, reach: f64) -> Pose {
        Pose::new(self.vector(reach), Quat::from_scaled_axis(self.vector(2.0)))
    }
}

/// The number from -1 to 1 that belongs to these keys.
pub fn random_at(keys: [u64; 4]) -> f64 {
    to_symmetric(keys.iter().fold(GOLDEN, |h, k| mix(h.wrapping_add(GOLDEN) ^ mix(k ^ GOLDEN))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_even_from_minus_one_to_one() {
        let mut random = Random::new(7);
        let series: Vec<f64> = (0..20_000).map(|_| random.symmetric()).collect();
        let keyed: Vec<f64> = (0..20_000).map(|k| random_at([1, 2, 3, k])).collect();
        for numbers in [series, keyed] {
            let n = numbers.len() as f64;
            let mean = numbers.iter().sum::<f64>() / n;
            let square = numbers.iter().map(|x| x * x).sum::<f64>() / n;
            let neighbours = numbers.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
            assert!(numbers.iter().all(|x| (-1.0..1.0).contains(x)));
            assert!(mean.abs() < 0.02 && (square - 1.0 / 3.0).abs() < 0.02, "{mean} {square}");
            assert!(neighbours.abs() < 0.02, "{neighbours}");
        }
        assert_ne!(random_at([1, 2, 3, 4]), random_at([1, 2, 4, 3]));
    }

    #[test]
    fn vectors_turns_and_ranges_keep_to_their_bounds() {
        let mut random = Random::new(5);
        let (mut sum, mut square) = (0.0, 0.0);
        for _ in 0..20_000 {
            assert!((-3.0..2.0).contains(&random.range(-3.0, 2.0)));
            assert!(random.vector(0.5).amax() <= 0.5);
            assert!(random.rotation(0.3).angle() < 0.3 + 1e-12);
            assert!(random.pose(0.5).position.amax() <= 0.5);
            let x = random.normal();
            (sum, square) = (sum + x, square + x * x);
        }
        // Five standard deviations: of the mean 1 / √n = 0.0071, of the square √(2 / n) = 0.01.
        assert!((sum / 2e4).abs() < 0.036 && (square / 2e4 - 1.0).abs() < 0.05, "{sum} {square}");
    }

    /// Values of SplitMix64 that are published for the state 1234567.
    #[test]
    fn bits_are_those_of_splitmix() {
        let mut random = Random { state: 1_234_567 };
        let bits = [0; 3].map(|_| random.bits());
        let published = [6457827717110365317, 3203168211198807973, 9817491932198370423];
        assert_eq!(bits, published);
    }

    #[test]
    fn parts_and_whole_numbers_are_even_too() {
        let mut random = Random::new(3);
        let mut counts = [0_i32; 7];
        let mut sum = 0.0;
        for _ in 0..70_000 {
            counts[random.below(7)] += 1;
            let part = random.unit();
            assert!((0.0..1.0).contains(&part));
            sum += part;
        }
        // Five standard deviations: of a count √(n p (1 - p)) = 93, of a mean √(1 / 12 n) = 0.0011.
        assert!(counts.iter().all(|n| (*n - 10_000).abs() < 465), "{counts:?}");
        assert!((sum / 7e4 - 0.5).abs() < 0.0055, "{sum}");
        assert_eq!((random.below(1), random.below(0)), (0, 0));
    }
}
