//! Goal: links of documents work, in the tree and in the book, which holds every page. Method: they
//! are read with `SUMMARY.md`; `book` stands for the built book, to which mdbook copies its files.

use crate::{files, prose, read, root};
use std::path::{Component, Path, PathBuf};

/// What links call a heading by.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    let words = heading.trim_start_matches('#').trim().to_lowercase();
    words.chars().filter(kept).collect::<String>().replace(' ', "-")
}

/// Targets of a document's links, outside code.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let links = prose(text).flat_map(|(_, line)| line.split("](").skip(1));
    links.filter_map(|rest| rest.split(')').next())
}

#[test]
fn links_between_documents_lead_somewhere() {
    let documents = files("", ".md");
    assert!(documents.len() > 25, "{documents:?}");
    for file in documents {
        if file.ends_with("peers/preface.md") {
            continue; // the beginning of `bench/peers/results.md`, and linked from there
        }
        let text = read(&file);
        let folder = root().join(&file).parent().map(Path::to_path_buf).unwrap_or_default();
        for target in links(&text) {
            if target.starts_with("http") {
                continue;
            }
            let (path, place) = target.split_once('#').unwrap_or((target, ""));
            let path = if path.is_empty() { root().join(&file) } else { folder.join(path) };
            assert!(path.exists(), "{file} links to {target}");
            let has = |place: &str| {
                let text = std::fs::read_to_string(&path).unwrap();
                text.lines().filter(|line| line.starts_with('#')).any(|line| anchor(line) == place)
            };
            assert!(place.is_empty() || has(place), "{file} links to {target}");
        }
    }
}

/// Chapters of the book, as paths from its root.
fn chapters() -> Vec<String> {
    let summary = read("SUMMARY.md");
    let targets = summary.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.map(str::to_owned).collect()
}

/// Path without `.` and `..`; none if it leaves the book.
fn inside_of_book(path: &Path) -> Option<PathBuf> {
    let mut inside = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => inside.pop().then_some(())?,
            Component::Normal(name) => inside.push(name),
            _ => {}
        }
    }
    Some(inside)
}

#[test]
fn the_book_lists_every_page() {
    let chapters = chapters();
    for file in files("docs", ".md") {
        assert!(chapters.contains(&file), "SUMMARY.md lacks {file}");
    }
    assert_eq!(read("book/SUMMARY.md"), read("SUMMARY.md"));
}

/// A link to a Markdown file needs a chapter; another needs a file that the book copies: a folder
/// has no page there.
#[test]
fn links_of_the_book_lead_somewhere_in_it() {
    let chapters = chapters();
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for chapter in &chapters {
        let text = read(&format!("book/{chapter}"));
        assert_eq!(text, read(chapter), "book/{chapter}");
        let folder = Path::new(chapter).parent().expect("a folder");
        for target in links(&text) {
            let path = target.split('#').next().unwrap_or_default();
            if path.is_empty() || target.starts_with("http") {
                continue;
            }
            seen += 1;
            let inside = inside_of_book(&folder.join(path));
            let leads = inside.is_some_and(|inside| match inside.to_str() {
                Some(name) if name.ends_with(".md") => chapters.iter().any(|c| c == name),
                _ => root().join("book").join(&inside).is_file(),
            });
            if !leads {
                wrong.push(format!("{chapter} links to {target}"));
            }
        }
    }
    assert!(seen > 100, "{seen} links");
    assert!(wrong.is_empty(), "{} of {seen} links are dead:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_path_that_leaves_the_book_is_none() {
    let inside = |path: &str| inside_of_book(Path::new(path));
    assert_eq!(inside("docs/../README.md"), Some(PathBuf::from("README.md")));
    assert_eq!(inside("docs/./a/../b.md"), Some(PathBuf::from("docs/b.md")));
    assert_eq!(inside("docs/../../README.md"), None);
}
