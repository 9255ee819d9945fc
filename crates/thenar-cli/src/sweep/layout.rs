//! Columns that the tables of all shards have, whatever became of their own cases.

use super::plan::Plan;
use super::record::{Record, Row};
use super::{Scene, ShardFiles};
use crate::building::unheard;
use crate::error::CliError;
use crate::interrupt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use thenar_scene::session::{Figures, Session};

/// Most cases that are opened to find one whose bodies can be built: a grid of which a 64th can be
/// is found.
const TRIES: u64 = 64;

/// The row of one case of the whole sweep, the same in every shard, of which names, units and kinds
/// count: the first case, or another that can be built where that cannot. Empty where none of
/// [`TRIES`] can.
///
/// # Errors
/// The program was asked to end.
pub fn row(scene: &Scene, plan: &Plan, place: &ShardFiles) -> Result<Row, CliError> {
    let mut tried = Vec::new();
    for case in (0..TRIES).map(|k| spread(k, plan.cases)) {
        if tried.contains(&case) {
            continue;
        }
        tried.push(case);
        // A record of this shard spares building what was built.
        let ran = Record::read(&place.cases, case).map(|record| record.row);
        if let Some(row) = ran.filter(|row| !row.is_empty()).or_else(|| start(scene, plan, case)) {
            return Ok(row);
        }
        if interrupt::pressed() {
            let what = "interrupted before the table was written; the same command goes on";
            return Err(CliError::Other(what.into()));
        }
    }
    Ok(Row::new())
}

/// The k-th of cases that are spread over all of them ever more densely (van der Corput 1935): 0,
/// 1/2, 1/4, 3/4, …
fn spread(k: u64, cases: u64) -> u64 {
    let scaled = u128::from(k.reverse_bits()) * u128::from(cases);
    (scaled >> 64) as u64
}

/// Row of a case at its start, if its bodies can be built.
fn start(scene: &Scene, plan: &Plan, case: u64) -> Option<Row> {
    let open = || Session::from_text(&scene.text, &scene.file, &plan.overrides(case));
    let row = AssertUnwindSafe(|| {
        let mut session = unheard(open).ok()?;
        let figures = Figures::new(&mut session);
        Some(Record::new(case, None, figures.row(&session)).row)
    });
    // A fault of the program is told where the case is run.
    catch_unwind(row).ok().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_are_tried_from_the_first_on_and_everywhere() {
        let tried: Vec<u64> = (0..8).map(|k| spread(k, 1000)).collect();
        assert_eq!(tried, [0, 500, 250, 750, 125, 625, 375, 875]);
        let most = 1_000_000_000;
        let mut all: Vec<u64> = (0..TRIES).map(|k| spread(k, most)).collect();
        all.sort();
        assert!(all.windows(2).all(|pair| pair[1] - pair[0] <= most / TRIES));
        let mut few: Vec<u64> = (0..TRIES).map(|k| spread(k, 3)).collect();
        few.sort();
        few.dedup();
        assert_eq!(few, [0, 1, 2]);
    }
}
