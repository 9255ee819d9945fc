//! Lines of a chart, and how a long run becomes one.

/// Most points of a line over time: a panel is not wider in pixels.
const BUCKETS: usize = 400;

/// Style of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    /// In one stroke.
    Solid,
    /// In dashes.
    Dashed,
}

/// A line with its name in the legend.
#[derive(Clone, Debug)]
pub struct Line {
    /// Name; a line without one is not in the legend.
    pub name: String,
    /// Number of the colour, from 0; colours repeat after 7.
    pub colour: usize,
    /// Dash pattern of the stroke.
    pub dash: Dash,
    /// Points; a value that is not a number breaks the line.
    pub points: Vec<(f64, f64)>,
    /// Points drawn as dots.
    pub dots: Vec<(f64, f64)>,
    /// Points drawn as crosses.
    pub crosses: Vec<(f64, f64)>,
}

impl Line {
    /// A line without dots and crosses.
    pub fn new(
        name: impl Into<String>,
        colour: usize,
        dash: Dash,
        points: Vec<(f64, f64)>,
    ) -> Self {
        let (dots, crosses) = (Vec::new(), Vec::new());
        Self { name: name.into(), colour, dash, points, dots, crosses }
    }
}

/// A long series, kept as the smallest and largest of each of a few hundred spans, so that no
/// spike is lost and memory does not grow with the run.
#[derive(Clone, Debug)]
pub struct Reduced {
    per_bucket: u64,
    taken: u64,
    buckets: Vec<[(f64, f64); 2]>,
}

impl Reduced {
    /// A line for a series of about this number of values.
    pub fn new(values: u64) -> Self {
        let per_bucket = values.div_ceil(BUCKETS as u64).max(1);
        Self { per_bucket, taken: 0, buckets: Vec::new() }
    }

    /// Takes in a value.
    pub fn push(&mut self, x: f64, y: f64) {
        let begins = self.taken.is_multiple_of(self.per_bucket);
        self.taken += 1;
        match self.buckets.last_mut() {
            Some([low, high]) if !begins && low.1.is_finite() => {
                // A number that is none ends the line, and stays out of a span with others.
                if y < low.1 {
                    *low = (x, y);
                }
                if y > high.1 {
                    *high = (x, y);
                }
            }
            _ => self.buckets.push([(x, y); 2]),
        }
    }

    /// The points of the line.
    pub fn points(&self) -> Vec<(f64, f64)> {
        let mut points = Vec::with_capacity(2 * self.buckets.len());
        for &[a, b] in &self.buckets {
            let (first, second) = if a.0 <= b.0 { (a, b) } else { (b, a) };
            points.push(first);
            if second != first {
                points.push(second);
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_in_a_long_series_is_kept() {
        let mut series = Reduced::new(100_000);
        for k in 0..100_000 {
            series.push(f64::from(k), if k == 54_321 { 9.0 } else { 1.0 });
        }
        let points = series.points();
        assert!(points.len() < 1000 && points.contains(&(54_321.0, 9.0)));
    }
}
