//! Limits of a soak. Those of quality are requirements, the same at every step, of one seed or of
//! several together: what a wearer of a glove or a viewer of the page would notice.

use super::Extremes;
use std::fmt;

/// A hand can put no more energy than this into the scene: its drives at full stretch across the
/// pen hold about 100 J.
const ENERGY_MAX_J: f64 = 1000.0;
/// Penetration that steps stay under \[m\], and how many of them at least \[%\].
pub const DEEP: f64 = 1e-3;
const SHALLOW_LEAST: f64 = 99.9;
/// Penetration that no step exceeds \[m\].
const PENETRATION_MAX: f64 = 5e-3;
/// No penetration stays above [`DEEP`] for so long \[s\].
const DEEP_TIME_MAX: f64 = 0.1;
/// Largest gap of a joint \[m\].
pub const JOINT_GAP_MAX: f64 = 5e-5;
/// Steps that may miss the accuracy of contact \[%\].
const MISSED_MAX: f64 = 5.0;
/// Largest error of contact where it missed its accuracy \[m/s\]: one below moves a point by less
/// than 17 µm in the longest usual step of 16.7 ms, which is a fiftieth of the contact margin.
pub const MISS_MAX: f64 = 1e-3;

/// One figure of a soak and its limit, in the unit that is printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    what: &'static str,
    value: f64,
    unit: &'static str,
    /// "at least", "at most", "under".
    bound: &'static str,
    limit: f64,
    /// The figure keeps to its limit.
    pub kept: bool,
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, value, unit, bound, limit, kept } = self;
        let verdict = if *kept { "ok" } else { "MISSED" };
        write!(f, "{verdict:6}  {what:42} {value:12.6} {unit:4} {bound} {limit}")
    }
}

fn at_least(what: &'static str, value: f64, unit: &'static str, limit: f64) -> Figure {
    Figure { what, value, unit, bound: "at least", limit, kept: value >= limit }
}

fn at_most(what: &'static str, value: f64, unit: &'static str, limit: f64) -> Figure {
    Figure { what, value, unit, bound: "at most", limit, kept: value <= limit }
}

fn under(what: &'static str, value: f64, unit: &'static str, limit: f64) -> Figure {
    // Steps that last as long as the limit, but for rounding, reach it.
    Figure { what, value, unit, bound: "under", limit, kept: value < limit * (1.0 - 1e-9) }
}

/// Figures that every soak is held to: finite numbers and bounded energy.
pub fn soundness(e: &Extremes) -> Vec<Figure> {
    vec![
        at_most("steps taken back", e.non_finite as f64, "", 0.0),
        under("largest energy", e.energy, "J", ENERGY_MAX_J),
    ]
}

/// Further figures that a soak at steps of `h` \[s\] is held to: no penetration that is felt or
/// seen, joints that hold, contact as accurate as it is asked for.
pub fn quality(e: &Extremes, h: f64) -> Vec<Figure> {
    let percent = |steps: u64| 100.0 * steps as f64 / e.steps.max(1) as f64;
    vec![
        at_least("steps under 1 mm of penetration", 100.0 - percent(e.deep), "%", SHALLOW_LEAST),
        at_most("deepest penetration", e.penetration * 1e3, "mm", PENETRATION_MAX * 1e3),
        under("longest time above 1 mm", e.deep_longest as f64 * h, "s", DEEP_TIME_MAX),
        under("largest joint gap", e.joint_gap * 1e3, "mm", JOINT_GAP_MAX * 1e3),
        under("steps that missed the contact accuracy", percent(e.missed), "%", MISSED_MAX),
        at_most("largest miss of it", e.missed_by, "m/s", MISS_MAX),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of the figures that miss their limits.
    fn missed(e: &Extremes, h: f64) -> Vec<&'static str> {
        let all = soundness(e).into_iter().chain(quality(e, h));
        all.filter(|figure| !figure.kept).map(|figure| figure.what).collect()
    }

    #[test]
    fn each_limit_is_kept_to_its_edge_and_missed_beyond() {
        // At every edge: 3 of 3600 steps are under 0.1 %, 179 under 5 %, five steps of 1/60 s under
        // 0.1 s.
        let e = Extremes {
            steps: 3600,
            deep: 3,
            deep_longest: 5,
            penetration: 5e-3,
            joint_gap: 4.99e-5,
            missed: 179,
            missed_by: 1e-3,
            energy: 999.0,
            ..Extremes::default()
        };
        let h = 1.0 / 60.0;
        assert_eq!(missed(&e, h), [""; 0]);
        let only = |e: Extremes, what: &str| assert_eq!(missed(&e, h), [what]);
        only(Extremes { non_finite: 1, ..e }, "steps taken back");
        only(Extremes { energy: 1000.0, ..e }, "largest energy");
        only(Extremes { deep: 4, ..e }, "steps under 1 mm of penetration");
        only(Extremes { penetration: 5.001e-3, ..e }, "deepest penetration");
        only(Extremes { deep_longest: 6, ..e }, "longest time above 1 mm");
        only(Extremes { joint_gap: 5e-5, ..e }, "largest joint gap");
        only(Extremes { missed: 180, ..e }, "steps that missed the contact accuracy");
        only(Extremes { missed_by: 1.001e-3, ..e }, "largest miss of it");
    }
}
