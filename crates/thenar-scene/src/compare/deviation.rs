//! Distances over several bodies.

/// A distance over several bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Mean over all.
    pub mean: f64,
    /// Largest of all.
    pub max: f64,
    /// Index of the largest in the list of bodies.
    pub at: usize,
}

impl Deviation {
    /// Mean and largest of these distances; `None` when there are none.
    pub fn over(distances: impl Iterator<Item = f64>) -> Option<Self> {
        let (mut apart, mut count) = (Self::default(), 0.0);
        for (at, distance) in distances.enumerate() {
            count += 1.0;
            apart.mean += (distance - apart.mean) / count;
            if distance > apart.max {
                (apart.max, apart.at) = (distance, at);
            }
        }
        (count > 0.0).then_some(apart)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_largest_are_found() {
        let apart = Deviation::over([1.0, 4.0, 1.0].into_iter());
        assert_eq!(apart, Some(Deviation { mean: 2.0, max: 4.0, at: 1 }));
        assert_eq!(Deviation::over(std::iter::empty()), None);
    }
}
