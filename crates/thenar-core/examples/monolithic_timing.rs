//! Times the stages of a step with both solvers, on the finger of the benches: free and pressed.
//! Prints the least time of each stage, which other load on the machine disturbs least.
//! `cargo run --release -p thenar-core --example monolithic_timing`

#[path = "../tests/common/mod.rs"]
mod common;

use common::{FLESH, bar, body, finger};
use std::time::Instant;
use thenar_core::model::{Binding, Drive, Motion, SolverKind, Springs};
use thenar_core::shape::Shape;
use thenar_core::world::{Stage, StageTimer, Target};
use thenar_core::{Pose, Quat, Vec3, World};

struct Watch {
    now: Option<(usize, Instant)>,
    step: [f64; 5],
    /// Least time of each stage, and of a whole step \[s\].
    least: [f64; 5],
    whole: f64,
}

impl Default for Watch {
    fn default() -> Self {
        Self { now: None, step: [0.0; 5], least: [f64::INFINITY; 5], whole: f64::INFINITY }
    }
}

impl Watch {
    fn finish(&mut self) {
        for (least, spent) in self.least.iter_mut().zip(self.step) {
            *least = least.min(spent);
        }
        self.whole = self.whole.min(self.step.iter().sum());
        self.step = [0.0; 5];
    }
}

impl StageTimer for Watch {
    fn begin(&mut self, stage: Option<Stage>) {
        let at = Instant::now();
        if let Some((stage, since)) = self.now.take() {
            self.step[stage] += at.duration_since(since).as_secs_f64();
        }
        let stages = [Stage::Skeleton, Stage::Flesh, Stage::Detect, Stage::Contact, Stage::Embed];
        self.now = stage.and_then(|s| stages.iter().position(|t| *t == s)).map(|s| (s, at));
    }
}

fn world(cells: [usize; 3], kind: SolverKind, height: f64) -> World {
    let mut desc = finger(1e9, 1e-3);
    let size = Vec3::new(0.06, 0.016, 0.016);
    let fine = bar(size, cells, FLESH);
    let soft = &mut desc.softs[0];
    if let Some(coupling) = &mut soft.coupling {
        let weight = |x: &Vec3| ((x.x - 0.02) / 0.02).clamp(0.0, 1.0);
        coupling.bindings = (fine.nodes.iter())
            .map(|x| Binding { bones: [0, 1], weights: [1.0 - weight(x), weight(x)] })
            .collect();
        let volume = size.product() / fine.nodes.len() as f64;
        let volumes = vec![volume; fine.nodes.len()];
        coupling.springs = Springs::PerVolume { stiffness: 1e9, volumes };
    }
    soft.flesh = fine;
    soft.flesh.mass_damping = 1.0;
    soft.flesh.stiffness_damping = 1e-3;
    let mut plane = body("ground", 1.0, [1.0; 3], Vec3::zeros());
    plane.motion = Motion::Prescribed;
    plane.shape = Some(Shape::HalfSpace);
    plane.pose_WB = Pose::translation(0.0, -height, 0.0);
    desc.add_rigid(plane);
    let drive =
        Drive { stiffness: 400.0, damping: 2.0, angular_stiffness: 0.4, angular_damping: 1e-3 };
    (desc.drives[0], desc.drives[1]) = (Some(drive), Some(drive));
    desc.solver.kind = kind;
    World::new(desc).expect("this example's own world")
}

fn main() {
    println!(
        "cells, height, solver: skeleton flesh detect contact embed, whole step, least [us]; work"
    );
    for cells in [[11, 3, 3], [14, 5, 5], [30, 10, 10]] {
        for (height, down) in [(10.0, 0.0), (0.0, 0.004)] {
            for kind in [SolverKind::TwoStep, SolverKind::Monolithic] {
                let mut world = world(cells, kind, height);
                let mut input = world.input();
                let start = [0, 1].map(|b| world.rigid_pose(b));
                let (mut watch, mut steps) = (Watch::default(), 0);
                let (mut cg, mut sweeps, mut active) = (0, 0, 0);
                for i in 0..400 {
                    let angle = 0.2 * (f64::from(i) * 6e-3).sin();
                    for b in 0..2 {
                        input.targets[b] = Some(Target {
                            pose_WB: Pose::new(
                                start[b].position - Vec3::y() * down,
                                Quat::from_scaled_axis(Vec3::z() * angle * b as f64),
                            ),
                            velocity_W: Vec3::zeros(),
                            angular_velocity_W: Vec3::zeros(),
                        });
                    }
                    if i == 200 {
                        (watch, steps, cg, sweeps, active) = (Watch::default(), 0, 0, 0, 0);
                    }
                    let report = world.step(&input, &mut watch);
                    watch.finish();
                    assert!(!report.fell_back && !report.non_finite, "{report:?}");
                    steps += 1;
                    cg += report.cg_iterations;
                    sweeps += report.contact_sweeps;
                    active += report.contacts_active;
                }
                let n = f64::from(steps);
                let us = watch.least.map(|s| (s * 1e6).round());
                println!(
                    "{cells:?} {height} {kind:?}: {us:?} {:.0}; cg {:.1}, sweeps {:.1}, active {:.0}",
                    watch.whole * 1e6,
                    f64::from(cg) / n,
                    f64::from(sweeps) / n,
                    f64::from(active) / n
                );
            }
        }
    }
}
