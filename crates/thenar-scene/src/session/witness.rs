//! The witness of a session: everything that enters is reported to it, so that the session can be
//! replayed.

use super::Session;
use crate::grip::Order;
use crate::live::LivePose;
use crate::tuning::SettingValue;
use std::fmt::Debug;
use thenar_core::world::{State, Target};

/// Input that enters a session from outside. The same entries before the same steps of a session
/// from the same source give the same bits.
#[derive(Clone, Copy, Debug)]
pub enum Entry<'a> {
    /// [`Session::live_pose`] took a pose.
    Pose {
        /// Number of the hand.
        hand: usize,
        /// By the client's clock \[s\].
        time: f64,
        /// Pose that arrived.
        pose: &'a LivePose,
    },
    /// A call of [`Session::live_lost`].
    Lost {
        /// Number of the hand.
        hand: usize,
    },
    /// A call of [`Session::follow_script`].
    Script {
        /// Number of the hand.
        hand: usize,
    },
    /// [`Session::lead`] was given targets.
    Lead {
        /// Number of the hand.
        hand: usize,
        /// One for each of its bones.
        targets: &'a [Target],
    },
    /// [`Session::let_go`] of a hand that was led.
    LetGo {
        /// Number of the hand.
        hand: usize,
    },
    /// [`Session::grip`] began a grip.
    Grip {
        /// Number of the hand.
        hand: usize,
        /// Order that the hand follows.
        order: &'a Order,
    },
    /// [`Session::release`] of a hand.
    Release {
        /// Number of the hand.
        hand: usize,
    },
    /// [`Session::resume`] took a state.
    Resume {
        /// State that was set.
        state: &'a State,
    },
    /// A call of [`Session::restart`].
    Restart,
    /// [`Session::set`] changed a setting.
    Set {
        /// Key of the setting.
        key: &'a str,
        /// New value of the setting.
        value: &'a SettingValue,
    },
}

/// Receives everything that enters a session, in order. It must not take long.
pub trait Witness: Debug + Send {
    /// A session begins; it has not made a step yet, or goes on from where it is.
    fn begins(&mut self, session: &Session);

    /// Something has entered, and acts in the next step.
    fn entered(&mut self, entry: Entry<'_>);

    /// A step begins.
    fn stepping(&mut self) {}

    /// A step has been made.
    fn stepped(&mut self, session: &Session);
}

impl Session {
    /// Reports this session to `witness` from now on.
    pub fn set_witness(&mut self, mut witness: Box<dyn Witness>) {
        witness.begins(self);
        self.witness = Some(witness);
    }

    /// Lets the witness go.
    pub fn take_witness(&mut self) -> Option<Box<dyn Witness>> {
        self.witness.take()
    }

    /// Tells the witness.
    pub(super) fn tell(&mut self, entry: Entry<'_>) {
        if let Some(witness) = &mut self.witness {
            witness.entered(entry);
        }
    }
}
