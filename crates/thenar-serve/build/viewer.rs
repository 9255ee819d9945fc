//! Builds the viewer with npm.

use crate::sources;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The oldest Node that the viewer's tools run on.
const NODE: u32 = 20;

/// Windows finds only programs of this name by itself.
const NPM: &str = if cfg!(windows) { "npm.cmd" } else { "npm" };

/// A built page, and the lock that keeps other builds from changing it meanwhile.
pub struct Page {
    /// The folder with its files.
    pub site: PathBuf,
    /// Let go when dropped.
    #[expect(dead_code, reason = "it is held, not read")]
    pub lock: Option<File>,
}

/// The page of the present sources: the one in the store if it fits, else a new one.
pub fn page(viewer: &Path, store: &Path, compress: &Path) -> Result<Page, String> {
    let broken = |e: std::io::Error| format!("The page cannot be built: {e}");
    let mut entries = sources::entries(viewer).map_err(broken)?;
    for entry in &entries {
        println!("cargo:rerun-if-changed={}", entry.display());
    }
    entries.push(compress.into());
    let fingerprint = sources::fingerprint(&entries).map_err(broken)?;

    fs::create_dir_all(store).map_err(broken)?;
    let lock = File::create(store.join("lock")).map_err(broken)?;
    lock.lock().map_err(broken)?;

    let (site, stamp) = (store.join("site"), store.join("sources"));
    let fits = fs::read_to_string(&stamp).is_ok_and(|text| text == fingerprint);
    if !(fits && site.is_dir()) {
        node_is_there()?;
        let new = store.join("new");
        build(viewer, &new, compress).inspect_err(|_| {
            // It may go better the next time: a file that is not there makes cargo run this again.
            println!("cargo:rerun-if-changed={}", store.join("try-again").display());
        })?;
        let _ = fs::remove_file(&stamp);
        if site.exists() {
            fs::remove_dir_all(&site).map_err(broken)?;
        }
        fs::rename(&new, &site).map_err(broken)?;
        fs::write(&stamp, fingerprint).map_err(broken)?;
    }
    Ok(Page { site, lock: Some(lock) })
}

fn node_is_there() -> Result<(), String> {
    let advice = format!(
        "Install Node {NODE} or newer with npm (https://nodejs.org, or your system's packages \
         nodejs and npm), then:\ncargo clean -p thenar-serve && cargo clean --release -p thenar-serve"
    );
    let Ok(output) = Command::new("node").arg("--version").output() else {
        return Err(format!("The live page was not built: Node is not installed.\n{advice}"));
    };
    let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let major = version.trim_start_matches('v').split('.').next().and_then(|v| v.parse().ok());
    if major.is_none_or(|major: u32| major < NODE) {
        return Err(format!("The live page was not built: Node {version} is too old.\n{advice}"));
    }
    if Command::new(NPM).arg("--version").output().is_err() {
        return Err(format!("The live page was not built: npm is not installed.\n{advice}"));
    }
    Ok(())
}

fn build(viewer: &Path, place: &Path, compress: &Path) -> Result<(), String> {
    if modules_are_stale(viewer) {
        let options = ["ci", "--ignore-scripts", "--prefer-offline", "--no-audit", "--no-fund"];
        run(Command::new(NPM).args(options), viewer)?;
    }
    run(Command::new(NPM).args(["run", "build"]).env("THENAR_PAGE_OUT", place), viewer)?;
    if !place.join("index.html").is_file() {
        return Err("The live page was not built: npm run build left no index.html.".into());
    }
    run(Command::new("node").arg(compress).arg(place), viewer)
}

/// npm notes in `node_modules` what it installed, after it did.
fn modules_are_stale(viewer: &Path) -> bool {
    let changed = |file: &str| fs::metadata(viewer.join(file)).and_then(|m| m.modified()).ok();
    let installed = changed("node_modules/.package-lock.json");
    installed.is_none() || installed < changed("package-lock.json")
}

fn run(command: &mut Command, folder: &Path) -> Result<(), String> {
    let shown = format!("{} in {}", show(command), folder.display());
    let output = command
        .current_dir(folder)
        .output()
        .map_err(|e| format!("The live page was not built: {shown}: {e}"))?;
    if output.status.success() {
        return Ok(());
    }
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    let lines: Vec<&str> = said.lines().filter(|line| !line.trim().is_empty()).collect();
    let last = lines[lines.len().saturating_sub(20)..].join("\n");
    Err(format!("The live page was not built: {shown} failed:\n{last}"))
}

fn show(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
