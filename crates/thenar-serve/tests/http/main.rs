//! Goal: whoever comes over the network is served, refused or cut off as promised, and nobody
//! slows anybody else. Method: a real server on real sockets, with a small stand-in for the
//! simulation behind it.

mod crowd;
mod hostile;
mod pairing;
mod requests;
mod sessions;
mod stage;
