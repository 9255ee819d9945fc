//! Thenar simulates a soft human hand that touches things.
