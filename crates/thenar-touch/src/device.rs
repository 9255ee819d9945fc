//! Interfaces of devices: what the loop asks of a tracker and of a force display, whichever they
//! are.

use crate::safety::Limits;
use crate::{HandOutput, HandSample, LoopProfile, Rendering, TrackerTiming};
use thenar_core::model::Side;

/// Asks a device what there is to tell a person, without having the device in hand.
pub type MessageSource = Box<dyn FnMut() -> Vec<String> + Send>;

/// Presence of a device: reached or not, and when it was last heard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presence {
    /// Address of the device, as `lucidgloves:/dev/ttyUSB0`.
    pub name: String,
    /// True while the device is reached: its port is open, its socket is connected.
    pub connected: bool,
    /// Time of the device's last meaningful message \[ns\].
    pub heard_ns: Option<u64>,
}

/// Asks whether devices are there, without having them in hand; one that has no line, such as a
/// recording, is left out.
pub type PresenceCheck = Box<dyn FnMut() -> Vec<Presence> + Send>;

/// Tells where hands are.
pub trait Tracker: Send {
    /// The newest sample of this hand, once. Never waits and never allocates.
    fn latest(&mut self, side: Side) -> Option<&HandSample>;

    /// Returns the time of the device's last meaningful message \[ns\]; `None` before the first.
    fn heard_ns(&mut self) -> Option<u64>;

    /// Length of the wearer's hand, wrist to middle fingertip \[m\], where the device's profile
    /// knows it: the simulated hand should be built as long.
    fn hand_length(&self) -> Option<f64> {
        None
    }

    /// Returns the rate, latency and noise of the tracker, where its driver or profile knows them;
    /// `None` where only the samples' own times tell.
    fn timing(&self) -> Option<TrackerTiming> {
        None
    }

    /// Returns messages for a person: notes and troubles since the last call, each reported once,
    /// either here or by the display. Not for the loop.
    fn messages(&mut self) -> Vec<String>;

    /// Tells the same on another thread, while this one is in the loop.
    fn message_source(&self) -> MessageSource {
        Box::new(Vec::new)
    }
    /// Tells whether it is there, while it is in the loop.
    fn presence_check(&self) -> PresenceCheck {
        Box::new(Vec::new)
    }
}

/// Lets a hand feel. It shows nothing until forces come, and releases the hand when it is dropped,
/// when its device is lost and when no output came for 20 ms.
pub trait ForceDisplay: Send {
    /// Returns what the display renders.
    fn rendering(&self) -> Rendering;

    /// Returns the limits of the actuators, per finger (or axis), for the guards before them.
    fn limits(&self) -> Limits;

    /// Returns the limits of torques, if the display renders any, for guards of their own.
    fn torque_limits(&self) -> Option<Limits> {
        None
    }

    /// Returns what bounds the stiffness of a coupling to the display, by its profile.
    fn loop_profile(&self) -> LoopProfile;

    /// Hands over the newest output. Never waits and never allocates.
    fn show(&mut self, output: &HandOutput);

    /// Returns the time when the device was last heard \[ns\]; `None` before the first time, or
    /// when it never answers.
    fn heard_ns(&mut self) -> Option<u64>;

    /// Returns messages for a person, as trackers do.
    fn messages(&mut self) -> Vec<String>;

    /// Returns a message source, as trackers do.
    fn message_source(&self) -> MessageSource {
        Box::new(Vec::new)
    }
    /// Tells whether it is there, while it is in the loop.
    fn presence_check(&self) -> PresenceCheck {
        Box::new(Vec::new)
    }
}
