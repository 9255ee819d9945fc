//! How what overlaps is moved apart: the speed that is asked for, and the impulse it may cost.
//!
//! A contact whose gap g is closed by the end of a step wants `J v ≥ -g/Δt` (Eq. 12). Where g is
//! negative that is a speed apart, which is kept low enough not to throw bodies; and where bodies may be
//! entangled, or caught between others, the impulse is bounded too (`solver::contact_law`). The same
//! holds for a joint that is past its bound.

use crate::contact::{Contact, Site};
use crate::solver::{Bounds, TURN_LEVER};

/// A penetrating point is moved out no faster than this \[m/s\], lest it be thrown out.
const PUSH_OUT_SPEED_MAX: f64 = 0.5;

/// Two deformable surfaces that overlap by more than this \[m\] may be entangled: then no force
/// beyond that which does `PUSH_OUT_WORK_MAX` \[J\] on the way out pushes them apart (10 N at 1 mm),
/// though any force keeps them from going deeper.
const ENTANGLED_DEPTH: f64 = 0.5e-3;
/// See [`ENTANGLED_DEPTH`] \[J\].
const PUSH_OUT_WORK_MAX: f64 = 0.01;

/// A surface point deeper than this is caught: perhaps between two bodies that cannot both let it
/// out \[m\]. It is then pushed no harder than `CAUGHT_FORCE_MAX` \[N\], lest a contradiction
/// between contacts pump energy into the flesh without end.
const CAUGHT_DEPTH: f64 = 2e-3;
/// See [`CAUGHT_DEPTH`] \[N\].
const CAUGHT_FORCE_MAX: f64 = 5.0;

/// An axis past its bound, perhaps placed there, is turned back no faster than this \[rad/s\], lest
/// it be thrown.
const TURN_BACK_RATE_MAX: f64 = 2.0;

/// How fast the sides of a contact should move apart at this gap \[m\], at least \[m/s\].
pub fn wanted_speed(gap: f64, h: f64) -> f64 {
    (-gap / h).min(PUSH_OUT_SPEED_MAX)
}

/// How fast to turn away from a joint's bound at this distance \[rad\], at [`TURN_LEVER`] \[m/s\].
pub fn wanted_turn(gap: f64, h: f64) -> f64 {
    TURN_LEVER * (-gap / h).min(TURN_BACK_RATE_MAX)
}

/// How hard a contact may push.
pub fn bounds(contact: &Contact, h: f64) -> Bounds {
    let softs = [&contact.a, &contact.b].map(|site| matches!(site, Site::Soft(_)));
    let depth = -contact.gap;
    let mut bounds = Bounds::NONE;
    if softs == [true; 2] && depth > ENTANGLED_DEPTH {
        bounds.push_out = wanted_speed(contact.gap, h);
        bounds.push_impulse_max = h * PUSH_OUT_WORK_MAX / depth;
    }
    if softs != [false; 2] && depth > CAUGHT_DEPTH {
        bounds.impulse_max = CAUGHT_FORCE_MAX * h;
    }
    bounds
}
