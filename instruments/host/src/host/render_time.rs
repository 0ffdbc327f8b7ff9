//! The time that a render takes, and how much of it the host itself takes.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use super::locked;

/// The time in the Render action, without what the host does before and after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderTime {
    /// On the clock, the host's work on images included: it copies them for the plugin and checks them when they are released.
    pub elapsed: Duration,
    /// Of all threads of the process, without the host's work on images. Zero where the system does not tell.
    pub cpu: Duration,
    /// From the moment when the host begins to abort to the end, on the clock, without the host's work on images.
    pub after_abort: Duration,
}

impl RenderTime {
    /// Adds the time of another render.
    pub(crate) fn add(&mut self, other: Self) {
        self.elapsed += other.elapsed;
        self.cpu += other.cpu;
        self.after_abort += other.after_abort;
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

    /// Returns the time since the start, with the work of the host `on_images`. The host aborts from `abort_from` on.
    pub(crate) fn stop(&self, on_images: &ImageWork, abort_from: Option<Instant>) -> RenderTime {
        let end = Instant::now();
        let cpu = cpu_of_process().saturating_sub(self.cpu);
        let after_abort = abort_from.map_or(Duration::ZERO, |from| {
            let all = end.saturating_duration_since(from);
            all.saturating_sub(on_images.elapsed_from(from))
        });
        RenderTime {
            elapsed: end.duration_since(self.start),
            cpu: cpu.saturating_sub(on_images.cpu),
            after_abort,
        }
    }
}

/// The host's work on images in a render: their copies for the plugin, and checks when they are released.
#[derive(Debug, Default)]
pub(crate) struct ImageWork {
    /// Processor time.
    cpu: Duration,
    /// Starts and ends.
    spans: Vec<(Instant, Instant)>,
}

impl ImageWork {
    /// Returns the time of the work after `from`.
    fn elapsed_from(&self, from: Instant) -> Duration {
        let after = |(start, end): &(Instant, Instant)| {
            end.saturating_duration_since(from)
                .min(end.duration_since(*start))
        };
        self.spans.iter().map(after).sum()
    }
}

/// Does `work` on images, and adds its time to `sum`.
pub(crate) fn timed<T>(sum: &Mutex<ImageWork>, work: impl FnOnce() -> T) -> T {
    let (start, cpu) = (Instant::now(), cpu_of_thread());
    let result = work();
    let mut sum = locked(sum);
    sum.cpu += cpu_of_thread().saturating_sub(cpu);
    sum.spans.push((start, Instant::now()));
    result
}

/// Returns the CPU time of the calling thread; zero where the system does not tell.
fn cpu_of_thread() -> Duration {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_on_images_counts_from_the_abort_on() {
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        let work = ImageWork {
            cpu: Duration::ZERO,
            spans: vec![(at(10), at(30)), (at(50), at(55))],
        };
        for (from, ms) in [(0, 25), (20, 15), (40, 5), (52, 3), (60, 0)] {
            assert_eq!(work.elapsed_from(at(from)), Duration::from_millis(ms));
        }
    }
}
