//! Checked access to memory of the caller.

use std::ffi::{CStr, c_char};

use crate::status::{Failure, Result, SeidelStatus};

/// A struct that begins with its size in bytes, so that later versions can add members at its end.
///
/// # Safety
/// `Self` must be `repr(C)`, begin with a `u64`, and be valid for all bytes.
pub(crate) unsafe trait Versioned: Copy {
    /// Size of the first version, bytes: no caller's struct is smaller. When members are added, it becomes the offset
    /// of the first one added.
    const MIN_SIZE: usize;

    /// Returns the values of the members that a caller's smaller struct lacks.
    fn defaults() -> Self;
}

/// Reads the struct at `from`, of the caller's version.
///
/// # Safety
/// `from` must be NULL or point to as many bytes as the struct's size states.
pub(crate) unsafe fn read_versioned<T: Versioned>(from: *const T, name: &str) -> Result<T> {
    if from.is_null() {
        return Err(Failure::null(name));
    }
    // SAFETY: the caller guarantees the size, which is the first member.
    let size = unsafe { from.cast::<u64>().read_unaligned() };
    let known = size_of::<T>() as u64;
    if size > known {
        return Err(Failure::new(
            SeidelStatus::Unsupported,
            format!(
                "{name}: has {size} bytes, but this library knows {known}; use the library that came with the header"
            ),
        ));
    }
    let size = size as usize;
    if size < T::MIN_SIZE {
        return Err(Failure::argument(
            name,
            format!("has a size of {size}"),
            &format!("set its size to its sizeof, at least {}", T::MIN_SIZE),
        ));
    }
    let mut value = T::defaults();
    // SAFETY: the caller guarantees `size` bytes; they fit in `value`, which is valid for all bytes.
    unsafe { copy_bytes(from.cast(), (&raw mut value).cast(), size) };
    Ok(value)
}

/// Reads the struct at `from` like [`read_versioned`], or returns `None` if `from` is NULL.
///
/// # Safety
/// That of [`read_versioned`].
pub(crate) unsafe fn read_optional<T: Versioned>(from: *const T, name: &str) -> Result<Option<T>> {
    if from.is_null() {
        return Ok(None);
    }
    // SAFETY: as the caller guarantees.
    unsafe { read_versioned(from, name).map(Some) }
}

/// Writes `value` to the caller's struct at `to`, up to the size that the struct states.
///
/// # Safety
/// `to` must be NULL or point to as many writable bytes as the struct's size states.
pub(crate) unsafe fn write_versioned<T: Versioned>(
    to: *mut T,
    value: &T,
    name: &str,
) -> Result<()> {
    // SAFETY: as the caller guarantees.
    unsafe { read_versioned(to.cast_const(), name)? };
    // SAFETY: `read_versioned` has read it before.
    let size = unsafe { to.cast::<u64>().read_unaligned() };
    let (head, all) = (size_of::<u64>(), size as usize);
    // SAFETY: both are `all` bytes long. The size itself remains the caller's.
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
/// Both must be `count` bytes long and must not overlap.
unsafe fn copy_bytes(from: *const u8, to: *mut u8, count: usize) {
    // SAFETY: as the caller guarantees.
    unsafe { std::ptr::copy_nonoverlapping(from, to, count) };
}

/// An output argument, checked before the work begins.
pub(crate) struct OutputPointer<T>(*mut T);

impl<T> OutputPointer<T> {
    /// # Safety
    /// `at` must be NULL or a place where a `T` can be written until the call ends.
    pub(crate) unsafe fn new(at: *mut T, name: &str) -> Result<Self> {
        if at.is_null() {
            Err(Failure::null(name))
        } else {
            Ok(Self(at))
        }
    }

    pub(crate) fn write(&self, value: T) {
        // SAFETY: the creator guarantees the place.
        unsafe { self.0.write_unaligned(value) };
    }
}

/// Returns the string at `from`.
///
/// # Safety
/// `from` must be NULL or point to a string with a terminating zero that does not change.
pub(crate) unsafe fn read_string<'a>(from: *const c_char, name: &str) -> Result<&'a str> {
    if from.is_null() {
        return Err(Failure::null(name));
    }
    // SAFETY: as the caller guarantees.
    let text = unsafe { CStr::from_ptr(from) };
    let invalid = |_| Failure::argument(name, "is not UTF-8", "give text in UTF-8");
    text.to_str().map_err(invalid)
}

/// Copies the `count` values at `from`, which may be NULL if `count` is 0.
///
/// # Safety
/// `from` must be NULL or point to `count` values.
pub(crate) unsafe fn read_array<T: Copy>(
    from: *const T,
    count: usize,
    name: &str,
) -> Result<Vec<T>> {
    if count == 0 {
        return Ok(Vec::new());
    }
    if from.is_null() {
        return Err(Failure::null(name));
    }
    // SAFETY: the caller guarantees `count` values.
    let value = |k: usize| unsafe { from.add(k).read_unaligned() };
    Ok((0..count).map(value).collect())
}

/// Copies `text` and a terminating zero to `buffer`, cut between characters to `capacity` bytes. Returns the size of
/// the whole text with its zero.
///
/// # Safety
/// `buffer` must be NULL or point to `capacity` writable bytes.
pub(crate) unsafe fn copy_string(text: &[u8], buffer: *mut c_char, capacity: usize) -> usize {
    if !buffer.is_null() && capacity > 0 {
        let mut count = text.len().min(capacity - 1);
        // Bytes 10xxxxxx continue a character of UTF-8.
        while count < text.len() && count > 0 && text[count] & 0xc0 == 0x80 {
            count -= 1;
        }
        // SAFETY: `count` is less than `capacity`, and `text` does not overlap the caller's memory.
        unsafe {
            copy_bytes(text.as_ptr(), buffer.cast(), count);
            buffer.add(count).write(0);
        }
    }
    text.len() + 1
}

/// Copies `text` with a terminating zero to `buffer`, and its size with the zero to `*needed`.
///
/// # Errors
/// A buffer that is NULL or too small, in which case the copy is cut.
///
/// # Safety
/// `buffer` must be NULL or `capacity` writable bytes, `needed` NULL or a writable place for a number.
pub(crate) unsafe fn copy_text(
    text: &str,
    buffer: *mut c_char,
    capacity: usize,
    needed: *mut usize,
) -> Result<()> {
    // SAFETY: as the caller guarantees.
    let size = unsafe { copy_string(text.as_bytes(), buffer, capacity) };
    if !needed.is_null() {
        // SAFETY: the caller guarantees the place.
        unsafe { needed.write_unaligned(size) };
    }
    if buffer.is_null() || size > capacity {
        return Err(Failure::new(
            SeidelStatus::TooSmall,
            format!("buffer: holds {capacity} bytes; give room for {size}"),
        ));
    }
    Ok(())
}
