//! The border: what goes wrong inside becomes a status and words, and nothing unwinds into the
//! caller.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Outcome of a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The call did what was asked.
    Ok = 0,
    /// A pointer is null or not aligned, a size does not fit, text is not UTF-8, or there is no
    /// such body or hand.
    Argument = 1,
    /// The scene is wrong, or there is none.
    Scene = 2,
    /// A hand cannot follow what was given.
    Pose = 3,
    /// The setting does not exist, or the value is out of its range.
    Setting = 4,
    /// The bytes are no state of this world.
    State = 5,
    /// Another thread has the world.
    Busy = 6,
    /// The world has failed for good: free it, and make another from its scene.
    Broken = 7,
}

/// Why a call was refused.
#[derive(Debug)]
pub struct Refusal {
    /// Kind of fault.
    pub status: Status,
    /// Words for people.
    pub words: String,
}

impl Refusal {
    /// An argument that does not fit.
    pub fn argument(words: impl Into<String>) -> Self {
        Self { status: Status::Argument, words: words.into() }
    }
}

thread_local! {
    /// Words of the last refusal in this thread.
    static LAST: RefCell<CString> = RefCell::default();
}

/// Does something, and turns refusals and panics into a status and words.
pub fn guard(act: impl FnOnce() -> Result<(), Refusal>) -> Status {
    let refusal = match catch_unwind(AssertUnwindSafe(act)) {
        Ok(Ok(())) => return Status::Ok,
        Ok(Err(refusal)) => refusal,
        Err(_) => crate::running::broken(),
    };
    // C ends a text at its first NUL: words with one in them go on without it.
    let mut words = refusal.words.into_bytes();
    words.retain(|byte| *byte != 0);
    let words = CString::new(words).unwrap_or_default();
    // In a thread that is going down nobody can ask any more.
    let _ = LAST.try_with(|last| last.replace(words));
    refusal.status
}

/// Words of the last refusal in this thread, UTF-8; empty when there was none. They stay until the
/// next refusal in this thread: copy what is to be kept.
#[unsafe(no_mangle)]
#[allow(unsafe_code)] // its name is seen by the linker
pub extern "C" fn thenar_last_error() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::running::World;
    use std::path::Path;
    use thenar_scene::build::Files;
    use thenar_scene::session::{Session, Source, builtin};

    fn words() -> String {
        LAST.with(|last| last.borrow().to_string_lossy().into_owned())
    }

    #[test]
    fn a_panic_stays_inside_and_ends_its_world_alone() {
        let scene = builtin("falling-box").expect("it comes along");
        let source = Source::new(scene.text, Path::new("scenes/falling-box.toml"), &[]);
        let open = || {
            let session = Session::open(&source, Files::beside(&source.file)).expect("a scene");
            World::new(session, &source)
        };
        let (bad, good) = (open(), open());
        let fail = || bad.with(|_| -> Result<(), Refusal> { panic!("on purpose") });
        assert_eq!(guard(fail), Status::Broken);
        assert!(words().contains("failed for good"), "{}", words());
        // From then on it is refused, without another panic; the other one goes on.
        let ask = |world: &World| {
            guard(|| {
                world.with(|running| {
                    running.session.step(&mut ());
                    Ok(())
                })
            })
        };
        assert_eq!(ask(&bad), Status::Broken);
        assert_eq!(ask(&good), Status::Ok);
    }

    #[test]
    fn words_are_of_the_last_refusal_in_this_thread() {
        assert_eq!(guard(|| Err(Refusal::argument("first\0 and more"))), Status::Argument);
        assert_eq!(words(), "first and more");
        let other = std::thread::spawn(words).join().expect("a thread");
        assert_eq!(other, "");
        assert_eq!(guard(|| Ok(())), Status::Ok);
        assert_eq!(words(), "first and more");
    }
}
