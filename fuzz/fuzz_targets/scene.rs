#![no_main]
use thenar_scene::format::Scene;
use thenar_scene::text::{Node, parse};

libfuzzer_sys::fuzz_target!(|text: &str| {
    // Reading only: what a scene names may be large to build.
    let _ = Node::parse(text).and_then(|node| parse::<Scene>(&node));
});
