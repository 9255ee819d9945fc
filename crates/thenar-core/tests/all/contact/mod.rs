//! Contact: what is found, how firm it is, what it lets slide, and what it tells.

mod area;
mod crowd;
mod entangled;
mod friction_by_load;
mod held_still;
mod pair_law;
mod push_out;
mod quality;
mod readout;
mod response;
mod rigid_rest;
mod rolling;
mod round_stack;
mod self_contact;
mod soft_flight;
mod spin;
mod taxels;
mod tunnelling;
mod warm_start;
