//! The other end: what a bridge implements, and a simulated unit.

use super::{ANSWER_MARK, COMMAND, COMMAND_MARK};
use crate::DIGITS;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpListener;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use thenar_touch::{CYBERGRASP_FORCE_MAX, tendon_pull};

/// Without a command for so long, all tendons are released.
pub const UNIT_SILENCE: Duration = Duration::from_millis(20);

/// A CyberGrasp's control unit, as its maker's library shows it.
pub trait GraspUnit {
    /// Pulls each tendon with this force \[N\], 0 to 12, thumb first. Returns within a
    /// millisecond.
    ///
    /// # Errors
    /// The unit is gone: the bridge closes the connection, and the program outside says so.
    fn pull(&mut self, forces: [f64; DIGITS]) -> io::Result<()>;
}

/// Serves a unit to one host after the other until `stop`; releases the tendons when a host goes
/// or falls silent.
///
/// # Errors
/// The listener fails, or the unit is gone.
pub fn serve_unit(
    listener: &TcpListener,
    unit: &mut dyn GraspUnit,
    stop: &AtomicBool,
) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    while !stop.load(Ordering::Acquire) {
        match listener.accept() {
            Ok((stream, _)) => {
                let served = serve_host(stream, unit, stop);
                unit.pull([0.0; DIGITS])?;
                // A host that goes is no failure of the unit's.
                drop(served);
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                std::thread::sleep(Duration::from_millis(1));
            }
            Err(error) => return Err(error),
        }
    }
    unit.pull([0.0; DIGITS])
}

fn serve_host(
    mut stream: std::net::TcpStream,
    unit: &mut dyn GraspUnit,
    stop: &AtomicBool,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_nonblocking(true)?;
    let (mut bytes, mut buffer) = (Vec::new(), [0; 4096]);
    let (mut commanded, mut pulling) = (Instant::now(), false);
    while !stop.load(Ordering::Acquire) {
        match stream.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(received) => bytes.extend_from_slice(&buffer[..received]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {
                std::thread::sleep(Duration::from_micros(200));
            }
            Err(error) => return Err(error),
        }
        while bytes.len() >= COMMAND {
            let Some(forces) = read(&bytes[..COMMAND]) else {
                return Err(ErrorKind::InvalidData.into());
            };
            unit.pull(forces)?;
            (commanded, pulling) = (Instant::now(), true);
            let answer = [ANSWER_MARK.as_slice(), &bytes[4..8]].concat();
            stream.write_all(&answer)?;
            bytes.drain(..COMMAND);
        }
        if pulling && commanded.elapsed() > UNIT_SILENCE {
            unit.pull([0.0; DIGITS])?;
            pulling = false;
        }
    }
    Ok(())
}

/// A command's forces; nothing but pulls within the rating leaves here.
fn read(bytes: &[u8]) -> Option<[f64; DIGITS]> {
    let (mark, rest) = bytes.split_first_chunk()?;
    if mark != COMMAND_MARK {
        return None;
    }
    let mut forces = [0.0; DIGITS];
    for (force, bytes) in forces.iter_mut().zip(rest[4..].chunks_exact(4)) {
        let wanted = f32::from_le_bytes(bytes.try_into().ok()?);
        *force = tendon_pull(f64::from(wanted), CYBERGRASP_FORCE_MAX);
    }
    Some(forces)
}

/// A unit that only remembers. Clones show the same tendons.
#[derive(Clone, Debug, Default)]
pub struct SimulatedUnit {
    tendons: Arc<Mutex<([f64; DIGITS], u64)>>,
}

impl SimulatedUnit {
    /// Forces now \[N\], and how many commands came.
    pub fn tendons(&self) -> ([f64; DIGITS], u64) {
        *self.tendons.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl GraspUnit for SimulatedUnit {
    fn pull(&mut self, forces: [f64; DIGITS]) -> io::Result<()> {
        let mut tendons = self.tendons.lock().unwrap_or_else(PoisonError::into_inner);
        *tendons = (forces, tendons.1 + 1);
        Ok(())
    }
}
