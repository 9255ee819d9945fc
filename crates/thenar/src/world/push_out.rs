//! Bodies that overlap are moved apart, not thrown apart: how fast, and by which solver.

use crate::math::Vec3;
use crate::model::SolverSettings;
use crate::solver::{TURN_LEVER, Wish};
use crate::world::model::Model;
use crate::world::scheme::Scheme;
use crate::world::state::{Scratch, State};

/// A free elastic body whose one side is moved by s leaves it with up to 2 s (a bar struck at one end),
/// and would so rise by `2 s²/g`: overlaps are undone at the speed that makes this part of
/// the contact margin, whatever the stiffness.
const LIFT: f64 = 0.1;
/// Standard gravity \[m/s²\], also where there is none.
const GRAVITY: f64 = 9.80665;
/// Overlaps that the velocities' tolerance makes in so many steps are not worth a solve.
const STEPS_OF_TOLERANCE: f64 = 4.0;

/// How fast overlaps are undone at most \[m/s\]: 22 mm/s at a margin of 1 mm.
pub fn speed_max(settings: &SolverSettings) -> f64 {
    (0.5 * GRAVITY * LIFT * margin(settings)).sqrt()
}

/// The contact margin \[m\], that of the default where there is none.
pub fn margin(settings: &SolverSettings) -> f64 {
    let margin = settings.contact_margin;
    if margin > 0.0 { margin } else { SolverSettings::default().contact_margin }
}

/// What a contact at `gap` \[m\] that opens at `speed` \[m/s\] asks for.
pub fn wish(gap: f64, speed: f64, h: f64, speed_max: f64) -> Wish {
    let least = (-gap.max(0.0) / h - speed).min(0.0);
    if gap >= 0.0 {
        return Wish { wanted: least, least };
    }
    Wish { wanted: ((-gap / h).min(speed_max) - speed).max(least), least }
}

/// Lists what all rows ask for, given the velocities at the end of the step. False when none asks for
/// more than the tolerance. A contact may be pushed faster by as much as its sides would close without it
/// in this step: that gives no more than a landing at this speed would, and keeps pace with
/// surfaces that are driven together. A load closes them likewise: where they overlap by more than the
/// contact margin, that part falls with the square of the depth, as the energy it gives does, lest
/// a body that is let out throws what rests on it.
pub fn list(settings: &SolverSettings, state: &State, h: f64, scratch: &mut Scratch) -> bool {
    let Scratch { found, gaps, rows, wishes, limits, .. } = scratch;
    gaps.clear();
    gaps.extend(found.iter().map(|contact| contact.gap));
    gaps.extend(limits.iter().map(|limit| limit.gap * TURN_LEVER));
    wishes.clear();
    let (margin, speed_max) = (margin(settings), speed_max(settings));
    let opening = |row| (rows.relative_velocity(row, &state.v), row.frame);
    wishes.extend(gaps.iter().zip(&rows.rows).map(|(gap, row)| {
        let (v, frame) = opening(row);
        let shallow = (margin / gap.min(-margin)).powi(2);
        wish(*gap, (frame * v).x, h, speed_max + shallow * row.target.x.max(0.0))
    }));
    let enough = STEPS_OF_TOLERANCE * settings.velocity_tolerance;
    let asks = |(wish, gap): (&Wish, &f64)| wish.wanted > enough && -gap / h > enough;
    wishes.iter().zip(gaps.iter()).any(asks)
}

/// Finds the pseudo-velocity of this step by its scheme, when one is needed.
pub fn find<S: Scheme>(
    scheme: &mut S,
    factored: &S::Factored,
    settings: &SolverSettings,
    model: &Model,
    state: &State,
    h: f64,
    scratch: &mut Scratch,
) {
    if !scheme.pushes_out() || !list(settings, state, h, scratch) {
        return;
    }
    scratch.push.fill(Vec3::zeros());
    scheme.push_out(factored, model, scratch);
    scratch.pushes = scratch.push.iter().all(|v| v.iter().all(|v| v.is_finite()));
}
