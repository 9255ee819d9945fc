#![no_main]
use std::path::Path;
use thenar_scene::motion::Recording;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = Recording::read(bytes, Path::new("fuzz.jsonl"));
});
