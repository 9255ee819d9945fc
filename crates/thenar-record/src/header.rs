//! Header of a recording.

use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;

/// The first frame: who wrote the recording, where and when.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Header {
    /// Program and version, e.g. `thenar 0.1.0`.
    pub program: String,
    /// The program's file: the same build gives the same bits.
    pub build: Build,
    /// Vector instructions in use, e.g. `Avx512`: bits are the same only where they are.
    pub vectors: String,
    /// Operating system and processor family, e.g. `linux x86_64`.
    pub system: String,
    /// Start of the recording \[ns since 1970-01-01 UTC\].
    pub created_unix_ns: u64,
    /// True when frames carry simulated time instead of that of a clock on the wall.
    pub simulated_time: bool,
}

/// Fingerprint of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Build {
    /// Size of the program's file \[bytes\]; 0 when it could not be read.
    pub bytes: u64,
    /// CRC-32 of the program's file.
    pub crc32: u32,
}

impl Build {
    /// Build of the running program. Reads the program's file, which takes some ten milliseconds.
    pub fn of_this_program() -> Self {
        // What runs, even when its file was replaced meanwhile.
        let running = Path::new("/proc/self/exe");
        let file =
            if running.exists() { Ok(running.to_path_buf()) } else { std::env::current_exe() };
        file.and_then(|file| Self::of(&file)).unwrap_or_default()
    }

    fn of(file: &Path) -> std::io::Result<Self> {
        let mut file = std::fs::File::open(file)?;
        let (mut sum, mut bytes) = (crc32fast::Hasher::new(), 0);
        let mut buffer = vec![0; 1 << 20];
        loop {
            match file.read(&mut buffer)? {
                0 => return Ok(Self { bytes, crc32: sum.finalize() }),
                n => {
                    sum.update(&buffer[..n]);
                    bytes += n as u64;
                }
            }
        }
    }
}
