//! Cache of the hands that the program has built, for its next run.

use std::ffi::OsString;
use std::path::PathBuf;

/// From now on hands are kept in the user's folder, if the system has one.
pub fn enable() {
    if let Some(folder) = folder(|name| std::env::var_os(name)) {
        thenar_scene::build::keep_hands_in(folder.join("hands"));
    }
}

/// The folder by variables of the environment; none where `THENAR_CACHE` is empty.
fn folder(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    if let Some(folder) = variable("THENAR_CACHE") {
        return (!folder.is_empty()).then(|| folder.into());
    }
    // A relative path would be another folder in each.
    let set = |name: &str| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let home = if cfg!(target_os = "macos") { "Library/Caches" } else { ".cache" };
    set("XDG_CACHE_HOME")
        .or_else(|| set("LOCALAPPDATA").filter(|_| cfg!(windows)))
        .or_else(|| Some(set("HOME")?.join(home)))
        .map(|caches| caches.join("thenar"))
}

#[cfg(test)]
mod tests {
    use super::folder;
    use std::path::{Path, PathBuf};

    fn of(set: &[(&str, &str)]) -> Option<PathBuf> {
        folder(|name| set.iter().find(|(n, _)| *n == name).map(|(_, value)| value.into()))
    }

    #[test]
    fn the_folder_is_the_users_unless_another_is_named() {
        assert_eq!(of(&[]), None);
        let home = ("HOME", "/home/a");
        assert!(of(&[home]).unwrap().starts_with("/home/a"));
        assert!(of(&[home]).unwrap().ends_with("thenar"));
        let caches = of(&[home, ("XDG_CACHE_HOME", "/caches")]).unwrap();
        assert_eq!(caches, Path::new("/caches/thenar"));
        for none in ["", "caches"] {
            assert_eq!(of(&[home, ("XDG_CACHE_HOME", none)]), of(&[home]));
        }
        assert_eq!(of(&[home, ("THENAR_CACHE", "/mine")]).unwrap(), Path::new("/mine"));
        assert_eq!(of(&[home, ("THENAR_CACHE", "")]), None, "switched off");
    }
}
