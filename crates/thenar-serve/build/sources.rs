//! What the page is made of, and whether it has changed.

use std::collections::hash_map::DefaultHasher;
use std::fs;
use std::hash::Hasher;
use std::io;
use std::path::{Path, PathBuf};

/// In the viewer's folder, but not in the page.
const NOT_SOURCES: [&str; 4] = ["node_modules", "dist", "test", "e2e"];

/// What lies in the viewer's folder and goes into the page.
pub fn entries(viewer: &Path) -> io::Result<Vec<PathBuf>> {
    let mut entries = Vec::new();
    for entry in fs::read_dir(viewer)? {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if !NOT_SOURCES.contains(&name.as_str()) && !name.starts_with('.') {
            entries.push(entry.path());
        }
    }
    entries.sort();
    Ok(entries)
}

/// A number that changes when a name or a byte does. Times of files do not count: changing
/// branches to and fro builds nothing.
pub fn fingerprint(entries: &[PathBuf]) -> io::Result<String> {
    let mut hasher = DefaultHasher::new();
    for entry in entries {
        digest(entry, &mut hasher)?;
    }
    Ok(format!("{:016x}\n", hasher.finish()))
}

fn digest(path: &Path, hasher: &mut DefaultHasher) -> io::Result<()> {
    hasher.write(path.file_name().unwrap_or_default().as_encoded_bytes());
    if path.is_dir() {
        let mut inside: Vec<PathBuf> =
            fs::read_dir(path)?.map(|e| e.map(|e| e.path())).collect::<io::Result<_>>()?;
        inside.sort();
        hasher.write_usize(inside.len());
        return inside.iter().try_for_each(|path| digest(path, hasher));
    }
    let bytes = fs::read(path)?;
    hasher.write_usize(bytes.len());
    hasher.write(&bytes);
    Ok(())
}
