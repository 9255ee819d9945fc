//! Contacts in W.

use super::nodes_of;
use crate::capacity_vec::CapacityVec;
use crate::math::Vec3;
use crate::solver::ContactRows;
use crate::solver::monolithic::joining::{ALL_AT_ONCE, JoinQueue};

/// The contacts in W, and those that wait.
#[derive(Clone, Debug)]
pub struct Members {
    capacity: usize,
    list: CapacityVec<u32>,
    /// True for contacts in the list.
    is_member: Vec<bool>,
    joining: JoinQueue,
}

impl Members {
    /// Room for `capacity` members of `contacts_max` contacts.
    pub fn new(capacity: usize, contacts_max: usize, nodes: usize) -> Self {
        Self {
            capacity,
            list: CapacityVec::with_capacity(capacity),
            is_member: vec![false; contacts_max],
            joining: JoinQueue::new(contacts_max, nodes),
        }
    }

    /// All, in the order of W.
    pub fn list(&self) -> &[u32] {
        &self.list
    }

    /// Returns the number that wait to join.
    pub fn waiting(&self) -> usize {
        self.joining.len()
    }

    /// Starts with the contacts that press, and some of those that close although these press; the
    /// impulses of all others go. `measured` are their velocities less their targets.
    pub fn begin(&mut self, contacts: &mut ContactRows, measured: &[Vec3]) {
        self.clear();
        self.joining.clear();
        // Limits first: where room runs out, the skeleton must not be what gives.
        for turns in [true, false] {
            for i in 0..contacts.rows.len() {
                let (row, d) = (&mut contacts.rows[i], measured[i].x);
                if row.turns != turns {
                    continue;
                }
                let presses = row.lambda.x != 0.0 || row.included != 0.0;
                let needed = presses || (row.turns && d < 0.0);
                if !needed || !self.admit(i) {
                    row.lambda = Vec3::zeros();
                    if d < 0.0 {
                        self.joining.wait(i, -d);
                    }
                }
            }
        }
        let all = self.list.len() + self.joining.len() <= ALL_AT_ONCE;
        self.join(contacts, all);
    }

    /// Nobody is in or waits any more.
    pub fn clear(&mut self) {
        self.list.clear();
        self.is_member.fill(false);
    }

    /// Lets one in unless there is no room.
    pub fn admit(&mut self, contact: usize) -> bool {
        if self.list.len() == self.capacity || contact >= self.is_member.len() {
            return false;
        }
        self.list.push(contact as u32);
        self.is_member[contact] = true;
        true
    }

    /// All that are not members and close faster than `tolerance` \[m/s\] wait; returns the highest
    /// such speed.
    pub fn queue(&mut self, contacts: &ContactRows, measured: &[Vec3], tolerance: f64) -> f64 {
        self.joining.clear();
        let mut fastest = 0.0_f64;
        for i in 0..contacts.rows.len() {
            let d = measured[i].x;
            if !self.is_member[i] && d < -tolerance {
                self.joining.wait(i, -d);
                fastest = fastest.max(-d);
            }
        }
        fastest
    }

    /// Lets in some that wait, or all; false when there is no room for any.
    pub fn join(&mut self, contacts: &ContactRows, all: bool) -> bool {
        let mut waiting = std::mem::take(&mut self.joining);
        let joined = waiting.admit(contacts, all, |i| self.admit(i));
        let complete = joined > 0 || waiting.len() == 0;
        self.joining = waiting;
        complete
    }

    /// Only members with an impulse stay, in their order; false when all have one.
    pub fn keep_pressing(&mut self, contacts: &ContactRows) -> bool {
        let (before, is_member) = (self.list.len(), &mut self.is_member);
        self.list.retain(|&i| {
            let row = &contacts.rows[i as usize];
            is_member[i as usize] = row.lambda.x > 0.0 || row.included != 0.0;
            is_member[i as usize]
        });
        self.list.len() < before
    }

    /// Orders the members from `first` on: neighbours in space follow each other, so that load
    /// passes on within a sweep, and a batch reaches less of the flesh; those without flesh come
    /// last.
    pub fn arrange(&mut self, first: usize, contacts: &ContactRows, place: &[u32]) {
        self.list[first..].sort_unstable_by_key(|&m| {
            let node = nodes_of(contacts, &contacts.rows[m as usize]).next();
            (node.map_or(u32::MAX, |(node, _)| place[node]), m)
        });
    }
}
