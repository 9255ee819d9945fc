//! A comparison over time as a page of charts.

use super::{DEG, MM};
use crate::chart::{Axis, Dash, Line, Panel, Reduced, page};
use thenar_scene::compare::{CompareMode, Comparison, MONOLITHIC, SIDES, TWO_STEP};
use thenar_scene::session::PARTS;

/// Names of a panel and its lines, with colours.
struct Plan {
    title: &'static str,
    lines: Vec<(String, usize, Dash)>,
    log: bool,
}

/// Series of every panel, filled step by step.
pub struct Charts {
    plans: Vec<Plan>,
    series: Vec<Vec<Reduced>>,
    end: f64,
}

fn differences(title: &'static str) -> Plan {
    let lines =
        vec![("largest over bones".into(), 3, Dash::Solid), ("mean".into(), 2, Dash::Solid)];
    Plan { title, lines, log: false }
}

fn both(title: &'static str, log: bool) -> Plan {
    let line = |side: usize, dash| (SIDES[side].to_string(), side, dash);
    Plan { title, lines: vec![line(MONOLITHIC, Dash::Solid), line(TWO_STEP, Dash::Dashed)], log }
}

/// Values of the present moment, panel by panel and line by line.
fn values(of: &Comparison) -> Vec<Vec<f64>> {
    const NONE: f64 = f64::NAN;
    let (m, bodies) = (of.moment(), of.bodies());
    let mut panels = Vec::new();
    if !bodies.bones.is_empty() {
        for (apart, scale) in [(m.position, MM), (m.rotation, DEG)] {
            panels.push(apart.map_or(vec![NONE; 2], |a| vec![a.max * scale, a.mean * scale]));
        }
        let gap = |side: usize| m.sides[side].as_ref().map_or(NONE, |s| s.joint_gap * MM);
        panels.push(vec![gap(MONOLITHIC), gap(TWO_STEP)]);
    }
    for hand in 0..bodies.hands.len() {
        let force = |side: usize, part: usize| {
            m.sides[side].as_ref().map_or(NONE, |s| s.loads[hand][part].normal)
        };
        let of_part = |p: usize| [MONOLITHIC, TWO_STEP].map(|side| force(side, p));
        panels.push((0..PARTS.len()).flat_map(of_part).collect());
    }
    if !bodies.objects.is_empty() {
        panels.push(
            m.objects.iter().map(|o| o.map_or(NONE, |[position, _]| position * MM)).collect(),
        );
    }
    let energy = |side: usize| m.sides[side].as_ref().map_or(NONE, |s| s.energy);
    panels.push(vec![energy(MONOLITHIC), energy(TWO_STEP)]);
    panels
}

impl Charts {
    /// Charts for a comparison of a number of steps.
    pub fn new(of: &Comparison, steps: u64) -> Self {
        let bodies = of.bodies();
        let mut plans = Vec::new();
        if !bodies.bones.is_empty() {
            plans.push(differences("Bones: distance [mm]"));
            plans.push(differences("Bones: angle between them [deg]"));
            plans.push(both("Joint gap, largest [mm]", true));
        }
        for _ in &bodies.hands {
            // Each part once in the legend: the dashed one needs no name.
            let line = |p: usize, dash| {
                let name = if dash == Dash::Solid { PARTS[p].name() } else { "" };
                (name.to_string(), p, dash)
            };
            let lines =
                (0..PARTS.len()).flat_map(|p| [line(p, Dash::Solid), line(p, Dash::Dashed)]);
            plans.push(Plan {
                title: "Normal force [N], monolithic solid, two-step dashed",
                lines: lines.collect(),
                log: false,
            });
        }
        if !bodies.objects.is_empty() {
            let names = bodies.object_names.iter().enumerate();
            let lines = names.map(|(k, name)| (name.clone(), k + 2, Dash::Solid)).collect();
            plans.push(Plan { title: "Objects: distance [mm]", lines, log: false });
        }
        plans.push(both("Energy [J]", false));
        let series = |plan: &Plan| plan.lines.iter().map(|_| Reduced::new(steps)).collect();
        let end = steps as f64 * of.sessions()[MONOLITHIC].world().time_step();
        Self { series: plans.iter().map(series).collect(), plans, end }
    }

    /// Takes in the present moment.
    pub fn take(&mut self, of: &Comparison) {
        let time = of.moment().time;
        for (series, values) in self.series.iter_mut().zip(values(of)) {
            series.iter_mut().zip(values).for_each(|(series, value)| series.push(time, value));
        }
    }

    /// The page.
    pub fn page(&self, of: &Comparison) -> String {
        let session = &of.sessions()[MONOLITHIC];
        let marks: Vec<(f64, String)> = (0..2)
            .filter_map(|side| Some((side, of.summary().sides[side].diverged?)))
            .map(|(side, d)| (d.time, format!("{} diverged", SIDES[side])))
            .collect();
        let panels: Vec<Panel> = self
            .plans
            .iter()
            .zip(&self.series)
            .map(|(plan, series)| self.panel(plan, series, &marks))
            .filter(|panel| !panel.lines.is_empty())
            .collect();
        let what = match of.mode() {
            CompareMode::Trajectories => "each on its own way",
            CompareMode::SingleSteps => "single steps from the monolithic state",
        };
        let h = session.world().time_step() * 1e3;
        let title = session.scene().title.as_deref().unwrap_or_default().trim_end_matches('.');
        let subtitle = format!("{title}; step {h:.3} ms, {what}");
        page(&format!("{}: two-step against monolithic", session.name()), &subtitle, &panels)
    }

    fn panel(&self, plan: &Plan, series: &[Reduced], marks: &[(f64, String)]) -> Panel {
        let mut lines: Vec<Line> = plan
            .lines
            .iter()
            .zip(series)
            .map(|((name, colour, dash), s)| Line::new(name.clone(), *colour, *dash, s.points()))
            .collect();
        let forces = plan.title.starts_with("Normal force");
        if forces {
            // Only parts that something pressed on.
            let pressed = |k: &usize| {
                let pair = &lines[k / 2 * 2..k / 2 * 2 + 2];
                pair.iter().flat_map(|l| &l.points).any(|p| p.1 > 0.0)
            };
            let keep: Vec<usize> = (0..lines.len()).filter(pressed).collect();
            lines = keep.iter().map(|&k| lines[k].clone()).collect();
        }
        let all = || lines.iter().flat_map(|l| l.points.iter().map(|p| p.1));
        let y = if plan.log { Axis::log(all(), 6.0) } else { Axis::linear(all()) };
        Panel {
            title: plan.title.into(),
            x_label: "time [s]".into(),
            x: Axis::span(0.0, self.end),
            y,
            lines,
            marks: marks.to_vec(),
        }
    }
}
