//! The goals of speed, what is reached, and the two solvers side by side.

use super::haptic;
use super::memory::resident_mb;
use super::samples::{Samples, Stopwatch};
use super::works::{
    LASTS, SOLVERS, SessionSpec, default_free, default_holds, free, land, press, press_with,
};
use serde_json::{Value, json};
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;
use thenar_core::world::Stage;
use thenar_output::Output;
use thenar_scene::session::Session;

/// The goals' table.
#[derive(Debug, clap::Args)]
#[group(id = "goals")]
pub struct Args {
    /// Steps measured of each work and solver.
    #[arg(long, default_value_t = 400)]
    steps: usize,
    /// Leave out works with more tetrahedra than this.
    #[arg(long, default_value_t = 20_000)]
    tets_max: u32,
    /// Print the tables as Markdown.
    #[arg(long)]
    markdown: bool,
    /// Write all figures as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Active contacts that the works in contact hold.
const CONTACTS: u32 = 60;
/// Steps of one turn of a solver: long enough that each finds its data in the caches.
const TURN: usize = 20;

/// Turns of one session alone and of two at once.
const TURNS: usize = 8;

/// Ways in which a hand is kept busy.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Activity {
    /// Nothing touches.
    Free,
    /// Pressed on a table, at rest.
    Rests,
    /// Coming down on a table.
    Lands,
    /// The hand that comes with the program, in free air.
    DefaultFree,
    /// The default hand with bread in it.
    DefaultHolds,
}

impl Activity {
    fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Rests => "pressed on a table",
            Self::Lands => "landing on a table",
            Self::DefaultFree => "default hand, free",
            Self::DefaultHolds => "default hand, holding bread",
        }
    }

    fn touches(self) -> bool {
        !matches!(self, Self::Free | Self::DefaultFree)
    }

    /// A session of each of these, pressed as hard where they press.
    fn sessions(self, wanted: &[SessionSpec; 2]) -> Result<[Session; 2], String> {
        let [monolithic, two_step] = wanted;
        Ok(match self {
            Self::Free => [free(monolithic)?, free(two_step)?],
            Self::Rests => {
                let (hard, session) = press_with(monolithic, CONTACTS)?;
                [session, press(two_step, &hard)?]
            }
            Self::Lands => {
                let (hard, _) = press_with(monolithic, CONTACTS)?;
                [land(monolithic, &hard)?, land(two_step, &hard)?]
            }
            Self::DefaultFree => [default_free(monolithic)?, default_free(two_step)?],
            Self::DefaultHolds => [default_holds(monolithic)?, default_holds(two_step)?],
        })
    }
}

/// A work and how long it may take.
struct Work {
    doing: Activity,
    tets: u32,
    time_step: f64,
    /// Median and 99th percentile [ms].
    goal: (f64, Option<f64>),
}

impl Work {
    const fn new(doing: Activity, tets: u32, time_step: f64, goal: (f64, Option<f64>)) -> Self {
        Self { doing, tets, time_step, goal }
    }
}

/// Tetrahedra are no choice of the default hand, and no reason to leave it out.
const DEFAULT: u32 = 0;

const WORKS: [Work; 11] = [
    Work::new(Activity::DefaultFree, DEFAULT, 5e-3, (1.5, None)),
    Work::new(Activity::DefaultHolds, DEFAULT, 5e-3, (2.5, None)),
    Work::new(Activity::Free, 600, 1e-3, (0.2, None)),
    Work::new(Activity::Free, 600, 5e-3, (0.2, None)),
    Work::new(Activity::Rests, 600, 1e-3, (0.4, None)),
    Work::new(Activity::Lands, 600, 1e-3, (0.7, Some(1.1))),
    Work::new(Activity::Rests, 2000, 1e-3, (1.2, None)),
    Work::new(Activity::Lands, 2000, 1e-3, (1.2, None)),
    Work::new(Activity::Free, 17_000, 1.0 / 90.0, (4.0, None)),
    Work::new(Activity::Rests, 17_000, 1.0 / 90.0, (6.0, None)),
    Work::new(Activity::Lands, 17_000, 1.0 / 90.0, (9.0, None)),
];

/// Times of one solver at one work.
struct Times {
    watch: Stopwatch,
    contacts: Samples,
    iterations: f64,
    sweeps: f64,
    failed: usize,
}

impl Times {
    fn new(steps: usize) -> Self {
        Self {
            watch: Stopwatch::new(steps),
            contacts: Samples::default(),
            iterations: 0.0,
            sweeps: 0.0,
            failed: 0,
        }
    }

    fn step(&mut self, session: &mut Session) {
        self.watch.step(session);
        let report = session.report();
        self.contacts.push(f64::from(report.contacts_active));
        self.iterations += f64::from(report.cg_iterations);
        self.sweeps += f64::from(report.contact_sweeps);
        self.failed += usize::from(report.fell_back || report.non_finite);
    }

    /// Quantile of the samples \[ms\].
    fn quantile(&mut self, part: f64) -> f64 {
        self.watch.total.quantile(part) * 1e-3
    }

    fn stage(&mut self, stage: Stage) -> f64 {
        self.watch.stages[stage as usize].quantile(0.5)
    }

    fn json(&mut self, steps: usize) -> Value {
        let n = steps as f64;
        let contacts = [0.0, 0.5, 1.0].map(|part| self.contacts.quantile(part));
        json!({
            "median_ms": self.quantile(0.5),
            "p99_ms": self.quantile(0.99),
            "least_ms": self.quantile(0.0),
            "skeleton_us": self.stage(Stage::Skeleton),
            "flesh_us": self.stage(Stage::Flesh),
            "detect_us": self.stage(Stage::Detect),
            "contact_us": self.stage(Stage::Contact),
            "embed_us": self.stage(Stage::Embed),
            "contacts": { "least": contacts[0], "median": contacts[1], "most": contacts[2] },
            "iterations": self.iterations / n,
            "sweeps": self.sweeps / n,
            "steps_failed": self.failed,
        })
    }
}

/// Measures and prints.
pub fn run(args: &Args) -> Result<(), String> {
    if args.steps == 0 {
        return Err("at least one step must be measured".into());
    }
    let json = args.json.as_deref().map(Output::create).transpose().map_err(|e| e.to_string())?;
    let memory = paper_size_memory()?;
    let mut table = Table::new(
        args.markdown,
        &[
            "whole step",
            "step [ms]",
            "contacts",
            "goal [ms]",
            "monolithic [ms]",
            "p99 [ms]",
            "least [ms]",
            "monolithic/goal",
            "two-step [ms]",
            "p99 [ms]",
        ],
    );
    let mut stages = Table::new(
        args.markdown,
        &[
            "monolithic, median [us]",
            "skeleton",
            "flesh",
            "detect",
            "contact",
            "embed",
            "CG rounds",
            "contact sweeps",
            "steps failed",
        ],
    );
    let mut all = Vec::new();
    for work in WORKS.iter().filter(|work| work.tets <= args.tets_max) {
        // No longer than the state lasts.
        let steps = args.steps.min((LASTS / work.time_step) as usize);
        let (tets, [mut monolithic, mut two_step]) = measure(work, steps)?;
        let contacts = [0.0, 0.5, 1.0].map(|part| monolithic.contacts.quantile(part));
        let goal = match work.goal {
            (median, Some(p99)) => format!("{median} (p99 {p99})"),
            (median, None) => format!("{median}"),
        };
        let name = format!("{tets} tets, {}", work.doing.name());
        let ms = |x: f64| format!("{x:.3}");
        table.row(&[
            name.clone(),
            format!("{:.2}", work.time_step * 1e3),
            match work.doing.touches() {
                true => contacts.map(|c| format!("{c:.0}")).join("/"),
                false => "0".into(),
            },
            goal,
            ms(monolithic.quantile(0.5)),
            ms(monolithic.quantile(0.99)),
            ms(monolithic.quantile(0.0)),
            format!("{:.2}", monolithic.quantile(0.5) / work.goal.0),
            ms(two_step.quantile(0.5)),
            ms(two_step.quantile(0.99)),
        ]);
        let us = |x: f64| format!("{x:.0}");
        stages.row(&[
            format!("{name}, {:.2} ms", work.time_step * 1e3),
            us(monolithic.stage(Stage::Skeleton)),
            us(monolithic.stage(Stage::Flesh)),
            us(monolithic.stage(Stage::Detect)),
            us(monolithic.stage(Stage::Contact)),
            us(monolithic.stage(Stage::Embed)),
            format!("{:.1}", monolithic.iterations / steps as f64),
            format!("{:.1}", monolithic.sweeps / steps as f64),
            monolithic.failed.to_string(),
        ]);
        all.push(json!({
            "work": work.doing.name(),
            "tets": tets,
            "time_step_s": work.time_step,
            "goal_ms": work.goal.0,
            "goal_p99_ms": work.goal.1,
            "steps": steps,
            "monolithic": monolithic.json(steps),
            "two_step": two_step.json(steps),
        }));
    }
    table.print();
    stages.print();

    let mut others =
        Table::new(args.markdown, &["other", "goal", "reached", "p99", "reached/goal"]);
    let (median, p99) = haptic::proxies_us();
    others.row(&[
        "haptic step, 16 proxies [us]".into(),
        "5".into(),
        format!("{median:.2}"),
        format!("{p99:.2}"),
        format!("{:.2}", median / 5.0),
    ]);
    others.row(&[
        "resident memory, paper-size session [MB]".into(),
        "50".into(),
        memory.map_or("unknown".into(), |mb| format!("{mb:.1}")),
        "-".into(),
        memory.map_or("-".into(), |mb| format!("{:.2}", mb / 50.0)),
    ]);
    let cores = two_cores(args.steps)?;
    others.row(&[
        "two sessions on two cores, steps/s over one's".into(),
        "2".into(),
        format!("{cores:.2}"),
        "-".into(),
        format!("{:.2}", cores / 2.0),
    ]);
    others.print();
    println!(
        "One thread; {} steps of each solver, but no more than {LASTS} s of motion, in turns of {TURN}; \
         contacts are least/median/most active at a step of the monolithic solver.",
        args.steps
    );
    if let Some(mut json) = json {
        let report = json!({
            "works": all,
            "haptic_us": { "median": median, "p99": p99, "goal": 5.0 },
            "resident_mb": memory,
            "two_cores": cores,
        });
        let text = serde_json::to_string_pretty(&report).map_err(|e| e.to_string())?;
        json.write_all(text.as_bytes()).map_err(|e| format!("cannot write {e}"))?;
        json.finish().map_err(|e| e.to_string())?;
    }
    Ok(())
}

/// Times of one piece of work by both solvers in turns, and the number of the hand's tetrahedra.
fn measure(work: &Work, steps: usize) -> Result<(usize, [Times; 2]), String> {
    let wanted = SOLVERS.map(|(_, solver)| SessionSpec {
        tets: work.tets,
        time_step: work.time_step,
        solver,
    });
    let mut sessions = work.doing.sessions(&wanted)?;
    let mut times = [Times::new(steps), Times::new(steps)];
    let mut done = 0;
    while done < steps {
        let turn = TURN.min(steps - done);
        for (session, times) in sessions.iter_mut().zip(&mut times) {
            // The first step of a turn finds the caches full of the other's data.
            session.step(&mut ());
            (0..turn).for_each(|_| times.step(session));
        }
        done += turn;
    }
    Ok((sessions[0].world().model().flesh.tets.len(), times))
}

/// Resident memory with one session of the paper's sizes \[MB\].
fn paper_size_memory() -> Result<Option<f64>, String> {
    let wanted = SessionSpec { tets: 600, time_step: 1e-3, solver: SOLVERS[0].1 };
    let session = free(&wanted)?;
    let held = resident_mb();
    drop(session);
    Ok(held)
}

/// Steps per second of two independent sessions on two threads, over those of one alone: of each
/// the best of [`TURNS`] turns, as other jobs take what they can get.
fn two_cores(steps: usize) -> Result<f64, String> {
    let wanted = SessionSpec { tets: 600, time_step: 1e-3, solver: SOLVERS[0].1 };
    let mut sessions = [free(&wanted)?, free(&wanted)?];
    let run = |session: &mut Session| {
        let begun = Instant::now();
        for _ in 0..steps {
            session.step(&mut ());
        }
        steps as f64 / begun.elapsed().as_secs_f64()
    };
    let (mut alone, mut together) = (0.0_f64, 0.0_f64);
    for _ in 0..TURNS {
        alone = alone.max(run(&mut sessions[0]));
        together = together.max(std::thread::scope(|scope| {
            let threads: Vec<_> =
                sessions.iter_mut().map(|session| scope.spawn(|| run(session))).collect();
            threads.into_iter().map(|thread| thread.join().unwrap_or(f64::NAN)).sum()
        }));
    }
    Ok(together / alone)
}

/// A table as aligned text or as Markdown.
pub struct Table {
    markdown: bool,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// With this head.
    pub fn new(markdown: bool, head: &[&str]) -> Self {
        Self { markdown, rows: vec![head.iter().map(|h| (*h).into()).collect()] }
    }

    /// One more row.
    pub fn row(&mut self, cells: &[String]) {
        self.rows.push(cells.to_vec());
    }

    /// Prints it, and an empty line.
    pub fn print(&self) {
        let width = |c: usize| self.rows.iter().map(|r| r[c].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.rows[0].len()).map(width).collect();
        for (i, row) in self.rows.iter().enumerate() {
            let cells = row.iter().zip(&widths).enumerate().map(|(c, (cell, w))| match c {
                0 => format!("{cell:<w$}"),
                _ => format!("{cell:>w$}"),
            });
            let cells: Vec<String> = cells.collect();
            if self.markdown {
                println!("| {} |", cells.join(" | "));
                if i == 0 {
                    let rule = widths.iter().enumerate().map(|(c, w)| match c {
                        0 => "-".repeat(*w),
                        _ => format!("{}:", "-".repeat(w.saturating_sub(1))),
                    });
                    println!("| {} |", rule.collect::<Vec<_>>().join(" | "));
                }
            } else {
                println!("{}", cells.join("  "));
            }
        }
        println!();
    }
}
