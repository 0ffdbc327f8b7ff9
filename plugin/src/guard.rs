//! The panic guard of every export: a panic or an error becomes a status and the thread's last error.

use crate::last_error;
use crate::panics::catch_panic;
use crate::status::{Failure, Result, SeidelStatus};

/// Runs `work`. An error or a panic becomes a status, and the last error of this thread; success clears the last
/// error.
pub(crate) fn guard(work: impl FnOnce() -> Result<()>) -> SeidelStatus {
    let result = catch_panic(work).unwrap_or_else(|| Err(Failure::panicked()));
    match result {
        Ok(()) => {
            last_error::set("");
            SeidelStatus::Ok
        }
        Err(failure) => {
            last_error::set(&failure.text);
            failure.status
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panics::guard_or;
    use crate::seidel_last_error;
    use std::ffi::c_char;

    fn last_error() -> String {
        let mut bytes = [0_u8; 300];
        let buffer = bytes.as_mut_ptr().cast::<c_char>();
        // SAFETY: the buffer has the length passed.
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
    fn panics_do_not_leave_the_guard() {
        let status = guard(|| panic!("planted"));
        assert_eq!(status, SeidelStatus::Panicked);
        assert!(last_error().contains("internal error"));
        let status = guard(|| std::panic::panic_any(PanicsWhenDropped));
        assert_eq!(status, SeidelStatus::Panicked);
        assert_eq!(guard_or(7, || panic!("planted")), 7);
        assert_eq!(guard(|| Ok(())), SeidelStatus::Ok);
        assert_eq!(last_error(), "");
    }

    #[test]
    fn last_errors_are_per_thread_and_cut_between_characters() {
        let long = "é".repeat(3000);
        let status = guard(|| Err(Failure::new(SeidelStatus::Lens, long.clone())));
        assert_eq!(status, SeidelStatus::Lens);
        // SAFETY: NULL with a capacity of 0 is allowed.
        let needed = unsafe { seidel_last_error(std::ptr::null_mut(), 0) };
        assert_eq!(needed, 2049);
        let of_other_thread = std::thread::spawn(last_error).join().expect("no panic");
        assert_eq!(of_other_thread, "");
        let mut bytes = [1_u8; 4];
        // SAFETY: the buffer has four bytes.
        unsafe { seidel_last_error(bytes.as_mut_ptr().cast(), 4) };
        // One character of two bytes, then the terminator.
        assert_eq!(&bytes[..3], &[0xc3, 0xa9, 0]);
    }
}
