//! Scenes: what is in them, what moves them, what is measured.

pub mod motion;
