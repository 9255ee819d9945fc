//! Devices of systems on which no keeper runs.

use super::Shared;
use crate::{Protocol, Transport};

/// No keeper.
#[derive(Default)]
pub struct KeeperLink;

impl KeeperLink {
    /// Says nothing to nobody; false, for nobody takes over.
    pub fn beat(&mut self, _: u64, _: &dyn Protocol, _: &mut dyn Transport, _: &Shared) -> bool {
        false
    }

    /// Ends nothing.
    pub fn end(self, _: bool) {}
}
