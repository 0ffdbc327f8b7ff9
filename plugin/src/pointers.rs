//! Pointers that callers hand in: checked as far as they can be, and read without asking more of them than they give.

use std::ffi::{CStr, c_char};

use crate::status::{Failure, Result, SeidelStatus};

fn null(name: &str) -> Failure {
    Failure::argument(name, "is NULL", "give a pointer")
}

/// A value that any bytes make up, which begins with its size in bytes, so that it can grow at its end.
///
/// # Safety
/// `Self` must be `repr(C)`, begin with a `u64`, and be valid for all bytes.
pub(crate) unsafe trait Sized64: Copy {
    /// Bytes of the first version: no caller's is smaller. Where fields are added it stays the offset of the first of
    /// them.
    const LEAST: usize;

    /// What fields are that the caller does not know of.
    fn neutral() -> Self;
}

/// The value at `from`, whatever version of it the caller knows.
///
/// # Safety
/// `from` must be NULL or point to as many bytes as the value says it has.
pub(crate) unsafe fn sized<T: Sized64>(from: *const T, name: &str) -> Result<T> {
    if from.is_null() {
        return Err(null(name));
    }
    // SAFETY: the caller vouches for the size, the first field of every such value.
    let size = unsafe { from.cast::<u64>().read_unaligned() };
    let known = size_of::<T>() as u64;
    if size > known {
        return Err(Failure::new(
            SeidelStatus::Unsupported,
            format!(
                "{name}: is {size} bytes, this library knows {known}; use the library that came with the header"
            ),
        ));
    }
    let size = size as usize;
    if size < T::LEAST {
        return Err(Failure::argument(
            name,
            format!("has a size of {size}"),
            &format!("set its size to its sizeof, at least {}", T::LEAST),
        ));
    }
    let mut value = T::neutral();
    // SAFETY: `size` bytes are there by the caller's word and fit in `value`, which any bytes make up.
    unsafe { copy_bytes(from.cast(), (&raw mut value).cast(), size) };
    Ok(value)
}

/// Puts `value` where the caller keeps its own, which has the size it says: no more of it than that.
///
/// # Safety
/// `to` must be NULL or point to as many bytes as the value there says it has, which can be written.
pub(crate) unsafe fn put_sized<T: Sized64>(to: *mut T, value: &T, name: &str) -> Result<()> {
    // SAFETY: as the caller vouches.
    unsafe { sized(to.cast_const(), name)? };
    // SAFETY: `sized` has found it sound.
    let size = unsafe { to.cast::<u64>().read_unaligned() };
    let (head, all) = (size_of::<u64>(), size as usize);
    // SAFETY: both are `all` bytes long; the size itself stays the caller's.
    unsafe {
        copy_bytes(
            (&raw const *value).cast::<u8>().add(head),
            to.cast::<u8>().add(head),
            all - head,
        );
    }
    Ok(())
}

/// # Safety
/// Both must be `count` bytes long and apart.
unsafe fn copy_bytes(from: *const u8, to: *mut u8, count: usize) {
    // SAFETY: as the caller vouches.
    unsafe { std::ptr::copy_nonoverlapping(from, to, count) };
}

/// The same, nothing where `from` is NULL.
///
/// # Safety
/// That of [`sized`].
pub(crate) unsafe fn maybe_sized<T: Sized64>(from: *const T, name: &str) -> Result<Option<T>> {
    if from.is_null() {
        return Ok(None);
    }
    // SAFETY: as the caller vouches.
    unsafe { sized(from, name).map(Some) }
}

/// A place to put a result: found good before work begins.
pub(crate) struct Place<T>(*mut T);

impl<T> Place<T> {
    /// # Safety
    /// `at` must be NULL or a place where a `T` can be written until the call ends.
    pub(crate) unsafe fn new(at: *mut T, name: &str) -> Result<Self> {
        if at.is_null() {
            Err(null(name))
        } else {
            Ok(Self(at))
        }
    }

    pub(crate) fn put(&self, value: T) {
        // SAFETY: whoever made this vouched for the place.
        unsafe { self.0.write_unaligned(value) };
    }
}

/// The text at `from`.
///
/// # Safety
/// `from` must be NULL or point to a text with a zero at its end that stays as it is.
pub(crate) unsafe fn text<'a>(from: *const c_char, name: &str) -> Result<&'a str> {
    if from.is_null() {
        return Err(null(name));
    }
    // SAFETY: as the caller vouches.
    let text = unsafe { CStr::from_ptr(from) };
    let wrong = |_| Failure::argument(name, "is not UTF-8", "give text in UTF-8");
    text.to_str().map_err(wrong)
}

/// The `count` values at `from`, which may be anything if there are none.
///
/// # Safety
/// `from` must be NULL or point to `count` values.
pub(crate) unsafe fn values<T: Copy>(from: *const T, count: usize, name: &str) -> Result<Vec<T>> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if from.is_null() {
        return Err(null(name));
    }
    // SAFETY: the caller vouches for `count` values.
    let at = |k: usize| unsafe { from.add(k).read_unaligned() };
    Ok((0..count).map(at).collect())
}

/// Copies `text` and a zero to `buffer`, cut to `capacity` bytes between characters; returns the bytes it all takes.
///
/// # Safety
/// `buffer` must be NULL or point to `capacity` bytes that can be written.
pub(crate) unsafe fn copy_text(text: &[u8], buffer: *mut c_char, capacity: usize) -> usize {
    if !buffer.is_null() && capacity > 0 {
        let mut count = text.len().min(capacity - 1);
        // Not within a character of several bytes.
        while count < text.len() && count > 0 && text[count] & 0xc0 == 0x80 {
            count -= 1;
        }
        // SAFETY: `count` is less than `capacity`, and `text` is nowhere in the caller's memory.
        unsafe {
            copy_bytes(text.as_ptr(), buffer.cast(), count);
            buffer.add(count).write(0);
        }
    }
    text.len() + 1
}
