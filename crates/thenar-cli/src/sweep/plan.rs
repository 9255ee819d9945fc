//! Plan of a sweep's cases.

use super::axis::{Axis, tidy};
use super::cell::ColumnKind;
use super::{Args, Scene, seeds, table};
use crate::error::CliError;
use std::collections::BTreeSet;
use thenar_input::quoted;

/// Most cases of a sweep.
const CASES_MAX: u64 = 1_000_000_000;

/// Keys that change together: one choice is a value for each.
#[derive(Debug)]
struct Group {
    /// The keys that are set, and the column that shows each.
    targets: Vec<(String, usize)>,
    choices: Vec<Vec<String>>,
}

/// Every combination of a choice of each group.
#[derive(Debug)]
pub struct Plan {
    set: Vec<String>,
    groups: Vec<Group>,
    /// Name and kind of the columns that tell cases apart, in the order of groups.
    pub columns: Vec<(String, ColumnKind)>,
    /// Number of cases.
    pub cases: u64,
}

impl Plan {
    /// Reads what was asked for and checks each value in the scene; tells the files that cases
    /// name.
    ///
    /// # Errors
    /// Something makes no sense: says what.
    pub fn make(args: &Args, scene: &Scene) -> Result<(Self, BTreeSet<String>), CliError> {
        let mut plan = Self { set: args.set.clone(), groups: vec![], columns: vec![], cases: 1 };
        if let Some(file) = &args.table {
            let table = table::read(file)?;
            plan.add(table.keys, table.rows)?;
        }
        for text in &args.vary {
            let Axis { key, values } = Axis::parse(text)?;
            plan.add(vec![key], values.into_iter().map(|value| vec![value]).collect())?;
        }
        if let Some(text) = &args.seeds {
            let targets = seeds::keys(&scene.text)?;
            let choices = seeds::parse(text)?.iter().map(|seed| vec![seed.to_string()]).collect();
            plan.add_seeds(targets, choices)?;
        }
        plan.clash()?;
        if plan.groups.is_empty() {
            return Err(CliError::Input("nothing varies: give --vary, --table or --seeds".into()));
        }
        let files = plan.check(scene)?;
        Ok((plan, files))
    }

    fn add(&mut self, keys: Vec<String>, choices: Vec<Vec<String>>) -> Result<(), CliError> {
        let begin = self.columns.len();
        for (i, key) in keys.iter().enumerate() {
            let kind = ColumnKind::of(choices.iter().map(|choice| choice[i].as_str()));
            self.columns.push((key.clone(), kind));
        }
        let targets = keys.into_iter().enumerate().map(|(i, key)| (key, begin + i)).collect();
        self.push(Group { targets, choices })
    }

    fn add_seeds(&mut self, keys: Vec<String>, seeds: Vec<Vec<String>>) -> Result<(), CliError> {
        let column = self.columns.len();
        self.columns.push(("seed".into(), ColumnKind::Count));
        let targets: Vec<_> = keys.into_iter().map(|key| (key, column)).collect();
        let choices = seeds.into_iter().map(|s| vec![s[0].clone(); targets.len()]).collect();
        self.push(Group { targets, choices })
    }

    fn push(&mut self, group: Group) -> Result<(), CliError> {
        let cases = self.cases.checked_mul(group.choices.len() as u64);
        self.cases = cases.filter(|cases| *cases <= CASES_MAX).ok_or_else(|| {
            CliError::Input(format!("these are more than {CASES_MAX} cases, the most of a sweep"))
        })?;
        self.groups.push(group);
        Ok(())
    }

    /// No key may be set twice, nor one inside of another: which value counts would be anyone's
    /// guess.
    fn clash(&self) -> Result<(), CliError> {
        let fixed = self.set.iter().filter_map(|text| text.split_once('=')).map(|(k, _)| tidy(k));
        let varied = self.groups.iter().flat_map(|g| g.targets.iter().map(|(key, _)| key.clone()));
        let mut keys: Vec<Vec<String>> = Vec::new();
        for (key, is_varied) in fixed.map(|k| (k, false)).chain(varied.map(|k| (k, true))) {
            let parts: Vec<String> = key.split('.').map(String::from).collect();
            for other in keys.iter().filter(|_| is_varied) {
                let shared = parts.len().min(other.len());
                if parts[..shared] == other[..shared] {
                    let (key, other) = (quoted(&key), quoted(&other.join(".")));
                    let what = match key == other {
                        true => format!("the key {key} is given twice"),
                        false => format!("the keys {other} and {key} are one inside the other"),
                    };
                    return Err(CliError::Input(what));
                }
            }
            keys.push(parts);
        }
        let mut names: Vec<&str> = vec!["case", "failed"];
        for (name, _) in &self.columns {
            if names.contains(&name.as_str()) {
                let what = format!("two columns of the results would be named {}", quoted(name));
                return Err(CliError::Input(what));
            }
            names.push(name);
        }
        Ok(())
    }

    /// Reads the scene with every choice of each group beside the first of all others.
    fn check(&self, scene: &Scene) -> Result<BTreeSet<String>, CliError> {
        let mut at = vec![0; self.groups.len()];
        let mut files = scene.check(&self.overrides_at(&at))?;
        for (g, group) in self.groups.iter().enumerate() {
            for choice in 1..group.choices.len() {
                at[g] = choice;
                files.append(&mut scene.check(&self.overrides_at(&at))?);
            }
            at[g] = 0;
        }
        Ok(files)
    }

    /// Number of the choice of each group in a case; the last group changes fastest.
    fn choices_of(&self, case: u64) -> Vec<usize> {
        let mut rest = case;
        let mut at = vec![0; self.groups.len()];
        for (at, group) in at.iter_mut().zip(&self.groups).rev() {
            let count = group.choices.len() as u64;
            *at = (rest % count) as usize;
            rest /= count;
        }
        at
    }

    fn overrides_at(&self, at: &[usize]) -> Vec<String> {
        let chosen = self.groups.iter().zip(at).flat_map(|(group, &at)| {
            let values = group.targets.iter().zip(&group.choices[at]);
            values.map(|((key, _), value)| format!("{key}={value}"))
        });
        self.set.iter().cloned().chain(chosen).collect()
    }

    /// All changes to the scene that make a case.
    pub fn overrides(&self, case: u64) -> Vec<String> {
        self.overrides_at(&self.choices_of(case))
    }

    /// A case's value of each column, as it was written.
    pub fn values(&self, case: u64) -> Vec<&str> {
        let mut values = vec![""; self.columns.len()];
        for (group, at) in self.groups.iter().zip(self.choices_of(case)) {
            for ((_, column), value) in group.targets.iter().zip(&group.choices[at]) {
                values[*column] = value;
            }
        }
        values
    }

    /// Keys and their values, for the manifest: what two sweeps must have in common to be one.
    pub fn as_json(&self) -> serde_json::Value {
        let group = |group: &Group| {
            let keys: Vec<&str> = group.targets.iter().map(|(key, _)| key.as_str()).collect();
            serde_json::json!({ "keys": keys, "choices": group.choices })
        };
        self.groups.iter().map(group).collect()
    }
}
