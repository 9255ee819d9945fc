//! Files that are complete or not there.

use crate::RigError;
use std::fs;
use std::io::Write;
use std::path::Path;

/// Writes `bytes` beside `path` first and then gives the file its name, so that no reader ever
/// sees half of it.
///
/// # Errors
/// When the file system refuses; nothing is left behind then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), RigError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.part", std::process::id()));
    let draft = path.with_file_name(name);
    let written = fs::File::create(&draft)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&draft, path));
    written.map_err(|cause| {
        // The draft may not exist; the first cause is the one to tell.
        let _ = fs::remove_file(&draft);
        RigError::Write { file: path.display().to_string(), cause }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
