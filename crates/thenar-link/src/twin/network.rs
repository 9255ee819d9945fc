//! Simulated devices on the network, each in a thread of its own.

use super::hand;
use super::simulation::Simulation;
use crate::bhaptics::twin::{STATUS, SimulatedPlayer};
use crate::cybergrasp::{SimulatedUnit, serve_unit};
use crate::force_device::twin::SimulatedArm;
use crate::hand_tracking_streamer::{Points, twin};
use crate::{now_ns, pose_stream};
use std::io::{self, ErrorKind};
use std::net::{TcpListener, TcpStream, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_track::live::LivePose;
use tungstenite::{Message, WebSocket};

/// Between two looks of a device at its socket, and two states of an arm.
const TURN: Duration = Duration::from_millis(1);
/// Between two poses, as headsets have it.
const FRAME: Duration = Duration::from_millis(11);
/// A host has so long to greet a player.
const GREETING: Duration = Duration::from_secs(1);
/// Travel of an arm's handle to either side \[m\].
const REACH: f64 = 0.05;

/// A thread, and what it shares with a person.
struct Running<T> {
    state: Arc<Mutex<T>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

fn lock<T>(state: &Mutex<T>) -> MutexGuard<'_, T> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<T: Send + 'static> Running<T> {
    /// Runs until it is dropped; `run` looks at the flag at least every second.
    fn start(
        state: T,
        run: impl FnOnce(&Mutex<T>, &AtomicBool) + Send + 'static,
    ) -> io::Result<Self> {
        let (state, stop) = (Arc::new(Mutex::new(state)), Arc::new(AtomicBool::new(false)));
        let (shared, told) = (state.clone(), stop.clone());
        let thread = std::thread::Builder::new().name("twin".into()).spawn(move || {
            run(&shared, &told);
        })?;
        Ok(Self { state, stop, thread: Some(thread) })
    }
}

impl<T> Drop for Running<T> {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// An arm behind its bridge, listening at `place`. Its handle goes from side to side; from half-way
/// on its button is pressed.
///
/// # Errors
/// The port is taken.
pub fn arm(place: &str) -> io::Result<Box<dyn Simulation>> {
    let socket = UdpSocket::bind(place)?;
    socket.set_read_timeout(Some(TURN))?;
    let run = move |arm: &Mutex<SimulatedArm>, stop: &AtomicBool| {
        let (mut host, mut buffer) = (None, [0; 2000]);
        while !stop.load(Ordering::Acquire) {
            if let Ok((length, from)) = socket.recv_from(&mut buffer)
                && lock(arm).receive(now_ns(), &buffer[..length]).is_ok()
            {
                host = Some(from);
            }
            let state = lock(arm).state(now_ns());
            if let Some(host) = host {
                let _ = socket.send_to(&state, host);
            }
        }
    };
    Ok(Box::new(Running::start(SimulatedArm::new(), run)?))
}

impl Simulation for Running<SimulatedArm> {
    fn set_curls(&self, curls: [f64; 5]) {
        let mut arm = lock(&self.state);
        arm.pose = Pose::translation(REACH * (2.0 * curls[1] - 1.0), 0.0, 0.0);
        arm.buttons = u32::from(curls[1] > 0.5);
    }

    fn felt(&self) -> String {
        // Adding zero takes the sign from a zero.
        let force: Vec3 =
            lock(&self.state).force(now_ns()).map(|n| (n * 10.0).round() / 10.0 + 0.0);
        format!("{:.1} {:.1} {:.1} N", force.x, force.y, force.z)
    }
}

/// A CyberGrasp's control unit behind its bridge, listening at `place`.
///
/// # Errors
/// The port is taken.
pub fn tendons(place: &str) -> io::Result<Box<dyn Simulation>> {
    let listener = TcpListener::bind(place)?;
    let run = move |unit: &Mutex<SimulatedUnit>, stop: &AtomicBool| {
        let mut unit = lock(unit).clone();
        // It ends when the listener fails: then there is nobody to tell.
        let _ = serve_unit(&listener, &mut unit, stop);
    };
    Ok(Box::new(Running::start(SimulatedUnit::default(), run)?))
}

impl Simulation for Running<SimulatedUnit> {
    fn set_curls(&self, _: [f64; 5]) {}

    fn felt(&self) -> String {
        super::simulation::per_finger(lock(&self.state).tendons().0.map(|n| format!("{n:.1} N")))
    }
}

/// The player of vibrating gloves, listening at `place`.
///
/// # Errors
/// The port is taken.
pub fn player(place: &str) -> io::Result<Box<dyn Simulation>> {
    let listener = TcpListener::bind(place)?;
    listener.set_nonblocking(true)?;
    let run = move |player: &Mutex<SimulatedPlayer>, stop: &AtomicBool| {
        let mut host = None;
        while !stop.load(Ordering::Acquire) {
            // The newest host is heard.
            if let Ok((stream, _)) = listener.accept() {
                host = greeted(stream).ok().or(host);
            }
            match host.as_mut().map(WebSocket::read) {
                None => std::thread::sleep(TURN),
                // What is no request is left out.
                Some(Ok(Message::Text(text))) => _ = lock(player).receive(now_ns(), &text),
                Some(Ok(_)) => {}
                Some(Err(tungstenite::Error::Io(error))) if waits(&error) => {}
                Some(Err(_)) => host = None,
            }
        }
    };
    Ok(Box::new(Running::start(SimulatedPlayer::default(), run)?))
}

fn greeted(stream: TcpStream) -> Result<WebSocket<TcpStream>, Box<dyn std::error::Error>> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(GREETING))?;
    let mut host = tungstenite::accept(stream).map_err(|error| error.to_string())?;
    host.send(Message::text(STATUS))?;
    host.get_ref().set_read_timeout(Some(TURN))?;
    Ok(host)
}

fn waits(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

impl Simulation for Running<SimulatedPlayer> {
    fn set_curls(&self, _: [f64; 5]) {}

    fn felt(&self) -> String {
        let player = lock(&self.state);
        let of = |side| {
            super::simulation::per_finger(player.felt(side, now_ns()).map(|x| format!("{x}%")))
        };
        format!("left {}; right {}", of(Side::Left), of(Side::Right))
    }
}

/// Curls of a hand that only moves.
struct Curls([f64; 5]);

/// A tracker that sends both hands to `place`, in our own lines or as the app of headsets does.
///
/// # Errors
/// The system gives no socket, or knows no way there.
pub fn tracker(place: &str, streamer: bool) -> io::Result<Box<dyn Simulation>> {
    let socket = UdpSocket::bind("0.0.0.0:0")?;
    socket.connect(place)?;
    let run = move |curls: &Mutex<Curls>, stop: &AtomicBool| {
        let mut frame = 0;
        while !stop.load(Ordering::Acquire) {
            let (Curls(now), time_ns) = (Curls(lock(curls).0), now_ns());
            frame += 1;
            for (side, x) in [(Side::Left, -0.15), (Side::Right, 0.15)] {
                let joints = hand::joints(side, Pose::translation(x, 1.0, -0.2), now);
                let text = if streamer {
                    twin::lines(side, &joints, Points::Local, Some((frame, time_ns as i64)))
                } else {
                    let pose = LivePose::Joints { joints, radii: [0.008; 25] };
                    pose_stream::write(side, time_ns as f64 * 1e-9, Some(&pose))
                };
                // Whether anybody listens yet is not our concern.
                let _ = socket.send(text.as_bytes());
            }
            std::thread::sleep(FRAME);
        }
    };
    Ok(Box::new(Running::start(Curls([0.0; 5]), run)?))
}

impl Simulation for Running<Curls> {
    fn set_curls(&self, curls: [f64; 5]) {
        lock(&self.state).0 = curls;
    }

    fn felt(&self) -> String {
        "nothing".into()
    }
}
