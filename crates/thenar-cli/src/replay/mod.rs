//! `thenar replay`: a recorded session made again.

mod csv;
mod mcap;
mod show;

use crate::building::{heard, unheard};
use crate::error::CliError;
use crate::interrupt;
use crate::page::PageOptions;
use crate::progress::Meter;
use crate::recording::header;
use csv::Tables;
use mcap::Export;
use std::path::{Path, PathBuf};
use thenar_input::brief;
use thenar_record::{Gap, Header};
use thenar_scene::recording::{Event, Loss, Replay, ReplayError, TimeOf, Verdict};
use thenar_scene::session::TakenBack;

/// Replay a recorded session: verify it, export it, show it.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A recording, of `thenar record`, or of `--record` elsewhere.
    recording: PathBuf,
    /// Fail unless the recording is whole, nothing was dropped while recording, and every step
    /// gives the same bits.
    #[arg(long)]
    verify: bool,
    /// Begin at the last keyframe before this time of the recording [s]; an error beyond its end.
    #[arg(long, value_name = "S", default_value_t = 0.0, allow_negative_numbers = true)]
    from: f64,
    /// Write an MCAP file for Foxglove and Rerun.
    #[arg(long, value_name = "FILE.mcap")]
    mcap: Option<PathBuf>,
    /// Write tables of bones' poses, finger forces and probes; further scenes and channels get
    /// files of their own beside it.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Moments per second in the exported files, at most; the tables have every step without it,
    /// the MCAP file 30.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    rate: Option<f64>,
    /// Show it on the live page, at its own pace, with pause and places to go to.
    #[arg(long, conflicts_with_all = ["verify", "mcap", "csv", "rate"])]
    serve: bool,
    /// Options of that page: where it is, and for whom.
    #[command(flatten)]
    page: PageOptions,
    /// No summary.
    #[arg(long, short)]
    quiet: bool,
}

/// A file that is written while the session is made again.
trait Sink {
    /// Takes in what has just happened.
    fn take(&mut self, event: &Event, replay: &mut Replay) -> Result<(), CliError>;
    /// Completes the file.
    fn finish(self: Box<Self>, replay: &Replay) -> Result<(), CliError>;
}

/// Says when the next moment is due.
#[derive(Clone, Copy, Debug)]
struct Schedule {
    period: f64,
    next: Option<f64>,
}

impl Schedule {
    /// Most moments per second; `None` for all.
    fn at_most(rate: Option<f64>) -> Self {
        Self { period: rate.map_or(0.0, |rate| 1.0 / rate), next: None }
    }

    /// True when a moment at this time is due.
    fn is_due(&mut self, time_ns: u64) -> bool {
        let time = time_ns as f64 * 1e-9;
        // A microsecond early is not late.
        let due = self.next.is_none_or(|next| time >= next - 1e-6);
        if due {
            let next = self.next.unwrap_or(time) + self.period;
            // After a pause nothing is caught up.
            self.next = Some(if next > time { next } else { time + self.period });
        }
        due
    }
}

/// Replays a recording.
///
/// # Errors
/// The recording cannot be read, a file cannot be written, or `--verify` finds a difference.
pub fn run(args: &Args) -> Result<(), CliError> {
    if args.rate.is_some_and(|rate| !(rate > 0.0 && rate.is_finite())) {
        return Err(CliError::Input("--rate must be more than 0".into()));
    }
    if !args.from.is_finite() || args.from < 0.0 {
        return Err(CliError::Input("--from must be 0 or more".into()));
    }
    thenar_output::protect(&args.recording);
    if args.serve {
        return show::run(args);
    }
    if args.page.any() {
        let what = "--port, --lan, --open and --no-open are for --serve";
        return Err(CliError::Input(what.into()));
    }
    let opened = heard(|| match args.from {
        0.0 => Replay::open(&args.recording),
        from => Replay::open_at(&args.recording, from),
    });
    let mut replay = opened.map_err(|error| named(&args.recording, error))?;
    interrupt::listen();
    let mut sinks: Vec<Box<dyn Sink>> = Vec::new();
    if let Some(file) = &args.csv {
        sinks.push(Box::new(Tables::create(file, args.rate)?));
    }
    if let Some(file) = &args.mcap {
        sinks.push(Box::new(Export::create(file, args.rate, replay.header())?));
    }
    let bytes = std::fs::metadata(&args.recording).map_or(0, |file| file.len());
    let meter = Meter::of_bytes(bytes, args.quiet);
    let failed = loop {
        if interrupt::asked() {
            return Err(CliError::Other("interrupted; nothing was exported".into()));
        }
        match unheard(|| replay.next()) {
            Ok(Some(event)) => {
                meter.at(replay.bytes_read(), replay.verdict().steps);
                for sink in &mut sinks {
                    sink.take(&event, &mut replay)?;
                }
            }
            Ok(None) => break None,
            Err(_) if interrupt::asked() => {}
            // What was made before it is worth keeping.
            Err(error) => break Some(error),
        }
    };
    drop(meter);
    for sink in sinks {
        sink.finish(&replay)?;
    }
    let here = header(TimeOf::Clock);
    if !args.quiet {
        tell(args, &replay, &here);
    }
    match failed {
        Some(error) => Err(named(&args.recording, error)),
        None => {
            let verdict = replay.verdict();
            let judged = judge(args, verdict, replay.header(), &here).and_then(|()| {
                TakenBack::judge(verdict.taken_back, verdict.steps).map_err(CliError::from)
            });
            judged
                .map_err(|error| CliError::Other(format!("{}: {error}", args.recording.display())))
        }
    }
}

fn tell(args: &Args, replay: &Replay, here: &Header) {
    let (verdict, recorded) = (replay.verdict(), replay.header());
    // What the file says of itself may be anything.
    let said = |text: &str| println!("  {}", brief(text));
    println!(
        "{}",
        brief(&format!(
            "{}: {}, {}, {} vector instructions",
            args.recording.display(),
            recorded.program,
            recorded.system,
            recorded.vectors
        ))
    );
    if verdict.passed > 0 {
        println!("  {} steps passed over, up to the keyframe to begin at", verdict.passed);
    }
    println!("  {verdict}");
    if !verdict.is_same() {
        let causes = verdict.causes(recorded, here);
        causes.iter().for_each(|cause| said(cause));
        if causes.is_empty() {
            println!("  the build and the processor are the same: this should not be");
        }
    }
    if verdict.taken_back > 0 {
        println!("  {} steps were taken back: their numbers are not finite", verdict.taken_back);
    }
    verdict.refused.iter().take(3).for_each(|reason| said(&format!("refused: {reason}")));
    let more = verdict.gaps.len().saturating_sub(TOLD_MAX);
    verdict.gaps.iter().take(TOLD_MAX).for_each(|gap| println!("  {}", dropped(gap)));
    if more > 0 {
        println!("  and so at {more} more places");
    }
    if verdict.strays > 0 {
        println!("  {}", stray(verdict));
    }
    if !verdict.losses.is_empty() {
        println!("  {}", damaged(verdict));
    }
    // The end may be in the part that is damaged.
    if !verdict.ended && verdict.losses.last().is_none_or(|loss| loss.damage.resumed) {
        println!("  the recording was not ended: its program was killed, or still writes");
    }
    if let Some(session) = replay.session() {
        println!("  state {:016x}", session.world().state_hash());
    }
}

/// Pieces of a damaged file, and gaps, that are reported one by one.
const TOLD_MAX: usize = 5;

fn damaged(verdict: &Verdict) -> String {
    let told: Vec<String> = verdict.losses.iter().take(TOLD_MAX).map(Loss::to_string).collect();
    let mut text = format!("the file is damaged; {}", told.join("; "));
    match verdict.losses.len().saturating_sub(TOLD_MAX) {
        0 => {}
        more => text += &format!("; and so at {more} more places"),
    }
    if verdict.lost > 0 {
        text += &format!("; {} steps were not made, up to a keyframe after each", verdict.lost);
    }
    text
}

/// Frames that were dropped while recording, before this time \[s\].
fn dropped((time, gap): &(f64, Gap)) -> String {
    let of = if gap.source == 0 { "of the session" } else { "of a channel" };
    format!(
        "before {time:.3} s {} frames {of} were dropped, {} of them inputs or records: the disk was too slow",
        gap.frames, gap.heavy
    )
}

fn stray(verdict: &Verdict) -> String {
    format!("records that fit no channel as it was announced: {}", verdict.strays)
}

/// Judges the recording as `--verify` asks.
fn judge(args: &Args, verdict: &Verdict, recorded: &Header, here: &Header) -> Result<(), CliError> {
    if !args.verify {
        return Ok(());
    }
    if !verdict.is_same() {
        let mut lines = vec![verdict.to_string()];
        lines.extend(verdict.causes(recorded, here));
        lines.extend(verdict.refused.first().cloned());
        return Err(CliError::Other(lines.join("; ")));
    }
    let (put_right, _) = verdict.put_right;
    if put_right > 0 {
        let what = "keyframes remember something else than the session";
        return Err(CliError::Other(format!("{what}, {put_right} times")));
    }
    match verdict.losses.len() {
        1.. => Err(CliError::Other(damaged(verdict))),
        _ if !verdict.ended => Err(CliError::Other("the recording was not ended".into())),
        _ if verdict.unmarked > 0 => {
            Err(CliError::Other(format!("{} steps could not be compared", verdict.unmarked)))
        }
        _ if verdict.strays > 0 => Err(CliError::Other(stray(verdict))),
        _ if verdict.steps == 0 && (args.from > 0.0 || verdict.scenes == 0) => {
            Err(CliError::Other("there is no step to compare".into()))
        }
        _ => verdict.gaps.first().map_or(Ok(()), |gap| Err(CliError::Other(dropped(gap)))),
    }
}

/// Names the recording and the fault in it.
fn named(recording: &Path, error: ReplayError) -> CliError {
    match error {
        ReplayError::Open(error) => CliError::Input(error.to_string()),
        ReplayError::Read(_) | ReplayError::Asset(_) => {
            CliError::Other(format!("{}: {error}", recording.display()))
        }
        _ => CliError::Input(format!("{}: {error}", recording.display())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_keep_their_rate_and_none_is_caught_up_after_a_pause() {
        let mut every = Schedule::at_most(Some(30.0));
        let due = (0..2000_u64).filter(|k| every.is_due(k * 2_000_000)).count();
        // 4 s at 30 a second, and the one at the start.
        assert!((119..=121).contains(&due), "{due}");
        let after = (0..4_u64).filter(|k| every.is_due(9_000_000_000 + k * 2_000_000)).count();
        assert_eq!(after, 1);
        let mut all = Schedule::at_most(None);
        assert!((0..10).all(|k| all.is_due(k)));
    }
}
