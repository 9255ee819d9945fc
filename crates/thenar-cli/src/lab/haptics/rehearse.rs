//! A wearer and a tracker that do not exist, in closed loop with the product's own chain.

use crate::error::CliError;
use crate::run::open_live;
use crate::touch::ModeWord;
use std::path::PathBuf;
use thenar_rehearsal::{FingerImpedance, Outcome, Rehearsal, RehearsalError};
use thenar_touch::{GRIP, LoopProfile, MARGIN, TrackerTiming};

/// Names of fingers, thumb first.
const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "little"];

/// A hand that gives way, seen by a late tracker, in closed loop with a scene: what it feels, and
/// whether that dies out.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene whose first hand is worn, with its motion as the wearer's command.
    #[arg(default_value = "table-press")]
    scene: PathBuf,
    /// Mass [kg], damping [N s/m] and stiffness [N/m] of each finger at its pad.
    #[arg(long, value_name = "M,B,K", default_value = "0.05,1,50", value_parser = human)]
    human: FingerImpedance,
    /// Rate [Hz], delay [ms] and noise [mm] of the tracker; with units also as 90Hz,0.04s,1mm.
    #[arg(long, value_name = "HZ,DELAY,NOISE", default_value = "90,20,0", value_parser = tracker)]
    tracker: TrackerTiming,
    /// Mode in which touch joins the tracked hand and the simulation.
    #[arg(long, value_enum, default_value_t)]
    mode: ModeWord,
    /// Damping of the loosest grip that the loop reckons with [N s/m].
    #[arg(long, value_name = "B", default_value_t = GRIP)]
    grip: f64,
    /// Shows the couplings as they are, whatever the delay.
    #[arg(long, conflicts_with = "grip")]
    unbounded: bool,
    /// Time of the scene at which the command stands still [s].
    #[arg(long, value_name = "S", default_value_t = 1.3)]
    until: f64,
    /// Then the fingers close by so much more [mm].
    #[arg(long, value_name = "MM", default_value_t = 10.0)]
    press: f64,
    /// Fingers press and let go at this rate [Hz] instead of staying closed.
    #[arg(long, value_name = "HZ")]
    sway: Option<f64>,
    /// Then, after a push, so long until the end [s], of which the last second is looked at.
    #[arg(long, value_name = "S", default_value_t = 3.0)]
    after: f64,
    /// Change a value of the scene; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Three numbers, each with one of its units or none; the first unit is meant where there is none.
fn three(text: &str, units: [&[(&str, f64)]; 3], names: [&str; 3]) -> Result<[f64; 3], String> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let [_, _, _] = parts[..] else {
        return Err(format!("expected three numbers, {}", names.join(",")));
    };
    let mut numbers = [0.0; 3];
    for (k, part) in parts.iter().enumerate() {
        let unit = |(name, factor): &(&str, f64)| {
            let number = part.strip_suffix(name)?.trim().parse::<f64>().ok()?;
            Some(number * factor)
        };
        let plain = part.parse::<f64>().ok().map(|x| x * units[k][0].1);
        let found = plain.or_else(|| units[k].iter().find_map(unit));
        numbers[k] = found.ok_or_else(|| format!("{} is `{part}`, expected a number", names[k]))?;
    }
    Ok(numbers)
}

pub(super) fn human(text: &str) -> Result<FingerImpedance, String> {
    let units: [&[(&str, f64)]; 3] =
        [&[("kg", 1.0), ("g", 1e-3)], &[("Ns/m", 1.0)], &[("N/m", 1.0)]];
    let [mass, damping, stiffness] = three(text, units, ["M", "B", "K"])?;
    Ok(FingerImpedance { mass, damping, stiffness })
}

pub(super) fn tracker(text: &str) -> Result<TrackerTiming, String> {
    let units: [&[(&str, f64)]; 3] =
        [&[("Hz", 1.0)], &[("ms", 1e-3), ("s", 1.0)], &[("mm", 1e-3), ("m", 1.0)]];
    let [rate, latency, noise] = three(text, units, ["HZ", "DELAY", "NOISE"])?;
    Ok(TrackerTiming { rate, latency, noise })
}

/// Runs the command.
///
/// # Errors
/// A number or the scene is wrong.
pub fn run(args: &Args) -> Result<(), CliError> {
    let grip = (!args.unbounded).then_some(args.grip);
    let what = Rehearsal {
        human: args.human,
        tracker: args.tracker,
        mode: args.mode.into(),
        grip,
        until: args.until,
        press: 1e-3 * args.press,
        sway: args.sway,
        after: args.after,
    };
    let wrong = |error: RehearsalError| CliError::Input(error.to_string());
    what.check().map_err(wrong)?;
    let session = open_live(&args.scene, &args.set)?;
    let out = what.run_and_measure(session).map_err(wrong)?;
    print(&what, &out);
    Ok(())
}

fn print(what: &Rehearsal, out: &Outcome) {
    let FingerImpedance { mass, damping, stiffness } = what.human;
    let TrackerTiming { rate, latency, noise } = what.tracker;
    println!("fingers of {mass} kg, {damping} N s/m, {stiffness} N/m");
    println!("tracker of {rate} Hz, {:.1} ms late, noise {:.2} mm", 1e3 * latency, 1e3 * noise);
    let rule = what.grip.map(|grip| rule(grip, out.delay));
    match rule {
        Some(rule) => println!(
            "felt stiffness {:.0} N/m; {:.1} ms from motion to force allow {rule:.0} N/m, of which {:.0} % are used",
            out.stiffness,
            1e3 * out.delay,
            1e2 * MARGIN
        ),
        None => println!("felt stiffness {:.0} N/m, whatever the delay", out.stiffness),
    }
    println!(
        "(of a bone that cannot move; what is measured below has flesh, joints and what is touched in it)"
    );
    println!();
    println!(
        "{:8}{:>17}{:>12}{:>12}{:>14}{:>16}{:>16}{:>20}",
        "",
        "measured [N/m]",
        "force [N]",
        "rms [mN]",
        "motion [mm]",
        "given [mJ/s]",
        "most given [mJ]",
        "beyond damping [mJ]"
    );
    for (k, (name, felt)) in FINGERS.iter().zip(&out.fingers).enumerate() {
        let measured = out.measured.map_or("-".into(), |all| format!("{:.0}", all[k]));
        println!(
            "{name:8}{measured:>17}{:>12.3}{:>12.2}{:>14.4}{:>16.4}{:>16.4}{:>20.4}",
            felt.mean,
            1e3 * felt.rms,
            1e3 * felt.motion_rms,
            1e3 * felt.given,
            1e3 * felt.given_max,
            1e3 * felt.beyond
        );
    }
    println!();
    println!(
        "largest force {:.3} N, largest change in a tick {:.4} N",
        out.largest[0], out.largest[1]
    );
    out.trips.iter().for_each(|trip| println!("stopped at {trip}"));
    println!("{}", verdict(out, what.sway.is_some()));
}

/// The outcome of a rehearsal in a line.
fn verdict(out: &Outcome, sways: bool) -> &'static str {
    let passive = out.worst().beyond < 1e-3;
    match (out.trips.is_empty(), sways) {
        (false, _) => "the guards stopped it",
        (true, _) if !out.is_felt() => {
            "nothing was felt, so this says nothing of touch: where the command stands still, the hand is to press something \
             (a scene, --until, --press)"
        }
        (true, true) if passive => "passive: no finger is given more than its damper takes up",
        (true, true) => "not passive: more than 1 mJ beyond what a damper took up",
        (true, false) if out.is_still() => "still: what disturbs it dies out",
        (true, false) => "not still: more than 20 mN or 0.1 mm rms, or 0.1 mJ a second given",
    }
}

/// Gil's rule for a loop of 1 kHz \[N/m\].
fn rule(grip: f64, delay: f64) -> f64 {
    let [damping, friction, resolution] = [0.0; 3];
    let rated_stiffness = f64::INFINITY;
    LoopProfile { period: 1e-3, delay, damping, friction, resolution, rated_stiffness }
        .felt_stiffness_max(grip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_rehearsal::FingerOutcome;

    #[test]
    fn a_verdict_is_given_on_what_was_felt() {
        let felt = |mean: f64, rms: f64, beyond: f64| Outcome {
            fingers: [FingerOutcome { mean, rms, beyond, ..FingerOutcome::default() }; 5],
            // Something else was felt on the way.
            largest: [1.0, 0.0],
            felt: mean + rms,
            stiffness: 25.0,
            measured: None,
            delay: 0.03,
            trips: Vec::new(),
            live: true,
        };
        let begins = |out: Outcome, sways: bool, with: &str| {
            let said = verdict(&out, sways);
            assert!(said.starts_with(with), "{said}");
        };
        begins(felt(0.3, 1e-3, 0.0), false, "still");
        begins(felt(0.3, 0.03, 0.0), false, "not still");
        begins(felt(0.3, 0.03, 0.0), true, "passive");
        begins(felt(0.3, 0.03, 0.002), true, "not passive");
        // A phantom of the flesh may be as large in free air.
        for sways in [false, true] {
            begins(felt(0.015, 1e-4, 0.0), sways, "nothing was felt");
        }
        begins(Outcome { trips: vec!["1.2 s".into()], ..felt(0.0, 0.0, 0.0) }, false, "the guards");
    }

    #[test]
    fn numbers_have_units_or_the_usual_ones() {
        let want = TrackerTiming { rate: 90.0, latency: 0.04, noise: 1e-3 };
        for text in ["90,40,1", "90Hz,40ms,1mm", "90, 0.04s, 0.001m"] {
            assert_eq!(tracker(text).unwrap(), want, "{text}");
        }
        let want = FingerImpedance { mass: 0.05, damping: 1.0, stiffness: 50.0 };
        assert_eq!(human("0.05,1,50").unwrap(), want);
        assert_eq!(human("50g,1Ns/m,50N/m").unwrap(), want);
        assert_eq!(human("1,2").unwrap_err(), "expected three numbers, M,B,K");
        assert_eq!(tracker("90,x,0").unwrap_err(), "DELAY is `x`, expected a number");
    }
}
