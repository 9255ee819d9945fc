//! The last seconds before a trip, in memory that never grows.

use crate::safety::Status;

/// Inputs and outputs of a guard in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<const N: usize> {
    /// Time of the tick \[ns\].
    pub time_ns: u64,
    /// Force asked for \[N\].
    pub wanted: [f64; N],
    /// Measured velocity \[m/s\].
    pub velocity: [f64; N],
    /// Force sent \[N\].
    pub output: [f64; N],
    /// Energy taken in minus given out \[J\].
    pub energy: f64,
    /// Status after the tick.
    pub status: Status,
}

/// A ring of records. It stops taking them at a trip, so that what led to it stays.
#[derive(Clone, Debug)]
pub struct SignalLog<const N: usize> {
    records: Vec<Record<N>>,
    /// Index of the next record once the ring is full.
    next: usize,
    capacity: usize,
    frozen: bool,
}

impl<const N: usize> SignalLog<N> {
    /// Room for `capacity` records: seconds × rate.
    pub fn new(capacity: usize) -> Self {
        Self { records: Vec::with_capacity(capacity), next: 0, capacity, frozen: false }
    }

    /// A ring that takes none.
    pub(super) fn without_room() -> Self {
        Self::new(0)
    }

    /// Takes a record in place of the oldest; the first one whose status is a trip is the last.
    pub fn push(&mut self, record: Record<N>) {
        if self.frozen || self.capacity == 0 {
            return;
        }
        if self.records.len() < self.capacity {
            self.records.push(record);
        } else {
            self.records[self.next] = record;
            self.next = (self.next + 1) % self.capacity;
        }
        self.frozen = matches!(record.status, Status::Tripped(_));
    }

    /// Takes records again.
    pub fn resume(&mut self) {
        self.frozen = false;
    }

    /// Records, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Record<N>> {
        let (newer, older) = self.records.split_at(self.next.min(self.records.len()));
        older.iter().chain(newer)
    }
}
