//! Many at once.

use crate::stage::{Stage, rest};
use thenar_serve::http::Limits;

/// Of a hundred, 64 are served and 36 hear why not; when those have left, others get in.
#[test]
fn a_hundred_clients() {
    let stage = Stage::desk();
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

#[test]
fn connections_are_bounded_and_given_back() {
    let limits = Limits { connections: 8, connections_per_address: 6, ..Limits::default() };
    let stage = Stage::with(limits);
    let mut first = stage.join();
    let held: Vec<_> = (0..6).map(|_| stage.connect()).collect();
    // They are taken in the order in which they come.
    assert!(rest(&mut stage.connect()).starts_with("HTTP/1.1 503"));
    first.watch(20);
    drop(held);
    stage.wait("a place", |_| stage.get("/", "").starts_with("HTTP/1.1 200"));
}
