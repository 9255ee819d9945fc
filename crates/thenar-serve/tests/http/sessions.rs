//! What a well-meaning client gets.

use crate::stage::{Got, STATUS, Stage, events_of};
use std::sync::atomic::Ordering;
use thenar_serve::hub::{ClientId, Event};
use tokio_tungstenite::tungstenite::Message;

#[test]
fn a_session_opens_with_welcome_status_model_and_snapshots() {
    let stage = Stage::endpoint();
    stage.wait("snapshots", |s| s.number.load(Ordering::Relaxed) > 3);
    let mut client = stage.join();
    let Got::Text(welcome) = client.next() else { panic!("no welcome") };
    let welcome: serde_json::Value = serde_json::from_str(&welcome).unwrap();
    assert_eq!((&welcome["type"], &welcome["client"]), (&"welcome".into(), &1.into()));
    assert_eq!(client.next(), Got::Text(STATUS.into()));
    assert_eq!(client.next(), Got::Model { epoch: 1 });
    assert!(matches!(client.next(), Got::Snapshot { epoch: 1, .. }));
    client.watch(100);
}

#[test]
fn clients_are_told_apart() {
    let stage = Stage::endpoint();
    let (mut a, mut b) = (stage.join(), stage.join());
    for client in [&mut a, &mut b] {
        client.snapshot();
    }
    a.text("from a");
    b.text("from b");
    assert_eq!(a.news(), Got::Text("heard from a".into()));
    assert_eq!(b.news(), Got::Text("heard from b".into()));
    drop(a);
    stage.wait_left(1);
    b.watch(20);
    let first = events_of(&stage.shared, ClientId(1));
    let said = Event::Text(ClientId(1), "from a".into());
    assert_eq!(first, [Event::Joined(ClientId(1)), said, Event::Left(ClientId(1))]);
}

/// A client that looks away for 300 snapshots finds at most four old ones when it looks again,
/// then new ones.
#[test]
fn a_slow_client_gets_no_old_snapshots() {
    let stage = Stage::endpoint();
    let mut client = stage.join();
    let seen = client.snapshot();
    stage.wait("snapshots", |s| s.number.load(Ordering::Relaxed) > seen + 300);
    let now = stage.shared.number.load(Ordering::Relaxed);
    let old = (0..).take_while(|_| client.snapshot() < now).count();
    assert!(old <= 4, "{old}");
}

/// However models change, each snapshot follows the model that it belongs to.
#[test]
fn a_snapshot_never_comes_before_its_model() {
    let stage = Stage::endpoint();
    let mut client = stage.join();
    let mut epoch = 0;
    let (mut models, mut snapshots) = (0, 0);
    while models < 50 || snapshots < 50 {
        match client.next() {
            Got::Model { epoch: new } => {
                assert!(new > epoch);
                (epoch, models) = (new, models + 1);
            }
            Got::Snapshot { epoch: its, .. } => {
                assert_eq!(its, epoch);
                snapshots += 1;
                stage.shared.epoch.fetch_add(1, Ordering::Relaxed);
            }
            Got::Text(_) => {}
            closed @ Got::Closed { .. } => panic!("{closed:?}"),
        }
    }
}

/// A pose message is `[16, 1, hand, 0]` and its number.
fn pose(hand: u8, number: u32) -> Message {
    let mut bytes = vec![16, 1, hand, 0];
    bytes.extend(number.to_le_bytes());
    Message::Binary(bytes.into())
}

/// Of a burst of poses far beyond the rate, some are dropped, the order stays, and the newest of
/// each hand arrives.
#[test]
fn of_too_many_poses_the_newest_counts() {
    let stage = Stage::endpoint();
    let mut client = stage.join();
    for number in 1..=600 {
        for hand in [0, 1] {
            client.pour(pose(hand, number)).unwrap();
        }
    }
    let arrived = |hand: u8| -> Vec<u32> {
        let events = events_of(&stage.shared, ClientId(1)).into_iter();
        let poses = events.filter_map(|event| match event {
            Event::Binary(_, b) if b[2] == hand => {
                Some(u32::from_le_bytes(b[4..8].try_into().unwrap()))
            }
            _ => None,
        });
        poses.collect()
    };
    for hand in [0, 1] {
        stage.wait("the newest pose", |_| arrived(hand).last() == Some(&600));
        let numbers = arrived(hand);
        assert!(numbers.windows(2).all(|w| w[0] < w[1]), "{numbers:?}");
        assert!(numbers.len() < 600, "none was dropped");
    }
}

#[test]
fn the_tenth_refusal_ends_a_session() {
    let stage = Stage::endpoint();
    let mut client = stage.join();
    client.snapshot();
    for _ in 0..9 {
        client.text("no");
        assert_eq!(client.news(), Got::Text("heard no".into()));
    }
    client.text("yes");
    assert_eq!(client.news(), Got::Text("heard yes".into()));
    client.text("no");
    assert_eq!(client.news(), Got::Text("heard no".into()));
    let Got::Closed { code, reason } = client.news() else { panic!("it goes on") };
    assert_eq!(code, 1008);
    assert!(reason.contains("refused"), "{reason}");
    stage.wait_left(1);
}

#[test]
fn texts_beyond_the_rate_are_dropped_with_a_word() {
    let stage = Stage::endpoint();
    let mut client = stage.join();
    for _ in 0..400 {
        client.text("yes");
    }
    loop {
        match client.news() {
            Got::Text(text) if text.contains("some were dropped") => break,
            Got::Text(_) | Got::Model { .. } => {}
            closed => panic!("{closed:?}"),
        }
    }
    client.watch(20);
    let events = events_of(&stage.shared, ClientId(1));
    let heard = events.iter().filter(|e| matches!(e, Event::Text(..))).count();
    assert!((64..400).contains(&heard), "{heard}");
}

#[test]
fn everyone_hears_that_the_server_ends_and_the_port_is_free() {
    let mut stage = Stage::endpoint();
    let mut clients = [stage.join(), stage.join()];
    for client in &mut clients {
        client.snapshot();
    }
    let waiting = std::thread::spawn(move || clients.map(|mut client| client.closed()));
    stage.server.take().unwrap().stop();
    assert_eq!(waiting.join().unwrap(), [1001, 1001]);
    std::net::TcpListener::bind(&stage.host).unwrap();
}

#[test]
fn everyone_hears_that_the_simulation_has_ended() {
    let stage = Stage::endpoint();
    let mut client = stage.join();
    client.snapshot();
    stage.shared.end.store(true, Ordering::Relaxed);
    assert_eq!(client.closed(), 1011);
    assert_eq!(stage.join().closed(), 1011);
}
