//! Output files that are complete or not there.

use crate::error::CliError;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file that gets its name only when it is finished; dropped before, it leaves nothing.
#[derive(Debug)]
pub struct Draft {
    target: PathBuf,
    draft: PathBuf,
    out: Option<BufWriter<File>>,
}

fn failed(path: &Path, error: &std::io::Error) -> CliError {
    CliError::Other(format!("cannot write {}: {error}", path.display()))
}

impl Draft {
    /// Starts a file beside `target`.
    ///
    /// # Errors
    /// The folder is not there, or cannot be written to.
    pub fn create(target: &Path) -> Result<Self, CliError> {
        let mut name = target.file_name().unwrap_or_default().to_owned();
        if name.is_empty() || target.is_dir() {
            return Err(CliError::Input(format!("{} is not a file name", target.display())));
        }
        name.push(format!(".{}.part", std::process::id()));
        let draft = target.with_file_name(name);
        let file = File::create(&draft).map_err(|e| failed(target, &e))?;
        Ok(Self { target: target.into(), draft, out: Some(BufWriter::new(file)) })
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn finish(mut self) -> Result<(), CliError> {
        let Some(mut out) = self.out.take() else { return Ok(()) };
        out.flush()
            .and_then(|()| out.get_ref().sync_all())
            .and_then(|()| fs::rename(&self.draft, &self.target))
            .map_err(|e| {
                let _ = fs::remove_file(&self.draft);
                failed(&self.target, &e)
            })
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.out.as_mut().map_or(Ok(0), |out| out.write(bytes))
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.as_mut().map_or(Ok(()), Write::flush)
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        if self.out.take().is_some() {
            let _ = fs::remove_file(&self.draft);
        }
    }
}

/// A file's size for a person.
pub fn size(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} bytes"),
        10_000..10_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_draft_that_is_dropped_leaves_nothing() {
        let folder = std::env::temp_dir().join(format!("thenar-draft-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let target = folder.join("table.csv");
        let mut draft = Draft::create(&target).unwrap();
        draft.write_all(b"half").unwrap();
        drop(draft);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);

        let mut draft = Draft::create(&target).unwrap();
        draft.write_all(b"whole").unwrap();
        draft.finish().unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"whole");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_folder_that_is_not_there_is_named() {
        let error = Draft::create(Path::new("/nowhere/at/all.csv")).unwrap_err();
        assert!(error.to_string().contains("/nowhere/at/all.csv"), "{error}");
    }
}
