//! Places on the network as a person writes them.

/// `HOST:PORT`, with this port where none is given; names are looked up when they are called, since
/// a device need not be there yet.
///
/// # Errors
/// It is no such place: the cause, for a person.
pub fn host_and_port(text: &str, port: Option<u16>) -> Result<String, String> {
    let (host, given) = match text.rsplit_once(':') {
        // The colons of an address in brackets are its own.
        Some((host, given)) if !given.ends_with(']') => (host, Some(given)),
        _ => (text, None),
    };
    let bare = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    let right = match bare {
        Some(address) => address.parse::<std::net::Ipv6Addr>().is_ok(),
        None => {
            let plain = |c: char| c.is_alphanumeric() || matches!(c, '.' | '-' | '_');
            !host.is_empty() && host.chars().all(plain)
        }
    };
    let port = match given {
        Some(given) => given.parse().ok().filter(|port| *port > 0),
        None => port,
    };
    match port {
        Some(port) if right => Ok(format!("{host}:{port}")),
        Some(_) => Err(format!("`{text}` is not HOST:PORT, or [IPv6]:PORT")),
        None => Err(format!("`{text}` has no port from 1 to 65535, expected HOST:PORT")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read_strictly() {
        let read = |text, port| host_and_port(text, port).unwrap_or_default();
        assert_eq!(read("127.0.0.1:7070", None), "127.0.0.1:7070");
        assert_eq!(read("lab-pc.local", Some(9020)), "lab-pc.local:9020");
        assert_eq!(read("[::1]", Some(9020)), "[::1]:9020");
        assert_eq!(read("[fe80::1]:5", None), "[fe80::1]:5");
        for bad in
            ["", ":80", "a:", "a:99999", "a:0", "a b:80", "::1", "::1:80", "[x]:80", "a/b:80"]
        {
            assert!(host_and_port(bad, Some(1)).is_err(), "{bad}");
        }
        assert!(host_and_port("here", None).unwrap_err().contains("has no port"));
    }
}
