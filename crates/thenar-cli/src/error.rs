//! Why a command ended, and with which exit code.

use crate::recorder::RecordError;
use std::process::ExitCode;
use thenar_output::OutputError;
use thenar_picture::EncodeError;
use thenar_rig::RigError;
use thenar_scene::SceneError;
use thenar_scene::session::TakenBack;

/// Why a command did not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Fault of the request, or of a file that was named.
    #[error("{0}")]
    Input(String),
    /// Anything else: the disk is full, the run was interrupted, a value became non-finite.
    #[error("{0}")]
    Other(String),
}

impl CliError {
    /// 2 for bad usage or input, 1 for anything else.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Other(_) => ExitCode::from(1),
        }
    }
}

impl From<SceneError> for CliError {
    fn from(error: SceneError) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<TakenBack> for CliError {
    fn from(error: TakenBack) -> Self {
        Self::Other(error.to_string())
    }
}

impl From<RigError> for CliError {
    fn from(error: RigError) -> Self {
        match error {
            RigError::Write { .. } => Self::Other(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<RecordError> for CliError {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Picture(error) => error.into(),
            RecordError::Folder { .. } => Self::Other(error.to_string()),
        }
    }
}

impl From<EncodeError> for CliError {
    fn from(error: EncodeError) -> Self {
        match error {
            EncodeError::Output(error) => error.into(),
            _ => Self::Other(error.to_string()),
        }
    }
}

impl From<OutputError> for CliError {
    fn from(error: OutputError) -> Self {
        match error.is_usage() {
            true => Self::Input(error.to_string()),
            false => Self::Other(error.to_string()),
        }
    }
}
