//! Puts pairs of rigid shapes to Thenar's narrow phase and to parry3d's contact manifolds: time,
//! points, how far off the told distance is, and how steady the points are. Prints a section of
//! `results.md`.

mod ours;
mod parry;
mod placements;
mod truth;

use cpu_time::ThreadTime;
use placements::{Kind, Placement, kinds};
use thenar_core::Vec3;

/// Surfaces nearer than this are in contact, in every engine \[m\].
const MARGIN: f64 = 1e-3;
/// Timed rounds of every engine in turn; the quickest counts.
const ROUNDS: usize = 9;
/// A distance that is off by more than this counts as wrong \[m\].
const WRONG: f64 = 10e-6;
/// Points higher than this above the lowest have no part in the place of a manifold \[m\].
const FADE: f64 = 0.1e-3;

/// One contact point.
#[derive(Clone, Copy)]
pub struct Touch {
    pub on_a: Vec3,
    pub on_b: Vec3,
    /// From B to A.
    pub normal: Vec3,
    pub gap: f64,
}

/// What finds the contacts of a list of placements, and keeps them.
pub trait Engine {
    fn name(&self) -> &'static str;
    /// All placements as they are (0) or moved by 10 µm (1); `kept` from what the last search left,
    /// if it leaves anything.
    fn search(&mut self, moved: usize, kept: bool);
    /// What the last search found at placement `i`.
    fn touches(&self, i: usize) -> Vec<Touch>;
}

/// What is told of one engine.
#[derive(Default)]
struct Told {
    fresh: f64,
    kept: f64,
    points: usize,
    points_max: usize,
    /// Of placements apart, and of deep ones: the largest error \[m\], how many are wrong, and not
    /// found.
    off_max: [f64; 2],
    wrong: [usize; 2],
    missed: [usize; 2],
    /// Largest change of the distance by a move of 10 µm, fresh and kept \[m\].
    change_max: [f64; 2],
    /// Ways of the manifold's place by that move \[m\].
    ways: [Vec<f64>; 2],
}

fn main() {
    let head = [
        "pair",
        "engine",
        "µs fresh",
        "kept",
        "points (most)",
        "distance off, apart, most [µm]",
        "overlapping",
        "off by > 10 µm",
        "not found",
        "change, most [µm]",
        "place moves, fresh: median, most [µm]",
        "kept",
    ];
    println!("| {} |\n|{}", head.join(" | "), "---|".repeat(head.len()));
    for kind in kinds() {
        let placements = kind.placements();
        let mut engines: Vec<Box<dyn Engine>> = vec![
            Box::new(ours::Ours::new(&kind, &placements)),
            Box::new(parry::single::Parry::new(&kind, &placements)),
            Box::new(parry::centimetres::Parry::new(&kind, &placements)),
            Box::new(parry::double::Parry::new(&kind, &placements)),
        ];
        let mut told = judged(&kind, &placements, &mut engines);
        for round in 0..ROUNDS {
            for (engine, told) in engines.iter_mut().zip(&mut told) {
                let per_pair = 1e6 / placements.len() as f64;
                for (kept, least) in [(false, &mut told.fresh), (true, &mut told.kept)] {
                    let start = ThreadTime::now();
                    engine.search(usize::from(kept && round % 2 == 0), kept);
                    *least = least.min(start.elapsed().as_secs_f64() * per_pair);
                }
            }
        }
        for (engine, told) in engines.iter().zip(told) {
            println!("| {} | {} | {} |", kind.name, engine.name(), told.cells(placements.len()));
        }
    }
}

/// Everything but the times.
fn judged(kind: &Kind, placements: &[Placement], engines: &mut [Box<dyn Engine>]) -> Vec<Told> {
    let mut first: Vec<Vec<Option<Touch>>> = Vec::new();
    let mut all: Vec<Told> = Vec::new();
    for engine in engines {
        let mut told = Told { fresh: f64::INFINITY, kept: f64::INFINITY, ..Told::default() };
        let found = |engine: &dyn Engine| -> Vec<Vec<Touch>> {
            (0..placements.len()).map(|i| engine.touches(i)).collect()
        };
        let lowest =
            |touches: &Vec<Touch>| touches.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)).copied();
        for kept in [false, true] {
            let which = usize::from(kept);
            engine.search(0, false);
            let before = found(&**engine);
            engine.search(1, kept);
            for (before, now) in before.iter().zip(found(&**engine)) {
                if let (Some(p), Some(q)) = (lowest(before), lowest(&now)) {
                    told.change_max[which] = told.change_max[which].max((p.gap - q.gap).abs());
                }
                if let (Some(p), Some(q)) = (place(before), place(&now)) {
                    told.ways[which].push((p - q).norm());
                }
            }
            if !kept {
                told.points = before.iter().map(Vec::len).sum();
                told.points_max = before.iter().map(Vec::len).max().unwrap_or(0);
                first.push(before.iter().map(lowest).collect());
            }
        }
        all.push(told);
    }
    for (i, placement) in placements.iter().enumerate() {
        let normals = first.iter().filter_map(|of| Some(of[i]?.normal));
        let truth = truth::separation(kind, &placement.poses[0], normals);
        let deep = usize::from(truth < 0.0);
        for (told, of) in all.iter_mut().zip(&first) {
            let Some(found) = of[i] else {
                told.missed[deep] += 1;
                continue;
            };
            let off = (found.gap - truth).abs();
            told.off_max[deep] = told.off_max[deep].max(off);
            told.wrong[deep] += usize::from(off > WRONG);
        }
    }
    all
}

/// The middle of a manifold's points, the lower the heavier.
fn place(touches: &[Touch]) -> Option<Vec3> {
    let lowest = touches.iter().map(|t| t.gap).reduce(f64::min)?;
    let mut sum = (Vec3::zeros(), 0.0);
    for touch in touches {
        let weight = (lowest + FADE - touch.gap).max(0.0);
        sum = (sum.0 + 0.5 * weight * (touch.on_a + touch.on_b), sum.1 + weight);
    }
    Some(sum.0 / sum.1)
}

impl Told {
    fn cells(mut self, count: usize) -> String {
        self.ways.iter_mut().for_each(|ways| ways.sort_by(f64::total_cmp));
        let micrometres = |x: f64| format!("{:.1}", 1e6 * x);
        let ways = |ways: &[f64]| match ways {
            [] => "–".to_string(),
            [.., most] => {
                format!("{}, {}", micrometres(ways[ways.len() / 2]), micrometres(*most))
            }
        };
        let counts = |[apart, deep]: [usize; 2]| format!("{apart} + {deep}");
        [
            format!("{:.2}", self.fresh),
            format!("{:.2}", self.kept),
            format!("{:.1} ({})", self.points as f64 / count as f64, self.points_max),
            micrometres(self.off_max[0]),
            micrometres(self.off_max[1]),
            counts(self.wrong),
            counts(self.missed),
            self.change_max.map(micrometres).join(", "),
            ways(&self.ways[0]),
            ways(&self.ways[1]),
        ]
        .join(" | ")
    }
}
