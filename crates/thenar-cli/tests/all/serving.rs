//! Goal: a page is served where it was asked for, until Ctrl-C, and its port is free then. Method:
//! the program is run as a user runs it, and asked for pages as a browser asks.

use crate::stage::{Folder, err};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

/// A server that is killed where a test fails.
struct Served {
    child: Child,
    out: BufReader<std::process::ChildStdout>,
    /// `127.0.0.1:PORT`
    host: String,
}

impl Served {
    /// Starts one and reads its address from what it prints.
    fn start(folder: &Folder, args: &[&str]) -> Self {
        let mut child = folder.command(args).stdout(Stdio::piped()).spawn().unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        while !line.trim().starts_with("http://") {
            line.clear();
            assert!(out.read_line(&mut line).unwrap() > 0, "it ended without an address");
        }
        let host = line.trim().trim_start_matches("http://").trim_end_matches('/').to_owned();
        Self { child, out, host }
    }

    fn get(&self, path: &str) -> String {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        let host = &self.host;
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut reply = Vec::new();
        stream.read_to_end(&mut reply).unwrap();
        String::from_utf8_lossy(&reply).into_owned()
    }

    /// Ctrl-C, and the exit code that follows.
    fn interrupt(mut self) -> Option<i32> {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
        let mut rest = String::new();
        self.out.read_to_string(&mut rest).unwrap();
        self.child.wait().unwrap().code()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[cfg(unix)]
#[test]
fn alone_it_serves_a_page_until_ctrl_c_and_frees_the_port() {
    let folder = Folder::new("bare");
    let served = Served::start(&folder, &[]);
    let reply = served.get("/");
    assert!(reply.starts_with("HTTP/1.1 200 OK"), "{reply}");
    assert!(reply.contains("<title>Thenar"), "{reply}");
    let host = served.host.clone();
    assert_eq!(served.interrupt(), Some(0));
    let again = std::net::TcpListener::bind(&host);
    assert!(again.is_ok(), "{host}: {again:?}");
    assert!(folder.files().is_empty());
}

#[cfg(unix)]
#[test]
fn a_port_that_was_asked_for_is_had_or_refused() {
    let folder = Folder::new("port");
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let output = folder.thenar(&["serve", "soft-cube", "--port", &port]);
    assert_eq!(output.status.code(), Some(2));
    let expected = format!("port {port} is in use");
    assert!(err(&output).contains(&expected), "{}", err(&output));
    drop(taken);
    let served = Served::start(&folder, &["serve", "soft-cube", "--port", &port, "--no-open"]);
    assert_eq!(served.host, format!("127.0.0.1:{port}"));
    assert_eq!(served.interrupt(), Some(0));
}

#[test]
fn a_scene_that_cannot_be_served_exits_with_2() {
    let folder = Folder::new("serve-wrong");
    for (args, expected) in [
        (&["serve", "none"][..], "no scene `none`"),
        (&["serve", "soft-cube", "--set", "gravty=1"], "gravty"),
        (&["serve", "soft-cube", "--time-step", "0"], "time_step"),
    ] {
        let output = folder.thenar(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", err(&output));
        assert!(err(&output).contains(expected), "{args:?}: {}", err(&output));
    }
}
