//! Worlds are opened and freed.
#![allow(unsafe_code)] // exported by name, and handed pointers

use crate::boundary::{Refusal, Status, guard};
use crate::pointer;
use crate::running::World;
use std::ffi::c_char;
use std::path::Path;
use thenar_scene::SceneError;
use thenar_scene::build::Files;
use thenar_scene::session::{Session, Source, builtin, builtins, read_scene};

fn scene(error: &SceneError) -> Refusal {
    Refusal { status: Status::Scene, words: error.to_string() }
}

/// Texts of a list.
///
/// # Safety
/// As of [`pointer::slice`], and of [`pointer::text`] for each.
unsafe fn texts(
    name: &str,
    list: *const *const c_char,
    count: usize,
) -> Result<Vec<String>, Refusal> {
    // SAFETY: the caller's word.
    let list = unsafe { pointer::slice(name, list, count) }?;
    // SAFETY: the caller's word.
    list.iter().map(|text| Ok(unsafe { pointer::text(name, *text) }?.to_owned())).collect()
}

/// Opens the scene whose text and file `read` gives. `*world` is null until it is open.
///
/// # Safety
/// As of [`texts`] for `overrides`, and of [`pointer::put`] for `world`.
unsafe fn open<T: AsRef<str>, F: AsRef<Path>>(
    overrides: *const *const c_char,
    overrides_count: usize,
    world: *mut *mut World,
    read: impl FnOnce() -> Result<(T, F), Refusal>,
) -> Status {
    guard(|| {
        // SAFETY: the caller's word.
        unsafe { pointer::put("world", world, std::ptr::null_mut()) }?;
        // SAFETY: the caller's word.
        let overrides = unsafe { texts("overrides", overrides, overrides_count) }?;
        let (text, file) = read()?;
        let source = Source::new(text.as_ref(), file.as_ref(), &overrides);
        let files = Files::beside(file.as_ref());
        let session = Session::open(&source, files).map_err(|e| scene(&e))?;
        let opened = Box::into_raw(Box::new(World::new(session, &source)));
        // SAFETY: the caller's word.
        unsafe { pointer::put("world", world, opened) }
    })
}

/// Opens a scene file. `overrides`: `overrides_count` texts such as `solver.cone="circular"`, as
/// `--set` of the program; NULL and 0 for none. `*world` gets the handle, which `thenar_world_free`
/// frees.
///
/// # Safety
/// `file` and each override end with a NUL; `world` has room for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_open(
    file: *const c_char,
    overrides: *const *const c_char,
    overrides_count: usize,
    world: *mut *mut World,
) -> Status {
    let read = || {
        // SAFETY: the caller's word.
        let file = Path::new(unsafe { pointer::text("file", file) }?);
        Ok((read_scene(file).map_err(|e| scene(&e))?, file))
    };
    // SAFETY: the caller's word.
    unsafe { open(overrides, overrides_count, world, read) }
}

/// Opens a scene that comes along, by its name, such as `bread-grasp`. Else as `thenar_world_open`.
///
/// # Safety
/// `name` and each override end with a NUL; `world` has room for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_open_named(
    name: *const c_char,
    overrides: *const *const c_char,
    overrides_count: usize,
    world: *mut *mut World,
) -> Status {
    let read = || {
        // SAFETY: the caller's word.
        let name = unsafe { pointer::text("name", name) }?;
        let found = builtin(name).ok_or_else(|| {
            let known: Vec<&str> = builtins().iter().map(|scene| scene.name).collect();
            scene(&SceneError::Unknown { name: name.into(), known: known.join(", ") })
        })?;
        Ok((found.text, Path::new("scenes").join(name).with_extension("toml")))
    };
    // SAFETY: the caller's word.
    unsafe { open(overrides, overrides_count, world, read) }
}

/// Opens a scene's text. `file` names it in messages; files that the scene names are looked for in
/// its folder. Else as `thenar_world_open`.
///
/// # Safety
/// `text`, `file` and each override end with a NUL; `world` has room for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_open_text(
    text: *const c_char,
    file: *const c_char,
    overrides: *const *const c_char,
    overrides_count: usize,
    world: *mut *mut World,
) -> Status {
    // SAFETY: the caller's word.
    let read = || unsafe { Ok((pointer::text("text", text)?, pointer::text("file", file)?)) };
    // SAFETY: the caller's word.
    unsafe { open(overrides, overrides_count, world, read) }
}

/// Frees a world; NULL is none. Names that were read of it go with it.
///
/// # Safety
/// `world` is NULL, or of a world that was opened, is not freed yet, and that no other thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn thenar_world_free(world: *mut World) {
    guard(|| {
        if !world.is_null() {
            // SAFETY: it came from a box when it was opened, and is freed once, by the caller's
            // word.
            drop(unsafe { Box::from_raw(world) });
        }
        Ok(())
    });
}
