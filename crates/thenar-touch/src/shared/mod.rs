//! Shared constraints: each simulation frame publishes how its bones answer to forces and what they
//! touch, and the haptic loop resolves contact anew, every tick, against the proxies of that tick
//! (Peterlík et al. 2011, for a whole hand). Contact then begins and slides at the haptic rate, and
//! the softness between two frames is that of the hand, not that of a coupling to an old pose.
//!
//! Quasi-static and linear about the frame. With `δ` how far the proxies have moved since the
//! frame, `k` the bone couplings, `C` the bones' compliance (couplings, joints and flesh included),
//! `J` how contact values follow the bones, `W` how they follow contact forces while the bones are
//! held, `f₀` the frame's contact forces, and `q₀`, `d₀` how far the bones still are from rest
//! under these, and the contact values there:
//!
//! ```text
//! bones:     q = q₀ + C (k δ + Jᵀ (f - f₀))
//! contacts:  d = d₀ + J C k δ + B (f - f₀),   B = J C Jᵀ + W
//!            0 ≤ f_n ⊥ d_n ≥ 0,   |f_t| ≤ μ f_n, against sliding
//! ```
//!
//! What is felt is therefore where the hand comes to rest for these proxies, not where a simulation
//! that lags behind them has got to. Without `q₀` that lag e would be felt, and led the proxies to
//! `(k_s/k_h) e` beyond the hand: with bone couplings k_s stiffer than the device's k_h the two
//! chase each other.
//!
//! `World::condense` publishes it: bones and flesh as they come to rest, objects with their inertia
//! over one step; joint limits are listed as contacts. Only the monolithic solver has it.
//!
//! Guaranteed: with unmoved proxies a frame at rest gives its own forces and poses. Not included:
//! the hand's inertia between two frames, contacts that the frame does not list (it must list what
//! may touch before the next), and how flesh answers to large turns since the frame.

mod resolve;
#[cfg(test)]
mod slow_tests;
#[cfg(test)]
mod tests;
mod values;
#[cfg(test)]
mod values_tests;

pub use resolve::{Resolution, SharedConstraints};
pub use thenar_core::condensed::{Condensed, CondensedContact};
