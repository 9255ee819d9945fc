//! A part of a step that linearised forces did not foresee (`flesh::foresight`) is made again, half
//! as long; one that may not be halved any more is cut short.

use crate::math::Vec3;
use crate::world::parts::StepPart;
use crate::world::state::Scratch;
use crate::world::{StepReport, World};

/// Most halvings of what flesh moves in a part that is cut short: a billionth of the way is left
/// then.
const CUTS_MAX: u32 = 30;

impl World {
    /// True when linearised forces foresaw what the part just made did to flesh.
    pub(super) fn flesh_was_foreseen(&self, part: StepPart, report: &StepReport) -> bool {
        let Self { model, state, scratch, .. } = self;
        if report.non_finite {
            return !model.flesh.asks_foresight;
        }
        let all = 0..model.flesh.tets.len();
        model.flesh.foresaw(all, &scratch.before.x, &state.x, &state.faded, part.h)
    }

    /// True when the part just made brought no energy into corotational flesh. From `v₀` to `v₁` an
    /// implicit step takes out `½ |v₁ - v₀|²_M`, beside what elements tell of themselves.
    pub(super) fn flesh_gained_nothing(&mut self, part: StepPart, report: &StepReport) -> bool {
        let Self { model, state, scratch, .. } = self;
        let row0 = 2 * model.rigids.len();
        let push = scratch.pushes.then_some(&scratch.push[row0..]);
        for (n, to) in scratch.straight.iter_mut().enumerate() {
            let v = state.v[row0 + n] + push.map_or(Vec3::zeros(), |push| push[n]);
            *to = scratch.before.x[n] + v * part.h;
        }
        let Scratch { before, straight, .. } = scratch;
        report.non_finite
            || model.soft_nodes.iter().zip(&model.soft_tets).all(|(nodes, tets)| {
                let x = [&*before.x, &*state.x, &**straight];
                let gained = model.flesh.surprise(tets.clone(), x, &state.faded, part.h);
                gained <= 0.0 || {
                    let slowed = nodes.clone().map(|n| {
                        let change = state.v[row0 + n] - before.v[row0 + n];
                        model.flesh.mass[n] * change.norm_squared()
                    });
                    gained <= 0.5 * slowed.sum::<f64>()
                }
            })
    }

    /// Takes motion out of bodies whose flesh did what was not foreseen, by halves, until it is:
    /// the incremental energy falls along the way that was found, so that some part of it does. A
    /// body that nothing holds keeps its linear momentum.
    pub(super) fn cut_flesh_short(&mut self, part: StepPart) {
        let Self { desc, model, state, scratch, .. } = self;
        let (row0, before) = (2 * model.rigids.len(), &scratch.before.x);
        for (soft, (nodes, tets)) in model.soft_nodes.iter().zip(&model.soft_tets).enumerate() {
            let body = &desc.softs[soft];
            let free = body.coupling.is_none() && body.flesh.fixed.is_empty();
            let mass: f64 = model.flesh.mass[nodes.clone()].iter().sum();
            let momentum = |n: usize| state.v[row0 + n] * model.flesh.mass[n];
            let mean = match free {
                true => nodes.clone().map(momentum).sum::<Vec3>() / mass,
                false => Vec3::zeros(),
            };
            for _ in 0..CUTS_MAX {
                if model.flesh.foresaw(tets.clone(), before, &state.x, &state.faded, part.h) {
                    break;
                }
                for n in nodes.clone() {
                    let v = &mut state.v[row0 + n];
                    *v = (*v + mean) * 0.5;
                    state.x[n] = (state.x[n] + before[n] + mean * part.h) * 0.5;
                }
            }
        }
    }
}
