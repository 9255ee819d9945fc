//! Cost over mesh size and number of contacts.

use super::memory::resident_mb;
use super::samples::Stopwatch;
use std::path::Path;
use thenar_core::world::Stage;
use thenar_scene::session::Session;

/// Cost over 600 to 17 000 tetrahedra and 0 to 100 contacts, with resident memory.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Tetrahedra of the hand.
    #[arg(long, value_delimiter = ',', default_values_t = [600, 2000, 5000, 17000])]
    tets: Vec<u32>,
    /// Depth of the hand's rest pose in the table [mm]; the deeper, the more contacts.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true,
          default_values_t = [-100.0, 1.0, 3.0, 6.0, 12.0])]
    depth_mm: Vec<f64>,
    /// Time step [s].
    #[arg(long, default_value_t = 1.0 / 60.0)]
    time_step: f64,
    /// Steps measured of each, after as many to settle.
    #[arg(long, default_value_t = 100)]
    steps: usize,
}

/// Presses hands of several mesh sizes on a table and prints a row for each.
pub fn run(args: &Args) -> Result<(), String> {
    println!(
        "a hand pressed flat on a table, time step {:.2} ms, {} steps each, one thread",
        args.time_step * 1e3,
        args.steps
    );
    println!(
        "{:>7} {:>7} {:>9} {:>10} {:>10} {:>11} {:>12} {:>10} {:>9} {:>9} {:>7} {:>11}",
        "tets",
        "nodes",
        "contacts",
        "bones [us]",
        "flesh [us]",
        "detect [us]",
        "contact [us]",
        "whole [us]",
        "p99 [us]",
        "CG rounds",
        "sweeps",
        "memory [MB]"
    );
    for &tets in &args.tets {
        for &depth in &args.depth_mm {
            row(args, tets, depth)?;
        }
    }
    Ok(())
}

fn row(args: &Args, tets: u32, depth_mm: f64) -> Result<(), String> {
    let text = scene(tets, args.time_step);
    let mut session =
        Session::from_text(&text, Path::new("scaling.toml"), &[]).map_err(|e| e.to_string())?;
    // The table's height is known only once the hand is built: raise it to the palm.
    let lowest =
        session.world().collision_vertices(0).iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let height = lowest + depth_mm * 1e-3;
    let set = format!("rigid.table.position=[0,{height:.6},0]");
    session =
        Session::from_text(&text, Path::new("scaling.toml"), &[set]).map_err(|e| e.to_string())?;

    for _ in 0..args.steps {
        session.step(&mut ());
    }
    let mut watch = Stopwatch::new(args.steps);
    let (mut contacts, mut cg, mut sweeps) = (0u64, 0u64, 0u64);
    for _ in 0..args.steps {
        watch.step(&mut session);
        contacts += u64::from(session.report().contacts_active);
        cg += u64::from(session.report().cg_iterations);
        sweeps += u64::from(session.report().contact_sweeps);
    }
    let n = args.steps.max(1) as f64;
    let model = session.world().model();
    let mut stage = |stage: Stage| watch.stages[stage as usize].quantile(0.5);
    let [skeleton, flesh, detect, contact] =
        [Stage::Skeleton, Stage::Flesh, Stage::Detect, Stage::Contact].map(&mut stage);
    println!(
        "{:>7} {:>7} {:>9.1} {:>10.0} {:>10.0} {:>11.0} {:>12.0} {:>10.0} {:>9.0} {:>9.1} {:>7.1} {:>11}",
        model.flesh.tets.len(),
        model.flesh.mass.len(),
        contacts as f64 / n,
        skeleton,
        flesh,
        detect,
        contact,
        watch.total.quantile(0.5),
        watch.total.quantile(0.99),
        cg as f64 / n,
        sweeps as f64 / n,
        resident_mb().map_or("unknown".into(), |mb| format!("{mb:.1}")),
    );
    Ok(())
}

/// The right hand held palm down over a table that is far below.
fn scene(tets: u32, time_step: f64) -> String {
    format!(
        r#"
version = 1
time_step = {time_step}
solver = {{ contact_tolerance = 1e-3, contact_sweeps_max = 100 }}

[[rigid]]
name = "table"
shape = {{ kind = "plane" }}
motion = "fixed"
position = [0, -1, 0]

[[hand]]
preset = "paper"
name = "hand"
model = "right"
tets = {tets}
"#
    )
}
