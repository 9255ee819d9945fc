//! Goal: what the documents claim about the tree is so. Method: read them and look.

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// Words in backquotes that name a file or folder of the tree.
fn paths(text: &str) -> Vec<&str> {
    let starts = ["crates/", "scenes", "assets", "docs"];
    text.split('`').skip(1).step_by(2).filter(|w| starts.iter().any(|s| w.starts_with(s))).collect()
}

#[test]
fn every_path_in_the_architecture_exists() {
    let text = read("ARCHITECTURE.md");
    let named = paths(&text);
    assert!(named.len() > 10, "{named:?}");
    for path in named {
        assert!(root().join(path).exists(), "ARCHITECTURE.md names {path}");
    }
}

/// Links of the form `](target)` that stay in the tree.
/// What links call a heading by.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    let words = heading.trim_start_matches('#').trim().to_lowercase();
    words.chars().filter(kept).collect::<String>().replace(' ', "-")
}

#[test]
fn links_between_documents_lead_somewhere() {
    for file in [
        "README.md",
        "ARCHITECTURE.md",
        "docs/scene.md",
        "docs/serving.md",
        "docs/haptics.md",
        "docs/devices.md",
        "docs/theory.md",
        "docs/exact.md",
        "docs/two-step.md",
        "docs/recording.md",
        "docs/outputs.md",
        "docs/python.md",
        "docs/c.md",
        "docs/protocol.md",
        "examples/clients/README.md",
        "docs/scale.md",
        "crates/thenar-python/README.md",
    ] {
        let text = read(file);
        let folder = root().join(file).parent().map(Path::to_path_buf).unwrap_or_default();
        for target in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            if target.starts_with("http") || target.starts_with('#') {
                continue;
            }
            let (path, place) = target.split_once('#').unwrap_or((target, ""));
            let path = folder.join(path);
            assert!(path.exists(), "{file} links to {target}");
            let has = |place: &str| {
                let text = std::fs::read_to_string(&path).unwrap();
                text.lines().filter(|line| line.starts_with('#')).any(|line| anchor(line) == place)
            };
            assert!(place.is_empty() || has(place), "{file} links to {target}");
        }
    }
}

#[test]
fn the_readme_names_one_command_to_run_and_one_to_test() {
    let text = read("README.md");
    let line = |wanted: &str| text.lines().any(|line| line == wanted);
    assert!(line("cargo run --release") && line("cargo test --workspace"));
}

/// The core is pure: no files, clocks, threads or printing in it.
#[test]
fn the_core_does_no_input_or_output() {
    let mut folders = vec![root().join("crates/thenar/src")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            files += 1;
            let text = std::fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
            for banned in ["std::fs", "std::time", "std::thread", "std::net", "println!", "HashMap"]
            {
                assert!(!code.contains(banned), "{} uses {banned}", path.display());
            }
        }
    }
    assert!(files > 30);
}
