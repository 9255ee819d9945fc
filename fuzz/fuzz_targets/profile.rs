#![no_main]
use std::path::PathBuf;
use std::sync::LazyLock;

static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    std::env::temp_dir().join(format!("thenar-fuzz-profile-{}.toml", std::process::id()))
});

// The first byte chooses the driver.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let [driver, text @ ..] = bytes {
        let _ = thenar_fuzz::profiles::plays(usize::from(*driver), text, &FILE);
    }
});
