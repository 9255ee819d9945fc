//! Pairs of bodies that may touch, and their friction.

use crate::model::{BodyId, PairRule, SoftDesc, WorldDesc};

/// Pairs that differ from the rule "everything touches, with the geometric mean of friction".
#[derive(Clone, Debug)]
pub(crate) struct PairTable {
    rigids: u32,
    /// Pairs that do not touch, sorted.
    excluded: Vec<[u32; 2]>,
    /// Sorted by pair.
    overrides: Vec<([u32; 2], f64)>,
}

impl PairTable {
    /// Reads joints, couplings and pair rules. Excluded: bodies joined directly; flesh and the
    /// bones that carry it; the bones of one finger among themselves, and all bones of flesh that
    /// does not touch itself; rules without friction. A rule for the flesh of a hand holds for its
    /// bones too, unless another names the bone.
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
            let touches = desc.self_contact.contains(&(i as u32));
            for (k, &bone) in bones.iter().enumerate() {
                table.excluded.push(sorted(bone, id));
                let alike = |b: u32| !touches || desc.flesh_of_bone(b) == desc.flesh_of_bone(bone);
                let beside = bones[..k].iter().filter(|&&b| alike(b));
                table.excluded.extend(beside.map(|&other| sorted(other, bone)));
            }
        }
        for rule in &desc.pairs {
            table.add_rule_of_bones(desc, rule);
        }
        for rule in &desc.pairs {
            table.add_rule(rule.bodies, rule.friction);
        }
        table.excluded.sort_unstable();
        table.excluded.dedup();
        // A stable sort: of several rules for one pair the last is found.
        table.overrides.sort_by_key(|o| o.0);
        table
    }

    fn add_rule(&mut self, bodies: [BodyId; 2], friction: Option<f64>) {
        let pair = sorted(self.id(bodies[0]), self.id(bodies[1]));
        match friction {
            Some(friction) => self.overrides.push((pair, friction)),
            None => self.excluded.push(pair),
        }
    }

    /// Gives the bones inside two bodies what is said of their flesh.
    fn add_rule_of_bones(&mut self, desc: &WorldDesc, rule: &PairRule) {
        let sides = rule.bodies.map(|body| body_and_bones(desc, body));
        for (i, &a) in sides[0].iter().enumerate() {
            for (j, &b) in sides[1].iter().enumerate() {
                let named = |rule: &PairRule| rule.bodies == [a, b] || rule.bodies == [b, a];
                if a != b && i + j > 0 && !desc.pairs.iter().any(named) {
                    self.add_rule([a, b], rule.friction);
                }
            }
        }
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

/// A body, and the bones with a contact shape of a hand.
fn body_and_bones(desc: &WorldDesc, body: BodyId) -> Vec<BodyId> {
    let of_hand = desc.parts.iter().filter(|parts| body == BodyId::Soft(parts.soft));
    let bones = of_hand.flat_map(|parts| parts.bones.iter().map(|(bone, _)| *bone));
    let solid = bones.filter(|b| desc.rigids.get(*b as usize).is_some_and(|r| r.shape.is_some()));
    std::iter::once(body).chain(solid.map(BodyId::Rigid)).collect()
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
