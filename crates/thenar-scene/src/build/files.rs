//! Paths of the files that a scene names.

use crate::text::Located;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Files of a scene: beside it, or wherever a recording has put them.
#[derive(Debug, Default)]
pub struct Files {
    folder: PathBuf,
    moved: BTreeMap<String, PathBuf>,
    used: RefCell<BTreeMap<String, PathBuf>>,
}

impl Files {
    /// Files of the scene file `scene`: relative paths start at its folder.
    pub fn beside(scene: &Path) -> Self {
        Self { folder: scene.parent().unwrap_or(Path::new("")).into(), ..Self::default() }
    }

    /// Redirects the names in `moved` to its paths.
    pub fn moved(self, moved: BTreeMap<String, PathBuf>) -> Self {
        Self { moved, ..self }
    }

    /// The path of what a scene calls `file`.
    pub(super) fn path(&self, file: &Located<String>) -> PathBuf {
        let moved = self.moved.get(&file.value).cloned();
        let path = moved.unwrap_or_else(|| self.folder.join(&file.value));
        self.used.borrow_mut().insert(file.value.clone(), path.clone());
        path
    }

    /// The names that were asked for, and the files they stand for.
    pub fn into_used(self) -> BTreeMap<String, PathBuf> {
        self.used.into_inner()
    }
}
