//! From somewhere on, and on the page.

use crate::stage::{Folder, Running, err, out, state};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Stdio;

/// A hand that a glove leads: what leads it stands in the keyframes, not in the scene.
#[test]
fn from_any_second_on_a_session_that_was_touched_has_its_bits() {
    let folder = Folder::new("from");
    let scene = "version = 1\ntime_step = 0.01\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\nflesh = false\n";
    std::fs::write(folder.0.join("hand.toml"), scene).unwrap();
    let args = "touch hand.toml --device simulated --seconds 4 -q --keyframes 0.5 --record t.rec";
    let touched = folder.thenar(&args.split(' ').collect::<Vec<_>>());
    assert!(touched.status.success(), "{}", err(&touched));
    let whole = folder.thenar(&["replay", "t.rec", "--verify"]);
    assert!(whole.status.success(), "{}", err(&whole));
    for from in ["0.8", "2", "3.1"] {
        let part = folder.thenar(&["replay", "t.rec", "--from", from, "--verify"]);
        assert!(part.status.success(), "{from}: {}", err(&part));
        assert!(out(&part).contains("steps passed over"), "{}", out(&part));
        assert_eq!(state(&part), state(&whole), "{from}");
    }
}

#[test]
fn a_recording_has_a_page() {
    let folder = Folder::new("page");
    assert!(folder.thenar(&["record", "falling-box", "--seconds", "0.4", "-q"]).status.success());
    let mut command = folder.command(&["replay", "falling-box.rec", "--serve", "--no-open"]);
    let mut server = Running(command.stdout(Stdio::piped()).spawn().unwrap());
    let mut lines = BufReader::new(server.0.stdout.take().unwrap()).lines().map_while(Result::ok);
    let told = lines.next().unwrap();
    // Another program may have the port.
    let told = if told.starts_with("Port") { lines.next().unwrap() } else { told };
    assert_eq!(told, "falling-box.rec is shown at");
    let url = lines.next().unwrap();
    let address = url.trim().trim_start_matches("http://").trim_end_matches('/');
    let mut page = TcpStream::connect(address).unwrap();
    write!(page, "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    page.take(12).read_to_string(&mut answer).unwrap();
    assert_eq!(answer, "HTTP/1.1 200");
    drop(server);

    for (args, why) in [
        (&["replay", "falling-box.rec", "--port", "9000"][..], "--serve"),
        (&["replay", "falling-box.rec", "--serve", "--csv", "t.csv"], "cannot be used with"),
        (&["replay", "nothing.rec", "--serve"], "nothing.rec"),
    ] {
        let refused = folder.thenar(args);
        assert_eq!(refused.status.code(), Some(2), "{args:?}");
        assert!(err(&refused).contains(why), "{args:?}: {}", err(&refused));
    }
}
