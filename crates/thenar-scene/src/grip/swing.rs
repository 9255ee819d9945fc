//! Fingers that cannot draw straight back from their places swing open about the knuckle.
//!
//! Pads gather before their places and go in along the surface's normal, where the finger is long enough for that. One that is
//! to reach around a thing, to its far side, is not: drawn back it would be straight, lie on top of the thing, and take what
//! it touches there for its place.

use super::hand::BEFORE;
use thenar_track::reach::{Angles, Chain, Goal, solve};

/// Rounds in which a finger finds whether it reaches.
const ROUNDS: usize = 20;
/// A finger that ends nearer than this to where it was to draw back to is long enough \[m\].
const NEAR: f64 = 2e-3;
/// Farthest that it swings open \[rad\].
const SWING_MAX: f64 = 0.6;
/// Shortest lever that swings a pad away \[m/rad\].
const LEVER_MIN: f64 = 0.01;

/// True if a pad reaches where it gathers before a place, straight back from there.
pub fn backs_off(chain: &Chain, place: &Goal) -> bool {
    let back = Goal { centre: place.centre - place.normal * BEFORE, ..*place };
    let mut angles = chain.ease();
    solve(chain, &chain.ease(), &mut angles, &back, ROUNDS) < NEAR
}

/// Angles at which a pad is about `before` \[m\] from a place, as it comes there when the joint that moves it most
/// from there closes last.
pub fn swung(chain: &Chain, place: &Goal, before: f64) -> Angles {
    let mut angles = chain.ease();
    solve(chain, &chain.ease(), &mut angles, place, ROUNDS);
    let moves = chain.reach(&angles).moves;
    let levers = moves.iter().map(|way| -way.dot(&place.normal)).take(chain.freedoms.len());
    let most = levers.enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    if let Some((k, lever)) = most.filter(|(_, lever)| lever.abs() > LEVER_MIN) {
        angles[k] += (before / lever).clamp(-SWING_MAX, SWING_MAX);
    }
    chain.within(angles)
}
