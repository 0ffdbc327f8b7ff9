//! The resident memory of a process over a long run.

use std::fmt;
use std::fs;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;
use std::time::Duration;

/// Time between two samples.
const PERIOD: Duration = Duration::from_millis(20);

/// Parts of a run whose medians are compared. The first one is left out: caches fill there.
const PARTS: usize = 10;

/// Largest growth that counts as flat.
const FLAT: f64 = 0.05;

/// Samples the resident memory of a process from another thread.
#[derive(Default)]
pub(super) struct Watch {
    thread: Option<JoinHandle<Vec<u64>>>,
    is_over: Arc<AtomicBool>,
}

impl Watch {
    /// Begins to sample the process with this number.
    pub(super) fn begin(&mut self, process: u32) {
        let is_over = Arc::clone(&self.is_over);
        self.thread = Some(std::thread::spawn(move || {
            let mut samples = Vec::new();
            while !is_over.load(Relaxed) {
                samples.extend(resident_bytes(process).filter(|bytes| *bytes > 0));
                std::thread::sleep(PERIOD);
            }
            samples
        }));
    }

    /// Ends the samples.
    pub(super) fn end(mut self) -> Memory {
        self.is_over.store(true, Relaxed);
        let samples = self.thread.take().and_then(|thread| thread.join().ok());
        Memory::of(&samples.unwrap_or_default())
    }
}

/// Returns the resident memory of a process; nothing once it has ended.
fn resident_bytes(process: u32) -> Option<u64> {
    let text = fs::read_to_string(format!("/proc/{process}/statm")).ok()?;
    let pages: u64 = text.split(' ').nth(1)?.parse().ok()?;
    // SAFETY: asks for a number only.
    let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) };
    Some(pages * u64::try_from(page).ok()?)
}

/// Medians of the resident memory in equal parts of a run, bytes; none if the run was too short to tell.
pub(super) struct Memory(Vec<u64>);

impl Memory {
    fn of(samples: &[u64]) -> Self {
        let length = samples.len() / PARTS;
        if length == 0 {
            return Self(Vec::new());
        }
        let median = |part: &[u64]| {
            let mut part = part.to_vec();
            part.sort_unstable();
            part[part.len() / 2]
        };
        Self(
            samples
                .chunks_exact(length)
                .take(PARTS)
                .map(median)
                .collect(),
        )
    }

    /// Returns the largest median over the smallest, less one, without the first part of the run.
    fn growth(&self) -> Option<f64> {
        let rest = self.0.get(1..)?;
        let (low, high) = (rest.iter().min()?, rest.iter().max()?);
        Some(*high as f64 / *low as f64 - 1.0)
    }

    /// Returns what is wrong with the memory, if anything.
    pub(super) fn problem(&self) -> Option<String> {
        let growth = self.growth()?;
        (growth > FLAT).then(|| format!("resident memory varies by {:.1} %", 100.0 * growth))
    }
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(growth) = self.growth() else {
            return write!(f, "too short to judge its memory");
        };
        let mib: Vec<String> = (self.0.iter())
            .map(|bytes| format!("{:.1}", *bytes as f64 / f64::from(1 << 20)))
            .collect();
        write!(
            f,
            "resident memory by tenths of the time: {} MiB, within {:.1} % after the first",
            mib.join(" "),
            100.0 * growth
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leak_is_found_and_a_cache_that_fills_is_none() {
        let flat = |k: u64| 100_000 + 2000 * (k % 3);
        let cache: Vec<u64> = (0..500)
            .map(|k| if k < 40 { 500 * k } else { flat(k) })
            .collect();
        assert_eq!(Memory::of(&cache).problem(), None);
        let leak: Vec<u64> = (0..500).map(|k| flat(k) + 20 * k).collect();
        let problem = Memory::of(&leak).problem();
        assert!(problem.is_some_and(|text| text.contains("varies by 7.")));
        assert_eq!(Memory::of(&leak[..7]).problem(), None);
    }
}
