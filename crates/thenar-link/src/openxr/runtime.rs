//! The calls to the runtime.

use super::{HandJoints, Joint, Runtime};
use openxr::{
    ApplicationInfo, Entry, Event, EventDataBuffer, ExtensionSet, FormFactor, Hand, HandTracker,
    Headless, Instance, Posef, ReferenceSpaceType, SessionState, Space, SpaceLocationFlags,
    ViewConfigurationType,
};
use std::error::Error;
use std::io::{self, ErrorKind};
use std::path::Path;

/// Told where the floor is not known.
const NO_STAGE: &str = "there is no stage: the origin is where the head was, not on the floor";

/// A session without a picture, with both hands.
pub struct Session {
    instance: Instance,
    session: openxr::Session<Headless>,
    space: Space,
    /// Left, right.
    trackers: [HandTracker; 2],
    running: bool,
    /// Message for a person.
    note: Option<&'static str>,
}

fn lost(what: &str, cause: impl std::fmt::Display) -> io::Error {
    io::Error::new(ErrorKind::NotConnected, format!("{what}: {cause}"))
}

/// Error that lasts until somebody acts on it; reported even after a loss was reported.
fn lacking(what: String) -> io::Error {
    io::Error::new(ErrorKind::Unsupported, what)
}

impl Session {
    /// Opens the active runtime through the loader at a path, or the system's.
    ///
    /// # Errors
    /// There is no loader, no runtime, no headset, or one of them lacks hands or sessions without a
    /// picture.
    pub fn open(loader: Option<&Path>) -> io::Result<Self> {
        let entry = load(loader)?;
        let there = entry.enumerate_extensions().map_err(|e| {
            let hint = "no OpenXR runtime is active; start one or set XR_RUNTIME_JSON";
            io::Error::new(ErrorKind::ConnectionRefused, format!("{hint}: {e}"))
        })?;
        let mut wanted = ExtensionSet::default();
        wanted.ext_hand_tracking = true;
        wanted.mnd_headless = true;
        #[cfg(windows)]
        (wanted.khr_win32_convert_performance_counter_time = true);
        #[cfg(not(windows))]
        (wanted.khr_convert_timespec_time = true);
        let missing = wanted.difference(&there);
        if missing.ext_hand_tracking {
            return Err(lacking(
                "the OpenXR runtime has no hand tracking, XR_EXT_hand_tracking".into(),
            ));
        }
        if missing.mnd_headless {
            let why = "it gives hands only to programs that draw in the headset";
            return Err(lacking(format!("the OpenXR runtime lacks XR_MND_headless: {why}")));
        }
        if missing != ExtensionSet::default() {
            let names: Vec<_> = missing
                .names()
                .iter()
                .map(|name| String::from_utf8_lossy(name).trim_end_matches('\0').to_owned())
                .collect();
            return Err(lacking(format!("the OpenXR runtime lacks {}", names.join(", "))));
        }
        let about = ApplicationInfo { application_name: "Thenar", ..Default::default() };
        let instance = entry.create_instance(&about, &wanted, &[], &());
        let instance = instance.map_err(|e| lost("no instance", e))?;
        let system = instance.system(FormFactor::HEAD_MOUNTED_DISPLAY);
        let system = system.map_err(|e| lost("no headset", e))?;
        if !instance.supports_hand_tracking(system).map_err(|e| lost("no headset", e))? {
            return Err(lacking("this headset has no hand tracking, or it is switched off".into()));
        }
        let session = create(&instance, system)?;
        let space = |kind| session.create_reference_space(kind, Posef::IDENTITY);
        let (space, note) = match space(ReferenceSpaceType::STAGE) {
            Ok(stage) => (stage, None),
            Err(_) => {
                (space(ReferenceSpaceType::LOCAL).map_err(|e| lost("no space", e))?, Some(NO_STAGE))
            }
        };
        let tracker = |hand| session.create_hand_tracker(hand).map_err(|e| lost("no hands", e));
        let trackers = [tracker(Hand::LEFT)?, tracker(Hand::RIGHT)?];
        Ok(Self { instance, session, space, trackers, running: false, note })
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
    fn hands(&mut self) -> io::Result<Option<HandJoints>> {
        self.listen()?;
        if !self.running {
            return Ok(None);
        }
        let mut hands = [None, None];
        let now = self.instance.now().map_err(|e| lost("no clock", e))?;
        for (hand, tracker) in hands.iter_mut().zip(&self.trackers) {
            let located = self.space.locate_hand_joints(tracker, now);
            *hand = located.map_err(|e| lost("no joints", e))?.map(|joints| joints.map(joint));
        }
        Ok(Some(hands))
    }

    fn note(&mut self) -> Option<&'static str> {
        self.note.take()
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
fn load(path: Option<&Path>) -> io::Result<Entry> {
    // SAFETY: the library of this name is the system's OpenXR loader, or the one that the user
    // names; that its own start-up code is sound has to be relied upon, as with every library of
    // the system.
    let entry = unsafe {
        match path {
            Some(path) => Entry::load_from(path, &()),
            None => Entry::load(&()),
        }
    };
    entry.map_err(|error| {
        // The innermost cause is the one that says what is not there.
        let mut cause: &dyn Error = &error;
        while let Some(inner) = cause.source() {
            cause = inner;
        }
        let hint = match path {
            Some(_) => "the OpenXR loader cannot be loaded",
            None if cfg!(target_os = "linux") => {
                "the OpenXR loader is not installed (Debian: libopenxr-loader1)"
            }
            None => "there is no OpenXR loader; name it, openxr:PATH",
        };
        io::Error::new(ErrorKind::NotFound, format!("{hint}: {cause}"))
    })
}

/// A session without graphics.
#[allow(unsafe_code)]
fn create(instance: &Instance, system: openxr::SystemId) -> io::Result<openxr::Session<Headless>> {
    let info = openxr::headless::SessionCreateInfo {};
    // SAFETY: the requirement is on handles of a graphics library, of which there are none here.
    let made = unsafe { instance.create_session::<Headless>(system, &info) };
    made.map(|(session, ..)| session).map_err(|e| lost("no session without a picture", e))
}
