//! Durations in buckets that grow by 0.5 %, so that memory does not grow with the run.

/// Buckets per doubling.
const PER_OCTAVE: f64 = 128.0;
/// Up to 2⁴⁰ ns, 18 minutes.
const OCTAVES: usize = 40;

/// A histogram of durations.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Vec<u64>,
    count: u64,
    max_ns: u64,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { counts: vec![0; OCTAVES * PER_OCTAVE as usize], count: 0, max_ns: 0 }
    }
}

impl Histogram {
    /// Adds a duration \[ns\].
    pub fn add(&mut self, ns: u64) {
        let bucket = ((ns.max(1) as f64).log2() * PER_OCTAVE) as usize;
        let last = self.counts.len() - 1;
        self.counts[bucket.min(last)] += 1;
        self.count += 1;
        self.max_ns = self.max_ns.max(ns);
    }

    /// The duration \[s\] that this part of all durations does not exceed, to 0.5 %.
    pub fn quantile(&self, part: f64) -> f64 {
        let wanted = (part * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (bucket, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                let middle = ((bucket as f64 + 0.5) / PER_OCTAVE).exp2();
                return middle.min(self.max_ns as f64) * 1e-9;
            }
        }
        0.0
    }

    /// The longest duration \[s\].
    pub fn max(&self) -> f64 {
        self.max_ns as f64 * 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_half_a_percent() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.quantile(0.5), histogram.max()), (0.0, 0.0));
        (1..=10_000).for_each(|k| histogram.add(k * 1000));
        for part in [0.01, 0.5, 0.99] {
            let exact = part * 10_000.0 * 1e-6;
            assert!((histogram.quantile(part) / exact - 1.0).abs() < 0.006, "{part}");
        }
        assert_eq!(histogram.max(), 0.01);
        assert!(histogram.quantile(1.0) <= histogram.max());
        histogram.add(u64::MAX);
        assert!(histogram.quantile(1.0).is_finite());
    }
}
