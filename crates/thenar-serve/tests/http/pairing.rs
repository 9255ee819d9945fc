//! `--lan`: HTTPS, and nobody without the token.

use crate::stage::{Stage, rest, upgrade};
use ring::digest::{SHA256, digest};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use thenar_serve::http::{Reach, RequestLimits};
use tokio_rustls::rustls::client::danger::{
    HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier,
};
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::crypto::{verify_tls12_signature, verify_tls13_signature};
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use tokio_rustls::rustls::version::{TLS12, TLS13};
use tokio_rustls::rustls::{
    ALL_VERSIONS, ClientConfig, ClientConnection, DigitallySignedStruct, Error, SignatureScheme,
    StreamOwned, SupportedProtocolVersion,
};

type Tls = StreamOwned<ClientConnection, TcpStream>;

/// Trusts the one certificate whose fingerprint was printed.
#[derive(Debug)]
struct Printed(String);

impl ServerCertVerifier for Printed {
    fn verify_server_cert(
        &self,
        certificate: &CertificateDer<'_>,
        _: &[CertificateDer<'_>],
        _: &ServerName<'_>,
        _: &[u8],
        _: UnixTime,
    ) -> Result<ServerCertVerified, Error> {
        let bytes = digest(&SHA256, certificate);
        let text: Vec<String> = bytes.as_ref().iter().map(|b| format!("{b:02X}")).collect();
        match text.join(":") == self.0 {
            true => Ok(ServerCertVerified::assertion()),
            false => Err(Error::General("another certificate".into())),
        }
    }

    fn verify_tls12_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let known = default_provider().signature_verification_algorithms;
        verify_tls12_signature(message, certificate, signed, &known)
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signed: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, Error> {
        let known = default_provider().signature_verification_algorithms;
        verify_tls13_signature(message, certificate, signed, &known)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        default_provider().signature_verification_algorithms.supported_schemes()
    }
}

struct Lan {
    stage: Stage,
    config: Arc<ClientConfig>,
    token: String,
}

impl Lan {
    fn new() -> Self {
        Self::with(ALL_VERSIONS)
    }

    /// Asked by clients of these versions of TLS.
    fn with(versions: &[&'static SupportedProtocolVersion]) -> Self {
        let stage = Stage::new(Reach::Lan, RequestLimits::default(), 1000);
        let server = stage.server.as_ref().unwrap();
        let url = server.urls()[0].clone();
        let token =
            url.strip_prefix(&format!("https://{}/?token=", stage.host)).unwrap().to_owned();
        let printed = Printed(server.fingerprint().unwrap().to_owned());
        let config = ClientConfig::builder_with_provider(Arc::new(default_provider()))
            .with_protocol_versions(versions)
            .unwrap()
            .dangerous()
            .with_custom_certificate_verifier(Arc::new(printed))
            .with_no_client_auth();
        Self { stage, config: Arc::new(config), token }
    }

    fn ask(&self, head: &str) -> Tls {
        let name = ServerName::try_from("127.0.0.1").unwrap();
        let connection = ClientConnection::new(self.config.clone(), name).unwrap();
        let mut tls = StreamOwned::new(connection, self.stage.connect());
        tls.write_all(head.as_bytes()).unwrap();
        tls
    }

    fn get(&self, path: &str, headers: &str) -> String {
        let host = &self.stage.host;
        let head =
            format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{headers}\r\n");
        rest(&mut self.ask(&head))
    }

    /// The first line of the reply to an upgrade.
    fn join(&self, path: &str, headers: &str) -> String {
        let head = upgrade(&self.stage.host, headers).replace("/live", path);
        let mut tls = self.ask(&head);
        let mut line = [0; 12];
        tls.read_exact(&mut line).unwrap();
        String::from_utf8_lossy(&line).into_owned()
    }

    fn cookie(&self, token: &str) -> String {
        let port = self.stage.host.rsplit(':').next().unwrap();
        format!("Cookie: other=1; thenar_{port}={token}\r\n")
    }
}

#[test]
fn without_the_token_nobody_gets_anything() {
    let lan = Lan::new();
    let wrong = "0".repeat(32);
    let short = &lan.token[..31];
    let long = format!("{}0", lan.token);
    for path in ["/", "/index.html", "/live", "/assets/", "/nothing"] {
        let tokens = ["", &wrong, short, &long].map(|token| format!("{path}?token={token}"));
        for path in tokens.iter().map(String::as_str).chain([path]) {
            let reply = lan.get(path, "");
            assert!(reply.starts_with("HTTP/1.1 4"), "{path}: {reply}");
            assert!(!reply.contains("<html") && !reply.contains(&lan.token), "{path}: {reply}");
        }
    }
    let reply = lan.get("/", "");
    assert!(reply.starts_with("HTTP/1.1 403") && reply.contains("QR code"), "{reply}");
    assert_eq!(lan.join("/live", ""), "HTTP/1.1 403");
    assert!(lan.join("/live", &lan.cookie(&wrong)).starts_with("HTTP/1.1 4"));
    assert!(lan.join(&format!("/live?token={wrong}"), "").starts_with("HTTP/1.1 4"));
    // Plain HTTP gets a hint and no more.
    let reply = lan.stage.get(&format!("/?token={}", lan.token), "");
    assert!(reply.starts_with("HTTP/1.1 400") && reply.contains("https://"), "{reply}");
}

#[test]
fn game_engines_speak_an_older_tls() {
    for version in [&TLS12, &TLS13] {
        let lan = Lan::with(&[version]);
        assert_eq!(lan.join(&format!("/live?token={}", lan.token), ""), "HTTP/1.1 101");
        assert_eq!(lan.join("/live", ""), "HTTP/1.1 403");
    }
}

#[test]
fn the_token_becomes_a_cookie_that_opens_everything() {
    let lan = Lan::new();
    let reply = lan.get(&format!("/?token={}", lan.token), "");
    assert!(reply.starts_with("HTTP/1.1 303"), "{reply}");
    assert!(reply.contains("location: /\r\n"), "{reply}");
    let port = lan.stage.host.rsplit(':').next().unwrap();
    let cookie = format!(
        "set-cookie: thenar_{port}={}; Path=/; HttpOnly; SameSite=Strict; Secure\r\n",
        lan.token
    );
    assert!(reply.contains(&cookie), "{reply}");

    let cookie = lan.cookie(&lan.token);
    assert!(lan.get("/", &cookie).contains("<title>Thenar"));
    assert_eq!(lan.join("/live", &cookie), "HTTP/1.1 101");
    assert_eq!(lan.join(&format!("/live?token={}", lan.token), ""), "HTTP/1.1 101");
    // Being paired does not help another site's page.
    let evil = format!("{cookie}Origin: https://evil.example\r\n");
    assert_eq!(lan.join("/live", &evil), "HTTP/1.1 403");
    let own = format!("{cookie}Origin: https://{}\r\n", lan.stage.host);
    assert_eq!(lan.join("/live", &own), "HTTP/1.1 101");
}

/// Who guesses is slowed down; the right token still works from the same address.
#[test]
fn guessing_is_answered_late_and_locks_nobody_out() {
    let lan = Lan::new();
    for _ in 0..10 {
        assert!(lan.get(&format!("/?token={}", "f".repeat(32)), "").starts_with("HTTP/1.1 403"));
    }
    assert!(lan.get("/?token=f", "").starts_with("HTTP/1.1 429"));
    assert!(lan.get(&format!("/?token={}", lan.token), "").starts_with("HTTP/1.1 303"));
    assert!(lan.get("/", &lan.cookie(&lan.token)).starts_with("HTTP/1.1 200"));
}

#[test]
fn two_starts_have_different_tokens() {
    assert_ne!(Lan::new().token, Lan::new().token);
}

/// Connections that nobody goes on with, in every state before the token: silent, in the middle of
/// the handshake, shaken hands, half a request.
fn half_open(lan: &Lan, count: usize) -> Vec<Box<dyn std::any::Any>> {
    let open = |k: usize| -> Box<dyn std::any::Any> {
        match k % 4 {
            0 => Box::new(lan.stage.connect()),
            1 => {
                let mut stream = lan.stage.connect();
                // It may have been turned out already.
                let _ = stream.write_all(&[0x16, 0x03, 0x01, 0x02, 0x00, 0x01]);
                Box::new(stream)
            }
            2 => Box::new(lan.ask("")),
            _ => Box::new(lan.ask("GET / HTTP/1.1\r\n")),
        }
    };
    (0..count).map(open).collect()
}

#[test]
fn strangers_who_hold_connections_keep_nobody_out() {
    let lan = Lan::new();
    let limits = RequestLimits::default();
    let cookie = lan.cookie(&lan.token);
    for count in [limits.connections_per_address, 2 * limits.connections] {
        let held = half_open(&lan, count);
        assert!(lan.get(&format!("/?token={}", lan.token), "").starts_with("HTTP/1.1 303"));
        assert!(lan.get("/", &cookie).starts_with("HTTP/1.1 200"));
        assert_eq!(lan.join("/live", &cookie), "HTTP/1.1 101");
        drop(held);
    }
}

#[test]
fn who_has_shown_the_token_is_not_turned_out() {
    let lan = Lan::new();
    let cookie = lan.cookie(&lan.token);
    let request = format!("GET /none HTTP/1.1\r\nHost: {}\r\n{cookie}\r\n", lan.stage.host);
    let mut mine = lan.ask(&request);
    let answered = |mine: &mut Tls| {
        let mut text = Vec::new();
        while !text.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            mine.read_exact(&mut byte).unwrap();
            text.push(byte[0]);
        }
        let text = String::from_utf8(text).unwrap().to_lowercase();
        let length = text.lines().find_map(|line| line.strip_prefix("content-length: "));
        let mut body = vec![0; length.unwrap().parse().unwrap()];
        mine.read_exact(&mut body).unwrap();
        text
    };
    assert!(answered(&mut mine).starts_with("http/1.1 404"));
    let _held = half_open(&lan, 2 * RequestLimits::default().connections);
    mine.write_all(request.as_bytes()).unwrap();
    assert!(answered(&mut mine).starts_with("http/1.1 404"));
}
