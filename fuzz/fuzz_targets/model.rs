#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = thenar_rig::Model::from_bytes(bytes);
});
