//! Sessions: what moves them, what they measure, and what can be kept of them.

mod compare;
mod live;
mod motion;
mod probes;
mod reached;
mod settings;
mod snapshot;
mod taxels;
mod touch;
mod validation_states;
