//! Source of a session.

use crate::build::USUAL_PRESET;
use crate::format::PresetWord;
use crate::hands::Hands;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thenar_input::fnv1a;

/// All that a session is made from but the files that its scene names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// Names the scene in messages; relative paths in it start at its folder.
    pub file: PathBuf,
    /// The scene's text.
    pub text: String,
    /// Changes to it, `key=value`.
    pub overrides: Vec<String>,
    /// The hands that are in the scene.
    pub hands: Hands,
    /// Length of left and right hands \[m\], where it is not the scene's.
    pub lengths: [Option<f64>; 2],
    /// The hand that the scene means where it does not say: another one in recordings of earlier
    /// programs.
    #[serde(skip, default = "usual")]
    pub usual_hand: PresetWord,
}

impl Source {
    /// A hash of the scene's text and overrides, and of the state that it starts in: snapshots
    /// carry it, so that none enters another scene. FNV-1a.
    pub fn identity(&self, start: u64) -> u64 {
        let overrides = self.overrides.iter().flat_map(|set| [set.as_bytes(), b"\n"]);
        let texts = std::iter::once(self.text.as_bytes()).chain(overrides);
        texts.fold(start, fnv1a)
    }

    /// A scene as it is written.
    pub fn new(text: &str, file: &Path, overrides: &[String]) -> Self {
        Self {
            file: file.into(),
            text: text.into(),
            overrides: overrides.to_vec(),
            hands: Hands::Scene,
            lengths: [None; 2],
            usual_hand: USUAL_PRESET,
        }
    }
}

fn usual() -> PresetWord {
    USUAL_PRESET
}
