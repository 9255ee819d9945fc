//! Hands are built once: the next run of the program finds them in the user's folder.

use crate::stage::{Folder, err, out, state};
use std::fs;
use std::path::{Path, PathBuf};

/// Runs the paper's hand for two steps, at home in `folder`; what is printed ends with the hash of
/// its state.
fn run(folder: &Folder, cache: &str) -> String {
    let scene = ["run", "pinch", "--seconds", "0.02", "--set", "hand.hand.preset=paper"];
    let mut command = folder.command(&scene);
    command.env("HOME", &folder.0).env("XDG_CACHE_HOME", &folder.0).env("THENAR_CACHE", cache);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}{}", out(&output), err(&output));
    state(&output)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let listed = fs::read_dir(folder).map(|files| files.map(|file| file.unwrap().path()));
    listed.into_iter().flatten().collect()
}

/// Another number for each file that was written, whatever is in it.
fn number(file: &Path) -> u64 {
    std::os::unix::fs::MetadataExt::ino(&fs::metadata(file).unwrap())
}

#[test]
fn a_hand_is_kept_for_the_next_run_and_damage_is_no_matter() {
    let folder = Folder::new("cache");
    let kept = folder.0.join("kept/hands");
    let without = run(&folder, "");
    assert!(files(&folder.0).is_empty(), "{:?}", files(&folder.0));
    assert_eq!(run(&folder, "kept"), without);
    let [hand] = &files(&kept)[..] else { panic!("{:?}", files(&kept)) };
    let (whole, first) = (fs::read(hand).unwrap(), number(hand));

    // What a run takes from there is the same to the bit, and nothing is written again.
    assert_eq!(run(&folder, "kept"), without);
    assert_eq!(number(hand), first);

    fs::write(hand, &whole[..whole.len() / 2]).unwrap();
    assert_eq!(run(&folder, "kept"), without);
    assert_ne!(number(hand), first, "written anew");
    assert_eq!(fs::read(hand).unwrap(), whole);
    assert_eq!(files(&kept).len(), 1);

    // A folder that cannot be had costs time alone.
    fs::write(folder.0.join("taken"), "a file").unwrap();
    assert_eq!(run(&folder, "taken"), without);
}
