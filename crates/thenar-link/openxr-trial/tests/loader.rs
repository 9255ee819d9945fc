//! Goal: the real driver, through the real Khronos loader, gets hands from a runtime, loses and
//! takes up what a runtime may lose, and says in one line what is missing. Method: each test has a
//! process of its own (`openxr-hands`) whose `XR_RUNTIME_JSON` names the trial runtime, and writes
//! that runtime's script while it goes. The loader must be installed (Debian: libopenxr-loader1).

#![cfg(target_os = "linux")]

use std::collections::VecDeque;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use thenar_openxr_trial::hand::{JOINTS, LOCAL_HEIGHT, STEPS, joint};
use thenar_openxr_trial::script;

/// Longest that anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A program that has `openxr:` open, and its runtime's script.
struct Trial {
    child: Child,
    lines: Receiver<String>,
    /// Read and not looked at.
    ahead: VecDeque<String>,
    folder: PathBuf,
}

impl Trial {
    fn start(name: &str, says: &str) -> Self {
        Self::with(name, says, "openxr:", true)
    }

    /// `runtime`: whether the loader finds the trial runtime.
    fn with(name: &str, says: &str, address: &str, runtime: bool) -> Self {
        let folder = std::env::temp_dir().join(format!("thenar-xr-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let program = Path::new(env!("CARGO_BIN_EXE_openxr-hands"));
        let beside = program.parent().unwrap();
        let library = [beside.to_path_buf(), beside.join("deps")]
            .map(|place| place.join("libthenar_openxr_trial.so"))
            .into_iter()
            .find(|library| library.exists())
            .expect("the runtime's library beside the program");
        let place = folder.join("runtime.json");
        std::fs::write(&place, manifest(&library)).unwrap();
        std::fs::write(folder.join("script"), says).unwrap();
        let mut command = Command::new(program);
        command.arg(address).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        // Nothing of this computer's own runtimes.
        for variable in ["XR_ENABLE_API_LAYERS", "XDG_CONFIG_DIRS", "HOME"] {
            command.env_remove(variable);
        }
        command.env("XDG_CONFIG_HOME", &folder).env(script::VARIABLE, folder.join("script"));
        let none = folder.join("none.json");
        command.env("XR_RUNTIME_JSON", if runtime { &place } else { &none });
        let mut child = command.spawn().unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let (send, lines) = channel();
        std::thread::spawn(move || {
            for line in out.lines().map_while(Result::ok) {
                if send.send(line).is_err() {
                    return;
                }
            }
        });
        Self { child, lines, ahead: VecDeque::new(), folder }
    }

    fn says(&self, text: &str) {
        // At once for the reader: it must not see half of it.
        let half = self.folder.join("half");
        std::fs::write(&half, text).unwrap();
        std::fs::rename(half, self.folder.join("script")).unwrap();
    }

    fn log(&self) -> Vec<String> {
        let log = std::fs::read_to_string(self.folder.join("script.log")).unwrap_or_default();
        log.lines().map(str::to_owned).collect()
    }

    /// Reads until a line begins so, and returns it whole with what was read before.
    fn until(&mut self, begins: &str) -> (String, Vec<String>) {
        let (start, mut before) = (Instant::now(), Vec::new());
        loop {
            let next = match self.ahead.pop_front() {
                Some(line) => Ok(line),
                None => self.lines.recv_timeout(Duration::from_millis(50)),
            };
            match next {
                Ok(line) if line.starts_with(begins) => return (line, before),
                Ok(line) => before.push(line),
                Err(RecvTimeoutError::Timeout) if start.elapsed() < PATIENCE => {}
                Err(_) => {
                    before.retain(|line| !line.starts_with("hand"));
                    panic!("`{begins}` never came; {before:?}, runtime: {:?}", self.log());
                }
            }
        }
    }

    fn told(&mut self, what: &str) -> String {
        loop {
            let (line, _) = self.until("told ");
            if line.contains(what) {
                return line;
            }
        }
    }

    /// What waits to be read is of before.
    fn forget(&mut self) {
        while self.lines.try_recv().is_ok() {}
        self.ahead.clear();
    }

    fn hand(&mut self, name: &str) -> Hand {
        Hand::read(&self.until(&format!("hand {name} ")).0)
    }

    /// Ends the program; returns the runtime's log, which tells of nothing against the
    /// specification.
    fn end(mut self) -> Vec<String> {
        drop(self.child.stdin.take());
        self.until("ended");
        assert!(self.child.wait().unwrap().success());
        let log = self.log();
        assert!(log.iter().all(|line| !line.starts_with("violation")), "{log:?}");
        let count = |what: &str| log.iter().filter(|line| line.starts_with(what)).count();
        assert_eq!(count("instance XR"), count("instance ended"), "{log:?}");
        assert_eq!(
            log.iter().filter(|l| *l == "session").count(),
            count("session ended"),
            "{log:?}"
        );
        log
    }
}

impl Drop for Trial {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A manifest of the loader's.
fn manifest(library: &Path) -> String {
    format!(
        r#"{{"file_format_version":"1.0.0","runtime":{{"library_path":"{}"}}}}"#,
        library.display()
    )
}

/// 25 joints as the program told them: position, rotation, radius.
struct Hand(Vec<[f64; 8]>);

impl Hand {
    fn read(line: &str) -> Self {
        let numbers: Vec<f64> =
            line.split(' ').skip(2).map(|number| number.parse().unwrap()).collect();
        assert_eq!(numbers.len(), 25 * 8);
        Self(numbers.chunks_exact(8).map(|joint| joint.try_into().unwrap()).collect())
    }

    /// Checks all of it against the runtime's hand, whose origin is so high above the floor \[m\];
    /// returns which step of its motion it is. Ours are its joints without the first, the palm.
    fn is(&self, hand: usize, height: f32) -> u64 {
        let first = joint(hand, 1, 0).position[0];
        let step = ((self.0[0][0] as f32 - first) * 1e3).round() as u64;
        assert!(step < STEPS);
        for (k, told) in self.0.iter().enumerate() {
            let want = joint(hand, k + 1, step);
            let [x, y, z] = want.position;
            for (told, want) in told.iter().zip([x, y - height, z]) {
                assert!((told - f64::from(want)).abs() < 1e-6, "joint {k}");
            }
            for (told, want) in told[3..].iter().zip(want.rotation) {
                assert!((told - f64::from(want)).abs() < 1e-6, "joint {k}");
            }
            assert!((told[7] - f64::from(want.radius)).abs() < 1e-7, "joint {k}");
        }
        step
    }
}

/// Both hands, each joint where the runtime has it, in metres above the floor, and as they move.
#[test]
fn hands_come_as_the_runtime_has_them() {
    let mut trial = Trial::start("hands", "");
    assert_eq!(trial.until("told ").0, "told openxr: is connected");
    for (hand, name) in ["left", "right"].into_iter().enumerate() {
        let steps: Vec<u64> = (0..120).map(|_| trial.hand(name).is(hand, 0.0)).collect();
        // A reader that is late misses some, and none comes twice.
        assert!(steps.windows(2).all(|two| two[0] != two[1]), "{steps:?}");
        assert!(steps.contains(&0) || steps.windows(2).any(|two| two[0] > two[1]), "a round");
    }
    let log = trial.end();
    let wanted = ["XR_EXT_hand_tracking", "XR_KHR_convert_timespec_time", "XR_MND_headless"];
    assert_eq!(log[0], format!("instance {}", wanted.join(" ")));
    assert_eq!(log[1..], ["session", "session runs", "session ended", "instance ended"]);
    assert_eq!(JOINTS, 26);
}

/// One hand is lost, then both; a single joint that is not known loses the hand, the palm does not.
#[test]
fn hands_that_are_not_seen_are_lost_and_return() {
    let mut trial = Trial::start("lost", "");
    trial.hand("right");
    trial.says("hands left");
    trial.until("lost right");
    trial.forget();
    // The other goes on by itself.
    assert!(trial.until("hand left").1.iter().all(|line| !line.starts_with("hand right")));
    trial.says("hands none");
    trial.until("lost left");
    trial.says("blind 7");
    trial.says("hands both");
    trial.hand("right").is(1, 0.0);
    trial.says("blind 7");
    trial.until("lost");
    trial.says("blind 0");
    trial.hand("left").is(0, 0.0);
    trial.end();
}

/// No stage: hands are about where the head was, which is told.
#[test]
fn without_a_stage_hands_are_in_the_local_space() {
    let mut trial = Trial::start("stage", "stage no");
    trial.told("there is no stage");
    trial.hand("left").is(0, LOCAL_HEIGHT);
    trial.end();
}

/// The session stops and goes on, as with a headset that is taken off: no new session is made.
#[test]
fn a_session_that_stops_goes_on() {
    let mut trial = Trial::start("stop", "");
    trial.hand("left");
    trial.says("session stop");
    let (_, before) = trial.until("lost left");
    assert!(before.iter().all(|line| !line.starts_with("told openxr: is lost")));
    trial.told("has fallen silent");
    trial.says("");
    trial.hand("right").is(1, 0.0);
    trial.told("speaks again");
    let log = trial.end();
    let runs = ["session", "session runs", "session stopped", "session runs", "session ended"];
    assert_eq!(log[1..6], runs);
}

/// The runtime ends the session, its loss is near, the instance's too, or calls fail: it is told
/// once, and when the runtime is back so are the hands.
#[test]
fn what_the_runtime_ends_is_taken_up_again() {
    let ways = [
        ("session exit", "the runtime ended it"),
        ("session lose", "the runtime ended it"),
        ("session lose_instance", "the runtime goes away"),
        ("fail xrLocateHandJointsEXT -17", "no joints"),
        ("fail xrPollEvent -13", "no events"),
        ("fail xrConvertTimespecTimeToTimeKHR -2", "no clock"),
    ];
    let mut trial = Trial::start("ended", "");
    for (says, cause) in ways {
        trial.hand("left");
        trial.says(says);
        let told = trial.told("is lost");
        assert!(told.contains(cause), "{says}: {told}");
        trial.says("");
        trial.told("is back");
        trial.hand("left").is(0, 0.0);
    }
    trial.end();
}

/// What is missing is told in one line that names it, nothing moves, and it is taken up when it
/// comes.
#[test]
fn what_is_missing_is_named() {
    let cases = [
        ("without XR_EXT_hand_tracking", "the OpenXR runtime has no hand tracking"),
        (
            "without XR_MND_headless",
            "lacks XR_MND_headless: it gives hands only to programs that draw",
        ),
        ("without XR_KHR_convert_timespec_time", "lacks XR_KHR_convert_timespec_time"),
        ("tracks no", "this headset has no hand tracking"),
        ("fail xrGetSystem -35", "no headset"),
        ("fail xrCreateInstance -2", "no instance"),
        ("fail xrCreateSession -2", "no session without a picture"),
        ("fail xrCreateReferenceSpace -2", "no space"),
        ("fail xrCreateHandTrackerEXT -2", "no hands"),
    ];
    std::thread::scope(|scope| {
        for (k, (says, cause)) in cases.into_iter().enumerate() {
            scope.spawn(move || {
                let mut trial = Trial::start(&format!("missing-{k}"), says);
                let (told, before) = trial.until("told ");
                assert!(told.contains("is not there") && told.contains(cause), "{told}");
                assert!(told.ends_with("it is taken up when it comes"), "cut off: {told}");
                assert!(before.is_empty(), "{before:?}");
                trial.says("");
                assert_eq!(trial.until("told ").0, "told openxr: is connected");
                trial.hand("left").is(0, 0.0);
                trial.end();
            });
        }
    });
}

#[test]
fn without_a_runtime_it_says_so() {
    let mut trial = Trial::with("runtime", "", "openxr:", false);
    let told = trial.told("is not there");
    assert!(told.contains("no OpenXR runtime is active"), "{told}");
    // It is installed while the program waits.
    std::fs::copy(trial.folder.join("runtime.json"), trial.folder.join("none.json")).unwrap();
    trial.hand("left").is(0, 0.0);
    trial.end();
}

#[test]
fn without_a_loader_it_says_so() {
    let mut trial = Trial::with("loader", "", "openxr:/nowhere/libopenxr_loader.so.1", true);
    let told = trial.told("is not there");
    let cause = "the OpenXR loader cannot be loaded: /nowhere/libopenxr_loader.so.1: cannot open";
    assert!(told.contains(cause), "{told}");
    trial.end();
}
