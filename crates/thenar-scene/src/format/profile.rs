//! Size of a load over time.

use super::InterpolationWord;
use crate::text::{Located, choice, table};

table! {
    /// The full load, between two times.
    pub struct Constant {
        /// Nothing before [s]. Default 0.
        from: f64 where DURATION = 0.0;
        /// Nothing after [s]. Default: never ends.
        until: Option<f64> where DURATION;
    }
}

table! {
    /// From nothing to the full load.
    pub struct RampProfile {
        /// Starts to rise [s]. Default 0.
        from: f64 where DURATION = 0.0;
        /// Full at this time [s].
        full: f64 where DURATION;
        /// Nothing after [s]. Default: never ends.
        until: Option<f64> where DURATION;
        /// The rise: "smooth" or "linear" (default).
        interpolation: InterpolationWord = InterpolationWord::Linear;
    }
}

table! {
    /// Factors at given times; constant before the first and after the last.
    pub struct KeyframeProfile {
        /// Times [s], ascending.
        times: Located<Vec<f64>> where DURATION;
        /// A factor for each time.
        factors: Located<Vec<f64>> where PLACE;
        /// Between them: "smooth" or "linear" (default).
        interpolation: InterpolationWord = InterpolationWord::Linear;
    }
}

table! {
    /// sin(2π · frequency · (t − from) + phase).
    pub struct SineProfile {
        /// Frequency [Hz].
        frequency: f64 where SPRING;
        /// Phase [rad]. Default 0.
        phase: f64 where ANGLE = 0.0;
        /// Nothing before [s]. Default 0.
        from: f64 where DURATION = 0.0;
        /// Nothing after [s]. Default: never ends.
        until: Option<f64> where DURATION;
    }
}

table! {
    /// A new factor from -1 to 1 at random after every interval, joined smoothly; another series
    /// for each component and each body or joint that the load acts on.
    pub struct RandomProfile {
        /// Seed. Default 1.
        seed: u32 where INDEX = 1;
        /// Time between draws [s]. Default 0.1.
        interval: f64 where INTERVAL = 0.1;
        /// Nothing before [s]. Default 0.
        from: f64 where DURATION = 0.0;
        /// Nothing after [s]. Default: never ends.
        until: Option<f64> where DURATION;
    }
}

choice! {
    /// The factor of a load over time.
    pub enum Profile by "kind" {
        /// Full size throughout.
        "constant" => Constant(Constant),
        /// A rise to full size.
        "ramp" => Ramp(RampProfile),
        /// By a table.
        "keyframes" => Keyframes(KeyframeProfile),
        /// A sine.
        "sine" => Sine(SineProfile),
        /// Values drawn at random.
        "random" => Random(RandomProfile),
    }
}
