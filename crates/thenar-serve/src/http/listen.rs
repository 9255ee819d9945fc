//! Sockets to listen on, and the names under which others find them.

use super::options::{Options, Port, Reach};
use std::io::{Error, ErrorKind, Result};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, UdpSocket};

/// Number of ports that are tried from the wanted one on.
const PORTS: u16 = 20;

/// Takes the port; nothing is accepted yet.
pub fn bind(options: &Options) -> Result<TcpListener> {
    let addresses = match (options.address, options.reach) {
        (Some(address), _) => vec![address],
        (None, Reach::Loopback) => vec![Ipv4Addr::LOCALHOST.into()],
        // The first serves both families where the system has them.
        (None, Reach::Lan) => vec![Ipv6Addr::UNSPECIFIED.into(), Ipv4Addr::UNSPECIFIED.into()],
    };
    let (first, last) = match options.port {
        Port::Exactly(port) => (port, port),
        Port::From(port) => (port, port.saturating_add(PORTS - 1)),
    };
    let mut failure = Error::from(ErrorKind::AddrInUse);
    for port in first..=last {
        match bind_first(&addresses, port) {
            Ok(listener) => {
                listener.set_nonblocking(true)?;
                return Ok(listener);
            }
            Err(error) => failure = error,
        }
        if failure.kind() != ErrorKind::AddrInUse {
            break;
        }
    }
    Err(failure)
}

/// The first address that the machine has. A taken port is a failure: the other family's might be
/// free, and half the visitors would meet the other program.
fn bind_first(addresses: &[IpAddr], port: u16) -> Result<TcpListener> {
    let mut failure = Error::from(ErrorKind::AddrNotAvailable);
    for &address in addresses {
        match TcpListener::bind(SocketAddr::new(address, port)) {
            Ok(listener) => return Ok(listener),
            Err(error) if error.kind() == ErrorKind::AddrInUse => return Err(error),
            Err(error) => failure = error,
        }
    }
    Err(failure)
}

/// This machine's names and addresses on the network, the likeliest to work first.
pub fn names() -> Vec<String> {
    let mut addresses: Vec<(u8, IpAddr)> = if_addrs::get_if_addrs()
        .unwrap_or_default()
        .into_iter()
        .filter(|i| !i.is_loopback() && !i.is_link_local())
        .map(|i| (u8::from(is_virtual(&i.name)), i.ip()))
        .collect();
    let outward = outward();
    addresses.sort_by_key(|(virt, a)| (Some(*a) != outward, *virt, a.is_ipv6()));
    let mut names: Vec<String> = addresses.into_iter().map(|(_, a)| a.to_string()).collect();
    let host = gethostname::gethostname().to_string_lossy().into_owned();
    if is_host_name(&host) {
        if !host.contains('.') {
            names.push(format!("{host}.local"));
        }
        names.push(host);
    }
    names
}

/// Bridges and tunnels of containers and virtual machines: nobody comes from there.
fn is_virtual(interface: &str) -> bool {
    ["docker", "br-", "veth", "virbr", "vmnet", "vboxnet"].iter().any(|p| interface.starts_with(p))
}

/// The address from which packets leave for far away. Nothing is sent.
fn outward() -> Option<IpAddr> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).ok()?;
    // Any address outside will do; this one is set aside for examples (RFC 5737).
    socket.connect((Ipv4Addr::new(192, 0, 2, 1), 9)).ok()?;
    Some(socket.local_addr().ok()?.ip())
}

fn is_host_name(name: &str) -> bool {
    !name.is_empty()
        && name.len() < 64
        && name != "localhost"
        && name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'-' || c == b'.')
}

#[cfg(test)]
mod tests {
    use super::super::options::RequestLimits;
    use super::*;

    fn options(port: Port) -> Options {
        Options { reach: Reach::Loopback, address: None, port, limits: RequestLimits::default() }
    }

    #[test]
    fn a_taken_port_is_refused_or_passed_over_as_asked() {
        let first = bind(&options(Port::Exactly(0))).unwrap();
        let taken = first.local_addr().unwrap().port();
        let error = bind(&options(Port::Exactly(taken))).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::AddrInUse);
        let next = bind(&options(Port::From(taken))).unwrap().local_addr().unwrap().port();
        assert!(next > taken && next < taken + PORTS, "{taken} {next}");
    }

    #[test]
    fn the_desk_is_loopback_only() {
        let listener = bind(&options(Port::Exactly(0))).unwrap();
        assert!(listener.local_addr().unwrap().ip().is_loopback());
    }
}
