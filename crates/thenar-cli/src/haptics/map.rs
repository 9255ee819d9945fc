//! Stability maps: the stiffest coupling that does not oscillate, against rate and delay.

use crate::chart::{Axis, Dash, Line, Panel, page};
use crate::error::CliError;
use crate::files::Draft;
use std::io::Write;
use std::path::PathBuf;
use thenar::haptic::virtual_user::{Device, Wall, predicted_onset, stability_onset};

/// Rates of the device \[Hz\].
const RATES: [f64; 6] = [250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0];
/// Delays beyond the hold \[ms\].
const DELAYS_MS: [f64; 5] = [0.0, 1.0, 2.0, 4.0, 8.0];
/// Where onsets are sought \[N/m\].
const RANGE: [f64; 2] = [1.0, 1e6];
/// How long a swing is watched \[s\] per kilogram and N s/m: near the onset it changes at (excess of
/// damping) / (2 m) per second.
const WATCH: f64 = 400.0;

/// How stiff a coupling may be, against rate and delay: simulated beside theory.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Moving mass of device and finger [kg].
    #[arg(long, default_value_t = 0.1, value_parser = positive)]
    mass: f64,
    /// Their damping [N s/m].
    #[arg(long, default_value_t = 1.0, value_parser = positive)]
    damping: f64,
    /// Damping of the coupling [N s/m].
    #[arg(long, default_value_t = 0.0, value_parser = not_negative)]
    coupling_damping: f64,
    /// Also draws the map as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a number above 0".into()),
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x >= 0.0 && x.is_finite() => Ok(x),
        _ => Err("expected a number of 0 or more".into()),
    }
}

/// One place of the map.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// By simulation and by eigenvalues \[N/m\]; NaN when it is not within the range.
    simulated: f64,
    theory: f64,
}

/// Runs the command.
///
/// # Errors
/// The picture cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let svg = args.svg.as_deref().map(Draft::create).transpose()?;
    let map = RATES.map(|rate| DELAYS_MS.map(|delay| cell(args, rate, delay)));
    print!("{}", table(args, &map));
    if let Some(mut svg) = svg {
        svg.write_all(picture(args, &map).as_bytes())
            .map_err(|e| CliError::Other(format!("cannot write the map: {e}")))?;
        svg.finish()?;
    }
    Ok(())
}

/// None where the delay is no whole number of ticks.
fn cell(args: &Args, rate: f64, delay_ms: f64) -> Option<Cell> {
    let ticks = 1e-3 * delay_ms * rate;
    if (ticks - ticks.round()).abs() > 1e-9 {
        return None;
    }
    let device = Device {
        mass: args.mass,
        damping: args.damping,
        friction: 0.0,
        resolution: 0.0,
        delay_ticks: ticks.round() as usize,
        period: 1.0 / rate,
    };
    let wall = |k: f64| Wall { device, proxy: Wall::plain_proxy(k, args.coupling_damping) };
    let [low, high] = RANGE;
    let theory = predicted_onset(low, high, wall);
    let theory = if (2.0 * low..0.5 * high).contains(&theory) { theory } else { f64::NAN };
    let seconds = WATCH * args.mass / args.damping;
    let simulated = stability_onset(0.5 * theory, 2.0 * theory, seconds, wall);
    Some(Cell { simulated: simulated.unwrap_or(f64::NAN), theory })
}

type Map = [[Option<Cell>; DELAYS_MS.len()]; RATES.len()];

fn table(args: &Args, map: &Map) -> String {
    let mut out = format!(
        "stiffest stable coupling [N/m], simulated (by eigenvalues)\n\
         mass {} kg, damping {} N s/m, coupling damping {} N s/m\n\n{:>9} {:>12}",
        args.mass, args.damping, args.coupling_damping, "rate", "passive to"
    );
    for delay in DELAYS_MS {
        out += &format!(" {:>17}", format!("{delay} ms late"));
    }
    for (rate, row) in RATES.iter().zip(map) {
        let passive = 2.0 * (args.damping - args.coupling_damping).max(0.0) * rate;
        out += &format!("\n{:>6} Hz {passive:>12.0}", rate);
        for cell in row {
            let text = match cell {
                Some(c) if c.theory.is_finite() => format!("{:.0} ({:.0})", c.simulated, c.theory),
                Some(_) => "none".into(),
                None => "-".into(),
            };
            out += &format!(" {text:>17}");
        }
    }
    out + "\n"
}

fn picture(args: &Args, map: &Map) -> String {
    let all = || map.iter().flatten().flatten().flat_map(|c| [c.simulated, c.theory]);
    let column = |d: usize, value: fn(&Cell) -> f64| -> Vec<(f64, f64)> {
        let points =
            RATES.iter().zip(map).filter_map(|(rate, row)| Some((*rate, row[d].as_ref()?)));
        points.map(|(rate, cell)| (rate, value(cell))).collect()
    };
    let by_rate = DELAYS_MS.iter().enumerate().map(|(d, delay)| {
        let line = Line::new(format!("{delay} ms late"), d, Dash::Solid, column(d, |c| c.theory));
        Line { dots: column(d, |c| c.simulated), ..line }
    });
    let passive = RATES.map(|rate| (rate, 2.0 * (args.damping - args.coupling_damping) * rate));
    let passive = Line::new("passive, not late", 6, Dash::Dashed, passive.to_vec());
    let row = |r: usize, value: fn(&Cell) -> f64| -> Vec<(f64, f64)> {
        let points = DELAYS_MS.iter().zip(&map[r]);
        points.filter_map(|(delay, cell)| Some((*delay, value(cell.as_ref()?)))).collect()
    };
    let by_delay = RATES.iter().enumerate().map(|(r, rate)| {
        let line = Line::new(format!("{rate} Hz"), r, Dash::Solid, row(r, |c| c.theory));
        Line { dots: row(r, |c| c.simulated), ..line }
    });
    let panels = [
        Panel {
            title: "stiffest stable coupling [N/m]".into(),
            x_label: "rate [Hz]".into(),
            x: Axis::log(RATES.into_iter(), 3.0),
            y: Axis::log(all(), 5.0),
            lines: by_rate.chain([passive]).collect(),
            marks: Vec::new(),
        },
        Panel {
            title: "stiffest stable coupling [N/m]".into(),
            x_label: "delay beyond the hold [ms]".into(),
            x: Axis::linear(DELAYS_MS.into_iter()),
            y: Axis::log(all(), 5.0),
            lines: by_delay.collect(),
            marks: Vec::new(),
        },
    ];
    let subtitle = format!(
        "mass {} kg, damping {} N s/m, coupling damping {} N s/m; lines: eigenvalues, dots: simulated",
        args.mass, args.damping, args.coupling_damping
    );
    page("How stiff a coupling may be", &subtitle, &panels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args() -> Args {
        Args { mass: 0.1, damping: 1.0, coupling_damping: 0.0, svg: None }
    }

    /// Validation E1's figures are places of the map; every place that there is agrees with theory.
    #[test]
    fn the_map_goes_through_the_published_figures() {
        let map = RATES.map(|rate| DELAYS_MS.map(|delay| cell(&args(), rate, delay)));
        let theory = |rate: usize, delay: usize| map[rate][delay].unwrap().theory;
        assert!((theory(2, 0) - 2003.34).abs() < 0.01 && (theory(3, 0) - 4003.34).abs() < 0.01);
        assert!((theory(1, 0) - 1003.34).abs() < 0.01 && (theory(2, 1) - 668.51).abs() < 0.01);
        assert!(map[0][1].is_none(), "1 ms is a quarter of a tick");
        for cell in map.iter().flatten().flatten() {
            assert!((cell.simulated / cell.theory - 1.0).abs() < 0.02, "{cell:?}");
        }
        let text = table(&args(), &map);
        assert!(text.contains("(2003)") && text.lines().count() == 10, "{text}");
        let svg = picture(&args(), &map);
        assert!(svg.starts_with("<svg") && svg.contains("4 ms late") && !svg.contains("NaN"));
    }
}
