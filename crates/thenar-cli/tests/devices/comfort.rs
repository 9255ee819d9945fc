//! Goal: a wearer finds out what is comfortable, can stop it at any time, and never feels more from
//! then on. Method: a simulated glove on a pseudo-terminal, a simulated CyberGrasp behind its
//! bridge, and a person at a terminal.

use super::person::{Person, until};
use super::{line_with, line_with_any, text, thenar};
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use thenar_link::cybergrasp::{SimulatedUnit, serve_unit};
use thenar_link::lucidgloves::LucidGlovesTwin;
use thenar_link::twin::PtyTwin;
use thenar_link::wearer::Wearer;

const NAMES: [&str; 5] = ["thumb", "index finger", "middle finger", "ring finger", "little finger"];

/// A folder of settings, and a profile whose forces need not come up for two seconds.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("thenar-comfort-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        // A busy machine is silent for longer than a device should be.
        std::fs::write(
            path.join("quick.toml"),
            "[display]\nramp = 0.1\ndevice_silence_max = 0.5\n",
        )
        .unwrap();
        Self(path)
    }

    fn profile(&self) -> String {
        self.0.join("quick.toml").display().to_string()
    }

    fn wearer(&self, name: &str) -> PathBuf {
        self.0.join("wearers").join(format!("{name}.toml"))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A CyberGrasp's unit, and its bridge.
struct Grasp {
    unit: SimulatedUnit,
    port: u16,
    stop: Arc<AtomicBool>,
    bridge: Option<JoinHandle<()>>,
}

impl Grasp {
    fn start() -> Self {
        let (unit, stop) = (SimulatedUnit::default(), Arc::new(AtomicBool::new(false)));
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let (mut served, told) = (unit.clone(), stop.clone());
        let bridge = std::thread::spawn(move || drop(serve_unit(&listener, &mut served, &told)));
        Self { unit, port, stop, bridge: Some(bridge) }
    }

    fn address(&self, folder: &Folder) -> String {
        format!("cybergrasp:127.0.0.1:{}?side=right&profile={}", self.port, folder.profile())
    }

    fn force(&self, finger: usize) -> f64 {
        self.unit.tendons().0[finger]
    }

    fn is_slack(&self) -> bool {
        self.unit.tendons().0 == [0.0; 5]
    }

    /// The bridge is gone; it lets go, as bridges do.
    fn go(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(bridge) = self.bridge.take() {
            bridge.join().unwrap();
        }
    }
}

impl Drop for Grasp {
    fn drop(&mut self) {
        self.go();
    }
}

/// The force that was found for a finger, once the program says it; while it waits to go on,
/// somebody does.
fn found(person: &mut Person, finger: usize) -> f64 {
    let line = line_with(&person.said, &format!("{}: ", NAMES[finger]));
    let force = line.rsplit(": ").next().unwrap().trim_end_matches(" N").parse().unwrap();
    if finger < 4 {
        line_with(&person.said, &format!("Next: {}", NAMES[finger + 1]));
        person.press("n\n");
    }
    force
}

/// Someone who never stops it: each finger ends at what the glove's profile allows, 5 N of 10,
/// alone, and that is kept.
#[test]
fn who_never_stops_it_ends_at_the_limit() {
    let folder = Folder::new("never");
    let glove =
        PtyTwin::start(LucidGlovesTwin::new(false, false), &folder.0.join("glove")).unwrap();
    let address = format!("lucidgloves:{}?profile={}", glove.path().display(), folder.profile());
    let args = [
        "devices",
        "comfort",
        &address,
        "--wearer",
        "anna",
        "--arm",
        "--seconds",
        "0.15",
        "--ramp",
        "3",
    ];
    let mut person = Person::start(&args, &folder.0);
    for finger in 0..5 {
        line_with(&person.said, &format!("{}: rising", NAMES[finger]));
        // Half of the wearer's range.
        until("the finger is stopped", || glove.twin().servos[finger] == 500);
        let servos = glove.twin().servos;
        assert!((0..5).all(|k| k == finger || servos[k] == 0), "{servos:?}");
        assert_eq!(found(&mut person, finger), 5.0);
    }
    let (code, told) = person.end();
    assert_eq!(code, Some(0), "{told}");
    let wearer = Wearer::read(&folder.wearer("anna")).unwrap();
    let comfort = wearer.with("lucidgloves").unwrap();
    assert_eq!((comfort.force, comfort.ramp, comfort.stiffness), ([5.0; 5], 3.0, 1.0));
    until("all fingers are free", || glove.twin().servos == [0; 5]);
}

/// Any key stops a finger at once. Kept are 80 % of the last step that was over, of half a newton
/// each, and nothing of a finger that was stopped at once; the file keeps what else is in it. From
/// then on no finger feels more.
#[test]
fn a_key_stops_a_finger_and_the_wearer_never_feels_more() {
    let (folder, grasp) = (Folder::new("stops"), Grasp::start());
    let file = folder.wearer("default");
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    let own = "# mine\n[lucidgloves]\nforce = [1.0, 1.0, 1.0, 1.0, 1.0]\n";
    std::fs::write(&file, own).unwrap();
    let address = grasp.address(&folder);
    let mut person =
        Person::start(&["devices", "comfort", &address, "--seconds", "0.2"], &folder.0);
    line_with(&person.said, "Type `yes`");
    assert!(grasp.is_slack());
    person.press("yes\n");
    line_with(&person.said, "thumb: rising");
    person.press("x");
    line_with(&person.said, "stopped");
    until("the thumb is free", || grasp.is_slack());
    assert_eq!(found(&mut person, 0), 0.0);
    line_with(&person.said, "index finger: rising");
    until("the index finger is pulled by 2 N", || grasp.force(1) >= 2.0);
    assert!([0, 2, 3, 4].iter().all(|k| grasp.force(*k) == 0.0));
    // Several keys of somebody in a hurry are one stop.
    person.press("\n\n\n");
    line_with(&person.said, "stopped");
    until("the index finger is free", || grasp.is_slack());
    let index = found(&mut person, 1);
    assert!(
        index > 0.8 * 1.5 - 1e-6
            && index < 6.0
            && (index / 0.4 - (index / 0.4).round()).abs() < 0.03,
        "{index} N"
    );
    for finger in 2..5 {
        line_with(&person.said, &format!("{}: rising", NAMES[finger]));
        assert_eq!(found(&mut person, finger), 6.0);
    }
    let (code, told) = person.end();
    assert_eq!(code, Some(0), "{told}");
    let wearer = Wearer::read(&file).unwrap();
    assert_eq!(wearer.with("cybergrasp").unwrap().force, [0.0, index, 6.0, 6.0, 6.0]);
    assert!(std::fs::read_to_string(&file).unwrap().starts_with(own));

    // A newton on each finger, but for the thumb, which wants none.
    let less = "[cybergrasp]\nforce = [0.0, 0.5, 6.0, 6.0, 6.0]\nstiffness = 1.0\n";
    std::fs::write(&file, less).unwrap();
    let feel = ["devices", "test", &address, "--seconds", "0", "--feel", "--arm"];
    let mut process =
        thenar(&feel).env("THENAR_CONFIG", &folder.0).stdout(Stdio::piped()).spawn().unwrap();
    let mut most = [0.0_f64; 5];
    while process.try_wait().unwrap().is_none() {
        let now = grasp.unit.tendons().0;
        most = std::array::from_fn(|k| most[k].max(now[k]));
        std::thread::sleep(std::time::Duration::from_micros(300));
    }
    let output = process.wait_with_output().unwrap();
    assert!(
        output.status.success() && text(&output).contains("for you at most 0.00 0.50 6.00"),
        "{}",
        text(&output)
    );
    // A finger is left out where this program is held up.
    assert!(most[0] == 0.0 && most[1] <= 0.5 + 1e-6 && most.iter().any(|n| *n > 0.6), "{most:?}");
}

/// A bridge that goes in the middle, and a terminal that is closed: no force, and nothing is kept.
#[test]
fn a_lost_device_or_terminal_leaves_nothing() {
    for closes in [false, true] {
        let (folder, mut grasp) =
            (Folder::new(if closes { "closed" } else { "lost" }), Grasp::start());
        let address = grasp.address(&folder);
        let args = ["devices", "comfort", &address, "--arm", "--seconds", "1"];
        let mut person = Person::start(&args, &folder.0);
        line_with(&person.said, "thumb: rising");
        until("the thumb is pulled", || grasp.force(0) > 0.3);
        if closes {
            person.close()
        } else {
            grasp.go()
        }
        until("the thumb is free", || grasp.is_slack());
        let (code, told) = person.end();
        assert_eq!(code, Some(1), "{told}");
        assert!(told.contains("nothing is kept"), "{told}");
        assert!(grasp.is_slack() && !folder.wearer("default").exists());
    }
}

/// A glove whose cable is pulled in the middle.
#[test]
fn a_glove_that_is_unplugged_leaves_nothing() {
    let folder = Folder::new("unplugged");
    let glove =
        PtyTwin::start(LucidGlovesTwin::new(false, false), &folder.0.join("glove")).unwrap();
    let address = format!("lucidgloves:{}?profile={}", glove.path().display(), folder.profile());
    let mut person =
        Person::start(&["devices", "comfort", &address, "--arm", "--seconds", "1"], &folder.0);
    line_with(&person.said, "thumb: rising");
    until("the thumb is stopped", || glove.twin().servos[0] == 500);
    glove.plug(false);
    let (code, told) = person.end();
    assert_eq!(code, Some(1), "{told}");
    assert!(told.contains("the device is lost, and nothing is kept"), "{told}");
    assert!(!folder.wearer("default").exists());
}

/// Nobody goes on, nobody is known, nothing is there: refused, and nothing is kept.
#[test]
fn what_is_not_wanted_is_not_done() {
    let (folder, grasp) = (Folder::new("unwanted"), Grasp::start());
    let address = grasp.address(&folder);
    let mut person = Person::start(&["devices", "comfort", &address], &folder.0);
    line_with(&person.said, "Type `yes`");
    person.press("no\n");
    let (code, told) = person.end();
    assert!(code == Some(1) && told.contains("not armed: no force was shown"), "{told}");
    let mut person =
        Person::start(&["devices", "comfort", &address, "--arm", "--seconds", "0.1"], &folder.0);
    line_with(&person.said, "thumb: rising");
    person.press(" ");
    line_with_any(&person.said, &["Next: index finger"]);
    // Somebody who still presses keys does not go on.
    person.press("\n");
    let (code, told) = person.end();
    assert!(code == Some(1) && told.contains("nothing is kept"), "{told}");
    assert!(!folder.wearer("default").exists());
    for (args, told) in [
        (
            &["touch", "free-motion", "--device", "null:right", "--wearer", "otto"][..],
            "has no settings yet",
        ),
        (
            &["touch", "free-motion", "--device", "null:right", "--wearer", "../x"],
            "1 to 64 letters",
        ),
        (&["devices", "comfort", "hts:9000"], "shows no forces"),
    ] {
        let output =
            thenar(args).env("THENAR_CONFIG", &folder.0).stdin(Stdio::null()).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(told), "{}", text(&output));
    }
}

/// Bones alone, pushed on the palm and the index finger: what `touch` shows keeps to the wearer's,
/// and says so.
#[test]
fn touch_keeps_to_the_wearer() {
    let (folder, grasp) = (Folder::new("touch"), Grasp::start());
    let scene = folder.0.join("scene.toml");
    let text_of = "version = 1\ntime_step = 0.01\n[[hand]]\npreset = \"paper\"\nname = \"hand\"\nflesh = false\n\
                   [[load]]\nkind = \"force\"\nbody = \"hand/index-distal\"\nforce = [0, 6, 0]\n\
                   profile = { kind = \"sine\", frequency = 0.7 }\n";
    std::fs::write(&scene, text_of).unwrap();
    let wearers = folder.wearer("anna");
    std::fs::create_dir_all(wearers.parent().unwrap()).unwrap();
    std::fs::write(&wearers, "[cybergrasp]\nforce = [0.3, 0.2, 0.3, 0.3, 0.3]\n").unwrap();
    let address = grasp.address(&folder);
    let scene = scene.display().to_string();
    let args = [
        "touch",
        &scene,
        "--quiet",
        "--arm",
        "--wearer",
        "anna",
        "--seconds",
        "6",
        "--device",
        "null:right",
    ];
    let trips = folder.0.display().to_string();
    let mut process = thenar(&[&args[..], &["--device", &address, "--trips", &trips]].concat())
        .env("THENAR_CONFIG", &folder.0)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut most = [0.0_f64; 5];
    while process.try_wait().unwrap().is_none() {
        let now = grasp.unit.tendons().0;
        most = std::array::from_fn(|k| most[k].max(now[k]));
        std::thread::sleep(std::time::Duration::from_micros(300));
    }
    let output = process.wait_with_output().unwrap();
    assert!(text(&output).contains("at most 0.30 0.20 0.30 0.30 0.30 N"), "{}", text(&output));
    assert!(most[1] > 0.1 && most[1] <= 0.2 + 1e-6, "{most:?}: {}", text(&output));
    assert!(most.iter().all(|n| *n <= 0.3 + 1e-6), "{most:?}");
}
