//! Constraints between joints.

use super::super::link_tree::{Follows, Link, listed};
use super::super::mimic::MIMIC_TERMS;
use super::{Element, RigError};
use std::collections::BTreeSet;
use thenar_input::quoted;

/// Joints that follow others, of all `<equality>` elements; tells of the constraints that are
/// passed over.
///
/// MuJoCo counts these angles from the placement in the file, as links do.
pub(super) fn read(
    root: Element<'_>,
    links: &[Link],
    notes: &mut Vec<String>,
) -> Result<Vec<Follows>, RigError> {
    let joints: BTreeSet<&str> =
        links.iter().flat_map(|link| &link.joints).map(|joint| &joint.name[..]).collect();
    let mut follows = Vec::new();
    let mut passed: BTreeSet<&str> = BTreeSet::new();
    for constraint in root.named("equality").flat_map(Element::children) {
        let active = constraint.get("active").map(|a| a.one_of(&["true", "false"])).transpose()?;
        if active == Some(1) {
            continue;
        }
        if constraint.tag() != "joint" {
            passed.insert(constraint.tag());
            continue;
        }
        let follower = constraint.needs_name("joint1")?;
        let Some(leader) = constraint.name("joint2")? else {
            notes.push(format!(
                "joint {} is held at an angle by a constraint, which is passed over",
                quoted(follower)
            ));
            continue;
        };
        // Those of other bodies of the world, which are passed over, too.
        if let Some(name) = [follower, leader].into_iter().find(|name| !joints.contains(name)) {
            let [first, second, name] = [follower, leader, name].map(quoted);
            notes.push(format!(
                "joint {first} does not follow {second}: the figure has no joint {name}"
            ));
            continue;
        }
        let [follower, leader] = [follower, leader].map(str::to_owned);
        follows.push(Follows { follower, leader, law: law(constraint)? });
    }
    if !passed.is_empty() {
        notes.push(format!("constraints passed over: {}", listed(passed)));
    }
    Ok(follows)
}

fn law(constraint: Element<'_>) -> Result<[f64; MIMIC_TERMS], RigError> {
    let mut law = [0.0, 1.0, 0.0, 0.0, 0.0];
    if let Some(given) = constraint.get("polycoef") {
        // Coefficients that are left out keep their defaults.
        law.iter_mut().zip(given.list(MIMIC_TERMS)?).for_each(|(to, from)| *to = from);
    }
    Ok(law)
}
