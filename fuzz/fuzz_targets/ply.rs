#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = thenar_rig::mesh::read_ply(bytes);
});
