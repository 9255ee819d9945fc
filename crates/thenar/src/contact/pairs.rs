//! Which bodies may touch, and with what friction.

use crate::model::{BodyId, SoftDesc, WorldDesc};

/// Pairs that differ from the rule "everything touches, with the geometric mean of friction".
#[derive(Clone, Debug)]
pub(crate) struct PairTable {
    rigids: u32,
    /// Sorted.
    excluded: Vec<[u32; 2]>,
    /// Sorted by pair.
    overrides: Vec<([u32; 2], f64)>,
}

impl PairTable {
    /// Reads joints, couplings and pair rules. Excluded: bodies joined directly; flesh and the
    /// bones that carry it; the bones of one hand among themselves; rules without friction.
    pub fn new(desc: &WorldDesc) -> Self {
        let mut table =
            Self { rigids: desc.rigids.len() as u32, excluded: Vec::new(), overrides: Vec::new() };
        for joint in &desc.joints {
            if let Some(parent) = joint.parent {
                table.excluded.push(sorted(parent, joint.child));
            }
        }
        for (i, soft) in desc.softs.iter().enumerate() {
            let bones = shaped_bones(desc, soft);
            let id = table.id(BodyId::Soft(i as u32));
            for (k, &bone) in bones.iter().enumerate() {
                table.excluded.push(sorted(bone, id));
                table.excluded.extend(bones[..k].iter().map(|&other| sorted(other, bone)));
            }
        }
        for rule in &desc.pairs {
            let pair = sorted(table.id(rule.bodies[0]), table.id(rule.bodies[1]));
            match rule.friction {
                Some(friction) => table.overrides.push((pair, friction)),
                None => table.excluded.push(pair),
            }
        }
        table.excluded.sort_unstable();
        table.excluded.dedup();
        // A stable sort: of several rules for one pair the last is found.
        table.overrides.sort_by_key(|o| o.0);
        table
    }

    /// One number per body: rigid bodies first.
    pub fn id(&self, body: BodyId) -> u32 {
        match body {
            BodyId::Rigid(i) => i,
            BodyId::Soft(i) => self.rigids + i,
        }
    }

    /// Friction between two bodies with coefficients `mu_a` and `mu_b`; `None` if they do not
    /// touch.
    pub fn friction(&self, a: BodyId, b: BodyId, mu_a: f64, mu_b: f64) -> Option<f64> {
        let pair = sorted(self.id(a), self.id(b));
        if self.excluded.binary_search(&pair).is_ok() {
            return None;
        }
        let after = self.overrides.partition_point(|o| o.0 <= pair);
        match self.overrides[..after].last() {
            Some(&(found, friction)) if found == pair => Some(friction),
            _ => Some((mu_a * mu_b).sqrt()),
        }
    }
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The bones with a contact shape that carry this flesh, each once.
fn shaped_bones(desc: &WorldDesc, soft: &SoftDesc) -> Vec<u32> {
    let Some(coupling) = &soft.coupling else { return Vec::new() };
    let mut bones: Vec<u32> = coupling.bindings.iter().flat_map(|b| b.bones).collect();
    bones.sort_unstable();
    bones.dedup();
    bones.retain(|&b| desc.rigids.get(b as usize).is_some_and(|r| r.shape.is_some()));
    bones
}
