//! Ports of this computer that a test opens by number.

use std::sync::atomic::{AtomicU16, Ordering};

/// Blocks of ports, of which a process uses one.
const BLOCKS: u32 = 100;
/// Ports per block.
const BLOCK: u16 = 120;

/// Port that no other test of this process is given, and none that a system hands out by itself:
/// below where Linux (32 768), macOS and Windows (49 152) begin. It is not tried with a socket: a
/// program that starts at that moment would hold a copy of the socket, and so the port, until its
/// own code runs. Where some other program listens there, the test fails.
pub fn free_port() -> u16 {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let next = NEXT.fetch_add(1, Ordering::Relaxed);
    assert!(next < BLOCK, "a test process has {BLOCK} ports");
    20_000 + (std::process::id() % BLOCKS) as u16 * BLOCK + next
}
