//! Goal: CyberGrasp's tendons pull as told and let go on every way out. Method: a simulated unit
//! behind the bridge's own server, over a real socket.

#![cfg(unix)]

use crate::conformance::wait;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use thenar_core::model::Side;
use thenar_link::cybergrasp::{CyberGraspDriver, SimulatedUnit, serve_unit};
use thenar_link::{Driver, ForceDisplay, HandOutput, now_ns};

struct Bridge {
    unit: SimulatedUnit,
    port: u16,
    stop: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Bridge {
    fn start(port: u16) -> Self {
        let listener = wait("a port", || TcpListener::bind(("127.0.0.1", port)).ok());
        let port = listener.local_addr().unwrap().port();
        let (unit, stop) = (SimulatedUnit::default(), Arc::new(AtomicBool::new(false)));
        let (mut served, stopped) = (unit.clone(), stop.clone());
        let run = move || serve_unit(&listener, &mut served, &stopped).unwrap();
        Self { unit, port, stop, thread: Some(std::thread::spawn(run)) }
    }

    fn display(&self) -> Box<dyn ForceDisplay> {
        CyberGraspDriver.open(&format!("127.0.0.1:{}", self.port)).unwrap().display.unwrap()
    }

    fn released(&self, how: &str) {
        wait(how, || (self.unit.tendons().0 == [0.0; 5]).then_some(()));
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        let _ = self.thread.take().map(std::thread::JoinHandle::join);
    }
}

fn output(forces: [f64; 5]) -> HandOutput {
    let mut output = HandOutput::released(Side::Right, now_ns());
    output.digits.iter_mut().zip(forces).for_each(|(digit, force)| digit.pad_force = force);
    output
}

/// Pull only, half of twelve newtons at most as the profile says, and nothing for what is not a
/// number.
#[test]
fn tendons_pull_what_they_are_told_within_their_rating() {
    let bridge = Bridge::start(0);
    let mut display = bridge.display();
    let wanted = [3.5, -2.0, 40.0, f64::NAN, 12.0];
    wait("the pull", || {
        display.show(&output(wanted));
        (bridge.unit.tendons().0 == [3.5, 0.0, 6.0, 0.0, 6.0]).then_some(())
    });
    assert_eq!(display.limits().rated, 12.0);
    assert!(display.limits().unilateral);
    wait("the unit's answer", || display.heard_ns());
    bridge.released("silence");
    wait("the pull again", || {
        display.show(&output([1.0; 5]));
        (bridge.unit.tendons().0 == [1.0; 5]).then_some(())
    });
    drop(display);
    bridge.released("the drop");
}

/// Nobody said which hand wears it, and both press in turn: the tendons pull no more than the hand
/// that pressed first asks for, and a message says so.
#[test]
fn tendons_of_a_device_without_a_side_follow_one_hand() {
    let bridge = Bridge::start(0);
    let mut display = bridge.display();
    let press = |side: Side, force: f64| HandOutput { side, ..output([force; 5]) };
    wait("the right hand's pull", || {
        display.show(&press(Side::Right, 3.0));
        (bridge.unit.tendons().0 == [3.0; 5]).then_some(())
    });
    let told = wait("a message", || {
        display.show(&press(Side::Right, 3.0));
        display.show(&press(Side::Left, 5.0));
        assert!(bridge.unit.tendons().0[0] <= 3.0, "{:?} N", bridge.unit.tendons());
        display.messages().into_iter().find(|told| told.contains("the one that pressed first"))
    });
    assert!(told.contains("it holds one hand"), "{told}");
    // A tenth of a second of both hands in turn; the tendons may fall slack where this test did not
    // run for a while.
    for _ in 0..100 {
        display.show(&press(Side::Left, 5.0));
        display.show(&press(Side::Right, 3.0));
        std::thread::sleep(std::time::Duration::from_millis(1));
        assert!(bridge.unit.tendons().0[0] <= 3.0, "{:?} N", bridge.unit.tendons());
    }
}

/// The unit hears of us a thousand times a second even when nothing changes; the bridge's own
/// silence limit holds when the host is gone without a word.
#[test]
fn a_bridge_that_returns_is_taken_up_again() {
    let bridge = Bridge::start(0);
    let port = bridge.port;
    let mut display = bridge.display();
    wait("a hundred commands", || (bridge.unit.tendons().1 > 100).then_some(()));
    drop(bridge);
    wait("the loss", || display.messages().into_iter().find(|told| told.contains("is lost")));
    let bridge = Bridge::start(port);
    wait("the pull", || {
        display.show(&output([2.0; 5]));
        (bridge.unit.tendons().0 == [2.0; 5]).then_some(())
    });
}

#[test]
fn a_host_that_falls_silent_lets_go() {
    let bridge = Bridge::start(0);
    let mut host = std::net::TcpStream::connect(("127.0.0.1", bridge.port)).unwrap();
    let command = thenar_link::cybergrasp::command(1, &[5.0; 5]);
    std::io::Write::write_all(&mut host, &command).unwrap();
    wait("the pull", || (bridge.unit.tendons().1 >= 1).then_some(()));
    bridge.released("silence of the host");
}

#[path = "../../examples/cybergrasp_bridge.rs"]
mod bridge;

/// Lines of the example, for a test to read.
#[derive(Clone, Default)]
struct Lines(Arc<std::sync::Mutex<Vec<u8>>>);

impl std::io::Write for Lines {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// The bridge of the documents pulls what the driver says, and lets go when the driver is gone.
#[test]
fn the_example_of_a_bridge_pulls_and_lets_go() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let (lines, stop) = (Lines::default(), Arc::new(AtomicBool::new(false)));
    let (to, stopped) = (lines.clone(), stop.clone());
    let serve = move || {
        let mut unit = bridge::Printed { to, last: None };
        serve_unit(&listener, &mut unit, &stopped).unwrap();
    };
    let thread = std::thread::spawn(serve);
    let mut display = CyberGraspDriver.open(&format!("127.0.0.1:{port}")).unwrap().display.unwrap();
    let text = || String::from_utf8(lines.0.lock().unwrap().clone()).unwrap();
    wait("the pull", || {
        display.show(&output([0.5, 2.25, 0.0, 0.0, 40.0]));
        text().lines().any(|line| line == "0.50 2.25 0.00 0.00 6.00").then_some(())
    });
    drop(display);
    wait("slack tendons", || text().ends_with("0.00 0.00 0.00 0.00 0.00\n").then_some(()));
    stop.store(true, Ordering::Release);
    thread.join().unwrap();
}
