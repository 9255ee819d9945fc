//! Serves a live simulation, or a recorded one: a thread that steps a scene in real time, the
//! binary protocol of `docs/protocol.md`, and the page that draws it.

mod dead_man;
pub mod http;
pub mod hub;
pub mod live;
pub mod page;
pub mod playback;
pub mod protocol;
mod rounds;
