//! The files of a run: written as partial files, named when the run ends.

use super::vtk::VtkSeries;
use super::{Args, Outcome, report};
use crate::error::CliError;
use crate::recorder::Recorder;
use std::io::Write;
use thenar_output::Output;
use thenar_scene::session::{Session, TableFormat, TableWriter};

/// All files of a run.
pub struct Outputs {
    table: Option<TableWriter<Output>>,
    report: Option<Output>,
    vtk: Option<VtkSeries>,
    pictures: Option<Recorder>,
}

fn failed(error: &std::io::Error) -> CliError {
    CliError::Other(format!("cannot write the probe table: {error}"))
}

impl Outputs {
    /// Starts the files, so that one that cannot be written is known before the run.
    ///
    /// # Errors
    /// One cannot be created.
    pub fn create(args: &Args, session: &Session, steps: u64) -> Result<Self, CliError> {
        let table = match &args.probe {
            Some(path) => {
                let lines = path.extension().is_some_and(|e| e == "jsonl");
                let format = if lines { TableFormat::JsonLines } else { TableFormat::Csv };
                let output = Output::create(path)?;
                Some(TableWriter::new(output, format, session.columns()).map_err(|e| failed(&e))?)
            }
            None => None,
        };
        let report = args.report.as_deref().map(Output::create).transpose()?;
        let vtk = match &args.vtk {
            Some(folder) => Some(VtkSeries::create(folder, session, args.vtk_interval)?),
            None => None,
        };
        let seconds = steps as f64 * session.world().time_step();
        let pictures = Recorder::start(&args.pictures, session, seconds)?;
        Ok(Self { table, report, vtk, pictures })
    }

    /// Takes in the present state, at the start and after each step.
    ///
    /// # Errors
    /// Writing fails.
    pub fn take(&mut self, session: &mut Session) -> Result<(), CliError> {
        if let Some(table) = &mut self.table
            && session.steps().is_multiple_of(session.probe_every())
        {
            let time = session.world().time();
            table.row(time, session.probe()).map_err(|e| failed(&e))?;
        }
        if let Some(pictures) = &mut self.pictures
            && session.steps() > 0
        {
            pictures.observe(session)?;
        }
        match &mut self.vtk {
            Some(vtk) => vtk.take(session),
            None => Ok(()),
        }
    }

    /// Ends all files and gives them their names.
    ///
    /// # Errors
    /// Writing fails.
    pub fn finish(self, session: &Session, outcome: &Outcome) -> Result<(), CliError> {
        if let Some(table) = self.table {
            table.finish().map_err(|e| failed(&e))?.finish()?;
        }
        if let Some(mut output) = self.report {
            let text = serde_json::to_string_pretty(&report(session, outcome))
                .map_err(|e| CliError::Other(e.to_string()))?;
            writeln!(output, "{text}")
                .map_err(|e| CliError::Other(format!("cannot write the report: {e}")))?;
            output.finish()?;
        }
        if let Some(pictures) = self.pictures {
            pictures.finish(session)?;
        }
        Ok(())
    }
}
