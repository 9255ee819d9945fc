//! Connections that are no sessions, counted; and which of them has to go when there is no place.
//!
//! A visitor who has asked for something that it may have, with `--lan` by showing the token, keeps
//! a place until it leaves. Pending connections, whose clients have shown nothing yet, have as many
//! places of their own. When these are taken, a newcomer does not wait and is not refused: the
//! pending connection that has been there longest goes, of the address with the most of them, and
//! of addresses from which nobody was let in sooner than of others. So connections that are opened
//! and left keep nobody out: to shake hands and to ask takes milliseconds, and a newcomer is the
//! last to go.

use super::options::RequestLimits;
use std::collections::{HashMap, HashSet};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::task::AbortHandle;

/// Addresses remembered from which somebody was let in; beyond, all are forgotten.
const ADDRESSES: usize = 1024;

/// All connections that are no sessions.
#[derive(Debug, Default)]
pub struct ConnectionLimiter(Mutex<Tables>);

#[derive(Debug, Default)]
struct Tables {
    newest: u64,
    pending: HashMap<u64, PendingConnection>,
    /// Connections of clients that were let in, by address.
    admitted: HashMap<IpAddr, usize>,
    /// Addresses from which somebody was let in once.
    paired: HashSet<IpAddr>,
}

#[derive(Debug)]
struct PendingConnection {
    from: IpAddr,
    /// Ends it; `None` until it is served.
    end: Option<AbortHandle>,
}

/// A connection's place, given back when dropped.
#[derive(Debug)]
pub struct ConnectionPermit {
    connection_limiter: Arc<ConnectionLimiter>,
    number: u64,
    from: IpAddr,
    admitted: Mutex<bool>,
}

impl Tables {
    fn pending_from(&self, from: IpAddr) -> usize {
        self.pending.values().filter(|connection| connection.from == from).count()
    }

    /// The pending connection that has to go, of all or of one address.
    fn oldest(&self, of: Option<IpAddr>) -> Option<u64> {
        let mut counts: HashMap<IpAddr, usize> = HashMap::new();
        self.pending.values().for_each(|s| *counts.entry(s.from).or_default() += 1);
        let of_them = self.pending.iter().filter(|(_, s)| of.is_none_or(|from| s.from == from));
        of_them
            .max_by_key(|(number, s)| {
                let unknown = !self.paired.contains(&s.from);
                (unknown, counts.get(&s.from), std::cmp::Reverse(**number))
            })
            .map(|(number, _)| *number)
    }

    fn evict(&mut self, of: Option<IpAddr>) {
        let connection = self.oldest(of).and_then(|number| self.pending.remove(&number));
        if let Some(end) = connection.and_then(|connection| connection.end) {
            end.abort();
        }
    }

    fn admit(&mut self, from: IpAddr, limits: &RequestLimits) -> bool {
        let all: usize = self.admitted.values().sum();
        let here = self.admitted.get(&from).copied().unwrap_or(0);
        let free = all < limits.connections && here < limits.connections_per_address;
        if free {
            self.admitted.insert(from, here + 1);
        }
        free
    }
}

impl ConnectionLimiter {
    fn tables(&self) -> std::sync::MutexGuard<'_, Tables> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for a pending connection.
    pub fn admit_pending(
        self: &Arc<Self>,
        from: IpAddr,
        limits: &RequestLimits,
    ) -> Arc<ConnectionPermit> {
        let mut tables = self.tables();
        if tables.pending_from(from) >= limits.connections_per_address {
            tables.evict(Some(from));
        }
        if tables.pending.len() >= limits.connections {
            tables.evict(None);
        }
        tables.newest += 1;
        let number = tables.newest;
        tables.pending.insert(number, PendingConnection { from, end: None });
        drop(tables);
        Arc::new(ConnectionPermit {
            connection_limiter: self.clone(),
            number,
            from,
            admitted: Mutex::new(false),
        })
    }
}

impl ConnectionPermit {
    /// Tells how a pending connection is ended.
    pub fn served_by(&self, end: AbortHandle) {
        if let Some(connection) = self.connection_limiter.tables().pending.get_mut(&self.number) {
            connection.end = Some(end);
        }
    }

    /// A request was granted: nobody takes this place any more. False when there is none for such.
    pub fn admit(&self, limits: &RequestLimits) -> bool {
        let mut admitted = self.admitted.lock().unwrap_or_else(PoisonError::into_inner);
        if *admitted {
            return true;
        }
        let mut tables = self.connection_limiter.tables();
        if tables.paired.len() >= ADDRESSES {
            tables.paired.clear();
        }
        tables.paired.insert(self.from);
        *admitted = tables.admit(self.from, limits);
        if *admitted {
            tables.pending.remove(&self.number);
        }
        *admitted
    }
}

impl Drop for ConnectionPermit {
    fn drop(&mut self) {
        let mut tables = self.connection_limiter.tables();
        tables.pending.remove(&self.number);
        if *self.admitted.get_mut().unwrap_or_else(PoisonError::into_inner)
            && let Some(count) = tables.admitted.get_mut(&self.from)
        {
            *count -= 1;
            if *count == 0 {
                tables.admitted.remove(&self.from);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(k: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, k])
    }

    fn limits() -> RequestLimits {
        RequestLimits { connections: 6, connections_per_address: 4, ..RequestLimits::default() }
    }

    /// Strangers that are there, by address.
    fn there(connection_limiter: &ConnectionLimiter) -> Vec<(u64, IpAddr)> {
        let tables = connection_limiter.tables();
        let mut all: Vec<_> = tables.pending.iter().map(|(n, s)| (*n, s.from)).collect();
        all.sort();
        all
    }

    #[test]
    fn the_oldest_of_the_most_goes_first() {
        let (connection_limiter, limits) = (Arc::new(ConnectionLimiter::default()), limits());
        let places: Vec<_> = [1, 1, 1, 2, 2, 3]
            .map(|k| connection_limiter.admit_pending(address(k), &limits))
            .into();
        let _newcomer = connection_limiter.admit_pending(address(4), &limits);
        assert!(!there(&connection_limiter).iter().any(|(number, _)| *number == 1));
        assert_eq!(there(&connection_limiter).len(), 6);
        // Whoever was turned out gives nothing back that is another's.
        drop(places);
        assert_eq!(there(&connection_limiter), [(7, address(4))]);
    }

    #[test]
    fn an_address_has_its_share_and_the_token_a_place_of_its_own() {
        let (connection_limiter, limits) = (Arc::new(ConnectionLimiter::default()), limits());
        let mut held: Vec<_> =
            (0..9).map(|_| connection_limiter.admit_pending(address(1), &limits)).collect();
        assert_eq!(
            there(&connection_limiter).iter().map(|s| s.0).collect::<Vec<_>>(),
            [6, 7, 8, 9]
        );
        let last = held.pop().unwrap();
        assert!(last.admit(&limits) && last.admit(&limits));
        held.extend((0..9).map(|_| connection_limiter.admit_pending(address(1), &limits)));
        assert_eq!(there(&connection_limiter).len(), 4);
        assert_eq!(connection_limiter.tables().admitted[&address(1)], 1);
        // Where the token was shown, strangers stay longer.
        held.extend((0..2).map(|_| connection_limiter.admit_pending(address(2), &limits)));
        held.push(connection_limiter.admit_pending(address(3), &limits));
        let from = |k| there(&connection_limiter).iter().filter(|s| s.1 == address(k)).count();
        assert_eq!([from(1), from(2), from(3)], [4, 1, 1]);
        drop((held, last));
        let tables = connection_limiter.tables();
        assert!(tables.pending.is_empty() && tables.admitted.is_empty());
    }

    #[test]
    fn those_who_are_admitted_are_bounded() {
        let (connection_limiter, limits) = (Arc::new(ConnectionLimiter::default()), limits());
        let enter = |k| {
            Some(connection_limiter.admit_pending(address(k), &limits))
                .filter(|place| place.admit(&limits))
        };
        let places: Vec<_> = (0..4).filter_map(|_| enter(1)).collect();
        assert_eq!(places.len(), 4);
        assert!(enter(1).is_none());
        let others: Vec<_> = (0..4).filter_map(|_| enter(2)).collect();
        assert_eq!(others.len(), 2);
        drop(places);
        assert!(connection_limiter.admit_pending(address(1), &limits).admit(&limits));
    }
}
