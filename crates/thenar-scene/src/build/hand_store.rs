//! Hands kept in a folder from one run of a program to the next.
//!
//! A file begins with all that its hand was made from: the program that made it, by size and CRC of
//! its own file, the vector instructions that it ran with, the hash of the mesh's bytes, and the
//! options. Another program, mesh or option finds another name or another beginning. What is not
//! known is the system's mathematical library, where a program does not hold its own. What cannot
//! be read, is damaged or cannot be written is as if it were not there: the hand is built.

use super::hand_cache::Source;
use std::fs::{self, File};
use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, OnceLock};
use std::time::{Duration, SystemTime};
use thenar_core::model::HandModel;
use thenar_record::Build;
use thenar_rig::Model;

/// Hands kept in a folder. One of the default size has a file of less than a megabyte.
const CAPACITY: usize = 24;
/// Larger files are no hand's \[bytes\].
const FILE_BYTES_MAX: u64 = 256 << 20;
const ENDING: &str = "hand";
/// Ending of files that are being written.
const PARTIAL_ENDING: &str = "part";
/// Nobody still writes a partial file of this age.
const DAY: Duration = Duration::from_secs(86_400);

static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// The running program, by its file: read when the first hand is wanted.
static PROGRAM: LazyLock<Build> = LazyLock::new(Build::of_this_program);

/// Keeps the hands that scenes build in this folder, for the next run of the program; to be called
/// once, at its start, by a program that holds all of its code itself. Without it hands are kept in
/// memory alone.
pub fn keep_hands_in(folder: PathBuf) {
    // The first folder stays.
    let _ = FOLDER.set(folder);
}

/// The store of this program, if it has one.
pub(super) fn store() -> Option<Store<'static>> {
    let folder = FOLDER.get()?;
    (*PROGRAM != Build::default()).then(|| Store { folder, program: *PROGRAM })
}

/// A folder of hands, as one program sees it.
pub(super) struct Store<'a> {
    folder: &'a Path,
    program: Build,
}

impl Store<'_> {
    /// The hand that was made from this source.
    pub fn read(&self, source: &Source) -> Option<HandModel> {
        let (path, key) = self.entry(source);
        let bytes = thenar_input::read(&path, FILE_BYTES_MAX).ok()?;
        let Ok(Model::Hand(hand)) = Model::from_bytes(bytes.strip_prefix(key.as_bytes())?) else {
            return None;
        };
        // What was used last goes last.
        let _ = File::options()
            .append(true)
            .open(&path)
            .and_then(|f| f.set_modified(SystemTime::now()));
        Some(hand)
    }

    /// Keeps a hand; those not used for longest go.
    pub fn write(&self, source: &Source, hand: &HandModel) {
        let (path, key) = self.entry(source);
        let Ok(model) = Model::Hand(hand.clone()).to_bytes() else { return };
        let bytes = [key.into_bytes(), model].concat();
        if bytes.len() as u64 > FILE_BYTES_MAX {
            return;
        }
        let made = fs::create_dir_all(self.folder).is_ok();
        if made && thenar_output::write_whole(&path, &bytes).is_ok() {
            self.forget_oldest();
        }
    }

    /// Name and beginning of a hand's file.
    fn entry(&self, source: &Source) -> (PathBuf, String) {
        let Source { bytes, options } = source;
        let (Build { bytes: size, crc32 }, mesh) = (self.program, hash_of(bytes));
        let vectors = thenar_core::vector_instructions();
        let version = env!("CARGO_PKG_VERSION");
        let key = format!(
            "{version} {size} {crc32:08x} {vectors} {mesh:016x} {} {options}\n",
            bytes.len()
        );
        let name = format!("{:016x}.{ENDING}", hash_of(key.as_bytes()));
        (self.folder.join(name), key)
    }

    /// Removes hands that were not used for longest, and partial files that nobody finished.
    fn forget_oldest(&self) {
        let mut hands = self.files(ENDING);
        hands.sort();
        hands.truncate(hands.len().saturating_sub(CAPACITY));
        let mut partial_files = self.files(PARTIAL_ENDING);
        let is_left = |at: &SystemTime| at.elapsed().is_ok_and(|age| age > DAY);
        partial_files.retain(|(at, _)| is_left(at));
        for (_, path) in hands.into_iter().chain(partial_files) {
            // Another program may have been quicker.
            let _ = fs::remove_file(path);
        }
    }

    /// Files of this ending, each with the time of its last use.
    fn files(&self, ending: &str) -> Vec<(SystemTime, PathBuf)> {
        let listed = fs::read_dir(self.folder).into_iter().flatten().flatten();
        listed
            .filter(|file| file.path().extension().is_some_and(|own| own == ending))
            .filter_map(|file| Some((file.metadata().ok()?.modified().ok()?, file.path())))
            .collect()
    }
}

fn hash_of(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;
    use thenar_core::model::Side;
    use thenar_rig::hand::{HandOptions, asset, build_hand};

    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path =
                std::env::temp_dir().join(format!("thenar-hands-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            Self(path)
        }

        fn store(&self, crc32: u32) -> Store<'_> {
            Store { folder: &self.0, program: Build { bytes: 1, crc32 } }
        }

        fn files(&self) -> Vec<PathBuf> {
            fs::read_dir(&self.0).unwrap().map(|file| file.unwrap().path()).collect()
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    fn source(options: &str) -> Source {
        Source { bytes: vec![1, 2, 3], options: options.into() }
    }

    fn hand() -> HandModel {
        let options = HandOptions { tets: 60, render_triangles: 200, ..HandOptions::paper() };
        build_hand(asset(Side::Right), &options).unwrap()
    }

    fn bytes(hand: HandModel) -> Vec<u8> {
        Model::Hand(hand).to_bytes().unwrap()
    }

    #[test]
    fn a_hand_comes_back_to_the_bit_and_only_for_what_it_was_made_from() {
        let (folder, hand) = (Folder::new("back"), hand());
        let store = folder.store(7);
        assert!(store.read(&source("a")).is_none());
        store.write(&source("a"), &hand);
        assert_eq!(bytes(store.read(&source("a")).unwrap()), bytes(hand));
        assert!(store.read(&source("b")).is_none());
        assert!(store.read(&Source { bytes: vec![1, 2, 4], ..source("a") }).is_none());
        assert!(folder.store(8).read(&source("a")).is_none(), "another program");
        // A file of another hand under this one's name, as where hashes meet.
        fs::copy(&folder.files()[0], store.entry(&source("b")).0).unwrap();
        assert!(store.read(&source("b")).is_none());
    }

    #[test]
    fn damaged_files_are_no_hands_and_are_written_anew() {
        let (folder, hand) = (Folder::new("damaged"), hand());
        let store = folder.store(7);
        store.write(&source("a"), &hand);
        let path = folder.files().remove(0);
        let whole = fs::read(&path).unwrap();
        let key = store.entry(&source("a")).1.len();
        for at in [0, key - 1, key, key + 9, key + 20, key + 40, whole.len() / 2, whole.len() - 1] {
            let mut changed = whole.clone();
            changed[at] ^= 16;
            fs::write(&path, changed).unwrap();
            assert!(store.read(&source("a")).is_none(), "byte {at} of {}", whole.len());
            fs::write(&path, &whole[..at]).unwrap();
            assert!(store.read(&source("a")).is_none(), "cut at {at} of {}", whole.len());
        }
        store.write(&source("a"), &hand);
        assert!(store.read(&source("a")).is_some());
    }

    /// Neither waits for ever nor takes all memory.
    #[cfg(unix)]
    #[test]
    fn what_is_no_plain_file_is_no_hand() {
        let folder = Folder::new("device");
        fs::create_dir_all(&folder.0).unwrap();
        let store = folder.store(7);
        std::os::unix::fs::symlink("/dev/zero", store.entry(&source("a")).0).unwrap();
        assert!(store.read(&source("a")).is_none());
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_none() {
        let folder = Folder::new("taken");
        fs::write(&folder.0, "a file").unwrap();
        folder.store(7).write(&source("a"), &hand());
        assert!(folder.store(7).read(&source("a")).is_none());
        fs::remove_file(&folder.0).unwrap();
    }

    #[test]
    fn those_not_used_for_longest_go() {
        let (folder, hand) = (Folder::new("many"), hand());
        let store = folder.store(7);
        let of = |k: usize| source(&format!("hand {k}"));
        let age = |k: usize, seconds: u64| {
            let file = File::options().append(true).open(store.entry(&of(k)).0).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
        };
        for k in 0..CAPACITY {
            store.write(&of(k), &hand);
            age(k, 1000 - k as u64);
        }
        fs::write(folder.0.join("letter.txt"), "not a hand").unwrap();
        for (name, seconds) in [("old", 100_000), ("new", 10)] {
            let file = File::create(folder.0.join(format!("{name}.hand.1.part"))).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(seconds)).unwrap();
        }
        assert!(store.read(&of(0)).is_some());
        store.write(&of(CAPACITY), &hand);
        assert_eq!(folder.files().len(), CAPACITY + 2, "the letter and what is being written stay");
        assert!(folder.0.join("new.hand.1.part").exists());
        // The first was used since; the second is the oldest now.
        let there = |k: usize| store.read(&of(k)).is_some();
        assert_eq!([0, 1, 2, CAPACITY].map(there), [true, false, true, true]);
    }
}
