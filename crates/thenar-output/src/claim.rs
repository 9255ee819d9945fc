//! Ledger of what this process reads and writes, so that nothing is written twice or over an input,
//! and of what is unfinished, so that nothing of it is left behind.

use crate::error::Cause;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[derive(Debug)]
pub struct Ledger {
    inputs: BTreeSet<PathBuf>,
    /// Destinations of outputs.
    outputs: BTreeSet<PathBuf>,
    /// Files and folders that are not finished.
    pub unfinished: BTreeSet<PathBuf>,
}

static LEDGER: Mutex<Ledger> = Mutex::new(Ledger {
    inputs: BTreeSet::new(),
    outputs: BTreeSet::new(),
    unfinished: BTreeSet::new(),
});

/// The ledger of this process. Whoever holds it keeps [`seal`] waiting.
pub fn ledger() -> MutexGuard<'static, Ledger> {
    LEDGER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Says that a file is read by this process: no output replaces it from now on.
pub fn protect(input: &Path) {
    // What cannot be found cannot be replaced.
    if let Ok(file) = fs::canonicalize(input) {
        ledger().inputs.insert(file);
    }
}

/// Removes all outputs that are not finished. The process must end right after: outputs begun or
/// finished from now on wait for ever.
pub fn seal() {
    let ledger = ledger();
    for path in &ledger.unfinished {
        // One of the two it is; should neither go, nothing can be done about it.
        let _ = fs::remove_file(path);
        let _ = fs::remove_dir_all(path);
    }
    std::mem::forget(ledger);
}

/// The right to write a plain file, which one output has at a time.
#[derive(Debug)]
pub struct Claim {
    file: PathBuf,
    kept: bool,
}

impl Claim {
    /// Claims the file that a name leads to, through links; what writes it is not an [`Output`].
    ///
    /// # Errors
    /// The target is an input, or another output.
    ///
    /// [`Output`]: crate::Output
    pub fn of(target: &Path) -> Result<Self, crate::OutputError> {
        let fail = |cause| crate::OutputError::new(target, cause);
        let file = crate::place::end_of_links(target).map_err(|e| fail(e.into()))?;
        Self::at(file).map_err(fail)
    }

    /// Claims a file by its canonical path.
    pub(crate) fn at(file: PathBuf) -> Result<Self, Cause> {
        let mut ledger = ledger();
        if ledger.inputs.contains(&file) {
            return Err(Cause::Input);
        }
        match ledger.outputs.insert(file.clone()) {
            true => Ok(Self { file, kept: false }),
            false => Err(Cause::Twice),
        }
    }

    /// The canonical path of the file.
    pub(crate) fn file(&self) -> &Path {
        &self.file
    }

    /// Holds it until the process ends.
    pub fn keep(mut self) {
        self.kept = true;
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        if !self.kept {
            ledger().outputs.remove(&self.file);
        }
    }
}
