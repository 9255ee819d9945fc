//! One case, from its scene to its row.

use super::record::Record;
use super::{Args, Scene, ShardFiles};
use crate::building::unheard;
use crate::error::CliError;
use crate::{interrupt, run};
use std::panic::{AssertUnwindSafe, catch_unwind};
use thenar_output::Output;
use thenar_scene::session::{Figures, Session, TableFormat, TableWriter, TakenBack};

/// Why there is no record of a case.
#[derive(Debug)]
pub enum CaseFailure {
    /// The program was asked to end.
    Asked,
    /// An output cannot be written.
    Failed(CliError),
}

impl<E: Into<CliError>> From<E> for CaseFailure {
    fn from(error: E) -> Self {
        Self::Failed(error.into())
    }
}

/// Runs a case; `stop` is asked after each step. A case that fails has a record that says why.
///
/// # Errors
/// Cut, and to be run again.
pub fn run_case(
    args: &Args,
    scene: &Scene,
    place: &ShardFiles,
    case: u64,
    overrides: &[String],
    stop: impl Fn() -> bool,
) -> Result<Record, CaseFailure> {
    let work = AssertUnwindSafe(|| attempt(args, scene, place, case, overrides, &stop));
    catch_unwind(work).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().map(String::as_str);
        let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason");
        Ok(Record::new(case, Some(format!("the program has a fault: {said}")), Vec::new()))
    })
}

fn attempt(
    args: &Args,
    scene: &Scene,
    place: &ShardFiles,
    case: u64,
    overrides: &[String],
    stop: impl Fn() -> bool,
) -> Result<Record, CaseFailure> {
    let opened = unheard(|| Session::from_text(&scene.text, &scene.file, overrides));
    let mut session = match opened {
        Ok(session) => session,
        Err(_) if interrupt::pressed() => return Err(CaseFailure::Asked),
        Err(error) => return Ok(Record::new(case, Some(error.to_string()), Vec::new())),
    };
    scene.files.check(&session)?;
    let steps = run::steps(&session, args.seconds)?;
    let mut probes = Probes::create(args, place, case, &session)?;
    let mut figures = Figures::new(&mut session);
    probes.take(&mut session)?;
    for _ in 0..steps {
        session.step(&mut ());
        figures.take(&mut session);
        probes.take(&mut session)?;
        if stop() {
            return Err(CaseFailure::Asked);
        }
    }
    probes.finish()?;
    let judged = TakenBack::judge(figures.summary().non_finite, steps);
    let failed = judged.err().map(|error| error.to_string());
    Ok(Record::new(case, failed, figures.row(&session)))
}

/// The case's probe table, if it was asked for.
struct Probes(Option<TableWriter<Output>>);

impl Probes {
    fn create(
        args: &Args,
        place: &ShardFiles,
        case: u64,
        session: &Session,
    ) -> Result<Self, CliError> {
        if !args.probe || session.columns().is_empty() {
            return Ok(Self(None));
        }
        let folder = &place.probes;
        std::fs::create_dir_all(folder)
            .map_err(|e| CliError::Other(format!("cannot make {}: {e}", folder.display())))?;
        let output = Output::create(&folder.join(format!("{case}.csv")))?;
        let table = TableWriter::new(output, TableFormat::Csv, session.columns());
        Ok(Self(Some(table.map_err(|e| failed(&e))?)))
    }

    fn take(&mut self, session: &mut Session) -> Result<(), CliError> {
        match &mut self.0 {
            Some(table) if session.steps().is_multiple_of(session.probe_every()) => {
                let time = session.world().time();
                table.row(time, session.probe()).map_err(|e| failed(&e))
            }
            _ => Ok(()),
        }
    }

    fn finish(self) -> Result<(), CliError> {
        let Some(table) = self.0 else { return Ok(()) };
        Ok(table.finish().map_err(|e| failed(&e))?.finish()?)
    }
}

fn failed(error: &std::io::Error) -> CliError {
    CliError::Other(format!("cannot write the probe table: {error}"))
}
