//! Where contacts go as they are found.

use crate::contact::{Contact, Found};

/// Keeps at most `capacity` contacts, the deepest ones; or, without an output, only the depth.
pub(crate) struct Collector<'a> {
    out: Option<&'a mut Vec<Contact>>,
    capacity: usize,
    found: Found,
}

impl<'a> Collector<'a> {
    /// Collects into `out`, emptied first.
    pub fn into(out: &'a mut Vec<Contact>, capacity: usize) -> Self {
        out.clear();
        out.reserve(capacity);
        Self { out: Some(out), capacity, found: Found::default() }
    }

    /// Only measures.
    pub fn measuring() -> Self {
        Self { out: None, capacity: 0, found: Found::default() }
    }

    /// Takes one contact.
    pub fn push(&mut self, contact: Contact) {
        self.found.penetration = self.found.penetration.max(-contact.gap);
        let Some(out) = &mut self.out else { return };
        if out.len() < self.capacity {
            out.push(contact);
            return;
        }
        self.found.dropped += 1;
        let shallowest = (0..out.len()).max_by(|&i, &j| out[i].gap.total_cmp(&out[j].gap));
        if let Some(i) = shallowest.filter(|&i| out[i].gap > contact.gap) {
            out[i] = contact;
        }
    }

    /// Counts a contact for which there was no room.
    pub fn count_dropped(&mut self) {
        self.found.dropped += 1;
    }

    /// Counts a pair that was looked at.
    pub fn count_pair(&mut self) {
        self.found.pairs += 1;
    }

    /// Puts the contacts found so far in order of their key.
    pub fn sort_by_key(&mut self, key: impl Fn(&Contact) -> (u32, u32, u64)) {
        if let Some(out) = &mut self.out {
            out.sort_unstable_by_key(key);
        }
    }

    /// The counts.
    pub fn finish(self) -> Found {
        let contacts = self.out.map_or(0, |out| out.len() as u32);
        Found { contacts, ..self.found }
    }
}

/// A key from the parts that name a pair of features (the finaliser of SplitMix64, chained).
pub(crate) fn feature_key(parts: [u32; 4]) -> u64 {
    parts.iter().fold(0x9E37_79B9_7F4A_7C15, |key, &part| {
        let mut z = (key ^ u64::from(part)).wrapping_add(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Site, SurfacePoint};
    use crate::math::Vec3;

    #[test]
    fn when_full_the_deepest_stay() {
        let mut out = Vec::new();
        let mut collector = Collector::into(&mut out, 3);
        for gap in [0.5, -0.2, 0.1, 0.4, -0.3, 0.9] {
            collector.push(Contact {
                key: 0,
                a: Site::Soft(SurfacePoint::vertex(0, 0)),
                b: Site::Rigid { body: 0, offset_W: Vec3::zeros() },
                position_W: Vec3::zeros(),
                normal_W: Vec3::y(),
                gap,
                friction: 0.5,
            });
        }
        let found = collector.finish();
        assert_eq!((found.contacts, found.dropped, found.penetration), (3, 3, 0.3));
        let mut gaps: Vec<f64> = out.iter().map(|c| c.gap).collect();
        gaps.sort_by(f64::total_cmp);
        assert_eq!(gaps, [-0.3, -0.2, 0.1]);
    }
}
