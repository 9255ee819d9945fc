//! Faults of a scene, and their places.

use std::ops::Range;
use std::path::{Path, PathBuf};
use thenar_input::brief;

/// Place where a value was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SourcePlace {
    /// Bytes of the scene file.
    Text(Range<usize>),
    /// The override with this index, e.g. from `--set`.
    Override(usize),
}

/// A problem found while reading; the file name and the text are added by the caller.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Place in the text.
    pub place: SourcePlace,
    /// Full key, e.g. `rigid[0].mass`; empty for the file as a whole.
    pub key: String,
    /// Account of what was expected and found.
    pub problem: String,
}

/// Why a scene could not be loaded or run.
#[derive(Clone, Debug, thiserror::Error)]
pub enum SceneError {
    /// A value in the file.
    #[error("{}:{line}:{column}: {}{problem}", file.display(), prefix(key))]
    InFile {
        /// The scene file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Full key, e.g. `rigid[0].mass`; empty when the text is not TOML.
        key: String,
        /// Account of what was expected and found.
        problem: String,
    },
    /// A value given by an override such as `--set`.
    #[error("override `{text}`: {}{problem}", prefix(key))]
    InOverride {
        /// The override as it was given.
        text: String,
        /// Full key.
        key: String,
        /// Account of what was expected and found.
        problem: String,
    },
    /// A file that cannot be read.
    #[error("{}: {problem}", file.display())]
    File {
        /// Path of the file.
        file: PathBuf,
        /// Cause in words.
        problem: String,
    },
    /// No such built-in scene and no such file.
    #[error("no scene `{name}`: there is no such file, and the built-in scenes are {known}")]
    Unknown {
        /// Name that was asked for.
        name: String,
        /// Names of built-in scenes.
        known: String,
    },
    /// The simulator refused the finished world.
    #[error("{}: {problem}", file.display())]
    World {
        /// The scene file.
        file: PathBuf,
        /// Reason in words.
        problem: String,
    },
}

fn prefix(key: &str) -> String {
    if key.is_empty() { String::new() } else { format!("`{key}`: ") }
}

impl Fault {
    /// A fault at a place. What is long of key and problem is shortened: both may repeat what a
    /// user wrote.
    pub fn new(place: &SourcePlace, key: impl Into<String>, problem: impl Into<String>) -> Self {
        let (key, problem) = (brief(&key.into()), brief(&problem.into()));
        Self { place: place.clone(), key, problem }
    }

    /// Adds the file's name, line and column.
    pub fn locate(self, file: &Path, text: &str, overrides: &[String]) -> SceneError {
        let Fault { place, key, problem } = self;
        match place {
            SourcePlace::Text(bytes) => {
                let (line, column) = line_and_column(text, bytes.start);
                SceneError::InFile { file: file.to_path_buf(), line, column, key, problem }
            }
            SourcePlace::Override(i) => {
                let text = overrides.get(i).map(|text| brief(text)).unwrap_or_default();
                SceneError::InOverride { text, key, problem }
            }
        }
    }
}

/// Line and column, from 1, of a byte offset; past the end it is the end.
fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one_in_characters() {
        let text = "a = 1\nbé = 2\n";
        assert_eq!(line_and_column(text, 0), (1, 1));
        assert_eq!(line_and_column(text, 6), (2, 1));
        assert_eq!(line_and_column(text, 12), (2, 6)); // `é` takes two bytes
        assert_eq!(line_and_column(text, 8), (2, 2)); // inside `é`
        assert_eq!(line_and_column(text, 999), (3, 1));
    }
}
