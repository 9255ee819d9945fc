//! Goal: an output is complete or not there, and nothing that is no plain file is replaced. Method:
//! each kind of target in a folder of its own, and what lies in the folder afterwards.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use thenar_output::{Claim, Output, protect, write_whole};

/// An empty folder for each test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("thenar-output-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Names in it, sorted.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(&self.0)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[track_caller]
fn put(target: &Path, text: &str) {
    let mut output = Output::create(target).unwrap();
    output.write_all(text.as_bytes()).unwrap();
    output.finish().unwrap();
}

/// The message of a target that is refused, which names it.
#[track_caller]
fn refusal(target: &Path) -> String {
    let error = Output::create(target).expect_err("refused");
    assert!(error.is_usage(), "{error}");
    let told = error.to_string();
    assert!(told.contains(&target.display().to_string()), "{told}");
    told
}

#[test]
fn a_file_appears_whole_and_a_dropped_one_never() {
    let folder = Folder::new("whole");
    let target = folder.file("table.csv");
    fs::write(&target, "old").unwrap();
    let mut output = Output::create(&target).unwrap();
    output.write_all(b"half").unwrap();
    output.flush().unwrap();
    assert_eq!(fs::read(&target).unwrap(), b"old");
    drop(output);
    assert_eq!(folder.names(), ["table.csv"]);
    put(&target, "new");
    assert_eq!(fs::read(&target).unwrap(), b"new");
    assert_eq!(folder.names(), ["table.csv"]);
}

#[test]
fn what_is_no_file_name_is_refused() {
    let folder = Folder::new("names");
    fs::create_dir(folder.file("sub")).unwrap();
    assert!(refusal(&folder.file("sub")).ends_with("it is a folder"));
    assert!(refusal(&folder.file("sub/")).ends_with("it is a folder"));
    assert!(refusal(&folder.file("sub/..")).ends_with("it is a folder"));
    assert!(refusal(&folder.file("none/")).ends_with("not the name of a file"));
    assert!(refusal(Path::new("")).ends_with("not the name of a file"));
    let missing = Output::create(&folder.file("none/a.csv")).unwrap_err();
    assert!(!missing.is_usage());
    assert!(missing.to_string().contains("none/a.csv"), "{missing}");
    assert_eq!(folder.names(), ["sub"]);
}

#[test]
fn the_longest_name_that_a_file_may_have_is_written() {
    let folder = Folder::new("long");
    // Two bytes each but for the first: a cut at 200 would go through a character.
    let name = format!("a{}", "é".repeat(127));
    put(&folder.file(&name), "x");
    assert_eq!(folder.names(), std::slice::from_ref(&name));
    let error = Output::create(&folder.file(&format!("{name}b"))).unwrap_err();
    assert!(error.to_string().contains(&name), "{error}");
}

#[test]
fn two_outputs_or_an_input_of_one_name_are_refused() {
    let folder = Folder::new("twice");
    let target = folder.file("a.csv");
    let first = Output::create(&target).unwrap();
    assert!(
        refusal(&folder.file("../").join(folder.0.file_name().unwrap()).join("a.csv"))
            .ends_with("two outputs of this command have this name")
    );
    assert!(Claim::of(&target).is_err());
    // The name of one that came to nothing is free.
    drop(first);
    let first = Output::create(&target).unwrap();
    first.finish().unwrap();
    // What is finished stays.
    assert!(refusal(&target).ends_with("have this name"));

    let input = folder.file("scene.toml");
    fs::write(&input, "version = 1").unwrap();
    protect(&input);
    assert!(refusal(&input).contains("is an input"));
    assert_eq!(fs::read(&input).unwrap(), b"version = 1");
    protect(&folder.file("not there"));

    // What is written again and again is nobody else's meanwhile.
    let again = folder.file("again.vtk");
    write_whole(&again, b"1").unwrap();
    write_whole(&again, b"2").unwrap();
    assert_eq!(fs::read(&again).unwrap(), b"2");
    assert_eq!(folder.names(), ["a.csv", "again.vtk", "scene.toml"]);
}

#[test]
fn drafts_that_others_left_are_let_alone() {
    let folder = Folder::new("left");
    let left = format!("a.csv.{}.part", std::process::id());
    fs::write(folder.file(&left), "somebody's").unwrap();
    put(&folder.file("a.csv"), "new");
    assert_eq!(fs::read(folder.file(&left)).unwrap(), b"somebody's");
    assert_eq!(folder.names(), ["a.csv", left.as_str()]);
}

#[test]
fn a_temporary_folder_goes_with_all_that_is_in_it() {
    let [one, other] = [0, 1].map(|_| thenar_output::TemporaryFolder::new("thenar-test").unwrap());
    assert_ne!(one.path(), other.path());
    fs::create_dir(one.path().join("sub")).unwrap();
    fs::write(one.path().join("sub/file"), "x").unwrap();
    let path = one.path().to_path_buf();
    drop(one);
    assert!(!path.exists() && other.path().is_dir());
}

#[cfg(unix)]
mod unix {
    use super::*;
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    use std::io::Read;
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
    use std::os::unix::net::UnixListener;

    #[test]
    fn links_stay_and_what_they_lead_to_is_replaced() {
        let folder = Folder::new("links");
        fs::create_dir(folder.file("deep")).unwrap();
        fs::write(folder.file("deep/real"), "old").unwrap();
        symlink("deep/real", folder.file("direct")).unwrap();
        symlink(folder.file("direct"), folder.file("indirect")).unwrap();
        symlink("deep/new", folder.file("dangling")).unwrap();
        symlink("dangling", folder.file("dangling-twice")).unwrap();
        put(&folder.file("indirect"), "through two links");
        assert_eq!(fs::read(folder.file("deep/real")).unwrap(), b"through two links");
        put(&folder.file("dangling-twice"), "made");
        assert_eq!(fs::read(folder.file("deep/new")).unwrap(), b"made");
        for link in ["direct", "indirect", "dangling", "dangling-twice"] {
            assert!(folder.file(link).is_symlink(), "{link}");
        }
        // The partial file lay beside the file, not beside the link, and is gone.
        assert_eq!(folder.names(), ["dangling", "dangling-twice", "deep", "direct", "indirect"]);
        assert_eq!(fs::read_dir(folder.file("deep")).unwrap().count(), 2);
        // One file by two names is one file.
        assert!(refusal(&folder.file("direct")).ends_with("have this name"));
    }

    #[test]
    fn links_that_lead_nowhere_to_write_are_told() {
        let folder = Folder::new("astray");
        fs::create_dir(folder.file("sub")).unwrap();
        symlink("sub", folder.file("folder")).unwrap();
        symlink("round", folder.file("about")).unwrap();
        symlink("about", folder.file("round")).unwrap();
        symlink("no/such/folder/file", folder.file("far")).unwrap();
        assert!(refusal(&folder.file("folder")).ends_with("it is a folder"));
        for name in ["round", "far"] {
            let error = Output::create(&folder.file(name)).unwrap_err();
            assert!(error.to_string().contains(name), "{error}");
            assert!(folder.file(name).is_symlink());
        }
        assert_eq!(fs::read_dir(folder.file("sub")).unwrap().count(), 0);
    }

    /// Bytes that a reader gets out of a pipe while an output is written to it.
    fn piped(name: &str, after: std::time::Duration) -> (Folder, Vec<u8>) {
        let folder = Folder::new(name);
        let pipe = folder.file("pipe");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::from_raw_mode(0o600), 0).unwrap();
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || {
                std::thread::sleep(after);
                let mut bytes = Vec::new();
                fs::File::open(pipe).unwrap().read_to_end(&mut bytes).unwrap();
                bytes
            })
        };
        // More than a pipe holds: the writer must wait for the reader.
        put(&pipe, &"0123456789abcdef".repeat(20_000));
        assert!(fs::metadata(&pipe).unwrap().file_type().is_fifo());
        assert_eq!(folder.names(), ["pipe"]);
        (folder, reader.join().unwrap())
    }

    #[test]
    fn pipes_get_all_bytes_and_stay_pipes() {
        let (_folder, bytes) = piped("pipe", std::time::Duration::ZERO);
        assert_eq!(bytes.len(), 320_000);
        let (_folder, bytes) = piped("late", std::time::Duration::from_millis(200));
        assert_eq!(bytes.len(), 320_000);
    }

    #[test]
    fn a_pipe_that_nobody_reads_is_told() {
        let folder = Folder::new("unread");
        let pipe = folder.file("pipe");
        mknodat(CWD, &pipe, FileType::Fifo, Mode::from_raw_mode(0o600), 0).unwrap();
        let error = Output::create(&pipe).unwrap_err();
        assert!(error.to_string().contains("pipe: nobody reads"), "{error}");
        assert_eq!(folder.names(), ["pipe"]);
    }

    #[test]
    fn devices_are_written_and_stay_devices() {
        put(Path::new("/dev/null"), "away with it");
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        let folder = Folder::new("devices");
        symlink("/dev/null", folder.file("link")).unwrap();
        put(&folder.file("link"), "and this");
        // A second output may go there as well.
        put(Path::new("/dev/null"), "and that");
        if Path::new("/dev/full").exists() {
            let mut full = Output::create(Path::new("/dev/full")).unwrap();
            full.write_all(b"x").unwrap();
            let error = full.finish().unwrap_err();
            assert!(error.to_string().contains("/dev/full: No space left"), "{error}");
        }
        // Only root may make nodes.
        let node = folder.file("node");
        let number = rustix::fs::makedev(1, 3);
        let mode = Mode::from_raw_mode(0o600);
        if mknodat(CWD, &node, FileType::CharacterDevice, mode, number).is_ok() {
            // Some containers make nodes that nobody may open.
            let done = Output::create(&node).and_then(Output::finish);
            assert!(fs::metadata(&node).unwrap().file_type().is_char_device(), "{done:?}");
        }
        let block = folder.file("block");
        if mknodat(CWD, &block, FileType::BlockDevice, mode, rustix::fs::makedev(7, 200)).is_ok() {
            assert!(refusal(&block).ends_with("it is a block device"));
            assert!(fs::metadata(&block).unwrap().file_type().is_block_device());
        }
    }

    #[test]
    fn sockets_are_refused() {
        let folder = Folder::new("socket");
        let _listener = UnixListener::bind(folder.file("socket")).unwrap();
        assert!(refusal(&folder.file("socket")).ends_with("it is a socket"));
        assert!(fs::metadata(folder.file("socket")).unwrap().file_type().is_socket());
    }

    #[test]
    fn permissions_of_the_old_file_stay() {
        let folder = Folder::new("mode");
        for mode in [0o600, 0o640, 0o666, 0o755] {
            let target = folder.file(&format!("{mode:o}"));
            fs::write(&target, "old").unwrap();
            fs::set_permissions(&target, fs::Permissions::from_mode(mode)).unwrap();
            let output = Output::create(&target).unwrap();
            // Nobody else reads the partial file either.
            let partial = folder.file(&format!("{mode:o}.{}.part", std::process::id()));
            assert_eq!(fs::metadata(partial).unwrap().permissions().mode() & 0o777, mode);
            output.finish().unwrap();
            assert_eq!(fs::metadata(&target).unwrap().permissions().mode() & 0o777, mode);
        }
    }

    #[test]
    fn a_file_that_may_not_be_written_is_kept() {
        let folder = Folder::new("read-only");
        let target = folder.file("kept");
        fs::write(&target, "old").unwrap();
        fs::set_permissions(&target, fs::Permissions::from_mode(0o444)).unwrap();
        let may = fs::OpenOptions::new().write(true).open(&target).is_ok();
        // Root may write it.
        assert_eq!(Output::create(&target).is_ok(), may);
        assert_eq!(fs::read(&target).unwrap(), b"old");
        assert_eq!(folder.names(), ["kept"]);
    }
}
