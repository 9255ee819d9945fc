//! Clients that mean harm. In each test a good client watches along and keeps getting newer and
//! newer snapshots; the stand-in for the simulation publishes whatever happens.

use crate::stage::{Client, Got, Stage};
use std::io::Write;
use std::net::TcpStream;
use std::time::Duration;
use thenar_core::random::Random;
use thenar_serve::http::{Reach, RequestLimits};
use thenar_serve::hub::Event;
use tokio_tungstenite::tungstenite::Message;

/// A client's frame: first byte as given, mask 0.
fn frame(first: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![first];
    match payload.len() {
        0..126 => bytes.push(0x80 | payload.len() as u8),
        126..65536 => {
            bytes.push(0x80 | 126);
            bytes.extend((payload.len() as u16).to_be_bytes());
        }
        length => {
            bytes.push(0x80 | 127);
            bytes.extend((length as u64).to_be_bytes());
        }
    }
    bytes.extend([0; 4]);
    bytes.extend(payload);
    bytes
}

/// A session opened by hand, continued with a library.
fn by_hand(stage: &Stage, bytes: &[u8]) -> Client {
    use tokio_tungstenite::tungstenite::WebSocket;
    use tokio_tungstenite::tungstenite::protocol::Role;
    let mut stream = stage.join_raw();
    let _ = stream.write_all(bytes);
    Client(WebSocket::from_raw_socket(stream, Role::Client, None))
}

#[test]
fn what_is_too_long_is_refused_or_ends_the_session() {
    let stage = Stage::endpoint();
    let mut good = stage.join();
    let mut client = stage.join();
    client.snapshot();
    client.text(&"a".repeat(4096));
    assert_eq!(client.news(), Got::Text(format!("heard {}", "a".repeat(4096))));
    client.text(&"a".repeat(4097));
    let Got::Text(refused) = client.news() else { panic!("no word") };
    assert!(refused.contains("at most 4096 bytes"), "{refused}");
    client.pour(Message::Binary(vec![0; 1025].into())).unwrap();
    let Got::Text(refused) = client.news() else { panic!("no word") };
    assert!(refused.contains("at most 1024 bytes"), "{refused}");
    client.watch(10);
    let _ = client.pour(Message::Binary(vec![0; 20_000].into()));
    assert_eq!(client.closed(), 1009);
    // A frame that announces four exabytes.
    let announced = [&[0x82, 0xff][..], &(1_u64 << 62).to_be_bytes(), &[0; 4]].concat();
    assert_eq!(by_hand(&stage, &announced).closed(), 1009);
    // Only what was within bounds got through.
    let events = stage.shared.events.lock().unwrap();
    assert!(events.iter().all(|e| !matches!(e, Event::Binary(..))));
    assert_eq!(events.iter().filter(|e| matches!(e, Event::Text(..))).count(), 1);
    drop(events);
    good.watch(50);
}

#[test]
fn what_is_no_websocket_ends_the_session() {
    let stage = Stage::endpoint();
    let mut good = stage.join();
    let cases: [(&str, Vec<u8>, u16); 8] = [
        ("text that is not UTF-8", frame(0x81, &[0xc3, 0x28]), 1007),
        ("a frame without a mask", vec![0x81, 0x01, b'a'], 1002),
        ("a reserved bit", frame(0xc1, b"a"), 1002),
        ("a reserved kind", frame(0x83, b"a"), 1002),
        ("a continuation of nothing", frame(0x80, b"a"), 1002),
        ("a ping in pieces", frame(0x09, b"a"), 1002),
        ("a ping too long", frame(0x89, &[0; 126]), 1002),
        ("a text within a text", [frame(0x01, b"a"), frame(0x81, b"b")].concat(), 1002),
    ];
    for (name, bytes, code) in cases {
        assert_eq!(by_hand(&stage, &bytes).closed(), code, "{name}");
        good.watch(3);
    }
    assert!(stage.shared.events.lock().unwrap().iter().all(|e| !matches!(e, Event::Text(..))));
}

#[test]
fn pieces_are_put_together_within_the_same_bounds() {
    let stage = Stage::endpoint();
    let mut good = stage.join();
    let pieces =
        [frame(0x01, b"one "), frame(0x00, b"two "), frame(0x89, b"?"), frame(0x80, b"three")];
    let mut client = by_hand(&stage, &pieces.concat());
    let heard = |got: Got| matches!(got, Got::Text(text) if text == "heard one two three");
    while !heard(client.news()) {}
    // Pieces without end.
    let endless = [frame(0x01, &[b'a'; 100]), frame(0x00, &[b'a'; 100]).repeat(400)].concat();
    assert_eq!(by_hand(&stage, &endless).closed(), 1009);
    good.watch(50);
}

#[test]
fn sessions_that_break_off_anywhere_leave_nothing_behind() {
    let stage = Stage::endpoint();
    let mut good = stage.join();
    let whole = [frame(0x01, b"half "), frame(0x80, b"done"), frame(0x82, &[7; 300])].concat();
    let cuts: Vec<usize> = (0..whole.len()).step_by(13).collect();
    for &cut in &cuts {
        stage.join_raw().write_all(&whole[..cut]).unwrap();
    }
    stage.wait_left(cuts.len());
    good.watch(50);
}

/// Bytes that come next.
fn bytes(random: &mut Random, count: usize) -> Vec<u8> {
    (0..count).map(|_| random.below(256) as u8).collect()
}

#[test]
fn noise_is_survived() {
    let stage = Stage::endpoint();
    let mut good = stage.join();
    let mut random = Random::new(1);
    for round in 0..100 {
        // Before and after the upgrade, as raw bytes and in proper frames.
        let _ = stage.connect().write_all(&bytes(&mut random, 200));
        let _ = stage.join_raw().write_all(&bytes(&mut random, 200));
        let payload = bytes(&mut random, 1 + 10 * round);
        let mut stream = stage.join_raw();
        let _ = stream.write_all(&frame(0x82, &payload));
        let _ = stream.write_all(&frame(0x80 | (bytes(&mut random, 1)[0] & 0x0f), &payload));
    }
    stage.wait_left(200);
    good.watch(50);
}

/// Bounds on all that comes in, not only on messages that mean something: pings, and pieces that
/// never become a message.
#[test]
fn floods_end_the_session() {
    let limits = RequestLimits { bytes: 100_000.0, ..RequestLimits::default() };
    let stage = Stage::with(limits);
    let mut good = stage.join();
    let mut pings = by_hand(&stage, &frame(0x89, b"").repeat(10_000));
    assert_eq!(pings.closed(), 1008);
    let mut empty = stage.join_raw();
    let _ = empty.write_all(&frame(0x01, b"a"));
    let nothing = frame(0x00, b"").repeat(1000);
    // 6 kB at a time; the server's patience ends after 400 kB and some.
    let sent = (0..100_000).take_while(|_| empty.write_all(&nothing).is_ok()).count();
    assert!(sent < 100_000);
    stage.wait_left(2);
    good.watch(50);
}

/// Takes the opening, then neither reads nor answers: no sign of life.
#[test]
fn who_gives_no_sign_of_life_is_cut_off() {
    let limits = RequestLimits { ping: Duration::from_millis(100), ..RequestLimits::default() };
    let stage = Stage::with(limits);
    let gone: Vec<TcpStream> = (0..10).map(|_| stage.join_raw()).collect();
    let mut good = stage.join();
    let watching = std::thread::spawn(move || {
        good.watch(500);
        good
    });
    stage.wait_left(10);
    let mut good = watching.join().unwrap();
    good.watch(10);
    drop(gone);
}

/// Signs of life without reading a model larger than all buffers on the way.
#[test]
fn who_never_reads_is_cut_off() {
    let limits = RequestLimits {
        send: Duration::from_millis(500),
        stuck: Duration::from_millis(500),
        ..RequestLimits::default()
    };
    let stage = Stage::new(Reach::Loopback, limits, 30_000_000);
    let mut good = stage.join();
    good.watch(3);
    let mut full = stage.join_raw();
    let alive = frame(0x8a, b"");
    let mut left = 0;
    stage.wait("it is cut off", |shared| {
        let _ = full.write_all(&alive);
        let events = shared.events.lock().unwrap();
        left = events.iter().filter(|e| matches!(e, Event::Left(_))).count();
        left == 1
    });
    good.watch(50);
}

/// Clients send answers to pings that they have not read, and other signs of life, from all places
/// there are.
#[test]
fn who_reads_nothing_gives_way_to_who_does() {
    let stage = Stage::endpoint();
    let mut good = stage.join();
    let mut idle: Vec<TcpStream> =
        (1..RequestLimits::default().clients).map(|_| stage.join_raw()).collect();
    assert_eq!(stage.try_join().err(), Some(503), "any of them may be reading");
    let begun = std::time::Instant::now();
    let mut number = 0_u32;
    let mut newcomer = None;
    // Answers for all pings to come, and empty ones.
    while newcomer.is_none() {
        assert!(begun.elapsed() < crate::stage::FOREVER, "nobody gives way");
        number += 1;
        let signs = [frame(0x8a, &number.to_le_bytes()), frame(0x8a, b""), frame(0x89, b"")];
        for stream in &mut idle {
            let _ = stream.write_all(&signs.concat());
        }
        good.watch(3);
        newcomer = stage.try_join().ok();
    }
    newcomer.unwrap().watch(20);
    stage.wait_left(1);
    // Who reads stays, whoever comes.
    for _ in 0..10 {
        stage.join().watch(3);
    }
    good.watch(20);
}
