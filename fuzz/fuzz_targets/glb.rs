#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = thenar_rig::glb::read_glb(bytes);
    let _ = thenar_rig::glb::read_skinned_glb(bytes);
});
