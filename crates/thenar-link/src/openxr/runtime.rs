//! The calls to the runtime.

use super::{Joint, Runtime};
use crate::joints::OPENXR_JOINTS;
use openxr::{
    ApplicationInfo, Entry, Event, EventDataBuffer, ExtensionSet, FormFactor, Hand, HandTracker,
    Headless, Instance, Posef, ReferenceSpaceType, SessionState, Space, SpaceLocationFlags,
    ViewConfigurationType,
};
use std::io::{self, ErrorKind};

/// A session without a picture, with both hands.
pub struct Session {
    instance: Instance,
    session: openxr::Session<Headless>,
    space: Space,
    /// Left, right.
    trackers: [HandTracker; 2],
    running: bool,
}

fn lost(what: &str, cause: impl std::fmt::Display) -> io::Error {
    io::Error::new(ErrorKind::NotConnected, format!("{what}: {cause}"))
}

impl Session {
    /// Opens the active runtime.
    ///
    /// # Errors
    /// There is no loader, no runtime, or it lacks hands or sessions without a picture.
    pub fn open() -> io::Result<Self> {
        let entry = load()?;
        let there = entry.enumerate_extensions().map_err(|e| lost("no runtime", e))?;
        let mut wanted = ExtensionSet::default();
        wanted.ext_hand_tracking = true;
        wanted.mnd_headless = true;
        #[cfg(windows)]
        (wanted.khr_win32_convert_performance_counter_time = true);
        #[cfg(not(windows))]
        (wanted.khr_convert_timespec_time = true);
        let missing = wanted.difference(&there);
        if missing != ExtensionSet::default() {
            let names: Vec<_> = missing
                .names()
                .iter()
                .map(|name| String::from_utf8_lossy(name).trim_end_matches('\0').to_owned())
                .collect();
            return Err(lost("the runtime lacks", names.join(", ")));
        }
        let about = ApplicationInfo { application_name: "Thenar", ..Default::default() };
        let instance = entry.create_instance(&about, &wanted, &[], &());
        let instance = instance.map_err(|e| lost("no instance", e))?;
        let system = instance.system(FormFactor::HEAD_MOUNTED_DISPLAY);
        let system = system.map_err(|e| lost("no headset", e))?;
        let session = create(&instance, system)?;
        let space = |kind| session.create_reference_space(kind, Posef::IDENTITY);
        // The floor of the room where it is known, else the place of the head at the start.
        let space = space(ReferenceSpaceType::STAGE)
            .or_else(|_| space(ReferenceSpaceType::LOCAL))
            .map_err(|e| lost("no space", e))?;
        let tracker = |hand| session.create_hand_tracker(hand).map_err(|e| lost("no hands", e));
        let trackers = [tracker(Hand::LEFT)?, tracker(Hand::RIGHT)?];
        Ok(Self { instance, session, space, trackers, running: false })
    }

    /// Follows the session's states.
    fn listen(&mut self) -> io::Result<()> {
        let mut storage = EventDataBuffer::new();
        while let Some(event) =
            self.instance.poll_event(&mut storage).map_err(|e| lost("no events", e))?
        {
            match event {
                Event::SessionStateChanged(change) => match change.state() {
                    SessionState::READY => {
                        let begun = self.session.begin(ViewConfigurationType::PRIMARY_STEREO);
                        begun.map_err(|e| lost("no session", e))?;
                        self.running = true;
                    }
                    SessionState::STOPPING => {
                        self.running = false;
                        self.session.end().map_err(|e| lost("the session", e))?;
                    }
                    SessionState::EXITING | SessionState::LOSS_PENDING => {
                        return Err(lost("the session", "the runtime ended it"));
                    }
                    _ => {}
                },
                Event::InstanceLossPending(_) => {
                    return Err(lost("the session", "the runtime goes away"));
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl Runtime for Session {
    fn hands(&mut self) -> io::Result<[Option<[Joint; OPENXR_JOINTS]>; 2]> {
        self.listen()?;
        let mut hands = [None, None];
        if !self.running {
            return Ok(hands);
        }
        let now = self.instance.now().map_err(|e| lost("no clock", e))?;
        for (hand, tracker) in hands.iter_mut().zip(&self.trackers) {
            let located = self.space.locate_hand_joints(tracker, now);
            *hand = located.map_err(|e| lost("no joints", e))?.map(|joints| joints.map(joint));
        }
        Ok(hands)
    }
}

fn joint(location: openxr::HandJointLocation) -> Joint {
    let known = SpaceLocationFlags::POSITION_VALID | SpaceLocationFlags::ORIENTATION_VALID;
    let (p, q) = (location.pose.position, location.pose.orientation);
    Joint {
        valid: location.location_flags.contains(known),
        position: [p.x, p.y, p.z],
        rotation: [q.x, q.y, q.z, q.w],
        radius: location.radius,
    }
}

/// Looks for the loader.
#[allow(unsafe_code)]
fn load() -> io::Result<Entry> {
    // SAFETY: the library of this name is the system's OpenXR loader; that its own start-up code is
    // sound has to be relied upon, as with every library of the system.
    unsafe { Entry::load(&()) }.map_err(|e| lost("no OpenXR loader", e))
}

/// A session without graphics.
#[allow(unsafe_code)]
fn create(instance: &Instance, system: openxr::SystemId) -> io::Result<openxr::Session<Headless>> {
    let info = openxr::headless::SessionCreateInfo {};
    // SAFETY: the requirement is on handles of a graphics library, of which there are none here.
    let made = unsafe { instance.create_session::<Headless>(system, &info) };
    made.map(|(session, ..)| session).map_err(|e| lost("no session without a picture", e))
}
