//! Bodies that overlap are moved apart, not thrown apart: how fast, and by which solver.

use crate::contact::{Contact, Site};
use crate::math::Vec3;
use crate::model::SolverSettings;
use crate::solver::{PushTarget, TURN_LEVER};
use crate::world::model::Model;
use crate::world::scheme::Scheme;
use crate::world::state::{Scratch, State};

/// A free elastic body whose one side is moved by s leaves it with up to 2 s (a bar struck at one
/// end), and would so rise by `2 s²/g`: overlaps are undone at the speed that makes this part of
/// the contact margin, whatever the stiffness.
const LIFT: f64 = 0.1;
/// A fold of one body lifts little but itself: by as much as the margin, within which surfaces meet
/// anyway.
const FOLD_LIFT: f64 = 1.0;
/// Standard gravity \[m/s²\], also where there is none.
const GRAVITY: f64 = 9.80665;
/// Gaps and overlaps that the default tolerance of velocities makes in this many steps are its
/// doing: such overlaps are not worth a solve.
const STEPS_OF_TOLERANCE: f64 = 4.0;
/// The part of such an overlap that is left when one is undone: a body is not moved by more at once
/// than the tolerance may move it.
const LEFT: f64 = 1.0 - 1.0 / STEPS_OF_TOLERANCE;
/// The part of such a gap that is closed in a step.
const CLOSED_IN_A_STEP: f64 = 0.25 / STEPS_OF_TOLERANCE;

/// Returns the highest speed at which overlaps are undone \[m/s\]: 22 mm/s at a margin of 1 mm, 70
/// mm/s where a body overlaps itself.
pub fn speed_max(settings: &SolverSettings, lift: f64) -> f64 {
    (0.5 * GRAVITY * lift * margin(settings)).sqrt()
}

/// True when a contact is between two parts of one deformable body, which overlaps itself there.
fn is_fold(contact: &Contact) -> bool {
    matches!([&contact.a, &contact.b], [Site::Soft(a), Site::Soft(b)] if a.soft == b.soft)
}

/// The contact margin \[m\], that of the default where there is none.
pub fn margin(settings: &SolverSettings) -> f64 {
    let margin = settings.contact_margin;
    if margin > 0.0 { margin } else { SolverSettings::default().contact_margin }
}

/// Returns the gap or overlap that the tolerance leaves to contacts \[m\], 40 nm at 1 ms: of the
/// default tolerance, as what is asked of the solver must not change what it solves.
pub fn slack(h: f64) -> f64 {
    STEPS_OF_TOLERANCE * SolverSettings::default().velocity_tolerance * h
}

/// Returns the speed at which a contact may close at `gap` \[m/s\], as a target, not above zero. A
/// gap within the `slack` closes by a part in each step, no faster than a quarter of the tolerance:
/// to undo an overlap opens other contacts a little, and a body that fell as far at once would lose
/// a part of its weight for a step, `4 · 10 µm/s / (g h)`, 0.4 % at 1 ms.
pub fn closing(gap: f64, slack: f64, h: f64) -> f64 {
    let open = gap.max(0.0);
    -((open - slack).max(0.0) + open.min(slack) * CLOSED_IN_A_STEP) / h
}

/// The wish of a contact at `gap` \[m\] that opens at `speed` \[m/s\], if overlaps up to `left`
/// \[m\] are left.
pub fn wish(gap: f64, left: f64, speed: f64, h: f64, speed_max: f64) -> PushTarget {
    let least = (-gap.max(0.0) / h - speed).min(0.0);
    if gap >= -left {
        return PushTarget { wanted: least, least };
    }
    PushTarget { wanted: ((-(gap + left) / h).min(speed_max) - speed).max(least), least }
}

/// Lists what all rows ask for, given the velocities at the end of the step. False when none asks
/// for more than the tolerance and overlaps by more than the slack. A contact may be pushed faster
/// by as much as its sides would close without it in this step: that gives no more than a landing
/// at this speed would, and keeps pace with surfaces that are driven together. A load closes them
/// likewise: where they overlap by more than the contact margin, that part falls with the square of
/// the depth, as the energy it gives does, lest a body that is let out throws what rests on it.
pub fn list(settings: &SolverSettings, state: &State, h: f64, scratch: &mut Scratch) -> bool {
    let Scratch { found, gaps, rows, wishes, limits, .. } = scratch;
    gaps.clear();
    gaps.extend(found.iter().map(|contact| contact.gap));
    gaps.extend(limits.iter().map(|limit| limit.gap * TURN_LEVER));
    wishes.clear();
    let slack = slack(h);
    let margin = margin(settings);
    let speeds = [LIFT, FOLD_LIFT].map(|lift| speed_max(settings, lift));
    let of_contacts = found.iter().map(|contact| speeds[usize::from(is_fold(contact))]);
    let speeds = of_contacts.chain(std::iter::repeat(speeds[0]));
    let opening = |row| (rows.relative_velocity(row, &state.v), row.frame);
    wishes.extend(gaps.iter().zip(&rows.rows).zip(speeds).map(|((gap, row), speed_max)| {
        let (v, frame) = opening(row);
        let shallow = (margin / gap.min(-margin)).powi(2);
        let speed_max = speed_max + shallow * row.target.x.max(0.0);
        wish(*gap, LEFT * slack, (frame * v).x, h, speed_max)
    }));
    let asks = |(wish, gap): (&PushTarget, &f64)| {
        wish.wanted > settings.velocity_tolerance && -gap > slack
    };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::SurfacePoint;

    /// An elastic body that is pushed from one side leaves at twice that speed, and rises by a
    /// tenth of the margin; a fold by the margin.
    #[test]
    fn what_is_moved_apart_rises_by_a_part_of_the_margin() {
        for margin in [2e-4, 1e-3, 5e-3] {
            let settings = SolverSettings { contact_margin: margin, ..SolverSettings::default() };
            for (lift, part) in [(LIFT, 0.1), (FOLD_LIFT, 1.0)] {
                let rise = (2.0 * speed_max(&settings, lift)).powi(2) / (2.0 * GRAVITY);
                assert!((rise / (part * margin) - 1.0).abs() < 1e-12, "{rise} m at {margin}");
            }
        }
    }

    #[test]
    fn only_one_body_in_itself_is_a_fold() {
        let contact = |a, b| Contact {
            key: 0,
            a: Site::Soft(SurfacePoint::vertex(a, 3)),
            b,
            position_W: Vec3::zeros(),
            normal_W: Vec3::x(),
            gap: -1e-3,
            friction: 0.5,
        };
        let soft = |soft| Site::Soft(SurfacePoint::vertex(soft, 9));
        assert!(is_fold(&contact(1, soft(1))));
        assert!(!is_fold(&contact(0, soft(1))));
        let rigid = Site::Rigid { body: 1, offset_W: Vec3::zeros() };
        assert!(!is_fold(&contact(1, rigid)));
    }
}
