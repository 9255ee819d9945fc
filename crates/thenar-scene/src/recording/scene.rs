//! The files that a scene names, into a recording and out again.

use super::content::{Asset, SceneStart};
use super::replay::ReplayError;
use crate::build::Files;
use crate::session::{Session, Source};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use thenar_output::TemporaryFolder;

/// Larger files are not put into a recording, which then needs them where they were \[bytes\].
pub const ASSET_BYTES_MAX: u64 = 64 << 20;

/// The largest files that scenes name are models \[bytes\].
pub const FILE_BYTES_MAX: u64 = 1 << 30;

/// Returns the content of a session's scene frame; `None` for one that a program has changed.
pub fn start(session: &Session) -> Option<SceneStart> {
    Some(SceneStart {
        source: session.source()?.clone(),
        assets: session.files().iter().map(|(name, path)| asset(name, path)).collect(),
        hash: session.world().state_hash(),
        time: session.world().time(),
        time_step: session.world().time_step(),
    })
}

/// A file that has gone meanwhile is kept by name: replay says that it is missing.
fn asset(name: &str, path: &Path) -> Asset {
    let bytes = thenar_input::read(path, FILE_BYTES_MAX).unwrap_or_default();
    Asset {
        name: name.into(),
        bytes: bytes.len() as u64,
        crc32: crc32fast::hash(&bytes),
        content: (bytes.len() as u64 <= ASSET_BYTES_MAX).then_some(bytes),
    }
}

/// Makes the session of a scene frame.
pub fn session(start: &SceneStart) -> Result<Session, ReplayError> {
    let mut folder = Folder::default();
    let mut moved = BTreeMap::new();
    for (k, asset) in start.assets.iter().enumerate() {
        match &asset.content {
            Some(bytes) => {
                let path = folder.put(k, &asset.name, bytes).map_err(ReplayError::Asset)?;
                moved.insert(asset.name.clone(), path);
            }
            None => check(&start.source, asset)?,
        }
    }
    let files = Files::beside(&start.source.file).moved(moved);
    Ok(Session::open(&start.source, files)?)
}

/// A file that is not in the recording must be where it was, as it was.
fn check(source: &Source, asset: &Asset) -> Result<(), ReplayError> {
    let path = source.file.parent().unwrap_or(Path::new("")).join(&asset.name);
    let same = |bytes: Vec<u8>| crc32fast::hash(&bytes) == asset.crc32;
    match thenar_input::read(&path, FILE_BYTES_MAX).is_ok_and(same) {
        true => Ok(()),
        false => Err(ReplayError::NotThere(path)),
    }
}

/// A folder for the time in which a scene is built, if it needs one.
#[derive(Default)]
struct Folder(Option<TemporaryFolder>);

impl Folder {
    /// Only the ending of the name matters; the rest could lead anywhere.
    fn put(&mut self, k: usize, name: &str, bytes: &[u8]) -> io::Result<PathBuf> {
        let folder = match self.0.take() {
            Some(folder) => folder,
            None => TemporaryFolder::new("thenar-replay")?,
        };
        let ending = Path::new(name).extension().unwrap_or_default();
        let path = folder.path().join(format!("asset-{k}")).with_extension(ending);
        self.0 = Some(folder);
        std::fs::write(&path, bytes)?;
        Ok(path)
    }
}
