//! Time series: a `.pvd` file that lists other VTK files with their times.

use super::file::write_whole;
use crate::RigError;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A folder of VTK files over time, which ParaView opens through `NAME.pvd`.
///
/// The list is rewritten whole after every moment, so that a run that is broken off can be
/// looked at up to there.
pub struct Series {
    folder: PathBuf,
    name: String,
    entries: String,
    moments: usize,
}

impl Series {
    /// Starts a series in `folder`, which is made if it does not exist.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn create(folder: &Path, name: &str) -> Result<Self, RigError> {
        std::fs::create_dir_all(folder)
            .map_err(|cause| RigError::Write { file: folder.display().to_string(), cause })?;
        Ok(Self {
            folder: folder.to_owned(),
            name: name.to_owned(),
            entries: String::new(),
            moments: 0,
        })
    }

    /// Adds a moment at `time` \[s\]: each part is (name, extension, contents).
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn push(&mut self, time: f64, parts: &[(&str, &str, String)]) -> Result<(), RigError> {
        for (index, (part, extension, text)) in parts.iter().enumerate() {
            let safe: String =
                part.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
            let file = format!("{}-{safe}-{:06}.{extension}", self.name, self.moments);
            write_whole(&self.folder.join(&file), text.as_bytes())?;
            // Writing to a string cannot fail.
            let _ = writeln!(
                self.entries,
                "<DataSet timestep=\"{time}\" part=\"{index}\" name=\"{safe}\" file=\"{file}\"/>"
            );
        }
        self.moments += 1;
        let text = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
             byte_order=\"LittleEndian\">\n<Collection>\n{}</Collection>\n</VTKFile>\n",
            self.entries
        );
        write_whole(&self.folder.join(format!("{}.pvd", self.name)), text.as_bytes())
    }
}
