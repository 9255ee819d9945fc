#![no_main]
use std::path::PathBuf;
use std::sync::LazyLock;

static FILE: LazyLock<PathBuf> =
    LazyLock::new(|| std::env::temp_dir().join(format!("thenar-fuzz-{}.rec", std::process::id())));

// Bytes that begin with `+` are frames after a shared beginning, whose hand takes a second to
// build; checksums are made to agree.
libfuzzer_sys::fuzz_target!(
    init: {
        thenar_fuzz::recordings::beginning();
    },
    |bytes: &[u8]| {
        let _ = thenar_fuzz::recordings::replays(bytes, &FILE);
    }
);
