//! Collection of contacts as they are found.

use crate::contact::{Contact, SearchReport, Site};
use crate::random::{GOLDEN, mix};

/// Keeps at most `capacity` contacts, the deepest ones; or, without an output, only the depth.
pub(crate) struct Collector<'a> {
    out: Option<&'a mut Vec<Contact>>,
    capacity: usize,
    found: SearchReport,
    /// Since it was full the contacts are a heap, the shallowest first, until they are put in
    /// order.
    heaped: bool,
    /// Depths that are not measured.
    known: KnownDepths<'a>,
}

/// Depths that bodies are known to have in others \[m\].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct KnownDepths<'a> {
    pub rigids: &'a [f64],
    pub softs: &'a [f64],
    /// Depth beyond these that is not measured either \[m\].
    pub slack: f64,
}

impl KnownDepths<'_> {
    /// Depth that a deformable body is known to have in others \[m\]; zero where nothing is known.
    pub fn of_soft(&self, soft: u32) -> f64 {
        self.softs.get(soft as usize).copied().unwrap_or(0.0)
    }

    /// Depth that a rigid body is known to have in others \[m\]; zero where nothing is known.
    pub fn of_rigid(&self, rigid: u32) -> f64 {
        self.rigids.get(rigid as usize).copied().unwrap_or(0.0)
    }

    /// A pair is known to be at most as deep as the one of its bodies that is less so; zero for
    /// bodies of which nothing is known.
    fn of(&self, contact: &Contact) -> f64 {
        let of = |site: &Site| match site {
            Site::Rigid { body, .. } => self.of_rigid(*body),
            Site::Soft(point) => self.of_soft(point.soft),
        };
        of(&contact.a).min(of(&contact.b))
    }
}

impl<'a> Collector<'a> {
    /// Collects into `out`, emptied first.
    pub fn into(out: &'a mut Vec<Contact>, capacity: usize) -> Self {
        out.clear();
        out.reserve(capacity);
        let known = KnownDepths::default();
        Self { out: Some(out), capacity, found: SearchReport::default(), heaped: false, known }
    }

    /// Only measures, and only what is deeper than known.
    pub fn measuring(known: KnownDepths<'a>) -> Self {
        Self { out: None, capacity: 0, found: SearchReport::default(), heaped: false, known }
    }

    /// Takes one contact.
    pub fn push(&mut self, contact: Contact) {
        self.push_within(contact, f64::INFINITY);
    }

    /// Takes one contact of bodies of whose depth no more than this slack is passed over \[m\].
    pub fn push_within(&mut self, contact: Contact, slack: f64) {
        if -contact.gap > self.known.of(&contact) + self.known.slack.min(slack) {
            self.found.penetration = self.found.penetration.max(-contact.gap);
        }
        let Some(out) = &mut self.out else { return };
        if out.len() < self.capacity {
            out.push(contact);
            return;
        }
        self.found.dropped += 1;
        if !std::mem::replace(&mut self.heaped, true) {
            (0..out.len() / 2).rev().for_each(|i| sift(out, i));
        }
        if let Some(shallowest) = out.first_mut().filter(|c| c.gap > contact.gap) {
            *shallowest = contact;
            sift(out, 0);
        }
    }

    /// Counts contacts for which there was no room.
    pub fn count_dropped(&mut self, count: usize) {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        self.found.dropped = self.found.dropped.saturating_add(count);
    }

    /// Counts a pair that was looked at.
    pub fn count_pair(&mut self) {
        self.found.pairs += 1;
    }

    /// Puts the contacts found so far in order of their key.
    pub fn sort_by_key<B: Ord>(&mut self, key: impl Fn(&Contact) -> (B, B, u64)) {
        if let Some(out) = &mut self.out {
            out.sort_unstable_by_key(key);
            self.heaped = false;
        }
    }

    /// The counts. Contacts of one pair of bodies are then together, as they were found.
    pub fn finish(mut self) -> SearchReport {
        if self.heaped {
            self.sort_by_key(|c| (body_of(&c.a), body_of(&c.b), c.key));
        }
        let contacts = self.out.map_or(0, |out| out.len() as u32);
        SearchReport { contacts, ..self.found }
    }
}

/// Soft or not, and its number.
fn body_of(site: &Site) -> (bool, u32) {
    match site {
        Site::Rigid { body, .. } => (false, *body),
        Site::Soft(point) => (true, point.soft),
    }
}

/// Lets a contact sink in a heap until none below it is shallower.
fn sift(heap: &mut [Contact], mut i: usize) {
    loop {
        let below = (2 * i + 1..heap.len().min(2 * i + 3))
            .max_by(|&j, &k| heap[j].gap.total_cmp(&heap[k].gap))
            .filter(|&j| heap[j].gap > heap[i].gap);
        let Some(j) = below else { return };
        heap.swap(i, j);
        i = j;
    }
}

/// A key from the parts that name a pair of features.
pub(crate) fn feature_key(parts: [u32; 4]) -> u64 {
    parts.iter().fold(GOLDEN, |key, &part| mix((key ^ u64::from(part)).wrapping_add(GOLDEN)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::SurfacePoint;
    use crate::math::Vec3;

    /// Chained by hand, outside: contacts keep their keys, and with them their order and bits.
    #[test]
    fn keys_stay() {
        assert_eq!(feature_key([1, 2, 3, 4]), 0xc207_722d_002a_03fc);
        assert_ne!(feature_key([2, 1, 3, 4]), feature_key([1, 2, 3, 4]));
    }

    fn contact(key: u64, gap: f64) -> Contact {
        Contact {
            key,
            a: Site::Soft(SurfacePoint::vertex(0, 0)),
            b: Site::Rigid { body: 0, offset_W: Vec3::zeros() },
            position_W: Vec3::zeros(),
            normal_W: Vec3::y(),
            gap,
            friction: 0.5,
        }
    }

    /// Gaps without order, none twice: multiples of a number without common factor with 1009.
    fn gaps(count: u64) -> impl Iterator<Item = (u64, f64)> {
        (1..=count).map(|i| (i, (i * 619 % 1009) as f64 / 1009.0 - 0.5))
    }

    #[test]
    fn when_full_the_deepest_stay() {
        for capacity in [0, 1, 2, 3, 7, 64, 499, 500] {
            let mut out = Vec::new();
            let mut collector = Collector::into(&mut out, capacity);
            gaps(500).for_each(|(key, gap)| collector.push(contact(key, gap)));
            let found = collector.finish();
            let mut expected: Vec<f64> = gaps(500).map(|(_, gap)| gap).collect();
            expected.sort_by(f64::total_cmp);
            assert_eq!(found.penetration, -expected[0]);
            expected.truncate(capacity);
            let counts = (found.contacts as usize, found.dropped as usize);
            assert_eq!(counts, (capacity, 500 - capacity));
            let mut kept: Vec<f64> = out.iter().map(|c| c.gap).collect();
            kept.sort_by(f64::total_cmp);
            assert_eq!(kept, expected);
            assert!(out.is_sorted_by_key(|c| c.key), "those of one pair are in order");
        }
    }

    #[test]
    fn order_asked_for_between_changes_nothing_of_that() {
        let mut out = Vec::new();
        let mut collector = Collector::into(&mut out, 20);
        for (key, gap) in gaps(200) {
            collector.push(contact(key, gap));
            if key % 30 == 0 {
                collector.sort_by_key(|c| (0, 0, c.key));
            }
        }
        collector.finish();
        let mut expected: Vec<f64> = gaps(200).map(|(_, gap)| gap).collect();
        expected.sort_by(f64::total_cmp);
        let mut kept: Vec<f64> = out.iter().map(|c| c.gap).collect();
        kept.sort_by(f64::total_cmp);
        assert_eq!(kept, expected[..20]);
    }
}
