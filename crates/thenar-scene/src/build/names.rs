//! Names of bodies and joints, and what they stand for.

use crate::text::{Fault, Located, nearest};
use std::collections::BTreeMap;
use thenar_core::model::BodyId;

/// Indices that the names in a scene stand for.
#[derive(Clone, Debug, Default)]
pub struct Names {
    rigids: BTreeMap<String, u32>,
    softs: BTreeMap<String, u32>,
    joints: BTreeMap<String, u32>,
    hands: BTreeMap<String, u32>,
}

impl Names {
    /// Adds a rigid body.
    ///
    /// # Errors
    /// The name is taken, or not a name.
    pub fn add_rigid(&mut self, name: &Located<String>, index: u32) -> Result<(), Fault> {
        self.free(name)?;
        self.rigids.insert(name.value.clone(), index);
        Ok(())
    }

    /// Adds a deformable body.
    ///
    /// # Errors
    /// The name is taken, or not a name.
    pub fn add_soft(&mut self, name: &Located<String>, index: u32) -> Result<(), Fault> {
        self.free(name)?;
        self.softs.insert(name.value.clone(), index);
        Ok(())
    }

    /// Adds a hand.
    ///
    /// # Errors
    /// The name is taken, or not a name.
    pub fn add_hand(&mut self, name: &Located<String>, index: u32) -> Result<(), Fault> {
        self.free(name)?;
        self.hands.insert(name.value.clone(), index);
        Ok(())
    }

    /// Adds a bone of a hand or figure, as `hand/bone`.
    pub fn add_bone(&mut self, name: &str, index: u32) {
        self.rigids.insert(name.to_string(), index);
    }

    /// Adds the flesh of a hand, under the hand's name.
    pub fn add_flesh(&mut self, name: &str, index: u32) {
        self.softs.insert(name.to_string(), index);
    }

    /// Adds a joint of a hand or figure, as `hand/joint`.
    pub fn add_joint_of(&mut self, name: &str, index: u32) {
        self.joints.insert(name.to_string(), index);
    }

    /// Adds a joint.
    ///
    /// # Errors
    /// The name is taken, or not a name.
    pub fn add_joint(&mut self, name: &Located<String>, index: u32) -> Result<(), Fault> {
        check_word(name)?;
        match self.joints.insert(name.value.clone(), index) {
            None => Ok(()),
            Some(_) => Err(name.fault(format!("another joint is named \"{}\"", name.value))),
        }
    }

    fn free(&self, name: &Located<String>) -> Result<(), Fault> {
        check_word(name)?;
        let taken = [&self.rigids, &self.softs, &self.hands]
            .iter()
            .any(|names| names.contains_key(&name.value));
        match taken || name.value == "world" {
            false => Ok(()),
            true => Err(name.fault(format!("the name \"{}\" is already taken", name.value))),
        }
    }

    /// A rigid body.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn rigid(&self, name: &Located<String>) -> Result<u32, Fault> {
        find(&self.rigids, name, "rigid body")
    }

    /// A deformable body.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn soft(&self, name: &Located<String>) -> Result<u32, Fault> {
        find(&self.softs, name, "soft body or hand")
    }

    /// A joint.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn joint(&self, name: &Located<String>) -> Result<u32, Fault> {
        find(&self.joints, name, "joint")
    }

    /// A hand.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn hand(&self, name: &Located<String>) -> Result<u32, Fault> {
        find(&self.hands, name, "hand")
    }

    /// A body of either kind.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn body(&self, name: &Located<String>) -> Result<BodyId, Fault> {
        if let Some(i) = self.rigids.get(&name.value) {
            return Ok(BodyId::Rigid(*i));
        }
        if let Some(i) = self.softs.get(&name.value) {
            return Ok(BodyId::Soft(*i));
        }
        let known = self.rigids.keys().chain(self.softs.keys());
        Err(missing(name, "body", known))
    }

    /// Joints that fit a name, a `*` at whose end stands for any ending.
    ///
    /// # Errors
    /// None does.
    pub fn joints_like(&self, names: &Located<Vec<String>>) -> Result<Vec<u32>, Fault> {
        matching(&self.joints, names, "joint")
    }

    /// Rigid bodies that fit a name, a `*` at whose end stands for any ending.
    ///
    /// # Errors
    /// None does.
    pub fn bodies_like(&self, names: &Located<Vec<String>>) -> Result<Vec<BodyId>, Fault> {
        let mut found = Vec::new();
        for name in &names.value {
            let one =
                Located { value: name.clone(), place: names.place.clone(), key: names.key.clone() };
            match name.strip_suffix('*') {
                None => found.push(self.body(&one)?),
                Some(_) => {
                    let list = Located { value: vec![name.clone()], ..names.clone() };
                    let bones = matching(&self.rigids, &list, "rigid body")?;
                    found.extend(bones.into_iter().map(BodyId::Rigid));
                }
            }
        }
        found.sort_unstable();
        found.dedup();
        Ok(found)
    }
}

fn check_word(name: &Located<String>) -> Result<(), Fault> {
    let fine = |c: char| c.is_alphanumeric() || "-_. ".contains(c);
    match name.value.chars().all(fine) && name.value.len() <= 64 {
        true => Ok(()),
        false => Err(name.fault(format!(
            "expected a name of at most 64 letters, digits, '-', '_', '.' and spaces, got \"{}\"",
            name.value
        ))),
    }
}

fn find(names: &BTreeMap<String, u32>, name: &Located<String>, kind: &str) -> Result<u32, Fault> {
    names.get(&name.value).copied().ok_or_else(|| missing(name, kind, names.keys()))
}

fn matching(
    names: &BTreeMap<String, u32>,
    patterns: &Located<Vec<String>>,
    kind: &str,
) -> Result<Vec<u32>, Fault> {
    let mut found = Vec::new();
    for pattern in &patterns.value {
        let before = found.len();
        match pattern.strip_suffix('*') {
            Some(start) => {
                found.extend(names.iter().filter(|(n, _)| n.starts_with(start)).map(|(_, i)| *i));
            }
            None => found.extend(names.get(pattern)),
        }
        if found.len() == before {
            let one = Located {
                value: pattern.clone(),
                place: patterns.place.clone(),
                key: patterns.key.clone(),
            };
            return Err(missing(&one, kind, names.keys()));
        }
    }
    found.sort_unstable();
    found.dedup();
    Ok(found)
}

fn missing<'a>(
    name: &Located<String>,
    kind: &str,
    known: impl Iterator<Item = &'a String> + Clone,
) -> Fault {
    let hint = match nearest(&name.value, known.clone().map(String::as_str)) {
        Some(near) => format!("; did you mean \"{near}\"?"),
        None => {
            let list: Vec<_> = known.take(12).map(|n| format!("\"{n}\"")).collect();
            if list.is_empty() {
                "; there are none".into()
            } else {
                format!("; there are {}", list.join(", "))
            }
        }
    };
    name.fault(format!("no {kind} is named \"{}\"{hint}", name.value))
}
