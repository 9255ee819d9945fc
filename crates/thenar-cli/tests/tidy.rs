//! Goal: what the documents claim about the tree is so. Method: read them and look.

#[path = "tidy/book.rs"]
mod book;
#[path = "tidy/commits.rs"]
mod commits;
#[path = "tidy/glossary.rs"]
mod glossary;
#[path = "tidy/merged.rs"]
mod merged;

use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn read(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// Words in backquotes that name a file or folder of the tree.
fn paths(text: &str) -> Vec<&str> {
    let starts = ["crates/", "docs"];
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

/// Who audits what pushes on a person reads one crate, and who audits what moves a hand another:
/// neither may come to know scenes, devices or programs; nor may drivers come to know scenes.
#[test]
fn touch_tracking_and_drivers_know_only_what_is_below_them() {
    for (name, below) in [
        ("thenar-core", vec![]),
        ("thenar-track", vec!["thenar-core", "thenar-input"]),
        ("thenar-touch", vec!["thenar-core", "thenar-track"]),
        (
            "thenar-link",
            vec!["thenar-input", "thenar-core", "thenar-output", "thenar-touch", "thenar-track"],
        ),
    ] {
        let text = read(&format!("crates/{name}/Cargo.toml"));
        let ours: Vec<&str> =
            dependencies(&text).into_iter().filter(|word| word.starts_with("thenar")).collect();
        assert_eq!(ours, below, "{name} depends on {ours:?}");
    }
}

/// Names in a table of a crate's manifest, but for what is optional.
fn dependencies(manifest: &str) -> Vec<&str> {
    let lines = manifest.lines().skip_while(|line| *line != "[dependencies]").skip(1);
    (lines.take_while(|line| !line.starts_with('[')))
        .filter(|line| !line.starts_with('#') && !line.contains("optional = true"))
        .filter_map(|line| line.split(['.', ' ', '=']).next())
        .filter(|word| !word.is_empty())
        .collect()
}

/// Benchmarks against others are a workspace of their own, which nothing here builds: its lock file
/// must know what the crates that it measures depend on, or its first build fails.
#[test]
fn the_lock_file_of_the_peers_knows_what_our_crates_need() {
    let lock = read("bench/peers/Cargo.lock");
    let mut ours = 0;
    for package in lock.split("[[package]]").filter(|package| !package.contains("source = ")) {
        let name = package.split('"').nth(1).unwrap_or_default();
        let manifest = format!("crates/{name}/Cargo.toml");
        if !root().join(&manifest).exists() {
            assert!(name.is_empty() || name == "thenar-peers", "{name} is no crate of ours");
            continue;
        }
        ours += 1;
        for needed in dependencies(&read(&manifest)) {
            let listed = [format!("\"{needed}\""), format!("\"{needed} ")];
            assert!(listed.iter().any(|text| package.contains(text)), "{name} without {needed}");
        }
    }
    assert!(ours >= 2, "{ours} crates of ours in bench/peers/Cargo.lock");
}

/// All files under `folder` with this ending, paths from the root, without build output and what
/// packages bring.
fn files(folder: &str, ending: &str) -> Vec<String> {
    let skipped = ["target", "node_modules", "work", ".git", ".venv", "site", "dist"];
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).unwrap().flatten() {
            let name = entry.file_name().into_string().unwrap();
            let path = if folder.is_empty() { name.clone() } else { format!("{folder}/{name}") };
            let kind = entry.file_type().unwrap();
            if kind.is_symlink() {
                continue; // leads to what is found elsewhere
            }
            if kind.is_dir() && !skipped.contains(&name.as_str()) {
                folders.push(path);
            } else if name.ends_with(ending) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Lines of a document outside code, each with its number.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut code = false;
    text.lines().enumerate().filter_map(move |(i, line)| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        (!code && !fence).then_some((i + 1, line))
    })
}

/// What the badges say is what the manifests ask for.
#[test]
fn badges_are_true() {
    let (readme, cargo, python) = (read("README.md"), read("Cargo.toml"), read("pyproject.toml"));
    let value = |text: &str, key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key)).unwrap_or_default();
        line.trim_matches([' ', '=', '"', '>']).to_owned()
    };
    let (rust, needed) = (value(&cargo, "rust-version"), value(&python, "requires-python"));
    assert!(!rust.is_empty() && readme.contains(&format!("badge/rust-{rust}%2B")), "{rust}");
    assert!(
        !needed.is_empty() && readme.contains(&format!("badge/python-{needed}%2B")),
        "{needed}"
    );
    let licence = value(&cargo, "license").replace('-', "--").replace(" OR ", "%20or%20");
    assert!(readme.contains(&format!("badge/licence-{licence}")), "{licence}");
}

/// Longest line of prose in a document, in characters. Rows of tables are as long as they are.
const COLUMNS_MAX: usize = 100;

#[test]
fn prose_keeps_to_its_columns() {
    for file in files("", ".md") {
        let text = read(&file);
        for (number, line) in prose(&text) {
            // Pictures, links and code by themselves are as long as they are, too.
            let whole =
                line.starts_with("    ") || line.trim_start().starts_with(['|', '!', '[', '`']);
            let long = line.chars().count() > COLUMNS_MAX && !whole;
            assert!(!long || generated(&file, &text, number), "{file}:{number} is too long");
        }
    }
}

/// Whether a line stands in a part of a document that code writes.
fn generated(file: &str, text: &str, number: usize) -> bool {
    let heading = match file {
        "docs/scene.md" => "## All keys",
        "docs/hand.md" => "## Names and ranges",
        "bench/peers/results.md" | "docs/gallery.md" => return true,
        _ => return false,
    };
    text.lines().position(|line| line == heading).is_some_and(|at| number > at)
}

/// True for a table, or a drawing or formula whose columns stand under each other.
fn is_drawn(comment: &str) -> bool {
    let words = comment.trim_start_matches(['/', '!']);
    let text = words.trim();
    text.starts_with('|') || words.starts_with("    ") || text.contains("  ")
}

#[test]
fn comments_keep_to_their_columns() {
    let mut wrong = Vec::new();
    for file in files("crates", ".rs") {
        for (i, line) in read(&file).lines().enumerate() {
            let comment = line.trim();
            let is_long = comment.starts_with("//") && line.chars().count() > 100;
            if is_long && !is_drawn(comment) {
                wrong.push(format!("{file}:{}", i + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "{} lines are too long:\n{}", wrong.len(), wrong.join("\n"));
}

/// Turns of phrase that read as translated, each with what says it in English.
const TRANSLATED: [(&str, &str); 7] = [
    ("told of", "reported"),
    ("is told", "is reported"),
    ("are told", "are reported"),
    ("so many", "at most, or the number of"),
    ("what is held", "the noun"),
    ("what comes along", "the noun"),
    ("at the latest after", "within"),
];

#[test]
fn documents_avoid_what_reads_as_translated() {
    for file in files("", ".md") {
        let text = read(&file);
        for (number, line) in prose(&text) {
            for (phrase, rather) in TRANSLATED {
                assert!(!line.contains(phrase), "{file}:{number}: {phrase}; rather {rather}");
            }
        }
    }
}

#[test]
fn comments_of_documentation_avoid_what_reads_as_translated() {
    let mut wrong = Vec::new();
    for file in files("crates", ".rs").into_iter().filter(|file| file.contains("/src/")) {
        for (number, comment) in comments(&read(&file)) {
            for (phrase, rather) in TRANSLATED.iter().filter(|(p, _)| comment.contains(p)) {
                wrong.push(format!("{file}:{number}: {phrase}; rather {rather}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{} comments:\n{}", wrong.len(), wrong.join("\n"));
}

/// Comments of documentation in lower case, each in one line, with the number of the line where it
/// begins.
fn comments(text: &str) -> Vec<(usize, String)> {
    let mut found: Vec<(usize, String)> = Vec::new();
    let mut goes_on = false;
    for (i, line) in text.lines().map(str::trim).enumerate() {
        let words = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"));
        match (words, found.last_mut()) {
            (Some(words), Some((_, comment))) if goes_on => {
                comment.push(' ');
                comment.push_str(&words.trim().to_lowercase());
            }
            (Some(words), _) => found.push((i + 1, words.trim().to_lowercase())),
            (None, _) => {}
        }
        goes_on = words.is_some();
    }
    found
}

#[test]
fn a_comment_of_several_lines_is_read_as_one() {
    let text = "//! A\n\n/// There are so\n    /// many.\nfn f() {}\n// so many\n";
    assert_eq!(comments(text), [(1, "a".to_owned()), (3, "there are so many.".to_owned())]);
}

#[test]
fn the_page_of_commands_names_each() {
    let page = read("docs/cli.md");
    let main = read("crates/thenar-cli/src/main.rs");
    let (_, list) = main.split_once("enum Command {").unwrap();
    let (list, _) = list.split_once("\n}").unwrap();
    let names = list.lines().filter_map(|line| line.trim().split_once('(').map(|(name, _)| name));
    let names: Vec<_> = names.filter(|name| !name.starts_with('/')).collect();
    assert!(names.len() > 10, "{names:?}");
    for name in names {
        let row = format!("| `thenar {}` |", name.to_lowercase());
        assert!(page.contains(&row), "docs/cli.md lacks {row}");
    }
}

/// Each row of the policy's table of formats has the number that its constant has.
#[test]
fn the_table_of_formats_has_their_versions() {
    let rows: Vec<_> = read("docs/policy.md")
        .lines()
        .filter_map(|line| {
            let cells: Vec<_> = line.split('|').map(str::trim).collect();
            let path = cells.get(5)?.strip_prefix('`')?.strip_suffix('`')?;
            Some((path.to_owned(), cells[2].to_owned()))
        })
        .collect();
    assert!(rows.len() >= 7, "{rows:?}");
    for (path, version) in rows {
        let code = read(&path);
        let line = code.lines().find(|line| line.contains("VERSION: u")).unwrap();
        assert!(line.ends_with(&format!("= {version};")), "{path}: {line}, not {version}");
    }
}

/// Words with which no comment of documentation begins: in a list of items it would stand without
/// what they refer to.
const REFERRING: [&str; 20] = [
    "Its ", "It ", "Of ", "These ", "Those ", "They ", "Their ", "The same", "Whether ", "Which ",
    "Who ", "Whose ", "and ", "And ", "What ", "How ", "Where ", "When ", "As ", "There ",
];

#[test]
fn comments_of_documentation_can_be_read_alone() {
    let mut wrong = Vec::new();
    let sources: Vec<_> =
        files("crates", ".rs").into_iter().filter(|file| file.contains("/src/")).collect();
    assert!(sources.len() > 300, "{sources:?}");
    for file in sources {
        let text = read(&file);
        let docs: Vec<_> = text.lines().map(|line| line.trim().strip_prefix("/// ")).collect();
        for (i, doc) in docs.iter().enumerate() {
            let Some(doc) = doc else { continue };
            if i > 0 && text.lines().nth(i - 1).is_some_and(|line| line.trim().starts_with("///")) {
                continue;
            }
            let alone = docs.get(i + 1).is_none_or(Option::is_none);
            let refers = REFERRING.iter().any(|word| doc.starts_with(word));
            let words = words_beside_units(doc) + usize::from(doc.contains('['));
            if refers || (alone && words < 2) || doc.starts_with("\\[") {
                wrong.push(format!("{file}:{}: {doc}", i + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "{} comments:\n{}", wrong.len(), wrong.join("\n"));
}

/// How many words a comment has beside its units in brackets: a noun and a unit are enough.
fn words_beside_units(doc: &str) -> usize {
    let mut kept = String::new();
    let mut inside = false;
    for c in doc.chars() {
        match c {
            '[' => inside = true,
            ']' => inside = false,
            _ if !inside => kept.push(c),
            _ => {}
        }
    }
    kept.split_whitespace().filter(|word| word.chars().any(char::is_alphanumeric)).count()
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
    let mut folders = vec![root().join("crates/thenar-core/src")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if path.extension().is_none_or(|ending| ending != "rs") {
                continue; // data of a test
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

/// Crates that are published: those whose manifest does not say otherwise.
fn published() -> Vec<String> {
    let folders = std::fs::read_dir(root().join("crates")).unwrap().flatten();
    let names = folders.map(|entry| entry.file_name().into_string().unwrap());
    let goes_out = |name: &String| {
        let manifest = read(&format!("crates/{name}/Cargo.toml"));
        !manifest.lines().any(|line| line == "publish = false")
    };
    names.filter(goes_out).collect()
}

/// No draft of a release is made of packages from which the program does not build.
#[test]
fn a_release_waits_for_its_packages() {
    let text = read(".github/workflows/release.yml");
    let jobs = text.split_once("\njobs:\n").unwrap().1;
    let job = |name: &str| {
        let rest = jobs.split_once(&format!("  {name}:\n")).unwrap().1;
        rest.lines().take_while(|line| line.is_empty() || line.starts_with("    ")).collect()
    };
    let (packages, draft): (Vec<&str>, Vec<&str>) = (job("packages"), job("draft"));
    assert!(packages.iter().any(|line| line.trim() == "run: .ci/package verify"), "{packages:?}");
    assert!(draft.contains(&"    needs: [build, packages]"), "{draft:?}");
}

/// Arguments of what names files in a source: macros that build them in, and paths of modules. Each
/// with its place in the text.
fn named_files(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for start in ["include_str!(", "include_bytes!(", "include!(", "include_dir!("] {
        for (at, _) in text.match_indices(start) {
            let rest = &text[at + start.len()..];
            let mut open = 1;
            let end = rest.find(|c| {
                open += i32::from(c == '(') - i32::from(c == ')');
                open == 0
            });
            found.push((at, &rest[..end.unwrap_or(rest.len())]));
        }
    }
    let paths = text.match_indices("#[path = ").map(|(at, _)| (at, text[at..].lines().next()));
    found.extend(paths.map(|(at, line)| (at, line.unwrap_or_default())));
    found
}

/// True if a package of the crate at `folder` holds what `argument` names in `file`. Names that a
/// macro inserts are left out.
fn is_packaged(folder: &str, file: &str, argument: &str) -> bool {
    if argument.contains("OUT_DIR") {
        return true; // made by the crate's build script
    }
    let literals = argument.split('"').skip(1).step_by(2);
    let name: String = literals.filter(|word| *word != "CARGO_MANIFEST_DIR").collect();
    let own = argument.contains("CARGO_MANIFEST_DIR");
    let base = if own { folder } else { file.rsplit_once('/').unwrap().0 };
    let mut path: Vec<&str> = base.split('/').collect();
    for part in name.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(path.pop()),
            part => path.push(part),
        }
    }
    let inside = path.join("/");
    let inside = inside.strip_prefix(folder).and_then(|rest| rest.strip_prefix('/'));
    inside.is_some_and(|rest| !rest.starts_with("tests/"))
}

#[test]
fn what_a_package_holds_is_seen_from_its_names() {
    let holds = |argument| is_packaged("crates/a", "crates/a/src/b/c.rs", argument);
    assert!(holds("\"d.txt\"") && holds("\"../../data/d.txt\"") && holds("\"$OUT_DIR/page\""));
    assert!(holds("concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/data/\", $name, \".txt\")"));
    assert!(!holds("\"../../../data/d.txt\"") && !holds("\"../../../ab/d.txt\""));
    assert!(!holds("concat!(\"../../../../data/\", $name, \".txt\")"));
    assert!(!holds("concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/../b/d.txt\")"));
    assert!(!holds("\"../../tests/d.txt\""), "packages hold no tests");
}

/// Who takes one package has its licences: links to the texts of the whole, which become files when
/// it is packaged.
#[test]
fn published_crates_bring_their_licences() {
    for name in published() {
        for text in ["LICENSE-MIT", "LICENSE-APACHE"] {
            let inside = format!("crates/{name}/{text}");
            assert!(root().join(&inside).exists(), "{inside} is missing");
            assert_eq!(read(&inside), read(text), "{inside}");
            let manifest = read(&format!("crates/{name}/Cargo.toml"));
            let listed = manifest.lines().find(|line| line.starts_with("include = "));
            assert!(
                listed.is_none_or(|list| list.contains("\"/LICENSE-*\"")),
                "{name}: {listed:?}"
            );
        }
    }
}

/// A package is built where nothing of the tree is beside it.
#[test]
fn published_crates_build_in_only_files_of_their_own() {
    let (mut seen, mut wrong) = (0, Vec::new());
    for name in published() {
        let folder = format!("crates/{name}");
        for file in files(&folder, ".rs") {
            if !["/src/", "/build/"].iter().any(|part| file[folder.len()..].starts_with(part)) {
                continue;
            }
            let text = read(&file);
            for (at, argument) in named_files(&text) {
                seen += 1;
                // With the attributes right above it: documentation and modules of tests are no
                // part of the library.
                let line = text[..at].lines().count();
                let above = text.lines().take(line).collect::<Vec<_>>();
                let attributes = above.iter().rev().take_while(|l| l.trim().starts_with('#'));
                let tried = attributes
                    .chain(above.last())
                    .any(|line| line.contains("doctest") || line.trim() == "#[cfg(test)]");
                if !tried && !is_packaged(&folder, &file, argument) {
                    wrong.push(format!("{file}:{line}: {argument}"));
                }
            }
        }
    }
    assert!(seen > 20, "{seen} files are built in");
    assert!(wrong.is_empty(), "in no package:\n{}", wrong.join("\n"));
}
