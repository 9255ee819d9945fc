//! The timing table of the paper's section 6, beside ours: the paper's own scheme and the
//! monolithic solver.

use super::memory::resident_mb;
use super::samples::{Samples, Stopwatch};
use crate::words::counted;
use std::path::Path;
use thenar_core::world::Stage;
use thenar_scene::session::{Session, builtin};

/// The paper's table beside ours, on its bread scene and model sizes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Time step [s]; the paper's ran at the rate of a screen.
    #[arg(long, default_value_t = 1.0 / 60.0)]
    time_step: f64,
    /// Overrides as of `thenar run`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// The bread scene, run once through by one solver.
struct SolverRun {
    session: Session,
    steps: u64,
    watch: Stopwatch,
    /// The steps in which hand and bread touch.
    touching: Stopwatch,
    cg: u64,
    sweeps: u64,
    contacts: u32,
    fell_back: u64,
}

impl SolverRun {
    /// Runs it with a solver, as scenes name it.
    fn new(args: &Args, solver: &str) -> Result<Self, String> {
        let scene = builtin("bread-grasp").ok_or("the scene `bread-grasp` is missing")?;
        let mut overrides = [
            "hand.hand.preset=paper",
            &format!("time_step={}", args.time_step),
            &format!("solver.kind={solver}"),
        ]
        .map(str::to_owned)
        .to_vec();
        overrides.extend(args.overrides.iter().cloned());
        let session = Session::from_text(scene.text, Path::new("bread-grasp.toml"), &overrides)
            .map_err(|e| e.to_string())?;
        let steps = session.steps_wanted();
        let watch = || Stopwatch::new(steps as usize);
        let (watch, touching) = (watch(), watch());
        let (cg, sweeps, contacts, fell_back) = (0, 0, 0, 0);
        let mut run = Self { session, steps, watch, touching, cg, sweeps, contacts, fell_back };
        (0..steps).for_each(|_| run.step());
        Ok(run)
    }

    fn step(&mut self) {
        self.watch.step(&mut self.session);
        let report = self.session.report();
        self.cg += u64::from(report.cg_iterations);
        self.sweeps += u64::from(report.contact_sweeps);
        self.contacts = self.contacts.max(report.contacts_active);
        self.fell_back += u64::from(report.fell_back);
        if report.contacts_active > 0 {
            self.touching.take_last(&self.watch);
        }
    }

    fn mean(&self, count: u64) -> f64 {
        count as f64 / self.steps as f64
    }
}

/// Runs the bread scene once through with each solver and prints the table.
pub fn run(args: &Args) -> Result<(), String> {
    let mut runs = [SolverRun::new(args, "two-step")?, SolverRun::new(args, "monolithic")?];
    sizes(args, &runs)?;
    println!();
    times(&mut runs);
    println!();
    for (run, name) in runs.iter().zip(["two-step", "monolithic"]) {
        println!(
            "{name}: conjugate gradients {:.1} iterations, contact {:.1} sweeps a step on average; \
             {} fell back",
            run.mean(run.cg),
            run.mean(run.sweeps),
            counted(run.fell_back, "step")
        );
    }
    let memory = resident_mb().map_or("unknown".into(), |mb| format!("{mb:.1} MB"));
    println!("resident memory, both scenes: {memory}");
    println!(
        "The paper's machine was a quad-core at 2.4 GHz; compare the ratio of rows, not only times. \
         Two-step is the paper's scheme; monolithic, the default, solves joints, flesh and contact together."
    );
    Ok(())
}

fn sizes(args: &Args, runs: &[SolverRun; 2]) -> Result<(), String> {
    let hand = runs[0].session.hands().first().ok_or("the scene has no hand")?;
    let model = &hand.model;
    let (h, steps) = (args.time_step * 1e3, runs[0].steps);
    println!("bread-grasp, time step {h:.2} ms, {steps} steps, one thread");
    println!("{:<34} {:>12} {:>12}", "model", "paper (2011)", "thenar");
    let [two_step, monolithic] = [0, 1].map(|k| runs[k].contacts);
    let sizes = [
        ("bones", "16", model.bones.len()),
        ("tetrahedra of the hand", "597", model.flesh.tets.len()),
        ("collision triangles of the hand", "1441", model.flesh.collision.triangles.len()),
        ("render triangles of the hand", "23640", model.render.triangles.len()),
        ("tetrahedra, all", "-", runs[0].session.world().model().flesh.tets.len()),
        ("active contacts, most, two-step", "-", two_step as usize),
        ("active contacts, most, monolithic", "-", monolithic as usize),
    ];
    for (what, paper, ours) in sizes {
        println!("{what:<34} {paper:>12} {ours:>12}");
    }
    Ok(())
}

fn times(runs: &mut [SolverRun; 2]) {
    println!("{:<34} {:>12} {:^32} {:^32}", "", "paper", "two-step", "monolithic");
    print!("{:<34} {:>12}", "time of a step [ms]", "mean");
    println!("{}", format!(" {:>12} {:>9} {:>9}", "median", "p99", "max").repeat(2));
    let stages = [
        ("skeleton (step 1, Eq. 10)", "7", Stage::Skeleton),
        ("flesh and bones (step 2, Eq. 11)", "38", Stage::Flesh),
        ("collision detection", "-", Stage::Detect),
        ("contact response (Eq. 12)", "-", Stage::Contact),
        ("integration and embedding", "-", Stage::Embed),
    ];
    for (what, paper, stage) in stages {
        row(what, paper, runs.each_mut().map(|r| &mut r.watch.stages[stage as usize]));
    }
    row("whole step", "-", runs.each_mut().map(|r| &mut r.watch.total));
    row("whole step, touching", "53", runs.each_mut().map(|r| &mut r.touching.total));
}

fn row(what: &str, paper: &str, samples: [&mut Samples; 2]) {
    print!("{what:<34} {paper:>12}");
    for s in samples {
        let [median, p99, max] = [0.5, 0.99, 1.0].map(|part| s.quantile(part) / 1e3);
        print!(" {median:>12.3} {p99:>9.3} {max:>9.3}");
    }
    println!();
}
