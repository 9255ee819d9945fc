//! The page: the built viewer's files, inside the program.
//!
//! The build script puts them there (`build/main.rs`), most of them gzipped, each then under its
//! own name with `.gz` behind it. Where the viewer could not be built there is one plain page
//! instead, which says why.

use bytes::Bytes;
use flate2::read::GzDecoder;
use include_dir::{Dir, include_dir};
use std::collections::BTreeMap;
use std::collections::hash_map::DefaultHasher;
use std::hash::Hasher;
use std::io::Read;
use std::sync::{Arc, OnceLock};

static FILES: Dir<'static> = include_dir!("$OUT_DIR/page");

/// True if the viewer is in, not the plain page in its place.
pub const BUILT: bool = matches!(env!("THENAR_PAGE").as_bytes(), b"built");

/// One file of the page.
#[derive(Clone, Debug)]
pub struct Asset {
    /// Bytes as stored, gzipped or plain.
    pub bytes: &'static [u8],
    /// True if they are gzipped.
    pub gzipped: bool,
    /// Media type of the content.
    pub media_type: &'static str,
    /// Changes when the file does: an HTTP entity tag, quotes included.
    pub tag: String,
    /// True if the name changes with the content, so that it can be kept for good.
    pub lasting: bool,
    /// True if [`SOCKET`] in it stands for the address of the socket.
    pub names_socket: bool,
    /// Unpacked bytes, from the first time that they were asked for.
    plain: Arc<OnceLock<Bytes>>,
}

impl Asset {
    /// Unpacked bytes. Unpacked once: whoever asks for them again and again must cost
    /// neither time nor memory.
    pub fn plain(&self) -> Bytes {
        if !self.gzipped {
            return Bytes::from_static(self.bytes);
        }
        let unpack = || {
            let mut plain = Vec::new();
            // The build script packed it, so it can be unpacked.
            let _ = GzDecoder::new(self.bytes).read_to_end(&mut plain);
            Bytes::from(plain)
        };
        self.plain.get_or_init(unpack).clone()
    }
}

/// Stands in the plain page for the address of the socket, which only the visitor knows.
pub const SOCKET: &str = "{socket}";

/// All files by their path, `/index.html` also as `/`.
pub fn assets() -> BTreeMap<String, Asset> {
    let mut assets = BTreeMap::new();
    let mut folders = vec![&FILES];
    while let Some(folder) = folders.pop() {
        folders.extend(folder.dirs());
        for file in folder.files() {
            let stored = format!("/{}", file.path().to_string_lossy().replace('\\', "/"));
            let (path, gzipped) = match stored.strip_suffix(".gz") {
                Some(path) => (path.to_owned(), true),
                None => (stored, false),
            };
            let asset = Asset {
                bytes: file.contents(),
                gzipped,
                media_type: media_type(&path),
                tag: tag(file.contents()),
                lasting: is_hashed(&path),
                names_socket: !BUILT,
                plain: Arc::default(),
            };
            assets.insert(path, asset);
        }
    }
    if let Some(index) = assets.get("/index.html").cloned() {
        assets.insert("/".into(), index);
    }
    assets
}

fn tag(bytes: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    format!("\"{:016x}\"", hasher.finish())
}

/// Vite's own files: `/assets/NAME-HASH.EXT` with a hash of eight characters.
fn is_hashed(path: &str) -> bool {
    let Some(name) = path.strip_prefix("/assets/").filter(|name| !name.contains('/')) else {
        return false;
    };
    let stem = name.split_once('.').map_or(name, |(stem, _)| stem);
    stem.len() > 9
        && stem.is_char_boundary(stem.len() - 9)
        && stem[stem.len() - 9..].starts_with('-')
}

/// The media type that goes with a name.
fn media_type(path: &str) -> &'static str {
    match path.rsplit('.').next().unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" | "map" => "application/json",
        "webmanifest" => "application/manifest+json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "wasm" => "application/wasm",
        "glb" => "model/gltf-binary",
        "txt" | "md" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_page() {
        let assets = assets();
        let index = &assets["/"];
        assert!(index.media_type.starts_with("text/html") && !index.bytes.is_empty());
        assert!(!index.lasting, "the entry must not be kept for good");
        assert!(assets.keys().all(|path| path.starts_with('/') && !path.ends_with(".gz")));
        if BUILT {
            assert!(assets.values().any(|a| a.lasting && a.media_type.starts_with("text/java")));
        }
    }

    #[test]
    fn a_file_is_unpacked_once_for_everybody() {
        for asset in assets().values() {
            let (plain, again) = (asset.plain(), asset.clone().plain());
            assert_eq!(plain.as_ptr(), again.as_ptr());
            // A gzip file ends with the length of what it holds (RFC 1952, 2.3.1).
            let length = match (asset.gzipped, asset.bytes.last_chunk()) {
                (true, Some(end)) => u32::from_le_bytes(*end) as usize,
                _ => asset.bytes.len(),
            };
            assert_eq!(plain.len(), length);
        }
    }

    #[test]
    fn only_hashed_names_last() {
        assert!(is_hashed("/assets/index-B6GqVcaz.js"));
        assert!(is_hashed("/assets/worker-a_b-cdef.js.map"));
        for path in ["/index.html", "/assets/a.js", "/assets/x/index-B6GqVcaz.js", "/x-B6GqVcaz.js"]
        {
            assert!(!is_hashed(path), "{path}");
        }
    }
}
