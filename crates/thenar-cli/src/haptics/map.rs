//! Stability maps: the stiffest coupling that does not oscillate, against rate and delay.

use crate::chart::{Axis, Dash, Line, Panel, page};
use crate::error::CliError;
use std::io::Write;
use std::path::PathBuf;
use thenar_output::Output;
use thenar_touch::virtual_user::{Device, Wall, predicted_onset, stability_onset};

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
    /// Damping of device and finger [N s/m].
    #[arg(long, default_value_t = 1.0, value_parser = positive)]
    damping: f64,
    /// Damping of the coupling [N s/m].
    #[arg(long, default_value_t = 0.0, value_parser = not_negative)]
    coupling_damping: f64,
    /// Rates of the device [Hz], separated by commas.
    #[arg(
        long,
        value_name = "HZ,...",
        value_delimiter = ',',
        value_parser = positive,
        default_values_t = [250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0]
    )]
    rates: Vec<f64>,
    /// Delays beyond the hold [ms], separated by commas; places of the map whose delay is not a whole number of
    /// ticks are left out.
    #[arg(
        long,
        value_name = "MS,...",
        value_delimiter = ',',
        value_parser = not_negative,
        default_values_t = [0.0, 1.0, 2.0, 4.0, 8.0]
    )]
    delays: Vec<f64>,
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
    let svg = args.svg.as_deref().map(Output::create).transpose()?;
    let map = map(args);
    print!("{}", table(args, &map));
    if let Some(mut svg) = svg {
        svg.write_all(picture(args, &map).as_bytes())
            .map_err(|e| CliError::Other(format!("cannot write the map: {e}")))?;
        svg.finish()?;
    }
    Ok(())
}

fn map(args: &Args) -> Map {
    let row = |rate: &f64| args.delays.iter().map(|delay| cell(args, *rate, *delay)).collect();
    args.rates.iter().map(row).collect()
}

/// None where the delay is not a whole number of ticks.
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

/// By rate, then by delay.
type Map = Vec<Vec<Option<Cell>>>;

/// To three digits at least.
fn short(x: f64) -> String {
    let decimals = (2.0 - x.abs().log10().floor()).clamp(0.0, 3.0);
    format!("{x:.*}", if x == 0.0 { 0 } else { decimals as usize })
}

fn table(args: &Args, map: &Map) -> String {
    let mut out = format!(
        "stiffest stable coupling [N/m], simulated (by eigenvalues)\n\
         mass {} kg, damping {} N s/m, coupling damping {} N s/m\n\n{:>9} {:>12}",
        args.mass, args.damping, args.coupling_damping, "rate", "passive to"
    );
    for delay in &args.delays {
        out += &format!(" {:>17}", format!("{delay} ms late"));
    }
    for (rate, row) in args.rates.iter().zip(map) {
        let passive = 2.0 * (args.damping - args.coupling_damping).max(0.0) * rate;
        out += &format!("\n{rate:>6} Hz {:>12}", short(passive));
        for cell in row {
            let text = match cell {
                Some(c) if c.theory.is_finite() => {
                    format!("{} ({})", short(c.simulated), short(c.theory))
                }
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
            args.rates.iter().zip(map).filter_map(|(rate, row)| Some((*rate, row[d].as_ref()?)));
        points.map(|(rate, cell)| (rate, value(cell))).collect()
    };
    let by_rate = args.delays.iter().enumerate().map(|(d, delay)| {
        let line = Line::new(format!("{delay} ms late"), d, Dash::Solid, column(d, |c| c.theory));
        Line { dots: column(d, |c| c.simulated), ..line }
    });
    let damping = (args.damping - args.coupling_damping).max(0.0);
    let passive = args.rates.iter().map(|rate| (*rate, 2.0 * damping * rate)).collect();
    let passive = Line::new("passive, not late", args.delays.len() + 1, Dash::Dashed, passive);
    let row = |r: usize, value: fn(&Cell) -> f64| -> Vec<(f64, f64)> {
        let points = args.delays.iter().zip(&map[r]);
        points.filter_map(|(delay, cell)| Some((*delay, value(cell.as_ref()?)))).collect()
    };
    let by_delay = args.rates.iter().enumerate().map(|(r, rate)| {
        let line = Line::new(format!("{rate} Hz"), r, Dash::Solid, row(r, |c| c.theory));
        Line { dots: row(r, |c| c.simulated), ..line }
    });
    let panels = [
        Panel {
            title: "stiffest stable coupling [N/m]".into(),
            x_label: "rate [Hz]".into(),
            x: Axis::log(args.rates.iter().copied(), 3.0),
            y: Axis::log(all(), 5.0),
            lines: by_rate.chain([passive]).collect(),
            marks: Vec::new(),
        },
        Panel {
            title: "stiffest stable coupling [N/m]".into(),
            x_label: "delay beyond the hold [ms]".into(),
            x: Axis::linear(args.delays.iter().copied()),
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

    #[derive(clap::Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    fn args(words: &[&str]) -> Args {
        <Command as clap::Parser>::parse_from([&["map"], words].concat()).args
    }

    /// Validation E1's figures are places of the map; every place that there is agrees with theory.
    #[test]
    fn the_map_goes_through_the_published_figures() {
        let args = args(&[]);
        let map = map(&args);
        let theory = |rate: usize, delay: usize| map[rate][delay].unwrap().theory;
        assert!((theory(2, 0) - 2003.34).abs() < 0.01 && (theory(3, 0) - 4003.34).abs() < 0.01);
        assert!((theory(1, 0) - 1003.34).abs() < 0.01 && (theory(2, 1) - 668.51).abs() < 0.01);
        assert!(map[0][1].is_none(), "1 ms is a quarter of a tick");
        for cell in map.iter().flatten().flatten() {
            assert!((cell.simulated / cell.theory - 1.0).abs() < 0.02, "{cell:?}");
        }
        let text = table(&args, &map);
        assert!(text.contains("(2003)") && text.lines().count() == 10, "{text}");
        let svg = picture(&args, &map);
        assert!(svg.starts_with("<svg") && svg.contains("4 ms late") && !svg.contains("NaN"));
    }
    /// A light device, late: computed apart, by the eigenvalues of the exactly sampled loop in another
    /// language. Figures below 100 N/m keep three digits.
    #[test]
    fn other_masses_rates_and_delays_are_asked_for() {
        let words = ["--mass", "0.005", "--damping", "0.1", "--rates", "500,2000", "--delays", "8"];
        let args = args(&words);
        let map = map(&args);
        for (row, expected) in map.iter().zip([11.44, 12.44]) {
            let cell = row[0].unwrap();
            assert!((cell.theory - expected).abs() < 0.01, "{cell:?}");
            assert!((cell.simulated / expected - 1.0).abs() < 0.02, "{cell:?}");
        }
        assert!(table(&args, &map).contains("(11.4)"), "{}", table(&args, &map));
    }
}
