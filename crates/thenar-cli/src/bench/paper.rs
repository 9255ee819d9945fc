//! The timing table of the paper's section 6, beside ours.

use super::memory::resident_mb;
use super::samples::Stopwatch;
use std::path::Path;
use thenar::world::Stage;
use thenar_scene::session::{Session, builtin};

/// The paper's table beside ours, on its bread scene and model sizes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Time step \[s\]; the paper's ran at the rate of a screen.
    #[arg(long, default_value_t = 1.0 / 60.0)]
    time_step: f64,
    /// Overrides as of `thenar run`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

/// Runs the bread scene once through and prints the table.
pub fn run(args: &Args) -> Result<(), String> {
    let scene = builtin("bread-grasp").ok_or("the scene `bread-grasp` is missing")?;
    let mut overrides = vec![format!("time_step={}", args.time_step)];
    overrides.extend(args.overrides.iter().cloned());
    let mut session = Session::from_text(scene.text, Path::new("bread-grasp.toml"), &overrides)
        .map_err(|e| e.to_string())?;
    let steps = session.steps_wanted();
    let mut watch = Stopwatch::new(steps as usize);
    // Everything, and the steps in which hand and bread touch.
    let mut touching = Stopwatch::new(steps as usize);
    let (mut cg, mut sweeps, mut contacts) = (0u64, 0u64, 0u32);
    for _ in 0..steps {
        watch.step(&mut session);
        let report = *session.report();
        cg += u64::from(report.cg_iterations);
        sweeps += u64::from(report.contact_sweeps);
        contacts = contacts.max(report.contacts_active);
        if report.contacts_active > 0 {
            touching.take_last(&watch);
        }
    }

    let hand = session.hands().first().ok_or("the scene has no hand")?;
    let model = &hand.model;
    let world = session.world();
    println!("bread-grasp, time step {:.2} ms, {steps} steps, one thread", args.time_step * 1e3);
    println!("{:<34} {:>12} {:>12}", "model", "paper (2011)", "thenar");
    let sizes = [
        ("bones", "16", model.bones.len()),
        ("tetrahedra of the hand", "597", model.flesh.tets.len()),
        ("collision triangles of the hand", "1441", model.flesh.collision.triangles.len()),
        ("render triangles of the hand", "23640", model.render.triangles.len()),
        ("tetrahedra, all", "-", world.model().flesh.tets.len()),
        ("active contacts, most", "-", contacts as usize),
    ];
    for (what, paper, ours) in sizes {
        println!("{what:<34} {paper:>12} {ours:>12}");
    }
    println!();
    println!(
        "{:<34} {:>12} {:>12} {:>10} {:>10}",
        "time of a step [ms]", "paper, mean", "median", "p99", "max"
    );
    let row = |what: &str, paper: &str, median: f64, p99: f64, max: f64| {
        let [median, p99, max] = [median, p99, max].map(|x| x / 1e3);
        println!("{what:<34} {paper:>12} {median:>12.3} {p99:>10.3} {max:>10.3}");
    };
    let stages = [
        ("skeleton (step 1, Eq. 10)", "7", Stage::Skeleton),
        ("flesh and bones (step 2, Eq. 11)", "38", Stage::Flesh),
        ("collision detection", "-", Stage::Detect),
        ("contact response (Eq. 12)", "-", Stage::Contact),
        ("integration and embedding", "-", Stage::Embed),
    ];
    for (what, paper, stage) in stages {
        let s = &mut watch.stages[stage as usize];
        row(what, paper, s.quantile(0.5), s.quantile(0.99), s.quantile(1.0));
    }
    let t = &mut watch.total;
    row("whole step", "-", t.quantile(0.5), t.quantile(0.99), t.quantile(1.0));
    let t = &mut touching.total;
    row("whole step, touching", "53", t.quantile(0.5), t.quantile(0.99), t.quantile(1.0));
    println!();
    println!(
        "conjugate gradients {:.1} iterations, contact {:.1} sweeps a step on average; \
         resident memory {}",
        cg as f64 / steps as f64,
        sweeps as f64 / steps as f64,
        resident_mb().map_or("unknown".into(), |mb| format!("{mb:.1} MB"))
    );
    println!(
        "The paper's machine was a quad-core at 2.4 GHz; compare the ratio of rows, not only times."
    );
    Ok(())
}
