//! Many at once.

use crate::stage::{Stage, rest};
use std::io::{Read, Write};
use std::net::TcpStream;
use thenar_serve::http::RequestLimits;

/// Of a hundred, 64 are served and 36 hear why not; when those have left, others get in.
#[test]
fn a_hundred_clients() {
    let stage = Stage::endpoint();
    let mut clients: Vec<_> = (0..100).map(|_| stage.try_join()).collect();
    let refused = clients.extract_if(.., |client| client.is_err()).filter_map(Result::err);
    assert_eq!(refused.collect::<Vec<_>>(), [503; 36]);
    let mut clients: Vec<_> = clients.into_iter().filter_map(Result::ok).collect();
    assert_eq!(clients.len(), 64);
    for client in &mut clients {
        client.watch(3);
    }
    drop(clients.split_off(1));
    stage.wait_left(63);
    clients[0].watch(10);
    // A slot is free a moment after the client has left.
    let mut others = Vec::new();
    stage.wait("63 others get in", |_| {
        others.extend(stage.try_join().ok());
        others.len() == 63
    });
    assert_eq!(stage.try_join().err(), Some(503));
    for client in &mut others {
        client.watch(3);
    }
}

/// Connections that nobody goes on with: silent, or in the middle of a request.
fn half_open(stage: &Stage, count: usize) -> Vec<TcpStream> {
    let open = |k: usize| {
        let mut stream = stage.connect();
        stream.write_all(["", "G", "GET / HTTP/1.1\r\nHost: "][k % 3].as_bytes()).unwrap();
        stream
    };
    (0..count).map(open).collect()
}

#[test]
fn connections_that_ask_for_nothing_keep_nobody_out() {
    let stage = Stage::endpoint();
    let mut first = stage.join();
    let limits = RequestLimits::default();
    for count in [limits.connections_per_address, 2 * limits.connections] {
        let mut held = half_open(&stage, count);
        assert!(stage.get("/", "").starts_with("HTTP/1.1 200"), "{count}");
        stage.join().watch(3);
        // The oldest has given way.
        assert_eq!(rest(&mut held[0]), "");
    }
    first.watch(20);
}

#[test]
fn connections_that_ask_are_bounded_and_given_back() {
    let limits =
        RequestLimits { connections: 8, connections_per_address: 6, ..RequestLimits::default() };
    let stage = Stage::with(limits);
    let mut first = stage.join();
    let ask = || {
        let mut stream = stage.connect();
        write!(stream, "GET /none HTTP/1.1\r\nHost: {}\r\n\r\n", stage.host).unwrap();
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        (stream, String::from_utf8_lossy(&status).into_owned())
    };
    let held: Vec<_> = (0..6).map(|_| ask()).collect();
    assert!(held.iter().all(|(_, status)| status == "HTTP/1.1 404"));
    assert_eq!(ask().1, "HTTP/1.1 503");
    // Who has asked does not give way to who has not.
    let _silent = half_open(&stage, 20);
    let mut mine = &held[0].0;
    write!(mine, "GET /none HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", stage.host)
        .unwrap();
    assert!(rest(&mut mine).contains("HTTP/1.1 404"));
    first.watch(20);
    drop(held);
    stage.wait("a place", |_| stage.get("/", "").starts_with("HTTP/1.1 200"));
}
