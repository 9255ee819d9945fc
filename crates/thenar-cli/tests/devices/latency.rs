//! Goal: the delay of a tracker is measured and kept as a person would. Method: simulated gloves of
//! known delays on pseudo-terminals, moved by one hand, and a person at a terminal. How exact it
//! is, is shown in simulated time beside the method itself; here a busy machine is in it.

use super::person::Person;
use super::{Simulated, line_with, line_with_any};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use thenar_link::cyberglove::ClassicTwin;
use thenar_link::twin::{PtyTwin, Twin};
use toml::Table;

/// What the hand does.
const STILL: u8 = 0;
const WANDERS: u8 = 1;
const ENDS: u8 = 2;
/// From here on it taps: a stroke each `BEAT` from the moment on at which this was set.
const TAPS: u8 = 3;

/// Between taps \[s\].
const BEAT: f64 = 0.7;
/// A stroke ends so long after the beat, dead \[s\].
const STROKE: f64 = 0.08;

/// Gloves on one hand, each so much late \[s\].
struct Worn {
    does: Arc<AtomicU8>,
    thread: Option<JoinHandle<()>>,
    paths: Vec<PathBuf>,
}

/// How far the hand is closed at a time.
fn curl(does: u8, t: f64) -> f64 {
    match does {
        WANDERS => {
            let waves = [(0.31, 0.5), (0.53, 0.4), (0.89, 0.3), (1.27, 0.2), (1.71, 0.1)];
            0.5 + 0.3 * waves.iter().map(|(hz, size)| size * (TAU * hz * t).sin()).sum::<f64>()
        }
        TAPS => match t.rem_euclid(BEAT) {
            s if s < STROKE => 0.2 + 0.4 * (s / STROKE).powi(2),
            s if s < STROKE + 0.1 => 0.6,
            s if s < STROKE + 0.25 => 0.4 + 0.2 * ((s - STROKE - 0.1) / 0.15 * TAU / 2.0).cos(),
            _ => 0.2,
        },
        _ => 0.5,
    }
}

impl Worn {
    fn start(test: &str, late: &[f64], begun: Instant) -> Self {
        let place = |k: usize| {
            std::env::temp_dir().join(format!("thenar-late-{test}-{k}-{}", std::process::id()))
        };
        let paths: Vec<_> = (0..late.len()).map(place).collect();
        let gloves: Vec<_> = (paths.iter())
            .map(|path| PtyTwin::start(ClassicTwin::new(22), path).unwrap())
            .collect();
        let does = Arc::new(AtomicU8::new(STILL));
        let (told, late) = (does.clone(), late.to_vec());
        let thread = std::thread::spawn(move || {
            while told.load(Ordering::Relaxed) != ENDS {
                let t = begun.elapsed().as_secs_f64();
                for (glove, late) in gloves.iter().zip(&late) {
                    glove.twin().set_curls([curl(told.load(Ordering::Relaxed), t - late); 5]);
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        Self { does, thread: Some(thread), paths }
    }

    fn address(&self, k: usize) -> String {
        format!("cyberglove:{}", self.paths[k].display())
    }
}

impl Drop for Worn {
    fn drop(&mut self) {
        self.does.store(ENDS, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// The standard error that a line states \[s\].
fn stated_error(line: &str) -> f64 {
    let after = line.split("standard error ").nth(1).unwrap();
    after.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-3
}

fn tracking(file: &Path) -> [f64; 3] {
    let table: Table = std::fs::read_to_string(file).unwrap().parse().unwrap();
    ["latency", "rate", "noise"].map(|key| table["tracking"][key].as_float().unwrap())
}

/// A glove that is 40 ms late, beside one that is said to be 5 ms late and is not late at all: 45
/// ms are asked about, kept on `yes`, and all else in the profile stays.
#[test]
fn a_second_tracker_tells_the_delay() {
    let worn = Worn::start("two", &[0.04, 0.0], Instant::now());
    let file = worn.paths[0].with_extension("toml");
    let own = "# Anna's\n[tracking] # by the maker\nlatency = 0.01 # s\n\n[hand]\nlength = 0.18\n";
    std::fs::write(&file, own).unwrap();
    let address = format!("{}?profile={}", worn.address(0), file.display());
    let (second, none) = (worn.address(1), PathBuf::from("/nonexistent"));
    let args = [
        "devices",
        "latency",
        &address,
        "--with",
        &second,
        "--reference-latency",
        "0.005",
        "--seconds",
        "14",
        "--still",
        "3",
    ];
    let mut person = Person::start(&args, &none);
    line_with(&person.said, "Hold your hand still for 3 s");
    person.press("\n");
    line_with(&person.said, "Open and close your hand");
    worn.does.store(WANDERS, Ordering::Relaxed);
    person.press("\n");
    let (line, which) = line_with_any(&person.said, &["latency ", "nothing is kept"]);
    assert_eq!(which, 0, "{line}");
    line_with(&person.said, "noise   none: the hand stood stiller");
    line_with(&person.said, "Type `yes` to keep this in ");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), own, "nobody has agreed yet");
    person.press("yes\n");
    let (code, told) = person.end();
    assert_eq!(code, Some(0), "{told}");
    let [latency, rate, noise] = tracking(&file);
    let near = 0.003_f64.max(3.0 * stated_error(&line));
    assert!((latency - 0.045).abs() < near, "{latency} s, {line}");
    assert!((70.0..=101.0).contains(&rate), "{rate} Hz");
    // As stated before: nothing better is known.
    assert_eq!(noise, 1e-4);
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.starts_with("# Anna's\n[tracking] # by the maker\nlatency = 0.04"), "{text}");
    assert!(text.contains(" # s\n") && text.contains("\n[hand]\nlength = 0.18\n"), "{text}");
    std::fs::remove_file(&file).unwrap();
}

/// A person taps a key that is told 20 ms late with a finger that a glove sees 30 ms late.
#[test]
fn taps_on_a_key_tell_the_delay() {
    let begun = Instant::now();
    let worn = Worn::start("taps", &[0.03], begun);
    let file = worn.paths[0].with_extension("toml");
    let (address, output) = (worn.address(0), file.display().to_string());
    let args = [
        "devices",
        "latency",
        &address,
        "--key-delay",
        "0.02",
        "--taps",
        "14",
        "--still",
        "0",
        "--keep",
        "--output",
        &output,
    ];
    let mut person = Person::start(&args, Path::new("/nonexistent"));
    line_with(&person.said, "Tap a key with your index finger, 14 times");
    worn.does.store(TAPS, Ordering::Relaxed);
    // The first whole stroke after that.
    let first = (begun.elapsed().as_secs_f64() / BEAT).ceil() + 1.0;
    for k in 0..14 {
        let down = (first + f64::from(k)) * BEAT + STROKE + 0.02;
        std::thread::sleep(Duration::from_secs_f64(
            (down - begun.elapsed().as_secs_f64()).max(0.0),
        ));
        person.press(" ");
    }
    let (code, told) = person.end();
    assert_eq!(code, Some(0), "{told}");
    let line = told.lines().find(|line| line.starts_with("latency ")).unwrap();
    let [latency, ..] = tracking(&file);
    assert!(
        (latency - 0.03).abs() < 0.006_f64.max(3.0 * stated_error(line)),
        "{latency} s: {told}"
    );
    assert!(told.contains("Keyboards differ by some 15 ms"), "{told}");
    std::fs::remove_file(&file).unwrap();
}

/// As in the manual: two simulated gloves in processes of their own, the second 60 ms late.
#[test]
fn simulated_devices_can_be_late() {
    let (first, second) =
        (Simulated::start("cyberglove", "on-time"), Simulated::late("cyberglove", "late", 0.06));
    let file = second.port.with_extension("toml");
    let (address, with) = (second.address("cyberglove"), first.address("cyberglove"));
    let output = file.display().to_string();
    let args = [
        "devices",
        "latency",
        &address,
        "--with",
        &with,
        "--seconds",
        "14",
        "--still",
        "0",
        "--keep",
        "--output",
        &output,
    ];
    let mut person = Person::start(&args, Path::new("/nonexistent"));
    line_with(&person.said, "Open and close your hand");
    person.press("\n");
    let (code, told) = person.end();
    assert_eq!(code, Some(0), "{told}");
    let line = told.lines().find(|line| line.starts_with("latency ")).unwrap();
    // The first one's 10 ms are by its profile.
    let [latency, ..] = tracking(&file);
    assert!(
        (latency - 0.07).abs() < 0.004_f64.max(3.0 * stated_error(line)),
        "{latency} s: {told}"
    );
    std::fs::remove_file(&file).unwrap();
}

/// A hand that does not move, one that nobody taps with, a tracker that is not there: refused in a
/// line, nothing is kept.
#[test]
fn too_little_is_refused() {
    let worn = Worn::start("little", &[0.0, 0.0], Instant::now());
    let (address, second) = (worn.address(0), worn.address(1));
    let file = worn.paths[0].with_extension("toml").display().to_string();
    for (args, press, told) in [
        (
            &["--with", &second, "--seconds", "2"][..],
            "\n",
            "nothing is kept: too few seconds of motion",
        ),
        (&["--taps", "10"], "\x04", "nothing is kept: too few taps: 0, expected 10 or more"),
        (&["--with", "poses:0"], "", "states no delay: say --reference-latency"),
        (
            &["--with", "poses:0", "--reference-latency", "0.01"],
            "",
            "poses:0 sends no pose of the right hand",
        ),
        (&["--with", "nobody:0"], "", "no driver has that name"),
    ] {
        let args =
            [&["devices", "latency", &address, "--still", "0", "--keep", "--output", &file], args]
                .concat();
        let mut person = Person::start(&args, Path::new("/nonexistent"));
        if !press.is_empty() {
            line_with_any(&person.said, &["Enter begins", "It begins now"]);
            person.press(press);
        }
        if press == "\x04" {
            // A terminal whose keys count one by one has no end of input but this.
            person.close();
        }
        let (code, said) = person.end();
        assert!(code != Some(0) && said.contains(told), "{code:?} {said}");
        assert!(!Path::new(&file).exists());
    }
}
