//! The pairing token: who has seen the terminal may come in.

use hyper::HeaderMap;
use hyper::header::COOKIE;
use ring::rand::{SecureRandom, SystemRandom};
use std::collections::HashMap;
use std::fmt::Write as _;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use subtle::ConstantTimeEq;

/// 128 random bits, made at start and gone at the end.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// A new one.
    ///
    /// # Errors
    /// The system gives no randomness.
    pub fn new() -> Result<Self, std::io::Error> {
        let mut bytes = [0; 16];
        SystemRandom::new()
            .fill(&mut bytes)
            .map_err(|_| std::io::Error::other("the system gives no random numbers"))?;
        let mut text = String::with_capacity(32);
        for byte in bytes {
            let _ = write!(text, "{byte:02x}");
        }
        Ok(Self(text))
    }

    /// The token as it stands in addresses: 32 hexadecimal digits.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// True if this is it; takes the same time wherever the two differ.
    pub fn is(&self, text: &str) -> bool {
        self.0.as_bytes().ct_eq(text.as_bytes()).into()
    }
}

impl std::fmt::Debug for Token {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Token(..)")
    }
}

/// The token of an address: `?token=…`.
pub fn in_query(query: Option<&str>) -> Option<&str> {
    query?.split('&').find_map(|pair| pair.strip_prefix("token="))
}

/// The value of the cookie of this name; a browser may send several cookies of one name, and only
/// one of them need be ours.
pub fn in_cookies<'a>(headers: &'a HeaderMap, name: &'a str) -> impl Iterator<Item = &'a str> {
    headers
        .get_all(COOKIE)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|value| value.split(';'))
        .filter_map(move |pair| pair.trim().strip_prefix(name)?.strip_prefix('='))
        .take(8)
}

/// Addresses remembered; beyond, the oldest are forgotten.
const ADDRESSES: usize = 1024;

/// Number of wrong tokens within [`WINDOW`] after which an address gets its answers late.
const FREE_GUESSES: u32 = 10;

/// Time for which a wrong token is remembered.
const WINDOW: Duration = Duration::from_secs(60);

/// Counts wrong tokens by address. The right token always works: at 128 bits guessing is no
/// danger, and locking an address out would lock out a visitor whose old page still knocks.
#[derive(Debug, Default)]
pub struct WrongTokens(Mutex<HashMap<IpAddr, (u32, Instant)>>);

impl WrongTokens {
    /// Counts a wrong token; true if there were too many from this address.
    pub fn wrong(&self, from: IpAddr, now: Instant) -> bool {
        let mut table = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if table.len() >= ADDRESSES && !table.contains_key(&from) {
            table.retain(|_, (_, since)| now.duration_since(*since) < WINDOW);
            if table.len() >= ADDRESSES {
                table.clear();
            }
        }
        let (count, since) = table.entry(from).or_insert((0, now));
        if now.duration_since(*since) >= WINDOW {
            (*count, *since) = (0, now);
        }
        *count = count.saturating_add(1);
        *count > FREE_GUESSES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hyper::header::HeaderValue;

    #[test]
    fn tokens_are_128_bits_and_differ() {
        let (a, b) = (Token::new().unwrap(), Token::new().unwrap());
        assert_eq!(a.text().len(), 32);
        assert!(a.text().bytes().all(|c| c.is_ascii_hexdigit()));
        assert!(a.is(a.text()) && !a.is(b.text()) && !a.is("") && !a.is(&a.text()[..31]));
        assert!(!format!("{a:?}").contains(a.text()));
    }

    #[test]
    fn queries_and_cookies_are_read() {
        assert_eq!(in_query(Some("a=1&token=ab&b")), Some("ab"));
        assert_eq!(in_query(Some("nottoken=ab")), None);
        let mut headers = HeaderMap::new();
        headers.append(COOKIE, HeaderValue::from_static("x=1; t=old;t=new; tt=3"));
        assert_eq!(in_cookies(&headers, "t").collect::<Vec<_>>(), ["old", "new"]);
    }

    #[test]
    fn guesses_are_counted_by_address_and_forgotten() {
        let wrong_tokens = WrongTokens::default();
        let start = Instant::now();
        let [a, b] = [[10, 0, 0, 1], [10, 0, 0, 2]].map(IpAddr::from);
        assert!((0..FREE_GUESSES).all(|_| !wrong_tokens.wrong(a, start)));
        assert!(wrong_tokens.wrong(a, start));
        assert!(!wrong_tokens.wrong(b, start));
        assert!(!wrong_tokens.wrong(a, start + WINDOW));
        for i in 0..5000_u32 {
            wrong_tokens.wrong(IpAddr::from(i.to_be_bytes()), start);
        }
        assert!(wrong_tokens.0.lock().unwrap().len() <= ADDRESSES);
    }
}
