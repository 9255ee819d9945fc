//! Times, counted in fixed bins: nothing grows, however long a session.

/// A factor of two has 2^BITS bins: 256, each 0.4 % wide at most.
const BITS: u32 = 8;
const PER_OCTAVE: u32 = 1 << BITS;
/// Up to 2^41 ns, 37 minutes: below 2^BITS ns each time has a bin.
const OCTAVES: u32 = 34;

/// Counts of times \[ns\].
#[derive(Clone, Debug)]
pub struct Histogram {
    bins: Vec<u64>,
    count: u64,
    max: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { bins: vec![0; (OCTAVES * PER_OCTAVE) as usize], count: 0, max: 0 }
    }
}

impl Histogram {
    /// Counts one.
    pub fn add(&mut self, ns: u64) {
        let bin = bin(ns).min(self.bins.len() - 1);
        self.bins[bin] += 1;
        self.count += 1;
        self.max = self.max.max(ns);
    }

    /// Returns the number of values counted.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The largest \[ns\].
    pub fn max(&self) -> u64 {
        self.max
    }

    /// The time that a part `q` of all does not exceed \[ns\], rounded up to the end of its bin; 0
    /// when there are none.
    pub fn quantile(&self, q: f64) -> u64 {
        let rank = (q.clamp(0.0, 1.0) * self.count as f64).ceil().max(1.0) as u64;
        let mut sum = 0;
        for (i, n) in self.bins.iter().enumerate() {
            sum += n;
            if sum >= rank {
                // Beyond the last bin's end there is no bound but the largest.
                let last = i + 1 == self.bins.len();
                return if last { self.max } else { end(i).min(self.max) };
            }
        }
        self.max
    }

    /// Bins with something in them: where each ends \[ns\] and how many.
    pub fn bins(&self) -> impl Iterator<Item = (u64, u64)> {
        self.bins.iter().enumerate().filter(|(_, n)| **n > 0).map(|(i, n)| (end(i), *n))
    }
}

/// The bin of a time: by its octave and the bits below the leading one.
fn bin(ns: u64) -> usize {
    if ns < u64::from(PER_OCTAVE) {
        return ns as usize;
    }
    let octave = ns.ilog2();
    let within = (ns >> (octave - BITS)) % u64::from(PER_OCTAVE);
    ((octave - BITS + 1) * PER_OCTAVE) as usize + within as usize
}

/// The largest time of a bin.
fn end(bin: usize) -> u64 {
    let (bin, per_octave) = (bin as u64, u64::from(PER_OCTAVE));
    if bin < per_octave {
        return bin;
    }
    let shift = bin / per_octave - 1;
    ((per_octave + bin % per_octave + 1) << shift) - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_time_falls_into_the_bin_that_ends_just_above_it() {
        for ns in (0..5000).chain([1 << 20, (1 << 20) + 1, 999_999_999, (1 << 41) - 1]) {
            let i = bin(ns);
            assert!(i < Histogram::default().bins.len() && ns <= end(i), "{ns}");
            assert!(i == 0 || ns > end(i - 1), "{ns}");
            assert!(end(i) as f64 <= ns as f64 * 1.004, "{ns}");
        }
    }

    #[test]
    fn quantiles_are_those_of_the_times() {
        let mut histogram = Histogram::default();
        assert_eq!(histogram.quantile(0.5), 0);
        (1..=1000).for_each(|k| histogram.add(k * 1000));
        for (q, want) in [(0.5, 500e3), (0.99, 990e3), (0.999, 999e3), (0.001, 1e3)] {
            let got = histogram.quantile(q) as f64;
            assert!(got >= want && got <= want * 1.004, "{q}: {got}");
        }
        assert_eq!((histogram.quantile(1.0), histogram.max()), (1_000_000, 1_000_000));
        histogram.add(u64::MAX);
        assert_eq!((histogram.quantile(1.0), histogram.max()), (u64::MAX, u64::MAX));
    }
}
