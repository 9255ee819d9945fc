//! The last thing between a computed force and an actuator. Small on purpose: read all of it.
//!
//! One `Guard` stands before each actuator, a `Bank` before a whole device. Each tick goes through
//! the same eight stages, in this order (`Guard::tick`):
//!
//! 1. **finite**: a number that is not finite, or a clock that misbehaves, trips;
//! 2. **fresh**: an old simulation state, old tracking or a silent device is held, then fades, and
//!    what has faded for good pauses; so do a released dead-man switch, a loop that stood still and
//!    a hand on its way to its wearer's;
//! 3. **clamp**: length at most the device's rating times the user's fraction; tendons only pull;
//! 4. **slew**: how far the output may change in this tick, per second and per tick; it is held at
//!    the end of stage 7, so that nothing in between can exceed it;
//! 5. **engage**: nothing until the wanted force has been small for a few ticks, then a ramp; after
//!    a pause that nobody asked for, as of the tracker, nothing until all has been fresh for 0.2 s,
//!    then a ramp of 0.5 s;
//! 6. **speed**: a point moving faster than the limit trips, but where nothing is sent and forces
//!    wait;
//! 7. **energy**: a passivity observer keeps account; a deficit is damped away, by less force than
//!    is wanted and never by more, and one below the reserve trips (Hannaford and Ryu 2002). Each
//!    motion meets the force that was sent when it was made, as far back as its tracker is late.
//!    What can only hold gives out none;
//! 8. **quantise**, towards zero.
//!
//! Guaranteed whatever comes in (`tests.rs`): outputs are finite and within the clamp; two outputs
//! of successive ticks differ by no more than stage 4 allows (plus one quantum), except that a trip
//! and a loop that stood still go to zero at once; after a trip all is zero until armed again; no
//! force is sent while the energy account is below minus the reserve. A pause fades and comes back
//! by itself through stage 5; a trip does not.
//!
//! Not guaranteed: that a guard is ticked at all. A watchdog outside this crate must send zeros
//! when the loop does not. This is research software, certified for nothing.

mod arrays;
mod bank;
mod guard;
mod limits;
mod log;
mod passivity;
mod reason;
#[cfg(test)]
mod tests;
mod wearer_side;

pub use bank::Bank;
pub use guard::{Guard, Signal};
pub use limits::{LimitError, Limits};
pub use log::{Record, SignalLog};
pub use passivity::Passivity;
pub use reason::{Pause, Quantity, Status, Trip};
