//! Errors that keep a loop from running.

/// A setting that makes no sense, or a system that gives no thread.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what}: {cause}")]
pub struct LoopError {
    /// Setting or part of the loop.
    pub what: String,
    /// Cause in words.
    pub cause: String,
}
