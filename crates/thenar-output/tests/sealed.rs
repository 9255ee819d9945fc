//! Goal: what is unfinished when the process is asked to end is removed, and nothing else. Method:
//! this file holds one test, as nothing can be written in its process afterwards.

use std::fs;
use std::io::Write;
use thenar_output::{Output, TemporaryFolder, seal};

#[test]
fn nothing_unfinished_is_left_behind() {
    let folder = std::env::temp_dir().join(format!("thenar-sealed-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("old"), "old").unwrap();
    let done = Output::create(&folder.join("done")).unwrap();
    done.finish().unwrap();
    let mut half = Output::create(&folder.join("half")).unwrap();
    half.write_all(b"half").unwrap();
    half.flush().unwrap();
    let over = Output::create(&folder.join("old")).unwrap();
    let temporary = TemporaryFolder::new("thenar-sealed").unwrap();
    fs::write(temporary.path().join("file"), "x").unwrap();
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 4);
    seal();
    let mut names: Vec<_> =
        fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["done", "old"]);
    assert_eq!(fs::read(folder.join("old")).unwrap(), b"old");
    assert!(!temporary.path().exists());
    // Their ends would wait for ever, as they must.
    std::mem::forget((half, over, temporary));
    fs::remove_dir_all(&folder).unwrap();
}
