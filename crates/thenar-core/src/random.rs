//! Random numbers that are the same everywhere (SplitMix64, Steele et al. 2014).

/// A series of random numbers.
#[derive(Clone, Copy, Debug)]
pub struct Random {
    state: u64,
}

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
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

    /// The next whole number below `n`; 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() >> 33) as usize % n.max(1)
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
