#![no_main]
use std::sync::{Arc, LazyLock};
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_link::bhaptics::Bhaptics;
use thenar_link::cyberglove::{self, Classic, Third};
use thenar_link::cybergrasp::CyberGrasp;
use thenar_link::force_device::{self, ForceDevice};
use thenar_link::hand_tracking_streamer::{HandTrackingStreamer, Points};
use thenar_link::lucidgloves::{self, LucidGloves};
use thenar_link::pose_stream::PoseStream;
use thenar_link::profile::{Address, load};
use thenar_link::{Event, HandOutput, Protocol};

static NONE: LazyLock<Address> = LazyLock::new(Address::default);
static LUCID: LazyLock<Arc<lucidgloves::Profile>> =
    LazyLock::new(|| Arc::new(load("lucidgloves", lucidgloves::SHIPPED, &NONE).unwrap()));
static CLASSIC: LazyLock<Arc<cyberglove::Profile>> =
    LazyLock::new(|| Arc::new(load("cyberglove", cyberglove::SHIPPED, &NONE).unwrap()));
static THIRD: LazyLock<Arc<cyberglove::Profile>> =
    LazyLock::new(|| Arc::new(load("cyberglove3", cyberglove::SHIPPED_3, &NONE).unwrap()));
static ARM: LazyLock<force_device::profile::Profile> =
    LazyLock::new(|| load("force-device", force_device::profile::SHIPPED, &NONE).unwrap());

fn protocol(which: u8) -> Box<dyn Protocol> {
    match which % 10 {
        0 => Box::new(LucidGloves::new(LUCID.clone())),
        1 => Box::new(Classic::new(CLASSIC.clone())),
        2 => Box::new(Third::new(THIRD.clone())),
        3 => Box::new(CyberGrasp::new(None)),
        4 => Box::new(HandTrackingStreamer::new(false, Points::Auto)),
        5 => Box::new(HandTrackingStreamer::new(true, Points::World)),
        6 => Box::new(PoseStream::new(false)),
        7 => Box::new(PoseStream::new(true)),
        8 => Box::new(ForceDevice::new(ARM.setup().unwrap())),
        _ => Box::new(Bhaptics::default()),
    }
}

// The first byte chooses the protocol, the second how the rest is cut (0: not at all, as large
// datagrams are) and how fast time passes.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let [which, cut, stream @ ..] = bytes else { return };
    let mut protocol = protocol(*which);
    let length = match cut {
        0 => stream.len().max(1),
        cut => usize::from(*cut),
    };
    let step_ns = 1_000_000 << (cut % 13);
    let mut now_ns = 1;
    let mut event = |event| match event {
        Event::Sample(sample) => assert!(sample.time_ns < u64::MAX / 2),
        Event::Note(text) | Event::Refused(text) => assert!(text.len() < 400, "{text}"),
        Event::Alive => {}
    };
    protocol.start(now_ns, &mut |_| {});
    for (k, piece) in stream.chunks(length).enumerate() {
        now_ns += step_ns;
        protocol.receive(now_ns, piece, &mut event, &mut |_| {});
        // What it shall show comes and goes, nonsense included.
        let mut output = HandOutput::released(Side::Right, now_ns);
        output.force_W = Vec3::new(f64::from(piece[0]) - 128.0, f64::NAN, f64::INFINITY);
        for digit in &mut output.digits {
            digit.pad_force = f64::from(piece[0]);
            digit.curl_at_contact = Some(f64::from(piece[0]) / 100.0 - 1.0);
        }
        protocol.tick(now_ns, Some(&output).filter(|_| k % 3 == 0), &mut event, &mut |_| {});
    }
    protocol.stop(&mut |_| {});
});
