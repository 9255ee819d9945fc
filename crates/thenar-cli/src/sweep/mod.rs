//! `thenar sweep`: many cases of one scene, a row of a table each.
//!
//! | file in the folder | what it holds | written |
//! |---|---|---|
//! | `sweep.json` | what is swept: scene, files, keys, values; the same for all shards | first |
//! | `shard-K-of-N.lock` | the process that runs the shard | first; it goes with the cases' files |
//! | `shard-K-of-N/CASE.json` | a case that is whole | when it ends |
//! | `shard-K-of-N.parquet` | all rows of the shard | last; the cases' files go then |
//! | `shard-K-of-N.json` | figures of the shard: cases, failures, columns with units | beside it |
//!
//! Each of them is whole or not there, so that a sweep that was cut goes on with the cases that are
//! missing.

mod axis;
mod case;
mod cell;
mod files;
mod layout;
mod manifest;
mod plan;
mod pool;
mod record;
mod results;
mod seeds;
mod shard;
mod table;

use crate::error::CliError;
use crate::interrupt;
use crate::run::{SceneLocation, file, find};
use crate::words::counted;
use files::Files;
use manifest::Manifest;
use plan::Plan;
use shard::Shard;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use thenar_output::{Lock, LockError};
use thenar_scene::session::read_scene;

/// Run many cases of a scene, a row of a Parquet table each.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A scene file, or the name of a built-in scene (see `thenar scenes`).
    scene: PathBuf,
    /// Values of a key, e.g. hand.hand.friction=0.4,0.8; given several times, every combination is
    /// run.
    #[arg(long, value_name = "KEY=A,B,C")]
    vary: Vec<String>,
    /// A CSV file of cases, alone or combined with --vary: columns are keys, rows are cases.
    #[arg(long, value_name = "FILE.csv")]
    table: Option<PathBuf>,
    /// Seeds, as 1,2,5 or 1..10 with both ends: all seeds that the scene states are set to each.
    #[arg(long, value_name = "SEEDS")]
    seeds: Option<String>,
    /// Change a value of the scene for all cases.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Simulated time of a case [s] instead of the scene's own.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Run the K-th of N equal shares only; all shares may write into the same folder.
    #[arg(long, value_name = "K/N", default_value = "1/1")]
    shard: Shard,
    /// The folder of results; of a sweep that was cut, to go on with it.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Write each case's probe table too, as DIR/probes/CASE.csv.
    #[arg(long)]
    probe: bool,
    /// Cases at a time; as many as the processor has threads when left out. The results are the
    /// same.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
    /// No progress and no summary.
    #[arg(long, short)]
    quiet: bool,
}

/// A scene's text, where it is from, and the files that it names.
#[derive(Debug)]
pub struct Scene {
    text: String,
    file: PathBuf,
    files: Files,
}

impl Scene {
    /// # Errors
    /// There is no such scene.
    fn read(scene: &Path) -> Result<Self, CliError> {
        let text = match find(scene)? {
            SceneLocation::File(path) => {
                thenar_output::protect(&path);
                read_scene(&path)?
            }
            SceneLocation::Builtin(known) => known.text.into(),
        };
        Ok(Self { text, file: file(scene)?, files: Files::default() })
    }

    /// Checks the text with these changes, without building anything, and tells the files that it
    /// names then.
    ///
    /// # Errors
    /// Something is wrong; in the words of `--set`.
    fn check(&self, overrides: &[String]) -> Result<BTreeSet<String>, CliError> {
        let read = thenar_scene::session::read(&self.text, overrides)
            .map_err(|fault| fault.locate(&self.file, &self.text, overrides))?;
        Ok(read.files().into_iter().map(String::from).collect())
    }
}

/// Runs the cases of a shard that are not there yet, and writes the table when all are.
///
/// # Errors
/// What was asked for makes no sense, a file cannot be written, the sweep was interrupted, or cases
/// failed.
pub fn run(args: &Args) -> Result<(), CliError> {
    if args.seconds.is_some_and(|s| !(s > 0.0 && s <= 1e9)) {
        return Err(CliError::Input("--seconds must be more than 0 s and at most 1e9 s".into()));
    }
    let mut scene = Scene::read(&args.scene)?;
    let (plan, files) = Plan::make(args, &scene)?;
    scene.files = Files::read(files, &scene);
    let place = ShardFiles::new(&args.out, args.shard)?;
    let manifest = Manifest::new(args, &scene, &plan);
    manifest.settle(&args.out)?;
    interrupt::listen();
    let lock = match place.results.is_file() {
        true => None,
        false => place.lock(args)?,
    };
    // Another process may have ended the shard before the lock was taken.
    if !place.results.is_file() {
        let threads = args.threads.or_else(|| std::thread::available_parallelism().ok());
        let threads = threads.map_or(1, NonZeroUsize::get);
        pool::run(args, &scene, &plan, &place, threads)?;
        let row = layout::row(&scene, &plan, &place)?;
        results::write(&plan, &place, args.shard, &manifest, &row)?;
    }
    place.clear();
    drop(lock);
    conclude(args, &place)
}

/// Files of a shard.
#[derive(Debug)]
pub struct ShardFiles {
    /// Records of cases that are whole, as long as the table is not.
    cases: PathBuf,
    /// The cases' probe tables.
    probes: PathBuf,
    results: PathBuf,
    figures: PathBuf,
    lock: PathBuf,
}

impl ShardFiles {
    fn new(folder: &Path, shard: Shard) -> Result<Self, CliError> {
        let Shard { number, count } = shard;
        let name = format!("shard-{number}-of-{count}");
        let make = std::fs::create_dir_all(folder);
        make.map_err(|e| CliError::Other(format!("cannot make {}: {e}", folder.display())))?;
        Ok(Self {
            cases: folder.join(&name),
            probes: folder.join("probes"),
            results: folder.join(format!("{name}.parquet")),
            figures: folder.join(format!("{name}.json")),
            lock: folder.join(format!("{name}.lock")),
        })
    }

    /// Keeps other processes from this shard; of no use where files cannot be locked, which is
    /// reported.
    fn lock(&self, args: &Args) -> Result<Option<Lock>, CliError> {
        let Shard { number, count } = args.shard;
        let share = format!("{}: shard {number}/{count}", args.out.display());
        match Lock::take(&self.lock) {
            Ok(lock) => Ok(Some(lock)),
            Err(LockError::Held { holder, .. }) => {
                let by = holder.map_or("another process".into(), |id| format!("process {id}"));
                Err(CliError::Input(format!(
                    "{share} is being run by {by}; wait for it, or give another --shard or --out"
                )))
            }
            Err(error @ LockError::NoLocks { .. }) => {
                eprintln!("warning: {error}; do not run {share} twice at a time");
                Ok(None)
            }
            Err(error @ LockError::Write { .. }) => Err(CliError::Other(error.to_string())),
        }
    }

    /// Removes records whose rows are in the table, and the lock: whoever takes another finds the
    /// table.
    fn clear(&self) {
        // What cannot be removed is in nobody's way.
        let _ = std::fs::remove_dir_all(&self.cases);
        let _ = std::fs::remove_file(&self.lock);
    }
}

/// Says how it went, and whether cases failed.
fn conclude(args: &Args, place: &ShardFiles) -> Result<(), CliError> {
    let (cases, failed) = manifest::outcome(&place.figures)?;
    if !args.quiet {
        let (cases, results) = (counted(cases, "case"), place.results.display());
        println!("{cases} in {results}, {failed} of them failed");
    }
    match failed {
        0 => Ok(()),
        _ => Err(CliError::Other(format!(
            "{failed} of {} failed; the column `failed` of {} says why",
            counted(cases, "case"),
            place.results.display()
        ))),
    }
}
