//! Files that are complete or not there.

use crate::RigError;
use std::path::Path;

/// Writes `bytes` beside `path` first and then gives the file its name, so that no reader ever
/// sees half of it. Links, pipes and devices of this name stay what they are (`thenar-output`).
///
/// # Errors
/// When the file system refuses; nothing is left behind then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), RigError> {
    thenar_output::write_whole(path, bytes)
        .map_err(|error| RigError::Write { file: path.display().to_string(), cause: error.into() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_refused_file_is_named_and_leaves_nothing() {
        let dir = std::env::temp_dir().join(format!("thenar-whole-{}", std::process::id()));
        fs::create_dir_all(dir.join("taken/inside")).expect("a folder for the test");
        // A folder that is not empty cannot be replaced by a file.
        let error = write_whole(&dir.join("taken"), b"x").expect_err("refused");
        assert!(error.to_string().contains("taken"), "{error}");
        assert_eq!(fs::read_dir(&dir).expect("listed").count(), 1);
        write_whole(&dir.join("free"), b"abc").expect("written");
        assert_eq!(fs::read(dir.join("free")).expect("there"), b"abc");
        fs::remove_dir_all(dir).expect("removed");
    }
}
