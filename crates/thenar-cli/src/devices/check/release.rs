//! Time for which a stopped or killed program still holds its wearer, measured on this machine with
//! a simulated glove.

use crate::error::CliError;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use thenar_link::lucidgloves::LucidGlovesTwin;
use thenar_link::twin::{PtyTwin, Twin};

/// Bones alone; a load pulls the index finger open and lets it be, one and a half times a second.
const SCENE: &str = r#"version = 1
time_step = 0.01
[[hand]]
preset = "paper"
name = "hand"
flesh = false
[[load]]
kind = "force"
body = "hand/index-distal"
force = [0, 2, 0]
profile = { kind = "sine", frequency = 1.5 }
"#;
/// No ramp: nobody wears the glove.
const PROFILE: &str = "display.ramp = 0.0\n";
/// Longest that anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
/// Between two looks at the glove.
const LOOK: Duration = Duration::from_micros(100);

/// Prints the delays from the signal to free fingers, `times` of each kind.
///
/// # Errors
/// The glove cannot be simulated, the program not be started, or the wearer is held on.
pub fn measure(times: u32) -> Result<(), CliError> {
    let trial = Trial::new()?;
    let mut stopped = Vec::new();
    let mut killed = Vec::new();
    for _ in 0..times {
        let mut program = trial.start()?;
        trial.until("a stop of the finger", || trial.holds())?;
        stopped.push(trial.release(&program, Signal::SIGSTOP)?);
        program.signal(Signal::SIGCONT)?;
        trial.until("a stop of the finger after that", || trial.holds())?;
        killed.push(trial.release(&program, Signal::SIGKILL)?);
        program.end();
        // The keeper outlives the program by a second; the port is its own until then.
        std::thread::sleep(Duration::from_nanos(thenar_link::keeper::GONE_NS + 100_000_000));
    }
    println!("from the signal to free fingers, of a simulated glove at 115200 bit/s:");
    println!("{:10}{:>6}{:>12}{:>12}{:>12}", "", "", "median", "p99", "largest");
    for (name, mut delays) in [("stopped", stopped), ("killed", killed)] {
        delays.sort();
        let at = |part: f64| {
            let rank = (part * delays.len() as f64).ceil() as usize;
            1e3 * delays[rank.clamp(1, delays.len()) - 1].as_secs_f64()
        };
        let [median, p99, largest] = [at(0.5), at(0.99), at(1.0)];
        let count = format!("{}x", delays.len());
        println!("{name:10}{count:>6}{median:>9.1} ms{p99:>9.1} ms{largest:>9.1} ms");
    }
    Ok(())
}

/// A glove, and the files of a program that plays with it.
struct Trial {
    folder: PathBuf,
    glove: PtyTwin<LucidGlovesTwin>,
}

/// The program, armed.
struct Program(Child);

impl Program {
    fn signal(&self, signal: Signal) -> Result<(), CliError> {
        let id = i32::try_from(self.0.id()).unwrap_or(0);
        kill(Pid::from_raw(id), signal).map_err(|e| CliError::Other(format!("{signal}: {e}")))
    }

    fn end(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.end();
    }
}

impl Trial {
    fn new() -> Result<Self, CliError> {
        let folder = std::env::temp_dir().join(format!("thenar-release-{}", std::process::id()));
        let failed = |e: std::io::Error| CliError::Other(format!("no trial: {e}"));
        std::fs::create_dir_all(&folder).map_err(failed)?;
        std::fs::write(folder.join("scene.toml"), SCENE).map_err(failed)?;
        std::fs::write(folder.join("glove.toml"), PROFILE).map_err(failed)?;
        let glove = PtyTwin::start(LucidGlovesTwin::new(false, false), &folder.join("glove"));
        let glove = glove.map_err(failed)?;
        glove.twin().set_curls([0.3; 5]);
        Ok(Self { folder, glove })
    }

    fn start(&self) -> Result<Program, CliError> {
        let program = std::env::current_exe();
        let started = program.and_then(|program| {
            let port = self.folder.join("glove");
            Command::new(program)
                .args(["touch", "scene.toml", "--quiet", "--arm", "--device"])
                .arg(format!("lucidgloves:{}?profile=glove.toml", port.display()))
                .env("THENAR_CONFIG", self.folder.join("none"))
                .current_dir(Path::new(&self.folder))
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
        });
        started.map(Program).map_err(|e| CliError::Other(format!("no program to stop: {e}")))
    }

    fn holds(&self) -> bool {
        self.glove.twin().felt()[1] > 0.0
    }

    fn release(&self, program: &Program, signal: Signal) -> Result<Duration, CliError> {
        let begun = Instant::now();
        program.signal(signal)?;
        self.until("free fingers", || !self.holds())?;
        Ok(begun.elapsed())
    }

    fn until(&self, what: &str, done: impl Fn() -> bool) -> Result<(), CliError> {
        let begun = Instant::now();
        while !done() {
            if crate::interrupt::asked() {
                return Err(CliError::Other("interrupted".into()));
            }
            if begun.elapsed() > PATIENCE {
                return Err(CliError::Other(format!("waited in vain for {what}")));
            }
            std::thread::sleep(LOOK);
        }
        Ok(())
    }
}

impl Drop for Trial {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
