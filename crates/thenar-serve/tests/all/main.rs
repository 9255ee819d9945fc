//! Messages and the simulation's thread, in one binary:
//! `cargo test -p thenar-serve --test all playback::` runs a part. The server on real sockets is
//! `http`.

mod control;
#[path = "../decoder/mod.rs"]
mod decoder;
mod hands;
mod messages_in;
mod messages_out;
mod playback;
mod recording;
mod touch;
#[path = "../visitor/mod.rs"]
mod visitor;
