//! Errors that can occur while a model is built.

use thenar_input::brief;

/// Why a mesh or a model could not be read or built. The message names the place and the cause.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// A file could not be opened or read.
    #[error("cannot read {file}: {cause}")]
    Read {
        /// Path as given.
        file: String,
        /// Cause that the system reported.
        cause: std::io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {file}: {cause}")]
    Write {
        /// Path as given.
        file: String,
        /// Cause that the system reported.
        cause: std::io::Error,
    },
    /// Another error, in this file.
    #[error("{file}: {error}")]
    InFile {
        /// Path as given.
        file: String,
        /// The error inside.
        error: Box<RigError>,
    },
    /// A text file is wrong at this line.
    #[error("line {line}: {what}")]
    Line {
        /// Line, from 1.
        line: usize,
        /// Thing and cause.
        what: String,
    },
    /// A binary file is wrong at this place.
    #[error("byte {offset}: {what}")]
    Byte {
        /// Byte, from 0.
        offset: usize,
        /// Thing and cause.
        what: String,
    },
    /// The data is well formed, but no model can be built from it.
    #[error("{0}")]
    Invalid(String),
    /// A layer of flesh makes no sense.
    #[error("layer {layer}: {what}")]
    Layer {
        /// Number of the layer, from 1.
        layer: usize,
        /// Cause of the failure.
        what: String,
    },
    /// Whoever watched the work (see [`crate::work`]) ended it.
    #[error("stopped")]
    Stopped,
    /// A parameter is outside its range.
    #[error("{name} must be {expected}, not {value}")]
    Parameter {
        /// Name of the option.
        name: &'static str,
        /// Description of admissible values.
        expected: &'static str,
        /// Value that was given.
        value: f64,
    },
}

impl RigError {
    /// This error, naming the file it comes from.
    pub fn in_file(self, file: impl std::fmt::Display) -> Self {
        Self::InFile { file: brief(&file.to_string()), error: Box::new(self) }
    }

    /// Data from which no model can be built: thing and cause.
    pub fn invalid(what: impl Into<String>) -> Self {
        Self::Invalid(brief(&what.into()))
    }

    pub(crate) fn line(line: usize, what: impl Into<String>) -> Self {
        Self::Line { line, what: brief(&what.into()) }
    }

    pub(crate) fn byte(offset: usize, what: impl Into<String>) -> Self {
        Self::Byte { offset, what: brief(&what.into()) }
    }
}

/// `value` if it is positive and finite.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<f64, RigError> {
    if value.is_finite() && value > 0.0 {
        Ok(value)
    } else {
        Err(RigError::Parameter { name, expected: "positive and finite", value })
    }
}
