//! Stability maps: the stiffest coupling on which a loosely held hand comes to rest, against the
//! tracker's rate and delay.

use super::rehearse::human;
use crate::chart::{Axis, Dash, Line, Panel, page};
use crate::error::CliError;
use crate::run::{known, open_live};
use crate::touch::ModeWord;
use std::io::Write;
use std::path::{Path, PathBuf};
use thenar_output::Output;
use thenar_rehearsal::{FingerImpedance, Onset, Rehearsal, RehearsalError};
use thenar_scene::session::Session;
use thenar_touch::{GRIP, TrackerTiming};

/// The built-in scene in which a hand lies down on a table and presses.
const SCENE: &str = "table-press";
/// Time at which it lies there \[s\].
const UNTIL: f64 = 1.2;

/// Stiffness that a coupling may have for a hand that gives way, against the tracker's rate and
/// delay: found in closed loop with a scene, beside theory.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene whose first hand is worn, with its motion as the wearer's command; without one, a
    /// hand presses a table.
    scene: Option<PathBuf>,
    /// Mass [kg], damping [N s/m] and stiffness [N/m] of each finger at its pad.
    #[arg(long, value_name = "M,B,K", default_value = "0.05,1,50", value_parser = human)]
    human: FingerImpedance,
    /// Mode in which touch joins the tracked hand and the simulation.
    #[arg(long, value_enum, default_value_t)]
    mode: ModeWord,
    /// Rates of the tracker [Hz], separated by commas.
    #[arg(long, value_name = "HZ,...", value_delimiter = ',', default_values_t = [60.0, 120.0])]
    rates: Vec<f64>,
    /// Delays of the tracker [ms], separated by commas.
    #[arg(long, value_name = "MS,...", value_delimiter = ',', default_values_t = [0.0, 50.0])]
    delays: Vec<f64>,
    /// Time of the scene at which the command stands still [s].
    #[arg(long, value_name = "S", default_value_t = UNTIL)]
    until: f64,
    /// Then the fingers close by this much more [mm].
    #[arg(long, value_name = "MM", default_value_t = 10.0)]
    press: f64,
    /// Change a value of the scene; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Also draws the map as SVG.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// One of an onset's figures.
type Value = fn(&Onset) -> f64;
/// Points of a line in the picture.
type Points = Vec<(f64, f64)>;
/// By rate, then by delay.
type Map = Vec<Vec<Onset>>;

/// Runs the command.
///
/// # Errors
/// A number or the scene is wrong, or the picture cannot be written.
pub fn run(args: &Args) -> Result<(), CliError> {
    let svg = args.svg.as_deref().map(Output::create).transpose()?;
    let all = || args.rates.iter().flat_map(|rate| args.delays.iter().map(move |d| (rate, d)));
    for (rate, delay) in all() {
        rehearsal(args, *rate, *delay).check().map_err(wrong)?;
    }
    print!("{}", head(args));
    let mut map = Map::new();
    for rate in &args.rates {
        let onsets: Result<Vec<Onset>, CliError> =
            args.delays.iter().map(|delay| onset(args, *rate, *delay)).collect();
        map.push(onsets?);
        println!("{}", row(*rate, &map[map.len() - 1]));
    }
    if let Some(mut svg) = svg {
        svg.write_all(picture(args, &map).as_bytes())
            .map_err(|e| CliError::Other(format!("cannot write the map: {e}")))?;
        svg.finish()?;
    }
    Ok(())
}

fn wrong(error: RehearsalError) -> CliError {
    CliError::Input(error.to_string())
}

fn rehearsal(args: &Args, rate: f64, delay_ms: f64) -> Rehearsal {
    Rehearsal {
        human: args.human,
        tracker: TrackerTiming { rate, latency: 1e-3 * delay_ms, noise: 0.0 },
        mode: args.mode.into(),
        grip: Some(GRIP),
        until: args.until,
        press: 1e-3 * args.press,
        sway: None,
        after: 3.0,
    }
}

fn onset(args: &Args, rate: f64, delay_ms: f64) -> Result<Onset, CliError> {
    let open = || match &args.scene {
        Some(file) => open_live(file, &args.set),
        None => {
            let small = ["hand.hand.preset=paper", "hand.hand.tets=200"].map(str::to_owned);
            let set = [&small[..], &args.set].concat();
            Ok(Session::from_text(known(SCENE)?.text, Path::new("table-press.toml"), &set)?)
        }
    };
    rehearsal(args, rate, delay_ms).onset(|| open().map_err(Failed::Open)).map_err(CliError::from)
}

/// Why a place of the map is empty.
enum Failed {
    Open(CliError),
    Rehearsal(RehearsalError),
}

impl From<RehearsalError> for Failed {
    fn from(error: RehearsalError) -> Self {
        Self::Rehearsal(error)
    }
}

impl From<Failed> for CliError {
    fn from(failed: Failed) -> Self {
        match failed {
            Failed::Open(error) => error,
            Failed::Rehearsal(error) => wrong(error),
        }
    }
}

/// To three digits at least.
fn short(x: f64) -> String {
    if !x.is_finite() {
        return "all".into();
    }
    let decimals = (2.0 - x.abs().max(1.0).log10().floor()).clamp(0.0, 3.0);
    format!("{x:.*}", if x == 0.0 { 0 } else { decimals as usize })
}

fn head(args: &Args) -> String {
    let FingerImpedance { mass, damping, stiffness } = args.human;
    let mut out = format!(
        "stiffest coupling on which a hand comes to rest [N/m], rehearsed (by theory), and what the loop shows\n\
         fingers of {mass} kg, {damping} N s/m, {stiffness} N/m; `all`: it rests on the scene's own couplings; `>`: on all tried\n\n{:>9}",
        "tracker"
    );
    for delay in &args.delays {
        out += &format!(" {:>22}", format!("{delay} ms late"));
    }
    out + "\n"
}

fn row(rate: f64, onsets: &[Onset]) -> String {
    let mut out = format!("{rate:>6} Hz");
    for onset in onsets {
        let [found, theory, shown] = [onset.stiffness, onset.theory, onset.shown].map(short);
        let beyond = if onset.beyond { ">" } else { "" };
        out += &format!(" {:>22}", format!("{beyond}{found} ({theory}), {shown}"));
    }
    out
}

fn picture(args: &Args, map: &Map) -> String {
    let found = |onset: &Onset| onset.stiffness;
    let theory = |onset: &Onset| onset.theory;
    let shown = |onset: &Onset| onset.shown;
    let finite = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        points.into_iter().filter(|(_, y)| y.is_finite() && *y > 0.0).collect()
    };
    let column = |d: usize, value: fn(&Onset) -> f64| {
        finite(args.rates.iter().zip(map).map(|(rate, row)| (*rate, value(&row[d]))).collect())
    };
    let row = |r: usize, value: fn(&Onset) -> f64| {
        finite(args.delays.iter().zip(&map[r]).map(|(delay, o)| (*delay, value(o))).collect())
    };
    let lines =
        |count: usize, name: &dyn Fn(usize) -> String, points: &dyn Fn(usize, Value) -> Points| {
            let each = (0..count).flat_map(|i| {
                let line = Line::new(name(i), i, Dash::Solid, points(i, theory));
                let dots = Line { dots: points(i, found), ..line };
                let loops = format!("{}, shown", name(i));
                [dots, Line::new(loops, i, Dash::Dashed, points(i, shown))]
            });
            each.collect::<Vec<Line>>()
        };
    let all = || {
        let each = map.iter().flatten().flat_map(|o| [found(o), theory(o), shown(o)]);
        each.filter(|y| y.is_finite() && *y > 0.0)
    };
    let delays = |i: usize| format!("{} ms late", args.delays[i]);
    let rates = |i: usize| format!("{} Hz", args.rates[i]);
    let panels = [
        Panel {
            title: "stiffest coupling [N/m]".into(),
            x_label: "rate of the tracker [Hz]".into(),
            x: Axis::log(args.rates.iter().copied(), 3.0),
            y: Axis::log(all(), 5.0),
            lines: lines(args.delays.len(), &delays, &column),
            marks: Vec::new(),
        },
        Panel {
            title: "stiffest coupling [N/m]".into(),
            x_label: "delay of the tracker [ms]".into(),
            x: Axis::linear(args.delays.iter().copied()),
            y: Axis::log(all(), 5.0),
            lines: lines(args.rates.len(), &rates, &row),
            marks: Vec::new(),
        },
    ];
    let FingerImpedance { mass, damping, stiffness } = args.human;
    let subtitle = format!(
        "fingers of {mass} kg, {damping} N s/m, {stiffness} N/m; lines: a late spring, dots: rehearsed, dashed: shown"
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

    /// Stiffness above that of the scene's couplings is stated in words, and is no point of the
    /// picture.
    #[test]
    fn maps_are_printed_and_drawn() {
        let args = args(&["--rates", "60,120", "--delays", "0,50"]);
        let onset = |stiffness| Onset {
            stiffness,
            theory: 64.0,
            beyond: stiffness > 100.0 && stiffness < 1e3,
            shown: 49.2,
            delay: 0.0168,
        };
        let map = vec![vec![onset(87.4), onset(160.0)], vec![onset(f64::INFINITY), onset(0.0)]];
        assert!(row(60.0, &map[0]).contains(">160 (64.0), 49.2"), "{}", row(60.0, &map[0]));
        assert!(row(60.0, &map[0]).contains("87.4 (64.0), 49.2"), "{}", row(60.0, &map[0]));
        assert!(row(120.0, &map[1]).contains("all (64.0), 49.2"), "{}", row(120.0, &map[1]));
        assert!(head(&args).contains("50 ms late"));
        let svg = picture(&args, &map);
        assert!(svg.starts_with("<svg") && svg.contains("50 ms late") && !svg.contains("NaN"));
    }

    #[test]
    fn numbers_out_of_sense_are_refused_before_anything_runs() {
        for (words, name) in [
            (["--rates", "0", "--delays", "0"], "HZ is 0 Hz"),
            (["--rates", "90", "--delays", "900"], "DELAY is 0.9 s"),
            (["--human", "0.05,0,50", "--rates", "90"], "damping B is 0 N s/m"),
        ] {
            let error = run(&args(&words)).unwrap_err().to_string();
            assert!(error.contains(name), "{error}");
        }
    }
}
