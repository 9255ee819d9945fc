//! Connections that are no sessions, counted; and which of them has to go when there is no place.
//!
//! A visitor who has asked for something that it may have, with `--lan` by showing the token, keeps
//! a place until it leaves. Strangers, who have connected and shown nothing yet, have as many
//! places of their own. When these are taken, a newcomer does not wait and is not refused: the
//! stranger that has been there longest goes, of the address with the most of them, and of
//! addresses from which nobody was let in sooner than of others. So connections that are opened and
//! left keep nobody out: to shake hands and to ask takes milliseconds, and a newcomer is the last
//! to go.

use super::options::RequestLimits;
use std::collections::{HashMap, HashSet};
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::task::AbortHandle;

/// Addresses remembered from which somebody was let in; beyond, all are forgotten.
const ADDRESSES: usize = 1024;

/// All connections that are no sessions.
#[derive(Debug, Default)]
pub struct Crowd(Mutex<Tables>);

#[derive(Debug, Default)]
struct Tables {
    newest: u64,
    strangers: HashMap<u64, Stranger>,
    /// Connections of clients that were let in, by address.
    admitted: HashMap<IpAddr, usize>,
    /// Addresses from which somebody was let in once.
    paired: HashSet<IpAddr>,
}

#[derive(Debug)]
struct Stranger {
    from: IpAddr,
    /// Ends it; `None` until it is served.
    end: Option<AbortHandle>,
}

/// A place in the crowd, given back when dropped.
#[derive(Debug)]
pub struct CrowdSeat {
    crowd: Arc<Crowd>,
    number: u64,
    from: IpAddr,
    admitted: Mutex<bool>,
}

impl Tables {
    fn strangers_from(&self, from: IpAddr) -> usize {
        self.strangers.values().filter(|stranger| stranger.from == from).count()
    }

    /// The stranger who has to go, of all or of one address.
    fn oldest(&self, of: Option<IpAddr>) -> Option<u64> {
        let mut counts: HashMap<IpAddr, usize> = HashMap::new();
        self.strangers.values().for_each(|s| *counts.entry(s.from).or_default() += 1);
        let of_them = self.strangers.iter().filter(|(_, s)| of.is_none_or(|from| s.from == from));
        of_them
            .max_by_key(|(number, s)| {
                let unknown = !self.paired.contains(&s.from);
                (unknown, counts.get(&s.from), std::cmp::Reverse(**number))
            })
            .map(|(number, _)| *number)
    }

    fn turn_out(&mut self, of: Option<IpAddr>) {
        let stranger = self.oldest(of).and_then(|number| self.strangers.remove(&number));
        if let Some(end) = stranger.and_then(|stranger| stranger.end) {
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

impl Crowd {
    fn tables(&self) -> std::sync::MutexGuard<'_, Tables> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A place for a stranger.
    pub fn meet(self: &Arc<Self>, from: IpAddr, limits: &RequestLimits) -> Arc<CrowdSeat> {
        let mut tables = self.tables();
        if tables.strangers_from(from) >= limits.connections_per_address {
            tables.turn_out(Some(from));
        }
        if tables.strangers.len() >= limits.connections {
            tables.turn_out(None);
        }
        tables.newest += 1;
        let number = tables.newest;
        tables.strangers.insert(number, Stranger { from, end: None });
        drop(tables);
        Arc::new(CrowdSeat { crowd: self.clone(), number, from, admitted: Mutex::new(false) })
    }
}

impl CrowdSeat {
    /// Tells how a stranger's connection is ended.
    pub fn served_by(&self, end: AbortHandle) {
        if let Some(stranger) = self.crowd.tables().strangers.get_mut(&self.number) {
            stranger.end = Some(end);
        }
    }

    /// A request was granted: nobody takes this place any more. False when there is none for such.
    pub fn admit(&self, limits: &RequestLimits) -> bool {
        let mut admitted = self.admitted.lock().unwrap_or_else(PoisonError::into_inner);
        if *admitted {
            return true;
        }
        let mut tables = self.crowd.tables();
        if tables.paired.len() >= ADDRESSES {
            tables.paired.clear();
        }
        tables.paired.insert(self.from);
        *admitted = tables.admit(self.from, limits);
        if *admitted {
            tables.strangers.remove(&self.number);
        }
        *admitted
    }
}

impl Drop for CrowdSeat {
    fn drop(&mut self) {
        let mut tables = self.crowd.tables();
        tables.strangers.remove(&self.number);
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
    fn there(crowd: &Crowd) -> Vec<(u64, IpAddr)> {
        let tables = crowd.tables();
        let mut all: Vec<_> = tables.strangers.iter().map(|(n, s)| (*n, s.from)).collect();
        all.sort();
        all
    }

    #[test]
    fn the_oldest_of_the_most_goes_first() {
        let (crowd, limits) = (Arc::new(Crowd::default()), limits());
        let places: Vec<_> = [1, 1, 1, 2, 2, 3].map(|k| crowd.meet(address(k), &limits)).into();
        let _newcomer = crowd.meet(address(4), &limits);
        assert!(!there(&crowd).iter().any(|(number, _)| *number == 1));
        assert_eq!(there(&crowd).len(), 6);
        // Whoever was turned out gives nothing back that is another's.
        drop(places);
        assert_eq!(there(&crowd), [(7, address(4))]);
    }

    #[test]
    fn an_address_has_its_share_and_the_token_a_place_of_its_own() {
        let (crowd, limits) = (Arc::new(Crowd::default()), limits());
        let mut held: Vec<_> = (0..9).map(|_| crowd.meet(address(1), &limits)).collect();
        assert_eq!(there(&crowd).iter().map(|s| s.0).collect::<Vec<_>>(), [6, 7, 8, 9]);
        let last = held.pop().unwrap();
        assert!(last.admit(&limits) && last.admit(&limits));
        held.extend((0..9).map(|_| crowd.meet(address(1), &limits)));
        assert_eq!(there(&crowd).len(), 4);
        assert_eq!(crowd.tables().admitted[&address(1)], 1);
        // Where the token was shown, strangers stay longer.
        held.extend((0..2).map(|_| crowd.meet(address(2), &limits)));
        held.push(crowd.meet(address(3), &limits));
        let from = |k| there(&crowd).iter().filter(|s| s.1 == address(k)).count();
        assert_eq!([from(1), from(2), from(3)], [4, 1, 1]);
        drop((held, last));
        let tables = crowd.tables();
        assert!(tables.strangers.is_empty() && tables.admitted.is_empty());
    }

    #[test]
    fn those_who_are_admitted_are_bounded() {
        let (crowd, limits) = (Arc::new(Crowd::default()), limits());
        let enter = |k| Some(crowd.meet(address(k), &limits)).filter(|place| place.admit(&limits));
        let places: Vec<_> = (0..4).filter_map(|_| enter(1)).collect();
        assert_eq!(places.len(), 4);
        assert!(enter(1).is_none());
        let others: Vec<_> = (0..4).filter_map(|_| enter(2)).collect();
        assert_eq!(others.len(), 2);
        drop(places);
        assert!(crowd.meet(address(1), &limits).admit(&limits));
    }
}
