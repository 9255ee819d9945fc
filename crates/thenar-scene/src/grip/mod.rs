//! Grips by intent: what to grip, how, with what force and until when; pads find their way by
//! themselves.
//!
//! 1. [`Opposition`]: how the pads of a kind stand against each other at every width that the hand
//!    spans;
//! 2. `pair` and `choose`: opposed places of the object's surface for them, whatever its shape;
//! 3. `solve`: angles for a pad's place, by damped least squares within the joints' ranges;
//! 4. `squeeze`: how hard pads push, by the force that is felt;
//! 5. `hook`: fingers that bend around a handle instead;
//! 6. [`GripHand`]: these, step by step, of which `reaching` has the way to the object and
//!    `holding` what follows.
//!
//! The same calls give the same bits. Steps allocate nothing once a hand has learnt a kind. The
//! step in which a grip begins takes some milliseconds, for the search of places.

mod choose;
mod crowd;
mod felt;
mod hand;
mod holding;
mod hook;
mod kind;
mod loss;
mod memory;
mod opposition;
mod order;
mod pair;
mod reaching;
mod reasons;
mod row;
mod size;
mod squeeze;
mod surface;
mod trouble;

pub use hand::{GripHand, GripState};
pub use kind::GripKind;
pub use loss::Loss;
pub use memory::{GripMemory, PadMemory, Phase, Reflex};
pub use opposition::{Base, Opposition, Span};
pub use order::Order;
pub use size::{friction, narrowest, pads_middle, pads_middle_at, slip_limit, usual_force, way_to};
pub use surface::Anchor;
pub(crate) use surface::bounds;
pub use trouble::Trouble;
