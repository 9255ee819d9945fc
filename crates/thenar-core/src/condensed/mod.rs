//! A step's answer reduced to bones and contacts: what a frame tells whoever works between two
//! steps.
//!
//! Plain data with room for a fixed number of contacts. [`World::condense`](crate::World::condense)
//! fills a frame; a haptic loop resolves contact on it anew in each of its ticks (the crate
//! `thenar-touch`).

mod frame;
mod response;
mod rigid_state;

pub use frame::BoneFrame;
pub use response::{Condensed, CondensedContact};
pub use rigid_state::RigidState;
