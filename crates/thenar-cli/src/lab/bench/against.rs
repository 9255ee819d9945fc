//! Two builds of the program side by side, on a machine that has other work.
//!
//! Both take turns at the same works, a process each, in an order that changes from round to round.
//! A ratio is of two runs that follow each other; of all rounds the median counts, and how far the
//! others lie apart tells what it is worth.

use super::goals::Table;
use super::machine::Peaks;
use super::samples::Samples;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use thenar_scene::format::MONOLITHIC_ONCE;

/// The other build, and how long to measure.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Another build of this program.
    program: PathBuf,
    /// Times that each of the two measures.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Steps of each work and solver in a round.
    #[arg(long, default_value_t = 100)]
    steps: usize,
    /// Leave out works with more tetrahedra than this.
    #[arg(long, default_value_t = 4000)]
    tets_max: u32,
    /// Print the table as Markdown.
    #[arg(long)]
    markdown: bool,
}

/// One run's times of a work [ms].
struct Run {
    work: String,
    median: f64,
    least: f64,
}

/// A work over all rounds.
#[derive(Default)]
struct Pairs {
    medians: [Samples; 2],
    least: [f64; 2],
    ratios: Samples,
}

/// Measures and prints.
pub fn run(args: &Args) -> Result<(), String> {
    if args.rounds == 0 {
        return Err("at least one round must be measured".into());
    }
    let own = std::env::current_exe().map_err(|e| format!("this program is not found: {e}"))?;
    let programs = [own.as_path(), args.program.as_path()];
    let before = Peaks::measure();
    let mut works: Vec<(String, Pairs)> = Vec::new();
    for round in 0..args.rounds {
        eprintln!("round {} of {}", round + 1, args.rounds);
        // Whoever comes second finds the machine as the first left it.
        let order = if round % 2 == 0 { [0, 1] } else { [1, 0] };
        let mut runs = [Vec::new(), Vec::new()];
        for k in order {
            runs[k] = measure(programs[k], args)?;
        }
        take(&runs, &mut works);
    }
    if works.is_empty() {
        return Err(format!("`{}` measures none of these works", args.program.display()));
    }
    let head = ["whole step", "this [ms]", "that [ms]", "this/that", "from", "to", "least/least"];
    let mut table = Table::new(args.markdown, &head);
    for (name, pairs) in &mut works {
        let ms = |samples: &mut Samples| format!("{:.3}", samples.quantile(0.5));
        let ratio = |part: f64, pairs: &mut Pairs| format!("{:.2}", pairs.ratios.quantile(part));
        table.row(&[
            name.clone(),
            ms(&mut pairs.medians[0]),
            ms(&mut pairs.medians[1]),
            ratio(0.5, pairs),
            ratio(0.0, pairs),
            ratio(1.0, pairs),
            format!("{:.2}", pairs.least[0] / pairs.least[1]),
        ]);
    }
    table.print();
    let after = Peaks::measure();
    println!(
        "Medians of {} rounds of {} steps, and the ratios of rounds, by turns; before them {}; after them {}.",
        args.rounds,
        args.steps,
        before.line(),
        after.line()
    );
    Ok(())
}

/// Adds a round to the works that both have measured.
fn take(runs: &[Vec<Run>; 2], works: &mut Vec<(String, Pairs)>) {
    for this in &runs[0] {
        let Some(that) = runs[1].iter().find(|that| that.work == this.work) else { continue };
        let at = works.iter().position(|(name, _)| *name == this.work).unwrap_or_else(|| {
            let none = Pairs { least: [f64::INFINITY; 2], ..Pairs::default() };
            works.push((this.work.clone(), none));
            works.len() - 1
        });
        let pairs = &mut works[at].1;
        for (k, run) in [this, that].into_iter().enumerate() {
            pairs.medians[k].push(run.median);
            pairs.least[k] = pairs.least[k].min(run.least);
        }
        pairs.ratios.push(this.median / that.median);
    }
}

/// Lets a program measure in a process of its own.
fn measure(program: &Path, args: &Args) -> Result<Vec<Run>, String> {
    let folder = std::env::temp_dir();
    let file = folder.join(format!("thenar-bench-{}.json", std::process::id()));
    let failed = |what: &str| format!("`{} bench` {what}", program.display());
    let done = Command::new(program)
        .arg("bench")
        .args(["--steps", &args.steps.to_string(), "--tets-max", &args.tets_max.to_string()])
        .arg("--json")
        .arg(&file)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .output()
        .map_err(|e| failed(&format!("does not run: {e}")))?;
    let text = std::fs::read_to_string(&file);
    let _ = std::fs::remove_file(&file);
    if !done.status.success() {
        let why = String::from_utf8_lossy(&done.stderr);
        return Err(failed(&format!("failed: {}", why.trim())));
    }
    let text = text.map_err(|e| failed(&format!("wrote no figures: {e}")))?;
    let figures: Value =
        serde_json::from_str(&text).map_err(|e| failed(&format!("wrote other than JSON: {e}")))?;
    runs_of(&figures).ok_or_else(|| failed("wrote figures of another form"))
}

/// The monolithic solver's figures, of each work; an older build has them under its old name.
fn runs_of(figures: &Value) -> Option<Vec<Run>> {
    let of = |work: &Value| {
        let (name, tets) = (work["work"].as_str()?, work["tets"].as_u64()?);
        let ms = 1e3 * work["time_step_s"].as_f64()?;
        let monolithic = work.get("monolithic").or_else(|| work.get(MONOLITHIC_ONCE))?;
        Some(Run {
            work: format!("{tets} tets, {name}, {ms:.2} ms"),
            median: monolithic["median_ms"].as_f64()?,
            least: monolithic["least_ms"].as_f64()?,
        })
    };
    figures["works"].as_array()?.iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn figures(works: &[(&str, f64, f64)]) -> Value {
        let works: Vec<Value> = works
            .iter()
            .map(|(name, median, least)| {
                json!({
                    "work": name, "tets": 600, "time_step_s": 0.001,
                    "monolithic": { "median_ms": median, "least_ms": least },
                })
            })
            .collect();
        json!({ "works": works })
    }

    /// Works that only one of both knows are left out; a ratio is of one round.
    #[test]
    fn rounds_are_compared_work_by_work() {
        let rounds = [
            [figures(&[("free", 2.0, 1.5), ("new", 1.0, 1.0)]), figures(&[("free", 4.0, 3.5)])],
            [figures(&[("free", 9.0, 1.0)]), figures(&[("old", 1.0, 1.0), ("free", 10.0, 4.0)])],
            [figures(&[("free", 3.0, 2.0)]), figures(&[("free", 5.0, 3.0)])],
        ];
        let mut works = Vec::new();
        for round in &rounds {
            take(&[0, 1].map(|k| runs_of(&round[k]).expect("figures")), &mut works);
        }
        assert_eq!(works.len(), 1);
        let (name, pairs) = &mut works[0];
        assert_eq!(name, "600 tets, free, 1.00 ms");
        assert_eq!(pairs.ratios.quantile(0.5), 0.6);
        assert_eq!([pairs.ratios.quantile(0.0), pairs.ratios.quantile(1.0)], [0.5, 0.9]);
        assert_eq!(pairs.least, [1.0, 3.0]);
        assert!(runs_of(&json!({ "works": [{ "work": "free" }] })).is_none());
    }

    #[test]
    fn figures_of_older_builds_are_read() {
        let text = figures(&[("free", 2.0, 1.5)]).to_string();
        let older = text.replace("monolithic", MONOLITHIC_ONCE);
        let runs = runs_of(&serde_json::from_str(&older).expect("JSON")).expect("figures");
        assert_eq!((runs[0].median, runs[0].least), (2.0, 1.5));
    }
}
