//! Control of the simulation: one viewer at a time may change anything.

use crate::hub::ClientId;
use std::time::{Duration, Instant};

/// Poses that a former holder sent before it knew are dropped without blame for so long.
const GRACE: Duration = Duration::from_secs(2);

/// The viewers, and which of them holds control.
#[derive(Clone, Debug, Default)]
pub struct Control {
    /// In order of arrival.
    viewers: Vec<ClientId>,
    holder: Option<ClientId>,
    former: Option<(ClientId, Instant)>,
}

impl Control {
    /// The client that holds control.
    pub fn holder(&self) -> Option<ClientId> {
        self.holder
    }

    /// Number of viewers.
    pub fn viewers(&self) -> usize {
        self.viewers.len()
    }

    /// True for a viewer that is here.
    pub fn knows(&self, client: ClientId) -> bool {
        self.viewers.contains(&client)
    }

    /// A viewer came; it takes control where nobody holds it.
    pub fn join(&mut self, client: ClientId) {
        if !self.knows(client) {
            self.viewers.push(client);
        }
        self.holder.get_or_insert(client);
    }

    /// A viewer left; its control goes to the oldest that remains.
    pub fn leave(&mut self, client: ClientId) {
        self.viewers.retain(|viewer| *viewer != client);
        if self.holder == Some(client) {
            self.holder = self.viewers.first().copied();
        }
    }

    /// A viewer takes control from whoever has it.
    pub fn take(&mut self, client: ClientId, now: Instant) {
        if let Some(holder) = self.holder.filter(|holder| *holder != client) {
            self.former = Some((holder, now));
        }
        self.holder = Some(client);
    }

    /// The holder gives control up; the next to ask or to come gets it.
    pub fn give_up(&mut self, client: ClientId, now: Instant) {
        if self.holder == Some(client) {
            self.former = Some((client, now));
            self.holder = None;
        }
    }

    /// True for who holds control; false for who sent something before it knew that it had lost it.
    ///
    /// # Errors
    /// It never had it; says who has.
    pub fn may(&self, client: ClientId, now: Instant) -> Result<bool, String> {
        match self.holder {
            Some(holder) if holder == client => Ok(true),
            _ if self.held_just_now(client, now) => Ok(false),
            holder => {
                let who = holder.map_or("nobody".into(), |holder| format!("viewer {}", holder.0));
                Err(format!("{who} holds control; take it to change anything"))
            }
        }
    }

    /// True for a viewer that held control until just now.
    pub fn held_just_now(&self, client: ClientId, now: Instant) -> bool {
        self.former.is_some_and(|(former, since)| former == client && now - since < GRACE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: ClientId = ClientId(1);
    const B: ClientId = ClientId(2);
    const C: ClientId = ClientId(3);

    #[test]
    fn the_first_holds_control_and_the_oldest_inherits_it() {
        let mut control = Control::default();
        [A, B, C].into_iter().for_each(|client| control.join(client));
        assert_eq!(control.holder(), Some(A));
        control.leave(C);
        assert_eq!(control.holder(), Some(A));
        control.leave(A);
        assert_eq!((control.holder(), control.viewers()), (Some(B), 1));
        control.leave(B);
        assert_eq!(control.holder(), None);
        control.join(C);
        assert_eq!(control.holder(), Some(C));
    }

    #[test]
    fn control_can_be_taken_and_given_up() {
        let (mut control, now) = (Control::default(), Instant::now());
        [A, B].into_iter().for_each(|client| control.join(client));
        control.take(B, now);
        assert_eq!(control.holder(), Some(B));
        assert!(control.held_just_now(A, now) && !control.held_just_now(B, now));
        assert!(!control.held_just_now(A, now + Duration::from_secs(3)));
        // Only who has it can give it up; then who comes next has it.
        control.give_up(A, now);
        assert_eq!(control.holder(), Some(B));
        control.give_up(B, now);
        assert_eq!(control.holder(), None);
        control.join(C);
        assert_eq!(control.holder(), Some(C));
    }
}
