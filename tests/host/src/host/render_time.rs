//! The time that a render takes, and how much of it the host itself takes.

use std::time::{Duration, Instant};

/// The time in the Render action, without what the host does before and after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderTime {
    /// On the clock, the host's copies of images included.
    pub elapsed: Duration,
    /// Of all threads of the process, without the host's copies of images. Zero where the system does not tell.
    pub cpu: Duration,
}

impl RenderTime {
    /// Adds the time of another render.
    pub(crate) fn add(&mut self, other: Self) {
        self.elapsed += other.elapsed;
        self.cpu += other.cpu;
    }
}

/// A measurement under way.
pub(crate) struct Stopwatch {
    start: Instant,
    cpu: Duration,
}

impl Stopwatch {
    pub(crate) fn start() -> Self {
        Self {
            start: Instant::now(),
            cpu: cpu_of_process(),
        }
    }

    /// Returns the time since the start; the host took `in_host` of it.
    pub(crate) fn stop(&self, in_host: Duration) -> RenderTime {
        let elapsed = self.start.elapsed();
        let cpu = cpu_of_process().saturating_sub(self.cpu);
        RenderTime {
            elapsed,
            cpu: cpu.saturating_sub(in_host),
        }
    }
}

/// Returns the CPU time of the calling thread; zero where the system does not tell.
pub(crate) fn cpu_of_thread() -> Duration {
    read("/proc/thread-self/schedstat".as_ref())
}

/// Returns the CPU time of the threads that the process has; zero where the system does not tell.
fn cpu_of_process() -> Duration {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else {
        return Duration::ZERO;
    };
    let threads = threads.flatten().map(|thread| thread.path());
    threads.map(|path| read(&path.join("schedstat"))).sum()
}

/// Reads nanoseconds on a processor, the first number of the file.
fn read(path: &std::path::Path) -> Duration {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let first = text.split_whitespace().next();
    let nanoseconds = first.and_then(|number| number.parse().ok());
    Duration::from_nanos(nanoseconds.unwrap_or(0))
}
