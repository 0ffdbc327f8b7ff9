//! A memory budget shared by the frames in flight.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Default of `--memory`.
pub(super) const DEFAULT_MEMORY: &str = "4G";

/// Parses a size in bytes, or a number followed by K, M, G or T (powers of 1024).
pub(super) fn parse_size(text: &str) -> Result<u64, String> {
    let wrong = || "give a size such as 500M, 4G or 1.5G".to_owned();
    let plain = text.trim().to_ascii_uppercase();
    let plain = plain.strip_suffix('B').unwrap_or(&plain);
    let plain = plain.strip_suffix('I').unwrap_or(plain);
    let (number, power) = match plain.char_indices().last() {
        Some((at, 'K')) => (&plain[..at], 1),
        Some((at, 'M')) => (&plain[..at], 2),
        Some((at, 'G')) => (&plain[..at], 3),
        Some((at, 'T')) => (&plain[..at], 4),
        _ => (plain, 0),
    };
    let number: f64 = number.trim().parse().map_err(|_| wrong())?;
    let bytes = number * 1024_f64.powi(power);
    if bytes.is_finite() && bytes >= 1.0 && bytes < u64::MAX as f64 {
        Ok(bytes as u64)
    } else {
        Err(wrong())
    }
}

/// The memory budget of a run.
pub(super) struct Budget {
    limit: u64,
    state: Mutex<State>,
    freed: Condvar,
}

#[derive(Default)]
struct State {
    used: u64,
    /// The largest frame so far, bytes: the expected size of the next.
    largest: u64,
}

impl Budget {
    /// Creates a budget of `limit` bytes.
    pub(super) fn new(limit: u64) -> Self {
        Self {
            limit,
            state: Mutex::default(),
            freed: Condvar::new(),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // The numbers stay consistent even if another thread panicked.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until a frame as large as the largest so far fits, or no other is in flight.
    pub(super) fn claim(&self) -> Claim<'_> {
        let mut state = self
            .freed
            .wait_while(self.state(), |state| {
                state.used > 0 && state.used.saturating_add(state.largest) > self.limit
            })
            .unwrap_or_else(PoisonError::into_inner);
        // At least one byte, so that a first frame of unknown size keeps the others waiting.
        let bytes = state.largest.max(1);
        state.used += bytes;
        Claim {
            budget: self,
            bytes,
        }
    }
}

/// The memory of one frame, returned to the budget when dropped.
pub(super) struct Claim<'a> {
    budget: &'a Budget,
    bytes: u64,
}

impl Claim<'_> {
    /// Replaces the expected size by the actual one.
    pub(super) fn resize(&mut self, bytes: u64) {
        let mut state = self.budget.state();
        state.used = state.used - self.bytes + bytes;
        state.largest = state.largest.max(bytes);
        self.bytes = bytes;
        drop(state);
        self.budget.freed.notify_all();
    }
}

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        self.budget.state().used -= self.bytes;
        self.budget.freed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_parsed() {
        for (text, bytes) in [
            ("500M", 500 << 20),
            ("4G", 4 << 30),
            ("1.5g", 3 << 29),
            ("2GiB", 2 << 30),
            ("64kb", 64 << 10),
            ("1T", 1 << 40),
            ("4096", 4096),
        ] {
            assert_eq!(parse_size(text), Ok(bytes), "{text}");
        }
        for bad in ["", "G", "-1G", "0", "4X", "inf", "nan", "1e40G", "é"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
        assert!(parse_size(DEFAULT_MEMORY).is_ok());
    }

    #[test]
    fn a_frame_waits_for_memory() {
        let budget = Budget::new(100);
        let mut first = budget.claim();
        first.resize(60);
        std::thread::scope(|scope| {
            let second = scope.spawn(|| {
                let _claim = budget.claim();
                budget.state().used
            });
            // Whenever the second frame claims its memory, it gets it only after this.
            first.resize(150);
            drop(first);
            assert_eq!(second.join().expect("no panic"), 150);
        });
        assert_eq!(budget.state().used, 0);
    }
}
