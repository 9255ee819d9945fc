//! Goal: every driver of the registry keeps what drivers promise, and none is forgotten. Method:
//! one suite over `thenar_link::drivers()`, each device a simulated one at a place of its own. A
//! driver that is not in [`stand`] fails it: whoever adds one adds its stand here, and what is
//! particular to it in a test of its own, as `lucidgloves.rs` or `streams.rs`.

use crate::conformance::{opened_at_a_free_port, wait};
use std::collections::HashSet;
use std::path::PathBuf;
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_link::twin::{SIMULATIONS, Simulation};
use thenar_link::{Driver, HandOutput, LinkError, Opened, drivers, now_ns};
use thenar_testing::free_port;
use thenar_track::live::checked;

/// How a driver is tried.
struct Stand {
    /// An address that opens.
    address: String,
    /// What stands behind it, if that must be started: a name of [`SIMULATIONS`] and its place.
    simulated: Option<(&'static str, String)>,
    /// It has a line that may be away, and is told of by name.
    has_line: bool,
    /// It tracks, and it shows.
    is: [bool; 2],
    /// Addresses that it refuses.
    bad: &'static [&'static str],
}

fn simulated(driver: &dyn Driver, is: [bool; 2], bad: &'static [&'static str]) -> Stand {
    let name = driver.name();
    let kind = SIMULATIONS.iter().find(|kind| kind.name == name).expect("a simulated device");
    assert_eq!(kind.driver, name);
    let place = match kind.place {
        Some(_) => format!("127.0.0.1:{}", free_port()),
        None => {
            let file = format!("thenar-every-{name}-{}", std::process::id());
            std::env::temp_dir().join(file).display().to_string()
        }
    };
    let simulated = Some((kind.name, place.clone()));
    Stand { address: place, simulated, has_line: true, is, bad }
}

/// A driver's stand. None has none.
fn stand(driver: &dyn Driver) -> Stand {
    let plain = |address: &str, is, bad| Stand {
        address: address.into(),
        simulated: None,
        has_line: false,
        is,
        bad,
    };
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/hands.jsonl");
    match driver.name() {
        "null" => Stand { has_line: true, ..plain("right", [true, true], &["middle"]) },
        "lucidgloves" => simulated(driver, [true, true], &["/dev/x?side=up", "/dev/x?color=red"]),
        "cyberglove" | "cyberglove3" => simulated(driver, [true, false], &["/dev/x?wrist=nobody:"]),
        "cybergrasp" => simulated(driver, [false, true], &["here", "127.0.0.1:99999"]),
        "hts" => simulated(driver, [true, false], &["tcp:x", "call:there:99999", "9000?points=up"]),
        "poses" => simulated(driver, [true, false], &["9010?side=left", "/no/such/file.jsonl"]),
        "force-device" => simulated(driver, [true, true], &["here:99999", "omni@127.0.0.1:9020"]),
        "bhaptics" => simulated(driver, [false, true], &["127.0.0.1:99999"]),
        "replay" => plain(
            &format!("{recording}?loop=yes&speed=50"),
            [true, false],
            &["/no/such/file.jsonl", "x?speed=0"],
        ),
        "either" => Stand {
            has_line: true,
            ..plain("null:left||null:right", [true, true], &["null:left", "null:left||nobody:"])
        },
        "fault" => Stand {
            has_line: true,
            ..plain("1:null:right", [true, true], &["null:right", "1:nobody:"])
        },
        // With a runtime behind it: `openxr-trial`.
        "openxr" => Stand {
            has_line: true,
            ..plain("/nowhere/libopenxr_loader.so.1", [true, false], &["7", "loader.so"])
        },
        other => panic!("driver `{other}` passes no conformance suite: give it a stand here"),
    }
}

/// All at once: they mostly wait.
#[test]
fn every_driver_keeps_what_drivers_promise() {
    std::thread::scope(|scope| {
        for driver in drivers() {
            scope.spawn(move || {
                let stand = stand(&*driver);
                is_named_and_described(&*driver);
                refuses_what_makes_no_sense(&*driver, &stand);
                opens_tells_and_lets_go(&*driver, &stand);
            });
        }
    });
}

/// A person can find it, and its address is no other's.
fn is_named_and_described(driver: &dyn Driver) {
    let name = driver.name();
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    assert!(!name.is_empty() && name.chars().all(plain), "{name}");
    let about = driver.about();
    assert!(about.contains(&format!("{name}:")) && !about.contains('\n'), "{name}: {about}");
    assert!(about.len() < 200, "{name}: {about}");
    for found in driver.enumerate() {
        assert!(found.address.starts_with(&format!("{name}:")), "{found:?}");
    }
}

#[test]
fn every_name_is_one_drivers_and_in_the_documents() {
    let names: Vec<_> = drivers().iter().map(|driver| driver.name()).collect();
    let once: HashSet<_> = names.iter().collect();
    assert_eq!(once.len(), names.len(), "{names:?}");
    let documents = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/devices.md");
    let text = std::fs::read_to_string(documents).unwrap();
    for name in names.into_iter().filter(|name| *name != "null") {
        assert!(text.contains(&format!("`{name}:`")), "docs/devices.md does not tell of {name}");
    }
}

/// At once, by an error that names the address and the cause.
fn refuses_what_makes_no_sense(driver: &dyn Driver, stand: &Stand) {
    assert!(!stand.bad.is_empty());
    for bad in stand.bad {
        match driver.open(bad) {
            Err(LinkError::Setting { what, cause }) => {
                assert!(!what.is_empty() && !cause.is_empty(), "{}:{bad}", driver.name());
            }
            Err(other) => panic!("{}:{bad}: {other}", driver.name()),
            Ok(_) => panic!("{}:{bad} opens", driver.name()),
        }
    }
}

/// Opened before it is there; taken up when it comes; poses are sound and times go on; what is
/// shown is felt and let go of. Then the same once more.
fn opens_tells_and_lets_go(driver: &dyn Driver, stand: &Stand) {
    let name = driver.name();
    let open = || opened_at_a_free_port(|| driver.open(&stand.address));
    let mut opened = open();
    assert_eq!([opened.tracker.is_some(), opened.display.is_some()], stand.is, "{name}");
    if stand.simulated.is_some() {
        // A datagram socket is open without a partner: only some can tell that nobody is there.
        assert!(opened.tracker.as_mut().is_none_or(|t| t.heard_ns().is_none()), "{name}");
        assert!(opened.display.as_mut().is_none_or(|d| d.heard_ns().is_none()), "{name}");
    }
    for _ in 0..2 {
        let device = start(stand);
        if name == "openxr" {
            is_told_of_by_name(name, &mut opened);
            return;
        }
        let presence = || -> Vec<_> {
            let of_tracker = opened.tracker.iter().map(|tracker| tracker.presence_check());
            let of_display = opened.display.iter().map(|display| display.presence_check());
            of_tracker.chain(of_display).flat_map(|mut look| look()).collect()
        };
        if stand.has_line {
            wait(&format!("{name}'s presence"), || {
                let all = presence();
                (!all.is_empty() && all.iter().any(|one| one.connected)).then_some(())
            });
        }
        if opened.tracker.is_some() {
            tells_sound_poses(name, &mut opened);
        }
        if opened.display.is_some() {
            is_felt_and_let_go(name, &mut opened, device.as_deref());
        }
        if stand.simulated.is_some() {
            is_told_of_by_name(name, &mut opened);
        }
        drop((opened, device));
        opened = open();
    }
}

fn start(stand: &Stand) -> Option<Box<dyn Simulation>> {
    let (name, place) = stand.simulated.as_ref()?;
    let kind = SIMULATIONS.iter().find(|kind| kind.name == *name)?;
    let _ = std::fs::remove_file(PathBuf::from(place));
    // A port of the one before may be busy for a moment.
    Some(wait("its place", || kind.start(place).ok()))
}

/// Each sample once, newer than the one before, not from the future, and a hand nearby.
fn tells_sound_poses(name: &str, opened: &mut Opened) {
    let Some(tracker) = &mut opened.tracker else { return };
    let (mut last, mut seen) = ([0; 2], 0);
    while seen < 8 {
        wait(&format!("a sample of {name}"), || {
            let mut new = None;
            for side in [Side::Left, Side::Right] {
                let Some(sample) = tracker.latest(side) else { continue };
                let now = now_ns();
                assert_eq!(sample.side, side, "{name}");
                // What goes wrong as planned may do so.
                if name != "fault" {
                    assert!(
                        sample.time_ns > last[side as usize] && sample.time_ns <= now,
                        "{name}"
                    );
                    let sound = sample.pose.as_ref().is_none_or(|pose| checked(0.0, pose).is_ok());
                    assert!(sound, "{name}: {sample:?}");
                }
                last[side as usize] = sample.time_ns;
                new = Some(());
            }
            new
        });
        seen += 1;
    }
    assert!(tracker.heard_ns().is_some_and(|ns| ns <= now_ns()), "{name}");
    assert!(tracker.hand_length().is_none_or(|length| (0.1..0.3).contains(&length)), "{name}");
}

/// Until outputs stop. Limits and stiffness are those of something.
fn is_felt_and_let_go(name: &str, opened: &mut Opened, device: Option<&dyn Simulation>) {
    let Some(display) = &mut opened.display else { return };
    let (limits, profile) = (display.limits(), display.loop_profile());
    assert!(limits.rated > 0.0 && limits.rated.is_finite(), "{name}");
    assert!(profile.period > 0.0 && profile.rated_stiffness > 0.0, "{name}");
    let Some(device) = device else { return };
    let free = device.felt();
    let mut output = HandOutput::released(Side::Right, 0);
    for digit in &mut output.digits {
        digit.pad_force = 4.0;
        digit.curl_at_contact = Some(0.25);
    }
    output.force_W = Vec3::new(0.0, 2.0, 0.0);
    wait(&format!("what {name} shows"), || {
        output.time_ns = now_ns();
        display.show(&output);
        (device.felt() != free).then_some(())
    });
    wait(&format!("release of {name}"), || (device.felt() == free).then_some(()));
}

/// Whatever is told begins with the device's name, and is told once.
fn is_told_of_by_name(name: &str, opened: &mut Opened) {
    let mut ask = || -> Vec<String> {
        let of_tracker = opened.tracker.iter_mut().flat_map(|tracker| tracker.messages());
        let mut all: Vec<_> = of_tracker.collect();
        all.extend(opened.display.iter_mut().flat_map(|display| display.messages()));
        all
    };
    let told = wait(&format!("a message of {name}"), || Some(ask()).filter(|m| !m.is_empty()));
    for text in &told {
        assert!(text.starts_with(&format!("{name}:")) && !text.contains('\n'), "{text}");
    }
}
