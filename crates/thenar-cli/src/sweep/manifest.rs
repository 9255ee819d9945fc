//! Manifest of a sweep: what is swept, so that nobody continues it as another sweep, and what came
//! of it.

use super::plan::Plan;
use super::record::Record;
use super::{Args, Scene, seeds};
use crate::error::CliError;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Version of `sweep.json`, of the records and of the results. 2: how long tetrahedra were inside
/// out.
const SWEEP_VERSION: u32 = 2;
/// Largest manifest \[bytes\]: a table of cases of its largest size is in it.
const BYTES_MAX: u64 = 1 << 30;

/// Identity of a sweep: equal in all its shards, and in no other sweep.
#[derive(Debug)]
pub struct Manifest(Map<String, Value>);

impl Manifest {
    /// Identity of the sweep that was asked for.
    pub fn new(args: &Args, scene: &Scene, plan: &Plan) -> Self {
        let seeds = args.seeds.as_deref().and_then(|text| seeds::parse(text).ok());
        let columns = plan.columns.iter().map(|(key, kind)| json!([key, kind.name()]));
        let mut map = Map::new();
        let mut put = |key: &str, value: Value| _ = map.insert(key.into(), value);
        put("sweep_version", json!(SWEEP_VERSION));
        put("version", json!(env!("CARGO_PKG_VERSION")));
        let name = scene.file.file_stem().unwrap_or_default().to_string_lossy();
        put("scene", json!(name));
        put("scene_sha256", json!(sha256(scene.text.as_bytes())));
        put("files", scene.files.as_json());
        put("set", json!(args.set));
        put("seconds", json!(args.seconds));
        put("seeds", json!(seeds));
        put("keys", columns.collect());
        put("vary", plan.as_json());
        put("cases", json!(plan.cases));
        put("shards", json!(args.shard.count));
        Self(map)
    }

    /// Writes it into the folder, or finds that it is there already.
    ///
    /// # Errors
    /// The folder is another sweep's, or cannot be written.
    pub fn settle(&self, folder: &Path) -> Result<(), CliError> {
        let file = folder.join("sweep.json");
        if !file.exists() {
            let text = format!("{:#}\n", Value::Object(self.0.clone()));
            thenar_output::write_whole(&file, text.as_bytes())?;
        }
        let there = read(&file)?;
        let other = |key: &str, there: Option<&Value>, here: Option<&Value>| {
            let told = |value: Option<&Value>| match value {
                None => "nothing".into(),
                Some(Value::String(text)) => thenar_input::quoted(text),
                Some(value) => thenar_input::quoted(&value.to_string()),
            };
            let (there, here) = (told(there), told(here));
            let folder = folder.display();
            CliError::Input(format!(
                "{folder} holds another sweep: its {key} is {there}, not {here}; give --out another folder"
            ))
        };
        for key in self.0.keys().chain(there.keys()) {
            let (old, new) = (there.get(key), self.0.get(key));
            if old != new {
                return Err(match one_file(old, new) {
                    Some((file, [old, new])) => other(&format!("SHA-256 of {file}"), old, new),
                    None => other(key, old, new),
                });
            }
        }
        Ok(())
    }

    /// Text for the metadata of results.
    pub fn text(&self) -> String {
        Value::Object(self.0.clone()).to_string()
    }

    /// Figures of a shard: what is in `sweep.json`, the shard, how many cases it has and how many
    /// of them failed, and unit of each column.
    pub fn of_shard(
        &self,
        shard: super::Shard,
        records: &[Record],
        columns: &[(String, String)],
    ) -> String {
        let failed = records.iter().filter(|record| record.failed.is_some()).count();
        let units: Map<_, _> = columns.iter().map(|(n, unit)| (n.clone(), json!(unit))).collect();
        let mut map = self.0.clone();
        map.insert("shard".into(), json!(shard.number));
        map.insert("shard_cases".into(), json!(records.len()));
        map.insert("shard_failed".into(), json!(failed));
        map.insert("units".into(), Value::Object(units));
        format!("{:#}\n", Value::Object(map))
    }
}

/// Cases of a shard and how many of them failed, from its figures.
///
/// # Errors
/// The file cannot be read, or is damaged.
pub fn outcome(file: &Path) -> Result<(u64, u64), CliError> {
    let map = read(file)?;
    let of = |key: &str| map.get(key).and_then(Value::as_u64);
    of("shard_cases").zip(of("shard_failed")).ok_or_else(|| {
        CliError::Other(format!(
            "{} is damaged: remove it and its results to run again",
            file.display()
        ))
    })
}

/// One file that differs between two tables, and its entry in both.
fn one_file<'a>(
    old: Option<&'a Value>,
    new: Option<&'a Value>,
) -> Option<(&'a String, [Option<&'a Value>; 2])> {
    let (old, new) = (old?.as_object()?, new?.as_object()?);
    let entries = old.keys().chain(new.keys()).map(|file| (file, [old.get(file), new.get(file)]));
    entries.into_iter().find(|(_, [old, new])| old != new)
}

fn read(file: &Path) -> Result<Map<String, Value>, CliError> {
    let wrong = |what: String| CliError::Input(format!("{}: {what}", file.display()));
    let text = thenar_input::read_text(file, BYTES_MAX).map_err(|e| wrong(e.to_string()))?;
    serde_json::from_str(&text)
        .map_err(|e| wrong(format!("this is not a manifest of a sweep: {e}")))
}

/// Hash of bytes as `sha256sum` writes it.
pub fn sha256(bytes: &[u8]) -> String {
    let digest = ring::digest::digest(&ring::digest::SHA256, bytes);
    digest.as_ref().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1.
    #[test]
    fn the_hash_is_that_of_the_standard() {
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256(b"abc"), abc);
    }
}
