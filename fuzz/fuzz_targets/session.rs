#![no_main]
libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = thenar_fuzz::scenes::steps(text);
});
