//! Factors the flesh matrices of hands with the core's Cholesky factor and with faer's: times,
//! numbers of the factor, allocations, error, and the same bits with two threads. Prints a section
//! of `results.md`.

mod faer_engine;
mod flesh;
mod math;
mod ours;
mod solver;

use cpu_time::ThreadTime;
use faer::sparse::linalg::SupernodalThreshold as Threshold;
use faer_engine::Faer;
use flesh::Matrix;
use math::Vec3;
use ours::Ours;
use thenar_core::model::Side;
use thenar_testing::allocations;

#[global_allocator]
static ALLOCATOR: allocations::Counting = allocations::Counting;

/// Timed rounds of every engine in turn; the quickest counts. Fewer of what takes long.
const ROUNDS: [usize; 3] = [60, 30, 10];

/// What factors one matrix, and solves with it.
pub trait Engine {
    fn name(&self) -> String;
    /// Numbers that the factor keeps.
    fn numbers(&self) -> usize;
    /// Factors the matrix anew; false when it cannot.
    fn refresh(&mut self) -> bool;
    fn solve(&mut self, x: &mut [Vec3]);
    /// Sixteen columns: all full, or the three of one node.
    fn solve_columns(&mut self, touched: Option<usize>);
    /// True if two threads factor to the same bits, twenty times; `None` where there is no second
    /// thread.
    fn two_threads_agree(&mut self) -> Option<bool> {
        None
    }
}

/// Least times \[ms\].
#[derive(Clone)]
struct Times {
    plan: f64,
    factor: f64,
    solve: f64,
    columns: f64,
    touched: f64,
}

fn main() {
    let head = [
        "tetrahedra, unknowns",
        "engine",
        "plan [ms]",
        "factor [ms]",
        "one solve [ms]",
        "16 columns [ms]",
        "of one node [ms]",
        "numbers",
        "allocations per factor",
        "error",
        "two threads: same bits",
    ];
    println!("| {} |\n|{}", head.join(" | "), "---|".repeat(head.len()));
    let hands = [
        thenar_rig::uniform_hand(Side::Right, 600),
        thenar_rig::default_hand(Side::Right),
        thenar_rig::uniform_hand(Side::Right, 17_000),
    ];
    for (hand, rounds) in hands.into_iter().zip(ROUNDS) {
        match hand {
            Ok(hand) => compare(&Matrix::of(&hand), rounds),
            Err(problem) => eprintln!("{problem}"),
        }
    }
}

fn compare(matrix: &Matrix, rounds: usize) {
    let single = ("f32", (|x| x as f32) as fn(f64) -> f32, (|x| f64::from(*x)) as fn(&f32) -> f64);
    let double = ("f64", (|x| x) as fn(f64) -> f64, (|x| *x) as fn(&f64) -> f64);
    let order = Ours::new(matrix).order();
    type Plan<'a> = Box<dyn Fn() -> Box<dyn Engine + 'a> + 'a>;
    let plans: Vec<Plan<'_>> = vec![
        Box::new(|| Box::new(Ours::new(matrix))),
        Box::new(|| Box::new(Faer::new(single, matrix, None, Threshold::AUTO))),
        Box::new(|| Box::new(Faer::new(single, matrix, Some(&order), Threshold::AUTO))),
        Box::new(|| Box::new(Faer::new(single, matrix, None, Threshold::FORCE_SIMPLICIAL))),
        Box::new(|| Box::new(Faer::new(double, matrix, None, Threshold::AUTO))),
    ];
    // faer may have chosen by itself what it is made to do.
    let mut names = std::collections::HashSet::new();
    let made = plans.iter().map(|plan| (plan(), plan));
    let (mut engines, plans): (Vec<_>, Vec<_>) =
        made.filter(|(engine, _)| names.insert(engine.name())).unzip();
    let never = f64::INFINITY;
    let none = Times { plan: never, factor: never, solve: never, columns: never, touched: never };
    let mut times = vec![none; engines.len()];
    let (want, rhs) = problem(matrix);
    let mut x = rhs.clone();
    let touched = matrix.positions.len() / 2;
    for round in 0..rounds {
        for ((engine, plan), least) in engines.iter_mut().zip(&plans).zip(&mut times) {
            if round % 10 == 0 {
                time(&mut least.plan, || drop(plan()));
            }
            time(&mut least.factor, || assert!(engine.refresh(), "positive definite"));
            x.copy_from_slice(&rhs);
            time(&mut least.solve, || engine.solve(&mut x));
            time(&mut least.columns, || engine.solve_columns(None));
            time(&mut least.touched, || engine.solve_columns(Some(touched)));
        }
    }
    for (engine, times) in engines.iter_mut().zip(times) {
        let (allocations, _) = allocations::count(|| engine.refresh());
        x.copy_from_slice(&rhs);
        engine.solve(&mut x);
        let largest = want.iter().map(Vec3::amax).fold(0.0, f64::max);
        let error = x.iter().zip(&want).map(|(x, w)| (x - w).amax()).fold(0.0, f64::max) / largest;
        let agree = match engine.two_threads_agree() {
            Some(true) => "yes",
            Some(false) => "no",
            None => "–",
        };
        let Times { plan, factor, solve, columns, touched } = times;
        println!(
            "| {}, {} | {} | {plan:.1} | {factor:.3} | {solve:.3} | {columns:.3} | {touched:.3} | {} | {allocations} | {error:.0e} | {agree} |",
            matrix.tets,
            matrix.size(),
            engine.name(),
            engine.numbers(),
        );
    }
}

/// A solution, and the right-hand side that it comes from.
fn problem(matrix: &Matrix) -> (Vec<Vec3>, Vec<Vec3>) {
    let wave =
        |i: usize| Vec3::new((i as f64).sin(), (1.3 * i as f64).cos(), (0.7 * i as f64).sin());
    let want: Vec<Vec3> = (0..matrix.positions.len()).map(wave).collect();
    let rhs = matrix.times(&want);
    (want, rhs)
}

fn time(least: &mut f64, act: impl FnOnce()) {
    let start = ThreadTime::now();
    act();
    *least = least.min(1e3 * start.elapsed().as_secs_f64());
}
