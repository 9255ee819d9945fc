//! Figures of a run: as JSON with stable keys, and as a table.

use super::Outcome;
use super::timer::STAGES;
use super::verdict::{Evidence, Verdict};
use crate::words::{counted, joules};
use serde_json::{Map, Value, json};
use thenar_core::World;
use thenar_core::histogram::Histogram;
use thenar_core::model::Digit;
use thenar_scene::session::{HandLoad, Session, StartOverlap};

/// Version of the report. 2: each finger's mean pressure, and what overlaps at the start. 3:
/// contacts left out. 4: steps made in parts. 5: which figures to trust, and why. 6: how long
/// tetrahedra were inside out. What an earlier version gave is there under the same keys. 7: the
/// default `solver` is called "monolithic".
const REPORT_VERSION: u32 = 7;

/// The report as JSON. Units are part of the keys: `_s`, `_us`, `_m`, `_j`, `_n`, `_m2`, `_pa`.
pub fn report(session: &Session, outcome: &Outcome) -> Value {
    let world = session.world();
    let s = &outcome.summary;
    let simulated = session.steps() as f64 * world.time_step();
    let mut stages = Map::new();
    for ((_, name), histogram) in STAGES.iter().zip(&outcome.times.stages) {
        stages.insert((*name).into(), times(histogram));
    }
    stages.insert("total".into(), times(&outcome.times.total));
    let mut fingers = Map::new();
    for (digit, peak) in Digit::FINGERS.iter().zip(&s.fingers) {
        let peak = json!({
            "normal_n": peak.normal,
            "shear_n": peak.shear,
            "area_m2": peak.area,
            "pressure_mean_pa": peak.pressure,
        });
        fingers.insert(digit.name().into(), peak);
    }
    json!({
        "report_version": REPORT_VERSION,
        "scene": session.name(),
        "solver": world.desc().solver.kind.name(),
        "dt_s": world.time_step(),
        "steps": session.steps(),
        "simulated_s": simulated,
        "wall_s": outcome.wall,
        "realtime_factor": if outcome.wall > 0.0 { simulated / outcome.wall } else { 0.0 },
        "interrupted": outcome.interrupted,
        "stages": stages,
        "tets": tets(session),
        "nodes": world.state().x.len(),
        "contacts_max": s.contacts_max,
        "contacts_dropped_max": s.contacts_dropped_max,
        "max_joint_gap_m": s.joint_gap_max,
        "max_penetration_m": s.penetration_max,
        "inverted_tets_max": s.inverted_tets_max,
        "inverted_longest_s": s.inverted_longest as f64 * world.time_step(),
        "non_finite": s.non_finite,
        "fell_back": s.fell_back,
        "divided": s.divided,
        "contact_cut_short": s.contact_cut_short,
        "contact_unconverged": s.contact_unconverged,
        "contact_residual_max": s.contact_residual_max,
        "energy_j": {
            "initial": s.energy_initial.total(),
            "final": s.energy_final.total(),
            "max": s.energy_max,
        },
        "fingers": fingers,
        "start_overlaps": session.start_overlaps().iter().map(overlap).collect::<Vec<_>>(),
        "trust": verdict(session, outcome).json(),
        "state_hash": format!("{:016x}", world.state_hash()),
        "version": env!("CARGO_PKG_VERSION"),
    })
}

fn overlap(overlap: &StartOverlap) -> Value {
    let place = overlap.place_W;
    json!({
        "bodies": overlap.bodies,
        "depth_m": overlap.depth,
        "place_m": [place.x, place.y, place.z],
    })
}

/// Median, p99 and longest of durations.
pub fn times(histogram: &Histogram) -> Value {
    let us = |ns: u64| ns as f64 / 1e3;
    json!({
        "median_us": us(histogram.quantile(0.5)),
        "p99_us": us(histogram.quantile(0.99)),
        "max_us": us(histogram.max()),
    })
}

fn tets(session: &Session) -> usize {
    session.world().desc().softs.iter().map(|s| s.flesh.tets.len()).sum()
}

/// Judges the run by its figures.
fn verdict(session: &Session, outcome: &Outcome) -> Verdict {
    Verdict::new(&Evidence {
        steps: outcome.steps,
        time_step: session.world().time_step(),
        summary: &outcome.summary,
        settings: &session.world().desc().solver,
        tets: tets(session),
        inverted: session.report().inverted_tets,
        overlaps: session.start_overlaps(),
    })
}

/// Prints the figures for a person.
pub fn print(session: &Session, outcome: &Outcome) {
    let world = session.world();
    let s = &outcome.summary;
    let simulated = session.steps() as f64 * world.time_step();
    match session.scene().title.as_deref() {
        Some(title) => println!("{}: {title}", session.name()),
        None => println!("{}", session.name()),
    }
    println!(
        "  {:.3} s simulated in {:.3} s ({:.2} x real time), {} steps of {:.3} ms, {} solver",
        simulated,
        outcome.wall,
        if outcome.wall > 0.0 { simulated / outcome.wall } else { 0.0 },
        session.steps(),
        world.time_step() * 1e3,
        world.desc().solver.kind.name(),
    );
    let bodies: String = match world.desc().rigids.len() {
        1 => "1 rigid body".into(),
        count => format!("{count} rigid bodies"),
    };
    println!(
        "  {}, {}, {} tetrahedra, {} nodes",
        bodies,
        counted(world.desc().joints.len() as u64, "joint"),
        tets(session),
        world.state().x.len()
    );
    stages(outcome);
    println!(
        "  at most: {}, {:.4} mm joint gap, {:.4} mm penetration, {} inverted tetrahedra",
        counted(s.contacts_max, "contact"),
        s.joint_gap_max * 1e3,
        s.penetration_max * 1e3,
        s.inverted_tets_max
    );
    println!(
        "  energy: {} at the start, {} in the end, {} at most",
        joules(s.energy_initial.total()),
        joules(s.energy_final.total()),
        joules(s.energy_max)
    );
    let hands: Vec<_> = session
        .hands()
        .iter()
        .zip(&s.hands)
        .map(|(hand, peaks)| HandPeaks {
            name: &hand.name,
            peaks: *peaks,
            points: areas_of_points(world, hand.flesh()),
        })
        .collect();
    fingers(&hands).iter().for_each(|line| println!("  {line}"));
    if s.contact_cut_short > 0 {
        println!(
            "  contact was cut short by contact_work_max in {}",
            counted(s.contact_cut_short, "step")
        );
    }
    if s.divided > 0 {
        println!(
            "  made in parts, as contact changed too much within them: {}",
            counted(s.divided, "step")
        );
    }
    println!("  state {:016x}", world.state_hash());
    println!("  {}", verdict(session, outcome).line());
}

/// Prints the time of each stage of a step.
fn stages(outcome: &Outcome) {
    println!("  {:10} {:>11} {:>11} {:>11}", "stage", "median [us]", "p99 [us]", "max [us]");
    let line = |name: &str, h: &Histogram| {
        let us = |ns: u64| ns as f64 * 1e-3;
        println!(
            "  {name:10} {:11.1} {:11.1} {:11.1}",
            us(h.quantile(0.5)),
            us(h.quantile(0.99)),
            us(h.max())
        );
    };
    for ((_, name), histogram) in STAGES.iter().zip(&outcome.times.stages) {
        line(name, histogram);
    }
    line("whole step", &outcome.times.total);
}

/// A hand, and the most that pressed on its fingers.
struct HandPeaks<'a> {
    name: &'a str,
    peaks: [HandLoad; 5],
    /// Area for which a vertex stands where each finger's skin is fine \[m²\].
    points: [f64; 5],
}

/// Area for which a vertex stands where each finger's skin is fine \[m²\], a third of the triangles
/// around it: a quarter of the finger's vertices stand for less. 0 without flesh.
fn areas_of_points(world: &World, soft: Option<u32>) -> [f64; 5] {
    let Some(soft) = soft else { return [0.0; 5] };
    let body = &world.desc().softs[soft as usize];
    let x = world.collision_vertices(soft);
    let mut areas = vec![0.0; x.len()];
    for triangle in &body.flesh.collision.triangles {
        let [a, b, c] = triangle.map(|v| x[v as usize]);
        let third = (b - a).cross(&(c - a)).norm() / 6.0;
        triangle.iter().for_each(|&v| areas[v as usize] += third);
    }
    Digit::FINGERS.map(|digit| {
        let is_on = |v: u32| world.model().part_of(soft, v) == u32::from(digit.part());
        let own = (0..).zip(&areas).filter(|(v, _)| is_on(*v));
        let mut own: Vec<f64> = own.map(|(_, area)| *area).collect();
        own.sort_by(f64::total_cmp);
        own.get(own.len() / 4).copied().unwrap_or(0.0)
    })
}

/// Tables of the fingers that touched something, one for each hand, under its name where there are
/// several.
fn fingers(hands: &[HandPeaks]) -> Vec<String> {
    let touched = |hand: &&HandPeaks| hand.peaks.iter().any(|peak| peak.normal > 0.0);
    let (mut lines, mut is_fine) = (Vec::new(), true);
    for hand in hands.iter().filter(touched) {
        if hands.len() > 1 {
            lines.push(format!("{}:", hand.name));
        }
        lines.push(format!(
            "{:10} {:>11} {:>11} {:>11} {:>14}",
            "at most", "normal [N]", "shear [N]", "area [mm²]", "mean [kPa] (*)"
        ));
        let all = Digit::FINGERS.iter().zip(&hand.peaks).zip(hand.points);
        for ((digit, peak), point) in all.filter(|((_, peak), _)| peak.normal > 0.0) {
            let HandLoad { normal, shear, area, pressure } = peak;
            let is_resolved = *normal >= pressure * point;
            is_fine &= is_resolved;
            let pressure = match is_resolved {
                true => format!("{:.2}", pressure * 1e-3),
                false => "(**)".into(),
            };
            lines.push(format!(
                "{:10} {normal:11.3} {shear:11.3} {:11.1} {pressure:>14}",
                digit.name(),
                area * 1e6,
            ));
        }
    }
    if !lines.is_empty() {
        lines.push("(*) mean pressure, force over area, when the normal force was largest".into());
    }
    if !is_fine {
        lines.push(
            "(**) on less skin than one vertex of the mesh stands for: its pressure would be the mesh's, not that of flesh"
                .into(),
        );
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hand(name: &str, peaks: [HandLoad; 5]) -> HandPeaks<'_> {
        HandPeaks { name, peaks, points: [4e-6; 5] }
    }

    /// A hand of which one finger is pressed by `normal` on `area`.
    fn pressed(finger: usize, normal: f64, area: f64) -> [HandLoad; 5] {
        let mut peaks = [HandLoad::default(); 5];
        peaks[finger] = HandLoad { normal, shear: 0.5, area, pressure: normal / area };
        peaks
    }

    const HEAD: &str = "at most     normal [N]   shear [N]  area [mm²] mean [kPa] (*)";
    const NOTE: &str = "(*) mean pressure, force over area, when the normal force was largest";

    /// With several hands each has its table, under its name; one that touched nothing has none.
    #[test]
    fn forces_are_told_of_each_hand() {
        let none = [HandLoad::default(); 5];
        let thumb = "thumb            1.500       0.500        75.0          20.00";
        let index = "index            2.000       0.500       100.0          20.00";
        let right = || hand("right", pressed(0, 1.5, 7.5e-5));
        let left = || hand("left", pressed(1, 2.0, 1e-4));
        assert_eq!(fingers(&[right()]), [HEAD, thumb, NOTE]);
        let both = ["right:", HEAD, thumb, "left:", HEAD, index, NOTE];
        assert_eq!(fingers(&[right(), left()]), both);
        assert_eq!(fingers(&[hand("right", none), left()]), ["left:", HEAD, index, NOTE]);
        assert!(fingers(&[hand("right", none)]).is_empty());
    }

    /// A vertex stands for 4 mm²: a force on 4.1 has a pressure, one on 0.4 none that means
    /// anything.
    #[test]
    fn no_pressure_is_told_of_less_than_a_vertex() {
        let table = |area: f64| fingers(&[hand("right", pressed(1, 0.41, area))]);
        assert_eq!(
            table(4.1e-6)[1],
            "index            0.410       0.500         4.1         100.00"
        );
        assert_eq!(table(4.1e-6).len(), 3);
        let coarse = table(0.4e-6);
        assert_eq!(coarse[1], "index            0.410       0.500         0.4           (**)");
        assert!(coarse[3].starts_with("(**) on less skin than one vertex"), "{}", coarse[3]);
    }

    /// A quarter of the vertices of each finger stand for less.
    #[test]
    fn points_stand_for_a_third_of_what_is_around_them() {
        let text = "version = 1\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\n";
        let session = Session::from_text(text, std::path::Path::new("hand.toml"), &[]).unwrap();
        let (world, soft) = (session.world(), session.hands()[0].flesh().unwrap());
        let x = world.collision_vertices(soft);
        let triangles = &world.desc().softs[soft as usize].flesh.collision.triangles;
        let stands_for = |v: &u32| -> f64 {
            let around =
                triangles.iter().filter(|t| t.contains(v)).map(|t| t.map(|v| x[v as usize]));
            around.map(|[a, b, c]| (b - a).cross(&(c - a)).norm() / 6.0).sum()
        };
        for (digit, told) in Digit::FINGERS.iter().zip(areas_of_points(world, Some(soft))) {
            let is_on = |v: &u32| world.model().part_of(soft, *v) == u32::from(digit.part());
            let own: Vec<f64> = (0..x.len() as u32).filter(is_on).map(|v| stands_for(&v)).collect();
            let less = own.iter().filter(|area| **area < told * (1.0 - 1e-9)).count();
            assert!(own.len() > 20 && less == own.len() / 4, "{digit:?}: {less} of {}", own.len());
        }
        assert_eq!(areas_of_points(world, None), [0.0; 5]);
    }
}
