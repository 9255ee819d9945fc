//! Frequencies of a bar that rings freely.

use super::MODES;
use crate::lab::validate::case::{CaseError, Check, Figure};
use crate::lab::validate::run::{Series, Solver};
use std::f64::consts::TAU;

/// Ringing starts here \[s\]; the tap ends at 5 ms.
const FREE_FROM: f64 = 0.006;

/// A mode: what it is, its frequency \[Hz\], where to look for it, in which probe column.
const WANTED: [(&str, f64, [f64; 2], usize); 4] = [
    ("first bending [Hz]", 3.16, [2.0, 5.0], 1),
    ("torsion [Hz]", 14.28, [11.0, 19.0], 2),
    ("second bending [Hz]", 17.05, [14.0, 21.0], 1),
    ("axial [Hz]", 25.14, [20.0, 30.0], 0),
];

pub fn modes(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut run = solver.open(&MODES, &[])?;
    let series = run.to(FREE_FROM)?.record(1.2, &["end.x", "end.y", "turn.rx"])?;
    let figure = |(what, expected, band, column): (&str, f64, [f64; 2], usize)| {
        let got = spectral_peak(&series, column, band);
        Figure::new(what, run.setup(), expected, got, Check::Relative(0.03))
    };
    Ok(WANTED.into_iter().map(figure).collect())
}

/// Frequency within `band` \[Hz\] at which the Hann-windowed Fourier transform is largest.
fn spectral_peak(series: &Series, column: usize, band: [f64; 2]) -> f64 {
    let step = (band[1] - band[0]) / 64.0;
    let strength = |f: f64| spectrum(series, column, f);
    let largest = |a: f64, b: f64| if strength(b) > strength(a) { b } else { a };
    let coarse = (0..=64).map(|k| band[0] + step * f64::from(k));
    let start = coarse.reduce(largest).unwrap_or(band[0]);
    // Halve the step around the best so far.
    (0..16).fold((start, step), |(f, d), _| (largest(largest(f, f - d), f + d), 0.6 * d)).0
}

fn spectrum(series: &Series, column: usize, frequency: f64) -> f64 {
    let (first, last) = match series.time.as_slice() {
        [first, .., last] => (*first, *last),
        _ => return 0.0,
    };
    let (mut re, mut im) = (0.0, 0.0);
    for (t, y) in series.time.iter().zip(&series.columns[column]) {
        let window = 0.5 - 0.5 * (TAU * (t - first) / (last - first)).cos();
        let (sin, cos) = (TAU * frequency * t).sin_cos();
        re += window * y * cos;
        im -= window * y * sin;
    }
    re.hypot(im)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_frequencies_of_two_dying_tones() {
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 6e-4).collect();
        let tone = |t: f64| {
            (TAU * 3.2 * t).sin() * (-0.1 * t).exp()
                + 0.1 * (TAU * 17.3 * t + 1.0).sin() * (-t).exp()
        };
        let series = Series { columns: vec![time.iter().map(|t| tone(*t)).collect()], time };
        let near = |band, f: f64| (spectral_peak(&series, 0, band) / f - 1.0).abs() < 5e-3;
        assert!(near([2.0, 5.0], 3.2) && near([14.0, 21.0], 17.3));
    }
}
