//! Thenar for Python: the native half of the package, `thenar._thenar`.
//!
//! Sessions live behind a lock here; what Python reads of them are `bytes`, which nothing changes
//! any more, and which the Python half (`python/thenar`) shows as arrays without another copy. No
//! memory that a step writes is ever seen from Python, so no code here is unsafe. Numbers go in as
//! `bytes` too: little rows of `f64` in the machine's order, whose shapes the Python half has
//! checked.
#![cfg(feature = "extension")]

mod batch;
mod case;
mod claim;
mod describe;
mod error;
mod numbers;
mod picture;
mod quantity;
mod record;
mod replay;
mod report;
mod running;
mod scene;
mod taxels;
mod world;

/// The native half of Thenar. Use the package `thenar`.
#[pyo3::pymodule]
mod _thenar {
    #[pymodule_export]
    use crate::batch::step_all;
    #[pymodule_export]
    use crate::case::{case_columns, run_case};
    #[pymodule_export]
    use crate::error::{
        BusyError, GripError, PoseError, RecordingError, SceneError, SettingError, StaleViewError,
        StateError,
    };
    #[pymodule_export]
    use crate::replay::Recording;
    #[pymodule_export]
    use crate::report::StepReport;
    #[pymodule_export]
    use crate::scene::{Scene, scene_names};
    #[pymodule_export]
    use crate::taxels::Taxels;
    #[pymodule_export]
    use crate::world::World;
}
