//! Guard at the door: before anything else is looked at, every request passes here.

use super::site::{Access, Site};
use super::token::{in_cookies, in_query};
use hyper::header::{HOST, HeaderName, ORIGIN};
use hyper::http::request::Parts;
use hyper::{HeaderMap, StatusCode};
use std::net::IpAddr;
use std::time::Instant;

/// Why a request is not answered: status and a text for people.
#[derive(Debug, PartialEq, Eq)]
pub struct Refusal(pub StatusCode, pub &'static str);

const WRONG_HOST: Refusal = Refusal(
    StatusCode::FORBIDDEN,
    "This server answers on this computer only, as localhost, 127.0.0.1 or [::1]. \
     For other machines start it with `thenar serve --lan`.",
);
const WRONG_ORIGIN: Refusal =
    Refusal(StatusCode::FORBIDDEN, "Pages of other origins may not use this server.");
const NO_TOKEN: Refusal = Refusal(
    StatusCode::FORBIDDEN,
    "Open the whole address that `thenar serve --lan` prints, or scan its QR code: it carries the \
     pairing token, which is new at every start. If you just followed such an address from \
     another page, load this page again.",
);
/// The answer to those who guess.
pub const TOO_MANY: Refusal =
    Refusal(StatusCode::TOO_MANY_REQUESTS, "Too many wrong pairing tokens from your address.");

/// Admission of a request.
#[derive(Debug, PartialEq, Eq)]
pub enum Admission {
    /// The request may be answered.
    Granted,
    /// Likewise, and the address bar shows the token: give the cookie and lead to the bare page.
    Pairing,
}

/// Lets a request in or refuses it.
///
/// # Errors
/// Another host is meant, another site's page asks, or the token is missing or wrong.
pub fn admit(site: &Site, peer: IpAddr, request: &Parts) -> Result<Admission, Refusal> {
    let host = host(&request.headers)?;
    if matches!(site.access, Access::Loopback) && !is_this_computer(host) {
        return Err(WRONG_HOST);
    }
    if !own_origin(&request.headers, host) {
        return Err(WRONG_ORIGIN);
    }
    let Access::Lan { token, cookie, wrong_tokens, .. } = &site.access else {
        return Ok(Admission::Granted);
    };
    let offered = in_query(request.uri.query());
    if offered.is_some_and(|text| token.is(text)) {
        return Ok(match request.uri.path() {
            "/" => Admission::Pairing,
            _ => Admission::Granted,
        });
    }
    let mut known = in_cookies(&request.headers, cookie).peekable();
    let guessed = offered.is_some() || known.peek().is_some();
    // A wrong token in the address is not made good by an old cookie.
    if offered.is_none() && known.any(|text| token.is(text)) {
        return Ok(Admission::Granted);
    }
    match guessed && wrong_tokens.wrong(peer, Instant::now()) {
        true => Err(TOO_MANY),
        false => Err(NO_TOKEN),
    }
}

/// The one value of a header that may stand once at most.
fn single(headers: &HeaderMap, name: HeaderName) -> Result<Option<&str>, ()> {
    let mut values = headers.get_all(name).iter();
    match (values.next(), values.next()) {
        (None, _) => Ok(None),
        (Some(value), None) => value.to_str().map(Some).map_err(|_| ()),
        (Some(_), Some(_)) => Err(()),
    }
}

/// The host that is meant, which only has characters that hosts and ports are made of.
pub fn host(headers: &HeaderMap) -> Result<&str, Refusal> {
    let plain = |c: u8| c.is_ascii_alphanumeric() || b".:-_[]".contains(&c);
    match single(headers, HOST) {
        Ok(Some(host)) if !host.is_empty() && host.bytes().all(plain) => Ok(host),
        _ => Err(Refusal(StatusCode::BAD_REQUEST, "The request names no single host.")),
    }
}

/// Names that no name server can point elsewhere. The port may differ: it may be forwarded.
fn is_this_computer(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if !port.is_empty() && port.bytes().all(|c| c.is_ascii_digit()) => name,
        _ => host,
    };
    ["127.0.0.1", "[::1]"].contains(&name) || name.eq_ignore_ascii_case("localhost")
}

/// True if a page of this server asks, or a program that is no browser.
fn own_origin(headers: &HeaderMap, host: &str) -> bool {
    let Ok(origin) = single(headers, ORIGIN) else { return false };
    let Some(origin) = origin else { return true };
    ["http://", "https://"]
        .iter()
        .filter_map(|scheme| origin.strip_prefix(scheme))
        .any(|authority| authority.eq_ignore_ascii_case(host))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hyper::header::HeaderValue;

    fn headers(pairs: &[(HeaderName, &'static str)]) -> HeaderMap {
        let pairs =
            pairs.iter().map(|(name, value)| (name.clone(), HeaderValue::from_static(value)));
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(name, value);
        }
        headers
    }

    #[test]
    fn only_this_computer_is_meant() {
        for host in ["localhost", "LOCALHOST:8014", "127.0.0.1:1", "[::1]:8014", "[::1]"] {
            assert!(is_this_computer(host), "{host}");
        }
        for host in [
            "evil.example",
            "127.0.0.1.evil.example",
            "localhost.evil.example:8014",
            "0.0.0.0:8014",
            "192.168.1.2:8014",
            "localhost:",
            "localhost:80:80",
            "127.0.0.1:x",
            "::1",
            "[::1",
        ] {
            assert!(!is_this_computer(host), "{host}");
        }
    }

    #[test]
    fn a_host_is_named_once_and_plainly() {
        assert_eq!(host(&headers(&[(HOST, "a:1")])), Ok("a:1"));
        for wrong in [
            &[][..],
            &[(HOST, "")],
            &[(HOST, "a"), (HOST, "b")],
            &[(HOST, "a b")],
            &[(HOST, "a\"b")],
            &[(HOST, "user@a")],
            &[(HOST, "a;b")],
        ] {
            assert!(host(&headers(wrong)).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn the_origin_is_our_own_or_absent() {
        let own =
            |pairs: &[(HeaderName, &'static str)]| own_origin(&headers(pairs), "localhost:8014");
        assert!(own(&[]) && own(&[(ORIGIN, "http://localhost:8014")]));
        assert!(own(&[(ORIGIN, "https://LOCALHOST:8014")]));
        for wrong in [
            "null",
            "",
            "http://localhost:3000",
            "http://localhost",
            "http://localhost:8014.evil.example",
            "http://evil.example",
            "ftp://localhost:8014",
            "localhost:8014",
            "file://",
        ] {
            assert!(!own(&[(ORIGIN, wrong)]), "{wrong}");
        }
        assert!(!own(&[(ORIGIN, "http://localhost:8014"), (ORIGIN, "http://evil.example")]));
    }
}
