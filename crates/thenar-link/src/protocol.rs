//! Devices that speak in bytes: what is said, apart from how it travels.

use crate::{HandOutput, HandSample};
use std::io;

/// Event that a protocol makes of bytes.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant)] // handed over by value, one at a time: a box would allocate
pub enum Event {
    /// A hand.
    Sample(HandSample),
    /// The device lives, and had nothing else to tell.
    Alive,
    /// The device tells about itself: firmware, kind, battery.
    Note(String),
    /// Bytes that fit nothing were left out; why, for a person.
    Refused(String),
}

/// A device's language. Pure: the same calls give the same answers, and no bytes make it panic,
/// allocate without bound or fall silent.
///
/// `send` takes what goes to the device: one call is one datagram or line, never split.
pub trait Protocol: Send {
    /// The transport is open, for the first time or again. A device that shows forces is set free
    /// here: nobody knows what it still holds.
    fn start(&mut self, now_ns: u64, send: &mut dyn FnMut(&[u8]));

    /// Takes what arrived: any number of bytes of a stream, or one whole datagram.
    fn receive(
        &mut self,
        now_ns: u64,
        bytes: &[u8],
        event: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    );

    /// Called at least once a millisecond; `output` is what the device shall show from now on,
    /// given once, when it changes. Silence of the caller ends in
    /// [`released`](HandOutput::released), from the worker: a protocol needs no time limit of its
    /// own, but repeats what its device forgets or its transport may lose.
    fn tick(
        &mut self,
        now_ns: u64,
        output: Option<&HandOutput>,
        event: &mut dyn FnMut(Event),
        send: &mut dyn FnMut(&[u8]),
    ) {
        // A device that only tells needs nothing of this.
        let _ = (now_ns, output, event, send);
    }

    /// True if the device holds one hand and does not know which: it shows the one that presses
    /// first.
    fn holds_one_hand(&self) -> bool {
        false
    }

    /// The one message that sets the device free, whatever came before it and however often it
    /// comes: what a [keeper](crate::keeper) sends when this program cannot. None, the default, for
    /// a device that holds nobody. At most 255 bytes.
    fn release(&self, send: &mut dyn FnMut(&[u8])) {
        let _ = send;
    }

    /// The last words: what sets the device free, then what stops its stream.
    fn stop(&mut self, send: &mut dyn FnMut(&[u8])) {
        let _ = send;
    }
}

/// Moves bytes.
pub trait Transport: Send {
    /// Waits up to `timeout` (a fraction of a millisecond: system calls that round up to clock
    /// ticks will not do) for bytes; 0 when none came. An error means that it is lost; the end of
    /// a stream is `UnexpectedEof`.
    fn receive(&mut self, buffer: &mut [u8], timeout: std::time::Duration) -> io::Result<usize>;

    /// Sends these bytes whole, or nothing. Never waits longer than a few milliseconds: a device
    /// that takes nothing is lost.
    fn send(&mut self, bytes: &[u8]) -> io::Result<()>;

    /// A second handle of what the bytes go through, for a keeper; `None` where there is none to
    /// hand over.
    ///
    /// # Errors
    /// The system gives none.
    #[cfg(unix)]
    fn handle(&mut self) -> io::Result<Option<std::os::fd::OwnedFd>> {
        Ok(None)
    }

    /// Number of times that somebody else than the device spoke to us, and was not heard, since the
    /// last call.
    fn refused(&mut self) -> u64 {
        0
    }
}
