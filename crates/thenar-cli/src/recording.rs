//! Recording what runs.

use crate::error::CliError;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use thenar_output::Claim;
use thenar_record::{Build, Channel, Clock, Field, Header, RecordError, Recorder};
use thenar_scene::recording::{SessionWriter, TimeOf};
use thenar_scene::session::{Session, Witness};

/// Options of recording; part of those of every command that can record.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct RecordOptions {
    /// Record the session into this file, for `thenar replay`.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Simulated time between keyframes of the recording, from which a replay can begin [s]; 0 for
    /// none.
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true)]
    pub keyframes: f64,
}

/// A recording under way.
#[derive(Debug)]
pub struct Recording {
    file: PathBuf,
    recorder: Recorder,
    told: bool,
    /// No other output takes its name.
    claim: Claim,
}

/// A recording, and the witness that a session is to get.
pub type Started = (Recording, Box<dyn Witness>);

/// Header of a recording made here and now.
pub fn header(time_of: TimeOf) -> Header {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    Header {
        program: concat!("thenar ", env!("CARGO_PKG_VERSION")).into(),
        build: Build::of_this_program(),
        vectors: thenar_core::vector_instructions(),
        system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
        created_unix_ns: u64::try_from(since_1970.as_nanos()).unwrap_or(0),
        simulated_time: time_of == TimeOf::Simulation,
    }
}

impl Recording {
    /// Starts one, if it is wanted.
    ///
    /// # Errors
    /// The file is there already or cannot be created, or an option makes no sense.
    pub fn start(options: &RecordOptions, time_of: TimeOf) -> Result<Option<Started>, CliError> {
        let every = options.keyframes;
        if !(every >= 0.0 && every.is_finite()) {
            return Err(CliError::Input("--keyframes must be 0 or more".into()));
        }
        let Some(file) = &options.record else { return Ok(None) };
        let claim = Claim::of(file)?;
        let recorder = Recorder::create(file, &header(time_of))?;
        let every = if every == 0.0 { f64::INFINITY } else { every };
        let writer = SessionWriter::new(recorder.session(), recorder.clock(), time_of, every);
        Ok(Some((Self { file: file.clone(), recorder, told: false, claim }, Box::new(writer))))
    }

    /// The file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// A channel with these fields, and the clock of its records.
    pub fn channel(&mut self, name: &str, fields: &[Field], waiting: usize) -> (Channel, Clock) {
        (self.recorder.channel(name, fields, waiting), self.recorder.clock())
    }

    /// Says once, on the error output, that nothing is written any more.
    pub fn complain(&mut self) {
        if let Some(cause) = self.recorder.trouble().filter(|_| !self.told) {
            self.told = true;
            eprintln!("warning: {} goes no further: {cause}", self.file.display());
        }
    }

    /// Nothing came of what was to be recorded: no file stays.
    pub fn discard(self) {
        let Self { file, recorder, .. } = self;
        drop(recorder);
        // It was made by us, and is empty.
        let _ = std::fs::remove_file(file);
    }

    /// Ends it; returns its size \[bytes\].
    ///
    /// # Errors
    /// Not all of it could be written.
    pub fn finish(self) -> Result<u64, CliError> {
        let (told, file) = (self.told, self.file);
        self.claim.keep();
        match self.recorder.finish() {
            Ok(written) => Ok(written.bytes),
            // The cause has been told.
            Err(RecordError::Write { .. }) if told => {
                let what = "ends before the session does; what is in it can be replayed";
                Err(CliError::Other(format!("{} {what}", file.display())))
            }
            Err(error) => Err(error.into()),
        }
    }
}

/// Starts to record a session that runs as fast as it can.
///
/// # Errors
/// As [`Recording::start`].
pub fn attach(
    options: &RecordOptions,
    session: &mut Session,
) -> Result<Option<Recording>, CliError> {
    let Some((recording, witness)) = Recording::start(options, TimeOf::Simulation)? else {
        return Ok(None);
    };
    session.set_witness(witness);
    Ok(Some(recording))
}

impl From<RecordError> for CliError {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Exists(_) => Self::Input(error.to_string()),
            _ => Self::Other(error.to_string()),
        }
    }
}
