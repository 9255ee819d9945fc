//! Exceptions, with the program's own messages.

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::{PyFileExistsError, PyRuntimeError, PyValueError};
use thenar_scene::live::LiveError;
use thenar_scene::recording::{ReplayError, SnapshotError};
use thenar_scene::session;
use thenar_scene::tuning;

create_exception!(
    thenar,
    SceneError,
    PyValueError,
    "A scene is wrong, or there is none: says what and where."
);
create_exception!(
    thenar,
    PoseError,
    PyValueError,
    "A hand cannot follow what was given; nothing has changed."
);
create_exception!(
    thenar,
    GripError,
    PyValueError,
    "A hand does not grip what was asked for; nothing has changed."
);
create_exception!(
    thenar,
    SettingError,
    PyValueError,
    "There is no such setting, or the value is out of its range; nothing has changed."
);
create_exception!(
    thenar,
    StateError,
    PyValueError,
    "Bytes are no state of this world; nothing has changed."
);
create_exception!(
    thenar,
    RecordingError,
    PyValueError,
    "A recording cannot be read, written or replayed any further."
);
create_exception!(
    thenar,
    StaleViewError,
    PyRuntimeError,
    "A view is of a step that is past: the world has been stepped, reset or put into another state since."
);
create_exception!(thenar, BusyError, PyRuntimeError, "Another thread steps this world at present.");

/// The world is taken by another thread.
pub fn busy() -> PyErr {
    BusyError::new_err("another thread steps this world at present")
}

/// The view belongs to a step that is past.
pub fn stale() -> PyErr {
    StaleViewError::new_err("the view is of a step that is past: ask for it again after the step")
}

/// A panic has left the world in nobody knows which state.
pub fn broken() -> PyErr {
    PyRuntimeError::new_err("a step of this world has failed for good: make another from its scene")
}

/// The scene is wrong.
pub fn scene(error: &thenar_scene::SceneError) -> PyErr {
    SceneError::new_err(error.to_string())
}

/// The pose is none.
pub fn pose(error: &LiveError) -> PyErr {
    PoseError::new_err(error.to_string())
}

/// A hand does not grip so.
pub fn grip(error: &session::GripError) -> PyErr {
    GripError::new_err(error.to_string())
}

/// The setting is none.
pub fn setting(error: &tuning::SettingError) -> PyErr {
    SettingError::new_err(error.to_string())
}

/// The state is none.
pub fn state(error: SnapshotError) -> PyErr {
    StateError::new_err(error.to_string())
}

/// The recording cannot be replayed.
pub fn replay(error: &ReplayError) -> PyErr {
    RecordingError::new_err(error.to_string())
}

/// The recording cannot be written.
pub fn record(error: &thenar_record::RecordError) -> PyErr {
    match error {
        thenar_record::RecordError::Exists(_) => PyFileExistsError::new_err(error.to_string()),
        _ => RecordingError::new_err(error.to_string()),
    }
}
