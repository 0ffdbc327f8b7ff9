//! The one door of every export: no panic goes through it, and every failure leaves its words.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::last_error;
use crate::status::{Failure, Result, SeidelStatus};

/// Does `work`; its failure, or a panic, becomes a status and the last error of this thread.
pub(crate) fn guard(work: impl FnOnce() -> Result<()>) -> SeidelStatus {
    let done = caught(work).unwrap_or_else(|| Err(Failure::panicked()));
    match done {
        Ok(()) => {
            last_error::keep("");
            SeidelStatus::Ok
        }
        Err(failure) => {
            last_error::keep(&failure.text);
            failure.status
        }
    }
}

/// Does `work` that has no status to return; `otherwise` where it panics. The last error stays.
pub(crate) fn guard_or<T>(otherwise: T, work: impl FnOnce() -> T) -> T {
    caught(work).unwrap_or(otherwise)
}

/// What `work` gives, nothing if it panics.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> Option<T> {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => Some(done),
        Err(payload) => {
            // To drop what somebody else panicked with could panic again.
            std::mem::forget(payload);
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seidel_last_error;
    use std::ffi::c_char;

    fn last_error() -> String {
        let mut bytes = [0_u8; 300];
        let buffer = bytes.as_mut_ptr().cast::<c_char>();
        // SAFETY: the buffer is as long as is said.
        let length = unsafe { seidel_last_error(buffer, bytes.len()) };
        String::from_utf8_lossy(&bytes[..length - 1]).into_owned()
    }

    struct PanicsWhenDropped;

    impl Drop for PanicsWhenDropped {
        fn drop(&mut self) {
            panic!("again");
        }
    }

    #[test]
    fn panics_end_at_the_door() {
        let status = guard(|| panic!("planted"));
        assert_eq!(status, SeidelStatus::Panicked);
        assert!(last_error().contains("fault of this library"));
        let status = guard(|| std::panic::panic_any(PanicsWhenDropped));
        assert_eq!(status, SeidelStatus::Panicked);
        assert_eq!(guard_or(7, || panic!("planted")), 7);
        assert_eq!(guard(|| Ok(())), SeidelStatus::Ok);
        assert_eq!(last_error(), "");
    }

    #[test]
    fn texts_are_kept_for_each_thread_and_cut_between_characters() {
        let long = "é".repeat(3000);
        let status = guard(|| Err(Failure::new(SeidelStatus::Lens, long.clone())));
        assert_eq!(status, SeidelStatus::Lens);
        // SAFETY: nothing is written.
        let needed = unsafe { seidel_last_error(std::ptr::null_mut(), 0) };
        assert_eq!(needed, 2049);
        let elsewhere = std::thread::spawn(last_error).join().expect("no panic");
        assert_eq!(elsewhere, "");
        let mut three = [1_u8; 4];
        // SAFETY: three bytes may be written.
        unsafe { seidel_last_error(three.as_mut_ptr().cast(), 4) };
        // One character of two bytes, a zero, and what is left.
        assert_eq!(&three[..3], &[0xc3, 0xa9, 0]);
    }
}
