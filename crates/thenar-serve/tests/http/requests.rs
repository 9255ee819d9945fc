//! Plain requests: the page, and everything that is not the page.

use crate::stage::{Stage, rest, upgrade};
use flate2::read::GzDecoder;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;
use thenar_serve::http::RequestLimits;
use thenar_serve::page;

fn status(reply: &str) -> u16 {
    let code = reply.strip_prefix("HTTP/1.1 ").and_then(|r| r.get(..3));
    code.and_then(|c| c.parse().ok()).unwrap_or_else(|| panic!("no reply: {reply:?}"))
}

fn header<'a>(reply: &'a str, name: &str) -> &'a str {
    let head = reply.split("\r\n\r\n").next().unwrap();
    let line = head.lines().find(|l| l.to_ascii_lowercase().starts_with(&format!("{name}: ")));
    line.map_or("", |l| &l[name.len() + 2..])
}

#[test]
fn the_page_comes_with_its_types_and_its_fence() {
    let stage = Stage::endpoint();
    for (path, asset) in page::assets() {
        let reply = stage.get(&path, "");
        assert_eq!(status(&reply), 200, "{path}");
        assert_eq!(header(&reply, "content-type"), asset.media_type, "{path}");
        assert_eq!(header(&reply, "content-encoding"), "", "{path}: not asked for");
        let kept = header(&reply, "cache-control");
        assert_eq!(kept.contains("immutable"), asset.lasting, "{path}: {kept}");
    }
    let reply = stage.get("/", "");
    assert!(reply.contains("<!doctype html>") && reply.contains("<title>Thenar"));
    let policy = header(&reply, "content-security-policy");
    let host = &stage.host;
    for part in [
        "default-src 'none'",
        "'wasm-unsafe-eval'",
        &format!("ws://{host}"),
        "frame-ancestors 'none'",
    ] {
        assert!(policy.contains(part), "{part}: {policy}");
    }
    assert!(!policy.contains("'unsafe-eval'") && !policy.contains('*'), "{policy}");
    assert_eq!(header(&reply, "x-content-type-options"), "nosniff");
    if !page::BUILT {
        assert!(reply.contains(&format!("ws://{host}/live")), "{reply}");
    }
}

/// A gzipped reply holds the same bytes as a plain one, and a known tag brings no bytes at all.
#[test]
fn a_file_is_the_same_however_it_travels() {
    let stage = Stage::endpoint();
    let gzipped = page::assets().into_iter().filter(|(_, a)| a.gzipped).map(|(path, _)| path);
    for path in gzipped.take(3) {
        let ask = |headers: &str| {
            let mut stream = stage.connect();
            let host = &stage.host;
            write!(
                stream,
                "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{headers}\r\n"
            )
            .unwrap();
            let mut bytes = Vec::new();
            stream.read_to_end(&mut bytes).unwrap();
            let end = bytes.windows(4).position(|w| w == b"\r\n\r\n").unwrap() + 4;
            bytes.split_off(end)
        };
        let mut unpacked = Vec::new();
        GzDecoder::new(&ask("Accept-Encoding: br, gzip\r\n")[..])
            .read_to_end(&mut unpacked)
            .unwrap();
        assert!(unpacked == ask(""), "{path}");
        assert!(unpacked == ask("Accept-Encoding: gzip;q=0\r\n"), "{path}");
    }
    let tag = header(&stage.get("/", ""), "etag").to_owned();
    let again = stage.get("/", &format!("If-None-Match: \"other\", {tag}\r\n"));
    assert_eq!((status(&again), again.split("\r\n\r\n").nth(1)), (304, Some("")));
}

#[test]
fn only_names_of_this_computer_are_answered() {
    let stage = Stage::endpoint();
    let ask =
        |headers: &str| {
            status(&stage.exchange(
                format!("GET / HTTP/1.1\r\nConnection: close\r\n{headers}\r\n").as_bytes(),
            ))
        };
    for host in ["localhost", "localhost:1", "127.0.0.1", "[::1]:8014"] {
        assert_eq!(ask(&format!("Host: {host}\r\n")), 200, "{host}");
    }
    for host in ["evil.example", "127.0.0.1.evil.example", "192.168.0.1", "localhost.evil.example"]
    {
        assert_eq!(ask(&format!("Host: {host}\r\n")), 403, "{host}");
    }
    for headers in ["", "Host: localhost\r\nHost: evil.example\r\n", "Host: \r\n"] {
        assert_eq!(ask(headers), 400, "{headers:?}");
    }
    // The name in an absolute address does not stand in for the header.
    let reply = stage.exchange(
        b"GET http://localhost/ HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n",
    );
    assert_eq!(status(&reply), 403);
}

#[test]
fn only_own_pages_and_programs_reach_the_socket() {
    let stage = Stage::endpoint();
    let host = stage.host.clone();
    let ask = |headers: &str| {
        let mut stream = stage.connect();
        write!(stream, "{}", upgrade(&host, headers)).unwrap();
        let mut head = [0; 12];
        stream.read_exact(&mut head).unwrap();
        status(&String::from_utf8_lossy(&head))
    };
    assert_eq!(ask(""), 101);
    assert_eq!(ask(&format!("Origin: http://{host}\r\n")), 101);
    for origin in ["null", "http://evil.example", "http://127.0.0.1:1", "file://", ""] {
        assert_eq!(ask(&format!("Origin: {origin}\r\n")), 403, "{origin}");
    }
    let both = format!("Origin: http://{host}\r\nOrigin: http://evil.example\r\n");
    assert_eq!(ask(&both), 403);
    assert_eq!(status(&stage.get("/live", "")), 426);
    assert_eq!(status(&stage.get("/live", "Upgrade: h2c\r\n")), 426);
}

#[test]
fn no_path_leads_out_of_the_page() {
    let stage = Stage::endpoint();
    for path in [
        "/../Cargo.toml",
        "/../../../../../../etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "//etc/passwd",
        "/..%2f..%2fetc%2fpasswd",
        "/assets/../../../etc/passwd",
        "/....//etc/passwd",
        "/assets",
        "/assets/",
        "/index.html.gz",
        "/\\..\\..\\etc\\passwd",
        "/%00",
        "/etc/passwd",
        "/./",
        "/index.html/",
        "/live/",
        "/?/../../etc/passwd/..",
    ] {
        let reply = stage.get(path, "");
        let expected = if path.starts_with("/?") { 200 } else { 404 };
        assert_eq!(status(&reply), expected, "{path}");
        assert!(!reply.contains("root:") && !reply.contains("[package]"), "{path}");
    }
    assert_eq!(status(&stage.exchange(b"GET etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n")), 400);
}

#[test]
fn what_is_no_proper_request_is_refused() {
    let stage = Stage::endpoint();
    let host = &stage.host;
    let ask = |line: &str, headers: &str| {
        status(&stage.exchange(format!("{line}\r\nHost: {host}\r\n{headers}\r\n").as_bytes()))
    };
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "BREW", "PROPFIND"] {
        assert_eq!(ask(&format!("{method} / HTTP/1.1"), ""), 405, "{method}");
        assert_eq!(ask(&format!("{method} /live HTTP/1.1"), ""), 405, "{method}");
    }
    assert_eq!(ask("POST / HTTP/1.1", "Content-Length: 1000000000000\r\n"), 405);
    assert_eq!(ask("GET / HTTP/1.1", &format!("X: {}\r\n", "a".repeat(40_000))), 431);
    assert_eq!(ask("GET / HTTP/1.1", &"X: a\r\n".repeat(1000)), 431);
    assert_eq!(ask(&format!("GET /{} HTTP/1.1", "a".repeat(40_000)), ""), 431);
    for bytes in [
        &b"\0\0\0\0\r\n\r\n"[..],
        b"GET\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\r\n\r\n",
    ] {
        assert_eq!(status(&stage.exchange(bytes)), 400, "{bytes:?}");
    }
}

/// Connections that say nothing, say it one byte at a time, or have nothing more to say are closed
/// by the server; others are served meanwhile.
#[test]
fn who_does_not_get_to_the_point_is_cut_off() {
    let limits = RequestLimits { head: Duration::from_millis(300), ..RequestLimits::default() };
    let stage = Stage::with(limits);
    let mut silent = stage.connect();
    let mut idle = stage.connect();
    write!(idle, "GET / HTTP/1.1\r\nHost: {}\r\n\r\n", stage.host).unwrap();
    let mut slow: TcpStream = stage.connect();
    let mut trickle = slow.try_clone().unwrap();
    let trickling = std::thread::spawn(move || {
        // Ends when the server has closed: then writing fails.
        let head = b"GET / HTTP/1.1\r\nX: ".iter().chain(std::iter::repeat(&b'a'));
        for byte in head.take(100_000) {
            if trickle.write_all(&[*byte]).is_err() {
                return true;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        false
    });
    stage.join().watch(50);
    assert_eq!(rest(&mut silent), "");
    assert!(rest(&mut idle).starts_with("HTTP/1.1 200"));
    rest(&mut slow);
    assert!(trickling.join().unwrap());
}
