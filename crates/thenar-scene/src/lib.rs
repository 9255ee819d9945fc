//! Declarative scenes, drivers and probes for Thenar: what is in a scene, what moves it, what is
//! measured.
//!
//! A scene is one TOML file; `docs/scene.md` describes its keys, `docs/scene.schema.json` is
//! the same for editors.

mod math {
    pub use thenar_core::math::*;
}

pub mod build;
pub mod compare;
pub mod flat;
pub mod format;
pub mod grip;
pub mod hands;
pub mod motion;
pub mod recording;
pub mod reference;
pub mod session;
pub mod taxels;
pub mod text;
pub mod tuning;

pub use text::SceneError;
pub use thenar_track::live;
