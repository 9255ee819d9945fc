//! Axes: from values to places, and where numbers stand.

use crate::words::without_zeros;

/// A range of values, evenly or by powers of ten.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    min: f64,
    max: f64,
    log: bool,
}

impl Axis {
    /// An even axis that holds these values and zero, with a little room above.
    pub fn linear(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = range(values);
        let (low, high) = (low.min(0.0), high.max(0.0));
        let (low, high) = if high > low { (low, high) } else { (0.0, 1.0) };
        let room = 0.05 * (high - low);
        Self { min: if low < 0.0 { low - room } else { low }, max: high + room, log: false }
    }

    /// An even axis over exactly this range.
    pub fn span(min: f64, max: f64) -> Self {
        Self { min, max: if max > min { max } else { min + 1.0 }, log: false }
    }

    /// An axis by powers of ten that holds these values; those not above zero do not count, and it
    /// reaches at most `decades` down from the largest.
    pub fn log(values: impl Iterator<Item = f64>, decades: f64) -> Self {
        let (low, high) = range(values.filter(|v| *v > 0.0));
        let (low, high) = if high > 0.0 { (low, high) } else { (0.1, 1.0) };
        let max = 10.0_f64.powf((high.log10() + 0.05).ceil());
        let min = 10.0_f64.powf((low.log10() - 0.05).floor());
        Self { min: min.max(max * 10.0_f64.powf(-decades)), max, log: true }
    }

    /// Place of a value on the axis, from 0 to 1; values outside stay at the ends. None when it is
    /// not a number.
    pub fn place(&self, value: f64) -> Option<f64> {
        let part = match self.log {
            true if value > 0.0 => (value / self.min).log10() / (self.max / self.min).log10(),
            true => 0.0,
            false => (value - self.min) / (self.max - self.min),
        };
        value.is_finite().then(|| part.clamp(0.0, 1.0))
    }

    /// Values at which a line and a number stand.
    pub fn ticks(&self) -> Vec<f64> {
        if self.log {
            let decades = (self.max / self.min).log10().round() as i32;
            let every = (decades / 6).max(1) as usize;
            let power = |k: i32| 10.0_f64.powf(self.min.log10().round() + f64::from(k));
            return (0..=decades).step_by(every).map(power).collect();
        }
        let step = nice((self.max - self.min) / 5.0);
        let first = (self.min / step).ceil() as i64;
        let last = (self.max / step + 1e-9).floor() as i64;
        (first..=last).map(|k| k as f64 * step).collect()
    }

    /// Text at a tick.
    pub fn label(&self, tick: f64) -> String {
        if self.log {
            let power = tick.log10().round() as i32;
            return match power {
                -2..=3 => number(tick),
                _ => format!("1e{power}"),
            };
        }
        number(tick)
    }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|v| v.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// 1, 2 or 5 times a power of ten, not below `step`.
fn nice(step: f64) -> f64 {
    let power = 10.0_f64.powf(step.log10().floor());
    let digit = [1.0, 2.0, 5.0].into_iter().find(|d| d * power >= step * (1.0 - 1e-9));
    digit.unwrap_or(10.0) * power
}

/// Few digits, without a row of zeros.
fn number(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{x:.0e}");
    }
    let decimals = (2.0 - size.log10().floor()).clamp(0.0, 5.0) as usize;
    without_zeros(format!("{x:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        let axis = Axis::linear([0.0, 7.3].into_iter());
        assert_eq!(axis.ticks(), [0.0, 2.0, 4.0, 6.0]);
        let labels: Vec<String> = axis.ticks().iter().map(|t| axis.label(*t)).collect();
        assert_eq!(labels, ["0", "2", "4", "6"]);
        let log = Axis::log([0.02, 30.0].into_iter(), 9.0);
        let labels: Vec<String> = log.ticks().iter().map(|t| log.label(*t)).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10", "100"]);
    }

    #[test]
    fn values_are_placed_by_their_scale() {
        let even = Axis::span(1.0, 3.0);
        assert_eq!(even.place(2.0), Some(0.5));
        assert_eq!((even.place(9.0), even.place(f64::NAN)), (Some(1.0), None));
        let log = Axis::log([1.5, 80.0].into_iter(), 9.0);
        assert!((log.place(10.0).unwrap() - 0.5).abs() < 1e-12);
        assert_eq!(log.place(0.0), Some(0.0));
    }
}
