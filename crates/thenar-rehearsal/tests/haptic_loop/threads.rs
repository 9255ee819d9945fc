//! The loop on its own threads: every way out sends zeros.

use crate::rig::{MS, PRESS, SCENE, Wearer, blocked, devices_within, limits, session};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use thenar_core::Pose;
use thenar_link::haptic_loop::{HapticLoop, Remote, Settings, State};
use thenar_link::{Rendering, now_ns};
use thenar_touch::safety::Limits;
use thenar_track::ANGLES;
use thenar_track::live::LivePose;

/// Longest that anything may take on a busy machine before a test gives up.
const PATIENCE: Duration = Duration::from_secs(30);

/// Limits that a busy machine does not reach by being busy: what is tested here is brought about.
fn patient() -> Limits {
    Limits {
        ramp: 0.02,
        gap_hold: GAP.as_secs_f64(),
        gap_max: GAP.as_secs_f64(),
        simulation_hold: 0.3,
        tracking_hold: 0.3,
        device_silence_max: 0.3,
        speed_max: 100.0,
        ..limits()
    }
}

/// A loop that stands still for longer trips.
const GAP: Duration = Duration::from_millis(300);

fn until(what: &str, mut done: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !done() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A wearer that presses, and a simulation that holds the hand where it is.
struct World {
    wearer: Wearer,
    device: Arc<Mutex<Option<HapticLoop>>>,
    remote: Remote,
    flexion: Arc<Mutex<f64>>,
    run: Arc<AtomicBool>,
    simulation: Arc<Mutex<Simulation>>,
    threads: Vec<JoinHandle<()>>,
}

/// What the simulation does.
#[derive(Clone, Copy, PartialEq)]
enum Simulation {
    Steps,
    Stands,
    Panics,
}

impl World {
    /// Armed and pressing.
    fn pressing(folder: Option<std::path::PathBuf>) -> Self {
        let (wearer, tracker, display) = devices_within(patient(), Rendering::Tendons);
        let settings = Settings { trip_folder: folder, ..blocked() };
        let device = HapticLoop::start(settings, vec![tracker], vec![display]).expect("a loop");
        let remote = device.remote();
        let mut world = Self {
            wearer,
            device: Arc::new(Mutex::new(Some(device))),
            remote,
            flexion: Arc::new(Mutex::new(0.0)),
            run: Arc::new(AtomicBool::new(true)),
            simulation: Arc::new(Mutex::new(Simulation::Steps)),
            threads: Vec::new(),
        };
        let (wrist, rest) = world.simulate();
        let (run, wearer, flexion) =
            (world.run.clone(), world.wearer.clone(), world.flexion.clone());
        let glove = move || {
            while run.load(Ordering::Relaxed) {
                let mut angles = rest;
                angles[4] += *flexion.lock().unwrap();
                let now = now_ns();
                wearer.alive(now);
                wearer.say(now, Some(LivePose::Angles { wrist, angles }));
                std::thread::sleep(Duration::from_millis(2));
            }
        };
        world.threads.push(std::thread::spawn(glove));
        world.press_again();
        world
    }

    /// Starts a simulation; where its hand is.
    fn simulate(&mut self) -> (Pose, [f64; ANGLES]) {
        let mut port = self.device.lock().unwrap().as_ref().unwrap().port();
        let mut session = session(SCENE);
        port.attach(&session).expect("a hand");
        let hand = &session.hands()[0];
        let wrist: Pose = session.world().rigid_pose(hand.handle.bones.start) * hand.wrist_B();
        let rest = hand.angles().map(|range| range.map_or(0.0, |range| range.rest));
        self.does(Simulation::Steps);
        let (run, simulation) = (self.run.clone(), self.simulation.clone());
        self.threads.push(std::thread::spawn(move || {
            while run.load(Ordering::Relaxed) {
                let does = *simulation.lock().unwrap();
                match does {
                    Simulation::Steps => {
                        port.before_step(&mut session, now_ns()).expect("hands as before");
                        port.after_step(&mut session, now_ns());
                    }
                    Simulation::Stands => (),
                    Simulation::Panics => panic!("put in by the test"),
                }
                std::thread::sleep(Duration::from_millis(4));
            }
        }));
        (wrist, rest)
    }

    fn does(&self, what: Simulation) {
        *self.simulation.lock().unwrap() = what;
    }

    /// Arms, opens, waits for full force to be allowed, and presses.
    fn press_again(&self) {
        *self.flexion.lock().unwrap() = 0.0;
        until("full force", || self.allowed());
        // A busy machine may stop or pause the forces on the way: they come back to an open hand
        // only.
        until("a force", || {
            let press = if self.allowed() { PRESS } else { 0.0 };
            *self.flexion.lock().unwrap() = press;
            self.force() > 0.2
        });
    }

    /// Arms what is stopped; whether full force is allowed.
    fn allowed(&self) -> bool {
        let state = self.remote.status().state;
        if matches!(state, State::DryRun | State::Tripped(_)) {
            self.remote.arm();
            std::thread::sleep(Duration::from_millis(50));
        }
        state == State::Live
    }

    fn force(&self) -> f64 {
        let shown = self.wearer.shown.lock().unwrap();
        shown.outputs.last().map_or(0.0, |output| output.digits[1].pad_force)
    }

    fn mischief(&self, mischief: impl FnOnce() + Send + 'static) {
        let mut said = self.wearer.said.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        said.mischief = Some(Box::new(mischief));
    }
}

impl Drop for World {
    fn drop(&mut self) {
        self.run.store(false, Ordering::Relaxed);
        // One of them may have been made to panic.
        self.threads.drain(..).for_each(|thread| _ = thread.join());
    }
}

#[test]
fn the_end_of_the_loop_sends_zeros_and_closes_the_device() {
    let world = World::pressing(None);
    drop(world.device.lock().unwrap().take());
    assert_eq!(world.force(), 0.0);
    assert!(world.wearer.shown.lock().unwrap().dropped);
}

/// The watchdog speaks while the loop stands still: zeros are there before the loop moves again.
#[test]
fn a_loop_that_stands_still_is_taken_over_and_says_so() {
    let folder = std::env::temp_dir().join(format!("thenar-stall-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let world = World::pressing(Some(folder.clone()));
    let barks = world.remote.status().barks;
    let (go_on, waiting) = std::sync::mpsc::channel::<()>();
    world.mischief(move || {
        let _ = waiting.recv_timeout(PATIENCE);
    });
    until("zeros from the watchdog", || world.force() == 0.0);
    std::thread::sleep(GAP);
    go_on.send(()).unwrap();
    until("the trip", || matches!(world.remote.status().state, State::Tripped(_)));
    assert_eq!(world.force(), 0.0);
    until("its message", || {
        let told = world.remote.status();
        told.barks > barks && told.messages.iter().any(|m| m.contains("stood still"))
    });
    // The last seconds are written down, up to the trip.
    let files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|f| f.unwrap().path()).collect();
    let (incidents, files): (Vec<_>, Vec<_>) =
        files.into_iter().partition(|file| file.extension().is_some_and(|e| e == "touch"));
    assert_eq!(incidents.len(), files.len(), "what entered is kept beside the signals");
    let texts: Vec<_> = files.iter().map(|f| std::fs::read_to_string(f).unwrap()).collect();
    assert!(texts.iter().any(|text| {
        text.starts_with("# forces stopped: the haptic loop stood still")
            && text.lines().any(|line| line.contains(",live,"))
            && text.lines().any(|line| line.contains(",tripped,"))
    }));
    std::fs::remove_dir_all(&folder).unwrap();
    world.press_again();
}

#[test]
fn a_panic_in_the_loop_sends_zeros_and_is_told() {
    let world = World::pressing(None);
    world.mischief(|| panic!("put in by the test"));
    until("the end of the loop", || world.remote.status().state == State::Failed);
    until("zeros", || world.force() == 0.0);
}

#[test]
fn a_simulation_that_ends_fades_and_comes_back() {
    let world = World::pressing(None);
    world.does(Simulation::Stands);
    until("zero", || world.force() == 0.0);
    until("the reason", || {
        matches!(world.remote.status().state, State::Waiting(why) if why.contains("simulation"))
            || matches!(world.remote.status().state, State::Tripped(_))
    });
    // Its message stays, whatever comes after.
    until("the message", || {
        let told = world.remote.status().messages;
        told.iter().any(|m| m.starts_with("forces paused") || m.starts_with("forces stopped"))
    });
    world.does(Simulation::Steps);
    world.press_again();
}

/// The loop goes on without it, and feels the next one.
#[test]
fn a_simulation_that_panics_fades_and_another_takes_its_place() {
    let mut world = World::pressing(None);
    let begun = world.wearer.shown.lock().unwrap().outputs.len();
    let barks = world.remote.status().barks;
    world.does(Simulation::Panics);
    until("zero", || world.force() == 0.0);
    until(
        "the reason",
        || matches!(world.remote.status().state, State::Waiting(why) if why.contains("simulation")),
    );
    let ticks = world.remote.status().ticks;
    until("ticks", || world.remote.status().ticks > ticks + 20);
    // No jump on the way down, unless the machine was so busy that the watchdog spoke.
    let (limits, barked) = (patient(), world.remote.status().barks > barks);
    for pair in world.wearer.shown.lock().unwrap().outputs[begun..].windows(2) {
        let dt = (pair[1].time_ns - pair[0].time_ns) as f64 * 1e-9;
        let change = pair[1].digits[1].pad_force - pair[0].digits[1].pad_force;
        let slewed = change.abs() <= limits.change_max(dt) + 1e-9;
        assert!(slewed || barked && pair[1].digits[1].pad_force == 0.0, "{change} N in {dt} s");
    }
    world.simulate();
    world.press_again();
}

#[test]
fn stop_acts_without_the_simulation() {
    let world = World::pressing(None);
    // A busy machine may stall the loop just before, and the first reason stays.
    until("the trip", || {
        world.does(Simulation::Steps);
        world.press_again();
        world.does(Simulation::Stands);
        world.remote.stop();
        until("zero", || world.force() == 0.0);
        until("some trip", || matches!(world.remote.status().state, State::Tripped(_)));
        world.remote.status().state == State::Tripped("stop was asked for".into())
    });
    assert!(world.remote.status().ticks > 0 && now_ns() > MS);
}
