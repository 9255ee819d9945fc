//! A bridge between Thenar and a CyberGrasp: the small program that owns the maker's library.
//!
//! `cargo run -p thenar-link --example cybergrasp_bridge [HOST:PORT]`, by default 127.0.0.1:7070;
//! `thenar touch` and `thenar serve` reach it by `--device cybergrasp:HOST:PORT?side=right`. This
//! one has no library: it prints what each tendon would pull. Put the maker's call into
//! [`Printed::pull`].

use std::io::{self, Write};
use std::net::TcpListener;
use std::sync::atomic::AtomicBool;
use thenar_link::cybergrasp::{GraspUnit, serve_unit};

/// A unit that prints a line per change, thumb first \[N\].
pub struct Printed<W> {
    /// Where lines go.
    pub to: W,
    /// What was pulled last, in hundredths of a newton.
    pub last: Option<[i32; 5]>,
}

impl<W: Write> GraspUnit for Printed<W> {
    fn pull(&mut self, forces: [f64; 5]) -> io::Result<()> {
        // Forces are between 0 and 12 N here, whatever came over the network, and zero after 20 ms
        // without a command. The maker's call belongs here; it must return within a millisecond,
        // and its failure ends the bridge.
        let hundredths = forces.map(|force| (100.0 * force).round() as i32);
        if self.last.replace(hundredths) != Some(hundredths) {
            let [thumb, index, middle, ring, little] = forces;
            writeln!(self.to, "{thumb:.2} {index:.2} {middle:.2} {ring:.2} {little:.2}")?;
        }
        Ok(())
    }
}

/// Serves until the process ends.
#[allow(dead_code)] // tests serve by themselves
fn main() -> io::Result<()> {
    let place = std::env::args().nth(1).unwrap_or_else(|| "127.0.0.1:7070".into());
    let listener = TcpListener::bind(&place)?;
    eprintln!("a CyberGrasp's bridge at {place}");
    let mut unit = Printed { to: io::stdout(), last: None };
    serve_unit(&listener, &mut unit, &AtomicBool::new(false))
}
