//! Interfaces of devices: what the loop asks of a tracker and of a force display, whichever they
//! are.

use crate::safety::Limits;
use crate::{HandOutput, HandSample, LoopProfile, Rendering, TrackerTiming};
use thenar_core::model::Side;

/// Asks a device what there is to tell a person, without having the device in hand.
pub type Messenger = Box<dyn FnMut() -> Vec<String> + Send>;

/// Presence of a device: reached or not, and when it was last heard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Presence {
    /// Address of the device, as `lucidgloves:/dev/ttyUSB0`.
    pub name: String,
    /// True while the device is reached: its port is open, its socket is connected.
    pub connected: bool,
    /// When it last said something that made sense \[ns\].
    pub heard_ns: Option<u64>,
}

/// Asks whether devices are there, without having them in hand; one that has no line, such as a
/// recording, is left out.
pub type Lookout = Box<dyn FnMut() -> Vec<Presence> + Send>;

/// Tells where hands are.
pub trait Tracker: Send {
    /// The newest sample of this hand, once. Never waits and never allocates.
    fn latest(&mut self, side: Side) -> Option<&HandSample>;

    /// When the device last said something that made sense \[ns\]; `None` before the first time.
    fn heard_ns(&mut self) -> Option<u64>;

    /// Length of the wearer's hand, wrist to middle fingertip \[m\], where the device's profile
    /// knows it: the simulated hand should be built as long.
    fn hand_length(&self) -> Option<f64> {
        None
    }

    /// How often it samples, how late and how noisy, where its driver or profile knows; `None`
    /// where nothing but the samples' own times tells.
    fn timing(&self) -> Option<TrackerTiming> {
        None
    }

    /// What there is to tell a person: notes and troubles since the last call, each told once,
    /// be it here or by the display. Not for the loop.
    fn messages(&mut self) -> Vec<String>;

    /// Tells the same on another thread, while this one is in the loop.
    fn messenger(&self) -> Messenger {
        Box::new(Vec::new)
    }
    /// Tells whether it is there, while it is in the loop.
    fn lookout(&self) -> Lookout {
        Box::new(Vec::new)
    }
}

/// Lets a hand feel. It shows nothing until forces come, and releases the hand when it is dropped,
/// when its device is lost and when no output came for 20 ms.
pub trait ForceDisplay: Send {
    /// What it renders.
    fn rendering(&self) -> Rendering;

    /// What its actuators may do, per finger (or axis); for the guards before it.
    fn limits(&self) -> Limits;

    /// What it may turn with, for one that renders torques; for guards of their own.
    fn torque_limits(&self) -> Option<Limits> {
        None
    }

    /// What bounds the stiffness of a coupling to it, by its profile.
    fn loop_profile(&self) -> LoopProfile;

    /// Hands over the newest output. Never waits and never allocates.
    fn show(&mut self, output: &HandOutput);

    /// When the device was last heard \[ns\]; `None` before the first time, or when it never
    /// answers.
    fn heard_ns(&mut self) -> Option<u64>;

    /// What there is to tell a person, as for trackers.
    fn messages(&mut self) -> Vec<String>;

    /// As for trackers.
    fn messenger(&self) -> Messenger {
        Box::new(Vec::new)
    }
    /// Tells whether it is there, while it is in the loop.
    fn lookout(&self) -> Lookout {
        Box::new(Vec::new)
    }
}
