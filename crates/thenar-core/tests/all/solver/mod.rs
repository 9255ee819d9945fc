//! The exact solver against the dense reference, to the tolerance asked for.

mod exact_contact;
mod exact_contact_tolerance;
mod exact_solver;
