//! The monolithic solver against the dense reference, to the tolerance asked for.

mod monolithic_contact;
mod monolithic_contact_tolerance;
mod monolithic_solver;
