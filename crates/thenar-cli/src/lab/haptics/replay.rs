//! An incident of touch made again, bit for bit.

use crate::error::CliError;
use std::fmt::Write;
use std::path::PathBuf;
use thenar_link::haptic_loop::incident::{Difference, Incident, replay};
use thenar_link::haptic_loop::{TickRecord, header, line, word};

/// Make an incident of touch again with the chain that felt it, and compare each tick bit for bit.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A file that `thenar touch` or `serve` wrote when forces stopped: thenar-trip-TIME.touch.
    incident: PathBuf,
    /// Write a table of what the chain made of it, tick by tick.
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// The file is none, or the chain makes something else of what is in it.
pub fn run(args: &Args) -> Result<(), CliError> {
    let file = args.incident.display();
    let wrong = |error: &dyn std::fmt::Display| CliError::Input(format!("{file}: {error}"));
    let incident = Incident::read(&args.incident).map_err(|e| wrong(&e))?;
    println!("forces stopped: {}", incident.reason);
    println!(
        "recorded by thenar {} with {}; this is {} with {}",
        incident.program,
        incident.instructions,
        env!("CARGO_PKG_VERSION"),
        thenar_core::vector_instructions()
    );
    let made = replay(&incident).map_err(|e| wrong(&e))?;
    let seconds = made
        .records
        .first()
        .zip(made.records.last())
        .map_or(0.0, |(first, last)| last.time_ns.saturating_sub(first.time_ns) as f64 * 1e-9);
    println!(
        "{} ticks over {seconds:.2} s, {} samples, {} frames of the simulation",
        made.ticks,
        incident.samples.len(),
        incident.frames.len()
    );
    if let Some(path) = &args.csv {
        thenar_output::write_whole(path, table(&incident.reason, &made.records).as_bytes())
            .map_err(|e| CliError::Other(e.to_string()))?;
    }
    match &made.first {
        _ if made.compared == 0 => Err(CliError::Other("no tick was recorded to compare".into())),
        None => {
            println!("all {} records are the same, bit for bit", made.compared);
            Ok(())
        }
        Some(difference) => {
            let (different, compared) = (made.different, made.compared);
            let first = told(difference);
            Err(CliError::Other(format!("{different} of {compared} records differ; {first}")))
        }
    }
}

/// All ticks; times count back from the stop of forces, or from the end.
fn table(reason: &str, records: &[TickRecord]) -> String {
    use thenar_touch::safety::Status;
    let stop = records.iter().find(|record| matches!(record.status, Status::Tripped(_)));
    let zero_ns = stop.or(records.last()).map_or(0, |record| record.time_ns);
    let mut text = format!("# made again: forces stopped: {reason}\n{}\n", header());
    for record in records {
        // Into memory.
        let _ = writeln!(text, "{}", line(record, zero_ns));
    }
    text
}

/// The first difference, for a person.
fn told(difference: &Difference) -> String {
    let Difference { recorded, replayed } = difference;
    let at = recorded.time_ns;
    let Some(replayed) = replayed else {
        return format!("the tick at {at} ns was not made again");
    };
    let [was, is] = [recorded, replayed].map(|record| {
        let axes = record.axes.map(|axis| format!("{:e}/{:e}", axis.wanted, axis.output));
        format!("{} with {} N wanted/sent", word(&record.status), axes.join(" "))
    });
    format!("the first at {at} ns: recorded {was}, made again {is}")
}
