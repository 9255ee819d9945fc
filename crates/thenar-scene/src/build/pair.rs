//! Contact settings of pairs.

use super::Built;
use crate::format::{Pair, Scene};
use crate::text::Fault;
use thenar::model::PairRule;

/// Adds all pairs.
pub fn add_all(built: &mut Built, scene: &Scene) -> Result<(), Fault> {
    for pair in &scene.pair {
        let rule = rule(built, pair)?;
        built.world.pairs.extend(rule);
    }
    Ok(())
}

fn rule(built: &Built, pair: &Pair) -> Result<Option<PairRule>, Fault> {
    let [a, b] = &pair.bodies;
    let bodies = [built.names.body(a)?, built.names.body(b)?];
    if pair.contact && pair.friction.is_none() {
        return Err(a.fault("a pair needs `friction`, or `contact = false`"));
    }
    let mut sorted = bodies;
    sorted.sort();
    let known = built.world.pairs.iter().any(|rule| {
        let mut other = rule.bodies;
        other.sort();
        other == sorted
    });
    if known {
        let problem = format!("the pair \"{}\" and \"{}\" is given twice", a.value, b.value);
        return Err(a.fault(problem));
    }
    Ok(Some(PairRule { bodies, friction: pair.friction.filter(|_| pair.contact) }))
}
