//! Puts the page into the program: builds the viewer where its sources and Node are there, takes
//! the built page that a packaged crate carries, and else a plain page that says what is missing.
//!
//! What is built is kept in `page/` beside this folder and built anew only when a source has
//! changed, so most runs need neither Node nor a network.

mod sources;
mod viewer;

use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() {
    let package = PathBuf::from(variable("CARGO_MANIFEST_DIR"));
    let place = PathBuf::from(variable("OUT_DIR")).join("page");
    println!("cargo:rerun-if-changed=build");
    // Where Node was missing, it may be on another path the next time.
    println!("cargo:rerun-if-env-changed=PATH");
    let outcome = page(&package).and_then(|page| {
        replace(&page.site, &place).map_err(|e| format!("The page cannot be copied: {e}"))
    });
    match outcome {
        Ok(()) => println!("cargo:rustc-env=THENAR_PAGE=built"),
        Err(reason) => {
            for line in reason.lines() {
                println!("cargo:warning={line}");
            }
            plain(&place, &reason).unwrap_or_else(|e| panic!("{}: {e}", place.display()));
            println!("cargo:rustc-env=THENAR_PAGE=plain");
        }
    }
}

/// The built page, or why there is none.
fn page(package: &Path) -> Result<viewer::Page, String> {
    let store = package.join("page");
    let sources = package.join("../../viewer");
    if sources.join("package.json").is_file() {
        return viewer::page(&sources, &store, &package.join("build/compress.mjs"));
    }
    println!("cargo:rerun-if-changed=page/site");
    match store.join("site/index.html").is_file() || store.join("site/index.html.gz").is_file() {
        true => Ok(viewer::Page { site: store.join("site"), lock: None }),
        false => Err("This package was made without the page; take the sources from the \
                      repository instead."
            .into()),
    }
}

fn variable(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("cargo sets {name}"))
}

/// Copies a folder in place of another.
fn replace(from: &Path, to: &Path) -> io::Result<()> {
    if to.exists() {
        fs::remove_dir_all(to)?;
    }
    copy(from, to)
}

fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        match entry.file_type()?.is_dir() {
            true => copy(&entry.path(), &target)?,
            false => fs::write(target, fs::read(entry.path())?)?,
        }
    }
    Ok(())
}

/// The page that stands in for the real one.
fn plain(place: &Path, reason: &str) -> io::Result<()> {
    if place.exists() {
        fs::remove_dir_all(place)?;
    }
    fs::create_dir_all(place)?;
    let reason = reason.replace('&', "&amp;").replace('<', "&lt;");
    let page = include_str!("plain.html").replace("{reason}", &reason);
    fs::write(place.join("index.html"), page)
}
