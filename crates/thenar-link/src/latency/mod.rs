//! Delay, rate and noise with which a tracker sees a hand, from its samples while a person moved.
//!
//! Pure: times and places in, figures out. Who measures asks trackers, keys and the person
//! ([`Trace::take`]).
//!
//! - [`lag`]: two trackers of one hand at once. The one whose delay is known is the reference; the
//!   other is later by where the speeds of both match best.
//! - [`taps`]: one tracker, and keys that the tracked finger presses. The finger stops when the key
//!   is down.
//! - [`stillness`]: the hand held still, for the noise.
//!
//! All of them refuse rather than guess: too few events, two trackers that see different motions,
//! halves of a session that contradict each other ([`LatencyError`]).

mod lag;
mod moving;
mod seen;
mod still;
mod taps;
#[cfg(test)]
mod trial;

pub use lag::{Lag, lag};
pub use seen::{ComparedPart, LEVER_HAND, LEVERS, TIPS, Trace, TraceSample};
pub use still::stillness;
pub use taps::{KEY_DELAY, KEY_DELAY_SPREAD, taps};

/// A delay with its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredDelay {
    /// Mean \[s\].
    pub mean: f64,
    /// Standard error of the mean \[s\].
    pub error: f64,
    /// Number of events in the mean.
    pub events: usize,
}

/// A mean that is less certain than this is none \[s\]: behind 20 ms it changes what is felt by a
/// quarter.
pub const ERROR_MAX: f64 = 0.005;

/// Two halves of a session differ by more than this number of standard errors of their difference
/// ...
const HALVES_ERRORS: f64 = 4.0;
/// ... and by more than this \[s\]: something changed meanwhile.
const HALVES_APART: f64 = 0.005;

/// Why nothing was measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LatencyError {
    /// Too little happened.
    #[error("too few {what}: {count}, expected {wanted} or more")]
    TooFew {
        /// Kind of the events counted.
        what: &'static str,
        /// Number of them.
        count: usize,
        /// Number needed.
        wanted: usize,
    },
    /// The two saw different motions.
    #[error(
        "the two trackers do not see the same motion: their speeds correlate by {correlation:.2} at best"
    )]
    Unlike {
        /// Largest correlation over all lags.
        correlation: f64,
    },
    /// Motion repeats itself: several lags match as well.
    #[error(
        "the motion is too regular: a lag of {:.0} ms matches about as well as one of {:.0} ms; move unevenly",
        1e3 * *other, 1e3 * *best
    )]
    Ambiguous {
        /// The lag that matches best \[s\].
        best: f64,
        /// Another one \[s\].
        other: f64,
    },
    /// The best lag lies at the end of what is looked at.
    #[error("no lag between {:.0} and {:.0} ms matches best", 1e3 * *from, 1e3 * *to)]
    OutOfRange {
        /// Least lag looked at \[s\].
        from: f64,
        /// Largest \[s\].
        to: f64,
    },
    /// Events scatter too much.
    #[error("the events scatter: the mean is uncertain by {:.1} ms, at most {:.0} ms are believed", 1e3 * *error, 1e3 * ERROR_MAX)]
    Scatter {
        /// Standard error of the mean \[s\].
        error: f64,
    },
    /// The session's first half contradicts its second.
    #[error(
        "the session contradicts itself: {:.1} ms in its first half, {:.1} ms in its second",
        1e3 * *first, 1e3 * *second
    )]
    Halves {
        /// Mean of the first half \[s\].
        first: f64,
        /// Mean of the second half \[s\].
        second: f64,
    },
    /// Too many events that are none.
    #[error("{odd} of {count} {what}: at most a third is left out")]
    Odd {
        /// Description of the odd events.
        what: &'static str,
        /// Number of odd events.
        odd: usize,
        /// Number of all events.
        count: usize,
    },
    /// A hand was to be still.
    #[error("the hand moved by {:.0} mm; it has to be held still", 1e3 * *by)]
    Moved {
        /// Distance moved \[m\].
        by: f64,
    },
    /// A delay that no tracker has.
    #[error("the delay would be {:.1} ms, expected 0 to 500: {advice}", 1e3 * *delay)]
    Impossible {
        /// The delay \[s\].
        delay: f64,
        /// Hint at what may be wrong.
        advice: &'static str,
    },
}

/// Refuses a mean that is uncertain or changes on the way.
fn trusted(all: MeasuredDelay, halves: [MeasuredDelay; 2]) -> Result<MeasuredDelay, LatencyError> {
    if all.error.is_nan() || all.error > ERROR_MAX {
        return Err(LatencyError::Scatter { error: all.error });
    }
    let [first, second] = halves;
    let apart = (first.mean - second.mean).abs();
    if apart > HALVES_APART && apart > HALVES_ERRORS * first.error.hypot(second.error) {
        return Err(LatencyError::Halves { first: first.mean, second: second.mean });
    }
    Ok(all)
}

/// Largest delay that a profile takes \[s\].
const DELAY_MAX: f64 = 0.5;

/// The delay, refused if it is none of a tracker.
///
/// # Errors
/// It is negative beyond doubt, or more than half a second. One that is negative within its error
/// is zero.
pub fn possible(
    measured: MeasuredDelay,
    advice: &'static str,
) -> Result<MeasuredDelay, LatencyError> {
    let MeasuredDelay { mean, error, .. } = measured;
    if !(-3.0 * error..=DELAY_MAX).contains(&mean) {
        return Err(LatencyError::Impossible { delay: mean, advice });
    }
    Ok(MeasuredDelay { mean: mean.max(0.0), ..measured })
}
