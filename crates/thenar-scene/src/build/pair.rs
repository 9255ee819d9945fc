//! Contact settings of pairs.

use super::Built;
use crate::format::{PairFriction, Scene};
use crate::text::{Fault, Located};
use thenar_core::model::{BodyId, FrictionTable, PairRule};

/// Adds all pairs.
pub fn add_all(built: &mut Built, scene: &Scene) -> Result<(), Fault> {
    let mut known: Vec<[BodyId; 2]> = Vec::new();
    for pair in &scene.pair {
        let [a, b] = &pair.bodies;
        let bodies = [built.names.body(a)?, built.names.body(b)?];
        let mut sorted = bodies;
        sorted.sort();
        if known.contains(&sorted) {
            let problem = format!("the pair \"{}\" and \"{}\" is given twice", a.value, b.value);
            return Err(a.fault(problem));
        }
        known.push(sorted);
        let friction = match (pair.contact, pair.friction, &pair.friction_by_load) {
            (false, ..) => None,
            (true, Some(PairFriction::Coefficient(friction)), None) => Some(friction),
            (true, Some(PairFriction::Skin(word)), None) => {
                let points = word.points().to_vec();
                built.world.friction_tables.push(FrictionTable { bodies, points });
                continue;
            }
            (true, None, Some(points)) => {
                check_points(points)?;
                let points = points.value.clone();
                built.world.friction_tables.push(FrictionTable { bodies, points });
                continue;
            }
            (true, Some(_), Some(points)) => {
                return Err(points.fault("expected `friction` or `friction_by_load`, not both"));
            }
            (true, None, None) => {
                return Err(
                    a.fault("a pair needs `friction`, `friction_by_load`, or `contact = false`")
                );
            }
        };
        built.world.pairs.push(PairRule { bodies, friction });
    }
    Ok(())
}

fn check_points(points: &Located<Vec<[f64; 2]>>) -> Result<(), Fault> {
    let list = &points.value;
    if list.is_empty() {
        return Err(points.fault("expected at least one [load, coefficient]"));
    }
    if let Some(pair) = list.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
        let (before, after) = (pair[0][0], pair[1][0]);
        let problem = format!("expected rising loads, got {after} N after {before} N");
        return Err(points.fault(problem));
    }
    match list.iter().find(|[_, mu]| *mu > 100.0) {
        Some([_, mu]) => {
            Err(points.fault(format!("expected coefficients of at most 100, got {mu}")))
        }
        None => Ok(()),
    }
}
