//! Reports of a device that is away or silent: every change once, its cause included.

use super::Shared;
use std::io;

/// Least time between reports of others that speak in a device's place \[ns\].
const OTHERS_EVERY_NS: u64 = 10_000_000_000;
/// Time after which a device that sends nothing valid is reported \[ns\].
const SILENT_NS: u64 = 2_000_000_000;

/// Tells of losses and returns, each once.
#[derive(Default)]
pub struct LossNotice {
    /// The failure that was told last, while the device is away.
    told: Option<io::ErrorKind>,
    /// True if the device has been there before.
    known: bool,
    /// True if the device could be reached, but was lost before it said anything. A datagram socket
    /// can always be opened: only words show that somebody is there.
    only_seemed: bool,
}

impl LossNotice {
    /// The device cannot be reached.
    pub fn failed(&mut self, shared: &Shared, error: &io::Error) {
        if self.told != Some(error.kind()) {
            self.told = Some(error.kind());
            shared
                .messages()
                .tell(&format!("is not there ({error}); it is taken up when it comes"));
        }
    }

    /// The device was there until now, and `spoke`, or is of those that never speak.
    pub fn lost(&mut self, shared: &Shared, error: &io::Error, spoke: bool) {
        let first = !self.only_seemed;
        self.only_seemed = !spoke;
        if first || spoke {
            shared.messages().tell(&format!("is lost ({error}); it is taken up when it returns"));
            // That it is not there any more needs no second message, other hindrances do.
            self.told = Some(io::ErrorKind::NotFound);
        }
    }

    /// The device can be reached.
    pub fn reached(&mut self, shared: &Shared) {
        if !self.only_seemed {
            shared.messages().tell(if self.known { "is back" } else { "is connected" });
            (self.known, self.told) = (true, None);
        }
    }

    /// The device said something.
    fn spoke(&mut self, shared: &Shared) {
        if std::mem::take(&mut self.only_seemed) {
            self.reached(shared);
        }
    }
}

/// Tells of a device that can be reached and says nothing, and when it speaks again.
pub struct SilenceNotice {
    /// Time when the device was reached, or last made sense \[ns\].
    since_ns: u64,
    /// True if the device said something that made sense in this session.
    spoke: bool,
    /// Bytes came since.
    bytes: bool,
    /// True if the silence was reported.
    told: bool,
}

impl SilenceNotice {
    /// Silence of a device that was reached now.
    pub fn new(now_ns: u64) -> Self {
        Self { since_ns: now_ns, spoke: false, bytes: false, told: false }
    }

    /// Looks at the device, after the bytes that came were understood as far as they could be.
    pub fn look(&mut self, now_ns: u64, received: bool, shared: &Shared, away: &mut LossNotice) {
        self.bytes |= received;
        if let Some(heard) = shared.heard().filter(|heard| *heard > self.since_ns) {
            away.spoke(shared);
            if self.told {
                shared.messages().tell(if self.spoke { "speaks again" } else { "speaks now" });
            }
            *self = Self { since_ns: heard, spoke: true, bytes: false, told: false };
        } else if !self.told && now_ns.saturating_sub(self.since_ns) > SILENT_NS {
            self.told = true;
            shared.messages().tell(self.cause());
        }
    }

    fn cause(&self) -> &'static str {
        match (self.spoke, self.bytes) {
            (false, false) => {
                "is connected but says nothing: is it switched on, and is this its port?"
            }
            (true, false) => "has fallen silent; its next words are taken up",
            (_, true) => {
                "is connected but says nothing that makes sense: wrong port, speed or firmware?"
            }
        }
    }
}

/// Tells of others that speak in the device's place and are not heard.
#[derive(Default)]
pub struct OthersNotice {
    refused: u64,
    told_ns: Option<u64>,
}

impl OthersNotice {
    /// Adds how often others were refused since the last call, and reports it when that is due.
    pub fn look(&mut self, now_ns: u64, refused: u64, shared: &Shared) {
        self.refused += refused;
        let due = self.told_ns.is_none_or(|at| now_ns.saturating_sub(at) >= OTHERS_EVERY_NS);
        if self.refused > 0 && due {
            let text = format!("another sender is not heard ({} times)", self.refused);
            shared.messages().tell(&text);
            (self.refused, self.told_ns) = (0, Some(now_ns));
        }
    }
}
