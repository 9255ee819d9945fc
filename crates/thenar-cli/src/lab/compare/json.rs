//! A comparison as JSON with stable keys. Units are part of the keys.

use super::names;
use crate::run::{STAGES, StopWatch, times};
use serde_json::{Map, Value, json};
use thenar_scene::compare::{
    Cause, CompareMode, Comparison, MONOLITHIC, Peak, SideSummary, TWO_STEP,
};
use thenar_scene::session::PARTS;

/// The report.
pub fn report(of: &Comparison, paper: bool, watches: &[StopWatch; 2]) -> Value {
    let session = &of.sessions()[MONOLITHIC];
    let (s, bodies) = (of.summary(), of.bodies());
    let peak = |p: &Peak, unit: &str| {
        let mut keys = Map::new();
        keys.insert(format!("mean_{unit}"), json!(p.mean));
        keys.insert(format!("max_{unit}"), json!(p.max));
        keys.insert("max_at_s".into(), json!(p.time));
        keys
    };
    let bones = |p: &Peak, unit: &str| {
        let mut keys = peak(p, unit);
        keys.insert("max_bone".into(), json!(bodies.bone_names.get(p.at)));
        keys
    };
    let mut objects = Map::new();
    for (name, o) in bodies.object_names.iter().zip(&s.objects) {
        let of =
            json!({ "position": peak(&o.position, "m"), "rotation": peak(&o.rotation, "rad") });
        objects.insert(name.clone(), of);
    }
    let mut hands = Map::new();
    for (name, parts) in bodies.hand_names.iter().zip(&s.parts) {
        let mut hand = Map::new();
        for (part, p) in PARTS.iter().zip(parts) {
            let [two_step, monolithic] = p.normal.each_ref().map(|n| peak(n, "n"));
            let difference = peak(&p.difference, "n");
            let of =
                json!({ "difference": difference, "two_step": two_step, "monolithic": monolithic });
            hand.insert(part.name().into(), of);
        }
        hands.insert(name.clone(), Value::Object(hand));
    }
    let side = |i: usize| side(&s.sides[i], &watches[i], of.mode());
    json!({
        "scene": session.name(),
        "mode": match of.mode() { CompareMode::Trajectories => "trajectories", CompareMode::SingleSteps => "single-steps" },
        "scheme": names(paper)[TWO_STEP],
        "dt_s": session.world().time_step(),
        "steps": of.steps(),
        "difference": {
            "bone_position": bones(&s.position, "m"),
            "bone_rotation": bones(&s.rotation, "rad"),
            "drive_force": peak(&s.drive_force, "n"),
            "objects": objects,
            "normal_force": hands,
            "energy": peak(&s.energy, "j"),
        },
        "two_step": side(TWO_STEP),
        "monolithic": side(MONOLITHIC),
        "version": env!("CARGO_PKG_VERSION"),
    })
}

fn side(s: &SideSummary, watch: &StopWatch, mode: CompareMode) -> Value {
    let diverged = s.diverged.map(|d| match d.cause {
        Cause::NotFinite => json!({ "time_s": d.time, "cause": "not finite" }),
        Cause::Energy { energy, bound } => {
            json!({ "time_s": d.time, "cause": "energy", "energy_j": energy, "bound_j": bound })
        }
    });
    let mut stages = Map::new();
    if mode == CompareMode::Trajectories {
        for ((_, name), histogram) in STAGES.iter().zip(&watch.times.stages) {
            stages.insert((*name).into(), times(histogram));
        }
        stages.insert("total".into(), times(&watch.times.total));
    }
    json!({
        "diverged": diverged,
        "steps_taken_back": s.failed,
        "steps_fallen_back": s.fell_back,
        "joint_gap_mean_m": s.joint_gap.mean,
        "joint_gap_max_m": s.joint_gap.max,
        "joint_misalignment_mean_rad": s.joint_misalignment.mean,
        "joint_misalignment_max_rad": s.joint_misalignment.max,
        "penetration_max_m": s.penetration.max,
        "contacts_max": s.contacts,
        "energy_j": { "initial": s.energy_start, "final": s.energy_end, "max": s.energy_max },
        "stages": stages,
    })
}
