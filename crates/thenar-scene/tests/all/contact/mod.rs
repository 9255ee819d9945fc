//! Contact in scenes: what rests, slides, tumbles and touches itself.

mod crossed_plates;
mod force_spectrum;
mod long_steps;
mod overlaps;
mod peaks;
mod rest_matrix;
mod resting_hand;
mod rigid_wrench;
mod self_contact;
mod tumbling;
