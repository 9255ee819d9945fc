#![no_main]
use std::sync::Arc;
use thenar_link::Protocol;
use thenar_link::cyberglove::{self, Classic, Third};
use thenar_link::cybergrasp::CyberGrasp;
use thenar_link::lucidgloves::{self, LucidGloves};
use thenar_link::profile::{Address, load};

// The first byte chooses the protocol, the second how the rest is cut.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let [which, cut, stream @ ..] = bytes else { return };
    let none = Address::default();
    let mut protocol: Box<dyn Protocol> = match which % 4 {
        0 => {
            let profile = load("lucidgloves", lucidgloves::SHIPPED, &none).unwrap();
            Box::new(LucidGloves::new(Arc::new(profile)))
        }
        1 => {
            let profile = load("cyberglove", cyberglove::SHIPPED, &none).unwrap();
            Box::new(Classic::new(Arc::new(profile)))
        }
        2 => {
            let profile = load("cyberglove3", cyberglove::SHIPPED_3, &none).unwrap();
            Box::new(Third::new(Arc::new(profile)))
        }
        _ => Box::new(CyberGrasp::new(None)),
    };
    let mut now_ns = 1;
    protocol.start(now_ns, &mut |_| {});
    for piece in stream.chunks(usize::from(*cut).max(1)) {
        now_ns += 1_000_000;
        protocol.receive(now_ns, piece, &mut |_| {}, &mut |_| {});
        protocol.tick(now_ns, None, &mut |_| {}, &mut |_| {});
    }
    protocol.stop(&mut |_| {});
});
