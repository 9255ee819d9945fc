//! Cost of the live page: bytes and time of its messages, and how late a pose shows.

use super::samples::Samples;
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};
use thenar_scene::session::{Session, builtin};
use thenar_serve::http::{self, Port, Reach, RequestLimits, Server};
use thenar_serve::hub::{ClientId, Event, Hub};
use thenar_serve::live::{Live, Options, SceneSource};
use thenar_serve::protocol::{Pace, Snapshots, kind, model};
use tungstenite::{Message, WebSocket};

/// Bytes and time of the live page's messages, and how late a pose shows.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene, one that comes with the program.
    #[arg(long, default_value = "bread-grasp")]
    scene: String,
    /// Time steps at which the latency is measured [s].
    #[arg(long, value_delimiter = ',', default_values_t = [1.0 / 60.0, 0.01, 0.005])]
    time_step: Vec<f64>,
    /// Poses sent for each.
    #[arg(long, default_value_t = 300)]
    poses: u32,
}

/// Time between poses \[s\]: 90 Hz, as headsets track.
const POSE_EVERY: f64 = 1.0 / 90.0;
/// A pose that shows no sooner is given up \[s\].
const GIVEN_UP: Duration = Duration::from_secs(1);

/// Prints the tables.
pub fn run(args: &Args) -> Result<(), String> {
    messages(args)?;
    latency(args)
}

fn messages(args: &Args) -> Result<(), String> {
    let name = &args.scene;
    let scene = builtin(name).ok_or(format!("no scene is named `{name}`"))?;
    let mut session =
        Session::from_text(scene.text, Path::new(name), &[]).map_err(|e| e.to_string())?;
    let timed = Instant::now();
    let model = model(&session, name, 1).map_err(|e| e.to_string())?;
    let model_ms = timed.elapsed().as_secs_f64() * 1e3;

    let mut snapshots = Snapshots::default();
    let (mut bytes, mut write, mut energy) =
        (Samples::default(), Samples::default(), Samples::default());
    let (mut contacts, steps) = (0, session.steps_wanted());
    for _ in 0..steps {
        session.step(&mut ());
        let start = Instant::now();
        let energies = session.world().energy(session.input());
        let between = Instant::now();
        let length = snapshots.write(&session, &Pace { energy: energies, ..Pace::default() }).len();
        write.push(between.elapsed().as_secs_f64() * 1e6);
        energy.push((between - start).as_secs_f64() * 1e6);
        bytes.push(length as f64);
        contacts = contacts.max(session.report().contacts_active);
    }

    let world = session.world();
    println!(
        "{name}: {} rigid bodies, {} nodes, up to {contacts} active contacts, {steps} steps",
        world.desc().rigids.len(),
        world.state().x.len(),
    );
    println!("model message {:.2} MB, made in {model_ms:.0} ms", model.len() as f64 / 1e6);
    println!();
    println!("{:<34} {:>10} {:>10} {:>10} {:>10}", "snapshot", "goal", "median", "p99", "max");
    let row = |what: &str, goal: &str, s: &mut Samples| {
        let [median, p99, max] = [0.5, 0.99, 1.0].map(|part| s.quantile(part));
        println!("{what:<34} {goal:>10} {median:>10.1} {p99:>10.1} {max:>10.1}");
    };
    row("length [bytes]", "< 10000", &mut bytes);
    row("writing it [us]", "< 50", &mut write);
    row("energies in it [us]", "-", &mut energy);
    println!();
    Ok(())
}

fn latency(args: &Args) -> Result<(), String> {
    println!(
        "{:<34} {:>10} {:>10} {:>10} {:>10}",
        "pose to the snapshot with it [ms]", "goal", "median", "p99", "max"
    );
    for h in &args.time_step {
        let options = Options { overrides: vec![format!("time_step={h}")], ..Options::default() };
        let source = SceneSource::Builtin(args.scene.clone());
        let (_live, hub) = Live::start(&source, options).map_err(|e| e.to_string())?;
        let goal = format!("< {:.1}", h * 1e3 + 5.0);
        let row = |way: &str, mut late: Samples| {
            let [median, p99, max] = [0.5, 0.99, 1.0].map(|part| late.quantile(part));
            let what = format!("step {:.2} ms, {way}", h * 1e3);
            println!("{what:<34} {goal:>10} {median:>10.2} {p99:>10.2} {max:>10.2}");
        };
        row("in process", waits(&mut InProcess::new(&hub)?, args.poses)?);
        row("loopback socket", waits(&mut Socket::new(hub)?, args.poses)?);
    }
    Ok(())
}

/// A way to the simulation.
trait PosePath {
    fn send(&mut self, pose: Vec<u8>) -> Result<(), String>;
    /// Number of the newest pose that acts, as soon as there is news.
    fn acting(&mut self) -> Result<u32, String>;
}

/// Times between sending poses and seeing them act \[ms\].
fn waits(way: &mut dyn PosePath, poses: u32) -> Result<Samples, String> {
    let mut late = Samples::default();
    for number in 1..=poses {
        let sent = Instant::now();
        way.send(pose(number))?;
        while way.acting()? < number {
            if sent.elapsed() > GIVEN_UP {
                return Err(format!("pose {number} does not show"));
            }
        }
        late.push(sent.elapsed().as_secs_f64() * 1e3);
        // Not in step with the simulation: the golden ratio spreads the phases.
        let spread = (f64::from(number) * 0.618_034).fract();
        std::thread::sleep(Duration::from_secs_f64(POSE_EVERY * spread));
    }
    Ok(late)
}

/// Number of the newest pose that acts, from a snapshot.
fn acting(snapshot: &[u8]) -> u32 {
    snapshot.get(56..60).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
}

/// Through the hub.
struct InProcess(Hub);

impl InProcess {
    const ME: ClientId = ClientId(u32::MAX);

    fn new(hub: &Hub) -> Result<Self, String> {
        hub.submit(Event::Joined(Self::ME)).map_err(|e| e.to_string())?;
        Ok(Self(hub.clone()))
    }
}

impl PosePath for InProcess {
    fn send(&mut self, pose: Vec<u8>) -> Result<(), String> {
        self.0.submit(Event::Binary(Self::ME, pose.into())).map_err(|e| e.to_string())
    }

    fn acting(&mut self) -> Result<u32, String> {
        std::thread::sleep(Duration::from_micros(50));
        Ok(acting(&self.0.snapshot.borrow()))
    }
}

impl Drop for InProcess {
    fn drop(&mut self) {
        // Should the simulation have ended, there is nothing to leave.
        let _ = self.0.submit(Event::Left(Self::ME));
    }
}

/// Through a server on loopback.
struct Socket {
    socket: WebSocket<TcpStream>,
    _server: Server,
}

impl Socket {
    fn new(hub: Hub) -> Result<Self, String> {
        let options = http::Options {
            reach: Reach::Loopback,
            address: None,
            port: Port::Exactly(0),
            limits: RequestLimits::default(),
        };
        let server = Server::start(&options, hub).map_err(|e| e.to_string())?;
        let stream = TcpStream::connect(server.address()).map_err(|e| e.to_string())?;
        stream.set_nodelay(true).map_err(|e| e.to_string())?;
        let url = format!("ws://{}/live", server.address());
        let (socket, _) = tungstenite::client(url, stream).map_err(|e| e.to_string())?;
        Ok(Self { socket, _server: server })
    }
}

impl PosePath for Socket {
    fn send(&mut self, pose: Vec<u8>) -> Result<(), String> {
        self.socket.send(Message::binary(pose)).map_err(|e| e.to_string())
    }

    fn acting(&mut self) -> Result<u32, String> {
        match self.socket.read().map_err(|e| e.to_string())? {
            Message::Binary(bytes) if bytes.first() == Some(&kind::SNAPSHOT) => Ok(acting(&bytes)),
            _ => Ok(0),
        }
    }
}

/// A pose message: the right hand held out flat, swaying.
fn pose(number: u32) -> Vec<u8> {
    let t = f64::from(number) * POSE_EVERY;
    let mut bytes = vec![17, 1, 1, 0];
    bytes.extend(number.to_le_bytes());
    bytes.extend(t.to_le_bytes());
    let wrist = [0.05 * t.sin(), 0.2, 0.05, 0.0, 0.0, 0.0, 1.0];
    wrist.into_iter().chain([0.1; 20]).for_each(|x| bytes.extend((x as f32).to_le_bytes()));
    bytes
}
