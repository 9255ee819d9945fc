//! From C's pointers to references, and back: all that can be checked is checked here.
//!
//! What cannot be checked is left to the caller, in the words of each function's `Safety`.
#![allow(unsafe_code)] // a pointer from C can be followed in no other way

use crate::boundary::Refusal;
use crate::running::World;
use std::ffi::{CStr, c_char};

fn check<T>(name: &str, pointer: *const T) -> Result<(), Refusal> {
    if pointer.is_null() {
        return Err(Refusal::argument(format!("{name} is NULL")));
    }
    if !pointer.is_aligned() {
        return Err(Refusal::argument(format!("{name} is not aligned for its type")));
    }
    Ok(())
}

/// The world behind a handle.
///
/// # Safety
/// The pointer is null, or of a world that was opened and is not freed while the reference lives.
pub unsafe fn world<'a>(world: *const World) -> Result<&'a World, Refusal> {
    check("world", world)?;
    // SAFETY: not null, aligned, and a live world by the caller's word. All access to its inside is
    // locked.
    Ok(unsafe { &*world })
}

/// A text.
///
/// # Safety
/// The pointer is null, or of bytes that end with a NUL and are not changed while the reference
/// lives.
pub unsafe fn text<'a>(name: &str, text: *const c_char) -> Result<&'a str, Refusal> {
    check(name, text)?;
    // SAFETY: not null, and ends with a NUL by the caller's word.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| Refusal::argument(format!("{name} is not UTF-8")))
}

/// Elements to read. None are taken from a null pointer.
///
/// # Safety
/// The pointer is null, or of `count` elements that are not changed while the reference lives.
pub unsafe fn slice<'a, T: Copy>(
    name: &str,
    pointer: *const T,
    count: usize,
) -> Result<&'a [T], Refusal> {
    if count == 0 {
        return Ok(&[]);
    }
    check(name, pointer)?;
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(Refusal::argument(format!(
            "{name}: {count} elements are more than there is memory"
        )));
    }
    // SAFETY: not null, aligned, of a size that memory can have, and of so many elements by the
    // caller's word.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Exactly `N` elements to read.
///
/// # Safety
/// As of [`slice`].
pub unsafe fn array<T: Copy, const N: usize>(
    name: &str,
    pointer: *const T,
    count: usize,
) -> Result<[T; N], Refusal> {
    expect(name, count, N)?;
    // SAFETY: the caller's word.
    let elements = unsafe { slice(name, pointer, count) }?;
    let refused = |_| Refusal::argument(format!("{name}: expected {N} elements"));
    elements.try_into().map_err(refused)
}

/// Writes one value.
///
/// # Safety
/// The pointer is null, or of room for one value that nobody else uses meanwhile.
pub unsafe fn put<T>(name: &str, pointer: *mut T, value: T) -> Result<(), Refusal> {
    check(name, pointer)?;
    // SAFETY: not null, aligned, and ours to write by the caller's word. What is there needs no
    // drop: it is plain.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Writes exactly as many values as there is room for.
///
/// # Safety
/// The pointer is null, or of room for `room` values that nobody else uses meanwhile.
pub unsafe fn fill<T: Copy>(
    name: &str,
    pointer: *mut T,
    room: usize,
    values: &[T],
) -> Result<(), Refusal> {
    expect(name, room, values.len())?;
    if values.is_empty() {
        return Ok(());
    }
    check(name, pointer)?;
    // SAFETY: not null, aligned, room for as many by the caller's word; ours and theirs do not
    // overlap, as nobody outside has a pointer to what is inside.
    unsafe { pointer.copy_from_nonoverlapping(values.as_ptr(), values.len()) };
    Ok(())
}

/// Tells in `count` how many values there are, and writes them unless `pointer` is null.
///
/// # Safety
/// As of [`put`] for `count`, and of [`fill`] for `pointer`, with room for `room`.
pub unsafe fn list<T: Copy>(
    name: &str,
    pointer: *mut T,
    room: usize,
    count: *mut usize,
    values: &[T],
) -> Result<(), Refusal> {
    // SAFETY: the caller's word.
    unsafe { put("count", count, values.len()) }?;
    if pointer.is_null() {
        return expect(name, room, 0);
    }
    if room < values.len() {
        let words = format!("{name}: there are {} elements, and room for {room}", values.len());
        return Err(Refusal::argument(words));
    }
    // SAFETY: the caller's word, as there is room for at least as many.
    unsafe { fill(name, pointer, values.len(), values) }
}

fn expect(name: &str, got: usize, expected: usize) -> Result<(), Refusal> {
    match got == expected {
        true => Ok(()),
        false => Err(Refusal::argument(format!("{name}: expected {expected} elements, got {got}"))),
    }
}
