//! Judgement of a run by the steps that were taken back in it.

/// Largest share of the steps that may be taken back, as their numbers were not finite, before a
/// run has failed. A step that is taken back lets no time pass: of the simulated time as much is
/// missing, and one part in a hundred is what figures of a run are read to.
const SHARE_MAX: f64 = 0.01;

/// A run that has failed: too many of its steps were taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{taken_back} of {steps} steps gave numbers that are not finite and were taken back, more than {} %",
    100.0 * SHARE_MAX
)]
pub struct TakenBack {
    taken_back: u64,
    steps: u64,
}

impl TakenBack {
    /// Judges a run of `steps` steps.
    ///
    /// # Errors
    /// More than one in a hundred of them were taken back.
    pub fn judge(taken_back: u64, steps: u64) -> Result<(), Self> {
        match taken_back as f64 <= SHARE_MAX * steps as f64 {
            true => Ok(()),
            false => Err(Self { taken_back, steps }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_step_in_a_hundred_may_be_taken_back() {
        for (taken_back, steps) in [(0, 0), (0, 1), (1, 100), (10, 1000), (10, 1099)] {
            assert!(TakenBack::judge(taken_back, steps).is_ok(), "{taken_back} {steps}");
        }
        for (taken_back, steps) in [(1, 1), (1, 99), (11, 1000), (100, 100)] {
            let told = TakenBack::judge(taken_back, steps).unwrap_err().to_string();
            assert!(told.contains(&format!("{taken_back} of {steps} steps")), "{told}");
            assert!(told.ends_with("more than 1 %"), "{told}");
        }
    }
}
