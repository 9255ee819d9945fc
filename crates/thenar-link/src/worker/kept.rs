//! The keeper of an open device: started with it, and anew when it goes.

use super::Shared;
use crate::keeper::KeeperProcess;
use crate::{Protocol, Transport};
use std::io;

/// Time between two attempts to start a keeper \[ns\].
const AGAIN_NS: u64 = 1_000_000_000;

/// The keeper, if the device needs one and the program knows how to start it.
#[derive(Default)]
pub struct KeeperLink {
    keeping: Option<KeeperProcess>,
    /// Time when the next keeper may be started \[ns\].
    due_ns: u64,
    /// The absence of a keeper was reported.
    told: bool,
}

impl KeeperLink {
    /// Says to the keeper that this thread lives; true if the device was taken over and holds
    /// nothing now.
    pub fn beat(
        &mut self,
        now_ns: u64,
        protocol: &dyn Protocol,
        transport: &mut dyn Transport,
        shared: &Shared,
    ) -> bool {
        if self.keeping.is_none() && now_ns >= self.due_ns {
            self.due_ns = now_ns.saturating_add(AGAIN_NS);
            match begin(protocol, transport) {
                Ok(Some(keeping)) => self.keeping = Some(keeping),
                // It needs none, or none is wanted.
                Ok(None) => self.due_ns = u64::MAX,
                Err(error) => self.tell(shared, &error),
            }
        }
        let Some(keeping) = &mut self.keeping else { return false };
        match keeping.beat(now_ns, |send| protocol.release(send)) {
            Ok(taken_over) => {
                if taken_over {
                    shared.messages().tell("stood still; its keeper has let the wearer go");
                }
                self.told = false;
                taken_over
            }
            Err(error) => {
                self.keeping = None;
                self.tell(shared, &error);
                false
            }
        }
    }

    /// The thread is done with the device; `free` if it was told to let the wearer go and took
    /// that.
    pub fn end(self, free: bool) {
        if let Some(keeping) = self.keeping {
            keeping.end(free);
        }
    }

    fn tell(&mut self, shared: &Shared, error: &io::Error) {
        if !std::mem::replace(&mut self.told, true) {
            let text = format!(
                "has no keeper ({error}): it holds on if this program is stopped or killed; \
                 another is tried once a second"
            );
            shared.messages().tell(&text);
        }
    }
}

fn begin(
    protocol: &dyn Protocol,
    transport: &mut dyn Transport,
) -> io::Result<Option<KeeperProcess>> {
    let mut releases = false;
    protocol.release(&mut |bytes| releases |= !bytes.is_empty());
    if !releases || crate::keeper::program().is_none() {
        return Ok(None);
    }
    transport.handle()?.map_or(Ok(None), KeeperProcess::begin)
}
