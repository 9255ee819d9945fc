//! Distance of each stage of a step from what the machine allows.
//!
//! Operations and bytes are counted from the sizes of the model, not measured: a multiply-add is
//! two operations, every number that a stage reads or writes counts once. The floor of a stage is
//! the longer of doing the operations at the peak in f64 and of moving the bytes from where data of
//! that size lies.

use super::goals::Table;
use super::machine::Peaks;
use super::works::{SOLVERS, SessionSpec, free};
use std::time::Instant;
use thenar_core::Vec3;
use thenar_core::world::{Stage, StageTimer};
use thenar_scene::session::Session;

/// Floor and measured time of each stage, with the machine's peaks measured in the same run.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Tetrahedra of the hand.
    #[arg(long, value_delimiter = ',', default_values_t = [600, 2000, 17_000])]
    tets: Vec<u32>,
    /// Time step [s].
    #[arg(long, default_value_t = 1e-3)]
    time_step: f64,
    /// Steps measured of each; the least time of a stage counts.
    #[arg(long, default_value_t = 200)]
    steps: u32,
    /// Print the tables as Markdown.
    #[arg(long)]
    markdown: bool,
}

/// Operations and bytes of a stage.
struct StageCost {
    name: &'static str,
    flops: f64,
    bytes: f64,
    /// Least time measured \[s\].
    time: f64,
}

/// Prints the machine's peaks and a table for each mesh.
pub fn run(args: &Args) -> Result<(), String> {
    let peaks = Peaks::measure();
    println!("{}", peaks.line());
    println!();
    for &tets in &args.tets {
        let wanted = SessionSpec { tets, time_step: args.time_step, solver: SOLVERS[0].1 };
        let counts = counts(&wanted, args.steps)?;
        let mut table = Table::new(
            args.markdown,
            &["free hand", "kflop", "kB", "floor [us]", "measured [us]", "measured/floor"],
        );
        for count in &counts {
            let floor = (count.flops / (peaks.f64_gflops * 1e9))
                .max(count.bytes / peaks.bandwidth(count.bytes));
            table.row(&[
                format!("{tets} tets, {}", count.name),
                format!("{:.0}", count.flops * 1e-3),
                format!("{:.0}", count.bytes * 1e-3),
                format!("{:.1}", floor * 1e6),
                format!("{:.1}", count.time * 1e6),
                format!("{:.1}", count.time / floor),
            ]);
        }
        table.print();
    }
    Ok(())
}

/// Least times of the stages \[s\].
#[derive(Default)]
struct StageTimes {
    running: Option<(usize, Instant)>,
    now: [f64; 5],
}

impl StageTimer for StageTimes {
    fn begin(&mut self, stage: Option<Stage>) {
        let at = Instant::now();
        if let Some((stage, since)) = self.running.take() {
            self.now[stage] += (at - since).as_secs_f64();
        }
        self.running = stage.map(|stage| (stage as usize, at));
    }
}

/// For each number of iterations that occurred, the least time of the flesh stage; and the least
/// times of all stages.
fn stages(session: &mut Session, steps: u32) -> (Vec<(f64, f64)>, [f64; 5]) {
    let mut by_iterations: Vec<(f64, f64)> = Vec::new();
    let mut least = [f64::INFINITY; 5];
    for _ in 0..steps {
        let mut timer = StageTimes::default();
        let iterations = f64::from(session.step(&mut timer).cg_iterations);
        least.iter_mut().zip(timer.now).for_each(|(least, now)| *least = least.min(now));
        let flesh = timer.now[Stage::Flesh as usize];
        match by_iterations.iter_mut().find(|(n, _)| *n == iterations) {
            Some((_, time)) => *time = time.min(flesh),
            None => by_iterations.push((iterations, flesh)),
        }
    }
    (by_iterations, least)
}

fn counts(wanted: &SessionSpec, steps: u32) -> Result<Vec<StageCost>, String> {
    let mut session = free(wanted)?;
    let (usual, least) = stages(&mut session, steps);
    // The same steps solved more accurately, by which the factor is not yet worth its cost: the
    // difference is iterations alone.
    let mut settings = session.world().desc().solver;
    let (usual_n, usual_time) =
        usual.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no step was measured")?;
    settings.velocity_tolerance *= 1e-2;
    settings.step_halvings_max = 0;
    settings.cg_iterations_max = settings.cg_iterations_max.max(1000);
    session.world_mut().set_solver_settings(settings).map_err(|e| e.to_string())?;
    let (accurate, _) = stages(&mut session, steps);
    let (most_n, most_time) = accurate
        .iter()
        .copied()
        .filter(|(n, _)| *n > usual_n)
        .map(|(n, t)| (n, t, (t - usual_time) / (n - usual_n)))
        .min_by(|a, b| a.2.total_cmp(&b.2))
        .map(|(n, t, _)| (n, t))
        .ok_or("more accuracy took no more iterations")?;
    let iteration = (most_time - usual_time) / (most_n - usual_n);

    let world = session.world();
    let model = world.model();
    let (mut A, rows) = (model.pattern.clone(), model.rows());
    let row0 = 2 * model.rigids.len();
    let mut b = vec![Vec3::zeros(); rows];
    let (x, v, h) = (&world.state().x, &world.state().v[row0..], wanted.time_step);
    let mut assembly = f64::INFINITY;
    for _ in 0..steps {
        A.clear();
        let begun = Instant::now();
        model.flesh.assemble(x, v, &world.state().faded, h, row0, &mut A, &mut b);
        assembly = assembly.min(begun.elapsed().as_secs_f64());
    }

    let (tets, nodes) = (model.flesh.tets.len() as f64, model.flesh.mass.len() as f64);
    let carried: f64 = model.coupling.bound.iter().map(|b| b.bone_count() as f64).sum();
    let node_row = |i: usize| i >= row0;
    let blocks = (0..rows)
        .filter(|&i| node_row(i))
        .flat_map(|i| model.pattern.row(i))
        .filter(|&k| node_row(model.pattern.columns[k] as usize))
        .count() as f64;
    let met = carried / nodes;
    Ok(vec![
        StageCost {
            name: "assembly with rotations",
            // F 54, Newton 4×11, rotation 190, stress and forces 110, dots 60; 16 blocks of 9
            // numbers: two multiply-adds and the sum into the matrix.
            flops: tets * (460.0 + 16.0 * 9.0 * 5.0),
            // Rest shape 112, nodes and places 80; each block read and written once per element
            // is the caches' work: of the matrix once in, once out.
            bytes: tets * 192.0 + nodes * 72.0 + blocks * 144.0,
            time: assembly,
        },
        StageCost {
            name: "bones' system and block diagonal",
            // B J: nine multiply-adds of six numbers for each block and carrier; then Jᵀ.
            flops: blocks * met * 108.0 + nodes * met * 3.0 * 144.0 + nodes * 60.0,
            bytes: blocks * 72.0 + nodes * (144.0 + 192.0 * met),
            time: (usual_time - usual_n * iteration - assembly).max(0.0),
        },
        StageCost {
            name: "one iteration of conjugate gradients",
            flops: blocks * 18.0 + carried * 48.0 + nodes * (18.0 + 6.0 * 6.0),
            bytes: blocks * 76.0 + carried * 80.0 + nodes * (72.0 + 7.0 * 24.0),
            time: iteration,
        },
        StageCost {
            name: "all iterations of a step",
            flops: usual_n * (blocks * 18.0 + carried * 48.0 + nodes * 54.0),
            bytes: usual_n * (blocks * 76.0 + carried * 80.0 + nodes * 240.0),
            time: usual_n * iteration,
        },
        StageCost {
            name: "detection, nothing near",
            flops: model.vertices.len() as f64 * 48.0,
            bytes: model.vertices.len() as f64 * (48.0 + 48.0) + nodes * 48.0,
            time: least[Stage::Detect as usize],
        },
        StageCost {
            name: "integration and embedding",
            flops: model.vertices.len() as f64 * 24.0 + nodes * 6.0,
            bytes: model.vertices.len() as f64 * (48.0 + 24.0) + nodes * 72.0,
            time: least[Stage::Embed as usize],
        },
    ])
}
