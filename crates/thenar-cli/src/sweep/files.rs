//! Files that the scene names: what is in them is a part of what is swept.

use super::Scene;
use super::manifest::sha256;
use crate::error::CliError;
use std::collections::{BTreeMap, BTreeSet};
use thenar_scene::recording::FILE_BYTES_MAX;
use thenar_scene::session::Session;

/// SHA-256 of each file by the scene's name for it; `None` of one that cannot be read, whose cases
/// fail.
#[derive(Debug, Default)]
pub struct Files(BTreeMap<String, Option<String>>);

impl Files {
    /// Reads the files that the scene calls by these names. No output is written over them.
    pub fn read(names: BTreeSet<String>, scene: &Scene) -> Self {
        let folder = scene.file.parent().unwrap_or("".as_ref());
        let hash = |name: String| {
            let path = folder.join(&name);
            thenar_output::protect(&path);
            let digest = thenar_input::read(&path, FILE_BYTES_MAX).ok().map(|b| sha256(&b));
            (name, digest)
        };
        Self(names.into_iter().map(hash).collect())
    }

    /// Names and hashes, for the manifest.
    pub fn as_json(&self) -> serde_json::Value {
        serde_json::json!(self.0)
    }

    /// Looks whether a session that was just opened was built from the files as they were when the
    /// sweep began.
    ///
    /// # Errors
    /// One has changed since.
    pub fn check(&self, session: &Session) -> Result<(), CliError> {
        for (name, path) in session.files() {
            let now = thenar_input::read(path, FILE_BYTES_MAX).ok().map(|bytes| sha256(&bytes));
            if self.0.get(name) != Some(&now) {
                return Err(CliError::Other(format!(
                    "{} has changed since the sweep began; cases that are recorded are of the file as it was",
                    path.display()
                )));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_changes_meanwhile_is_noticed() {
        let folder = thenar_output::TemporaryFolder::new("thenar-sweep-files").unwrap();
        let tets = |last: f64| {
            let text = format!("nodes=[[0,0,0],[1,0,0],[0,1,0],[0,0,{last}]]\ntets=[[0,1,2,3]]\n");
            std::fs::write(folder.path().join("t.toml"), text).unwrap();
        };
        tets(1.0);
        let text = "version=1\n[[soft]]\nname=\"a\"\nshape={kind=\"tet-file\",file=\"t.toml\"}\n";
        let file = folder.path().join("s.toml");
        let mut scene = Scene { text: text.into(), file, files: Files::default() };
        let session = Session::from_text(&scene.text, &scene.file, &[]).unwrap();
        assert!(scene.files.check(&session).is_err(), "a file of which the sweep knows nothing");
        scene.files = Files::read(scene.check(&[]).unwrap(), &scene);
        scene.files.check(&session).unwrap();
        tets(2.0);
        let told = scene.files.check(&session).unwrap_err().to_string();
        assert!(told.contains("t.toml has changed since the sweep began"), "{told}");
    }
}
