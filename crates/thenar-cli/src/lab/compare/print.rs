//! A comparison for a person.

use super::{DEG, MM, names};
use crate::run::{STAGES, StopWatch};
use thenar_core::histogram::Histogram;
use thenar_scene::compare::{CompareMode, Comparison, MONOLITHIC, Object, Peak, SIDES, TWO_STEP};
use thenar_scene::session::PARTS;

/// Says that a side has diverged.
pub fn divergence(of: &Comparison, side: usize) {
    if let Some(divergence) = of.summary().sides[side].diverged {
        eprintln!("{} {divergence}", SIDES[side]);
    }
}

/// Prints means, extremes and times.
pub fn summary(of: &Comparison, paper: bool, watches: &[StopWatch; 2]) {
    let session = &of.sessions()[MONOLITHIC];
    let (world, s, bodies) = (session.world(), of.summary(), of.bodies());
    let title = session.scene().title.as_deref().unwrap_or_default();
    println!("{}: {title}", session.name());
    let h = world.time_step();
    println!(
        "  {:.3} s, {} steps of {:.3} ms; {} tetrahedra, {} rigid bodies, {} joints",
        of.steps() as f64 * h,
        of.steps(),
        h * 1e3,
        world.desc().softs.iter().map(|s| s.flesh.tets.len()).sum::<usize>(),
        world.desc().rigids.len(),
        world.desc().joints.len(),
    );
    let names = names(paper);
    if of.mode() == CompareMode::SingleSteps {
        println!("  every step from the monolithic state: differences are those of one step");
    }
    for (name, side) in names.iter().zip(&s.sides) {
        if let Some(divergence) = side.diverged {
            println!("  {name} {divergence}; differences are those until then");
        }
        if side.failed > 0 && side.diverged.is_none() {
            println!("  {name}: {} steps gave no finite numbers and were taken back", side.failed);
        }
        if side.fell_back > 0 {
            println!(
                "  {name}: {} steps could not be solved and were made another way",
                side.fell_back
            );
        }
    }
    println!("\n  {:30} {:>11} {:>11}  largest at", "difference", "mean", "largest");
    let difference = |what: &str, p: &Peak, scale: f64, unit: &str, at: &str| {
        let (mean, max, time) = (p.mean * scale, p.max * scale, p.time);
        let unit = format!("{what} [{unit}]");
        println!("  {unit:30} {} {}  {time:.3} s {at}", digits(mean), digits(max));
    };
    let bone = |p: &Peak| bodies.bone_names.get(p.at).map_or("", String::as_str);
    if !bodies.bones.is_empty() {
        difference("bones, position", &s.position, MM, "mm", bone(&s.position));
        difference("bones, rotation", &s.rotation, DEG, "deg", bone(&s.rotation));
    }
    if !bodies.driven.is_empty() {
        let driven = bodies.driven.get(s.drive_force.at);
        let name = driven.map_or("", |&i| world.desc().rigids[i as usize].name.as_str());
        difference("drive force", &s.drive_force, 1.0, "N", name);
    }
    for ((object, name), o) in bodies.objects.iter().zip(&bodies.object_names).zip(&s.objects) {
        difference(&format!("{name}, position"), &o.position, MM, "mm", "");
        if matches!(object, Object::Rigid(_)) {
            difference(&format!("{name}, rotation"), &o.rotation, DEG, "deg", "");
        }
    }
    for (h, p) in s.touched() {
        let what = format!("{} {}, force", bodies.hand_names[h], PARTS[p].name());
        difference(&what, &s.parts[h][p].difference, 1.0, "N", "");
    }
    difference("energy", &s.energy, 1e3, "mJ", "");

    let [a, b] = names;
    println!("\n  {:30} {a:>16} {b:>16}", "each");
    let each = |what: &str, of: [f64; 2]| {
        println!("  {what:30} {:>16} {:>16}", digits(of[0]), digits(of[1]));
    };
    let sides = |f: fn(&thenar_scene::compare::SideSummary) -> f64| s.sides.each_ref().map(f);
    if !world.desc().joints.is_empty() {
        each("joint gap, mean [mm]", sides(|s| s.joint_gap.mean * MM));
        each("joint gap, largest [mm]", sides(|s| s.joint_gap.max * MM));
        each("misalignment, mean [deg]", sides(|s| s.joint_misalignment.mean * DEG));
        each("misalignment, largest [deg]", sides(|s| s.joint_misalignment.max * DEG));
    }
    if s.sides.iter().any(|s| s.contacts > 0) {
        each("penetration, largest [mm]", sides(|s| s.penetration.max * MM));
    }
    for (h, p) in s.touched() {
        let name = format!("{} {}", bodies.hand_names[h], PARTS[p].name());
        let normal = &s.parts[h][p].normal;
        each(&format!("{name}, mean [N]"), normal.map(|n| n.mean));
        each(&format!("{name}, largest [N]"), normal.map(|n| n.max));
    }
    each("energy at the start [mJ]", sides(|s| s.energy_start * 1e3));
    each("energy in the end [mJ]", sides(|s| s.energy_end * 1e3));
    each("energy, largest [mJ]", sides(|s| s.energy_max * 1e3));
    if of.mode() == CompareMode::SingleSteps {
        return;
    }
    println!("\n  {:14} {:>25} {:>25}", "median / p99 [us]", a, b);
    let [two, monolithic] = [TWO_STEP, MONOLITHIC].map(|side| &watches[side].times);
    let cell = |h: &Histogram| {
        let [median, p99] = [0.5, 0.99].map(|q| h.quantile(q) as f64 * 1e-3);
        format!("{median:11.1} / {p99:11.1}")
    };
    for (k, (_, stage)) in STAGES.iter().enumerate() {
        println!("  {stage:17} {:>25} {:>25}", cell(&two.stages[k]), cell(&monolithic.stages[k]));
    }
    println!("  {:17} {:>25} {:>25}", "whole step", cell(&two.total), cell(&monolithic.total));
}

/// Four digits that matter, in eleven places.
pub fn digits(x: f64) -> String {
    let size = x.abs();
    let text = match size {
        _ if x == 0.0 => "0".into(),
        _ if !size.is_finite() => "-".into(),
        _ if !(1e-3..1e5).contains(&size) => format!("{x:.3e}"),
        _ => {
            let decimals = (3.0 - size.log10().floor()).clamp(0.0, 6.0) as usize;
            format!("{x:.decimals$}")
        }
    };
    format!("{text:>11}")
}
