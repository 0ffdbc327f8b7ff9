//! The pipeline of frames: while one is processed, the next is read and those before it are written.
//!
//! Frames are processed in sequence, each on all threads. Results are reported in the order of the frames.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::sync::{Mutex, PoisonError};

use rayon::ThreadPool;

use super::memory::{Budget, Claim};
use crate::commands::CommandError;

/// Frames that wait between two stages. More would not make the slowest stage faster.
const WAITING: usize = 1;

/// Frames written at once: one is compressed while another goes to disk.
const WRITERS: usize = 2;

/// The work on each frame before it is written. Frames are known by their index in the run.
pub(crate) trait FrameWork: Sync {
    /// A frame that was read.
    type Loaded: Send;
    /// A frame to be written.
    type Processed: Send;

    /// Reads a frame.
    fn read(&self, index: usize) -> Result<Self::Loaded, CommandError>;

    /// Returns an upper bound of the memory that the frame takes, bytes.
    fn memory_bytes(&self, frame: &Self::Loaded) -> u64;

    /// Returns the warnings about a frame that was read. They are reported even if it cannot be processed, since they may
    /// say why.
    fn warnings(&self, frame: &Self::Loaded) -> Vec<String>;

    /// Processes a frame.
    fn process(&self, index: usize, frame: Self::Loaded) -> Result<Self::Processed, CommandError>;
}

/// The result of a frame: warnings, or the error that stopped it.
pub(super) type FrameResult = Result<Vec<String>, FailedFrame>;

/// A frame that an error stopped.
#[derive(Debug)]
pub(super) struct FailedFrame {
    pub(super) error: CommandError,
    /// Warnings from before the error.
    pub(super) warnings: Vec<String>,
}

impl<E: Into<CommandError>> From<E> for FailedFrame {
    fn from(error: E) -> Self {
        Self {
            error: error.into(),
            warnings: Vec::new(),
        }
    }
}

/// The threads and the memory of a run.
pub(super) struct Resources {
    /// Threads that decode files, while others process another frame.
    pub(super) reading: ThreadPool,
    pub(super) processing: ThreadPool,
    /// Memory for the frames in flight, bytes. One frame is in flight even if it needs more.
    pub(super) memory: u64,
}

/// Takes `count` frames through `work` and `write`, as many at once as the memory allows.
///
/// Calls `report` for each frame in their order, as soon as all earlier frames are finished.
pub(super) fn run_pipeline<W: FrameWork>(
    work: &W,
    write: impl Fn(usize, W::Processed) -> FrameResult + Sync,
    count: usize,
    resources: &Resources,
    mut report: impl FnMut(usize, FrameResult),
) {
    let budget = Budget::new(resources.memory);
    let (loaded, to_process) = sync_channel(WAITING);
    let (processed, to_write) = sync_channel(WAITING);
    let to_write = Mutex::new(to_write);
    let (finished, results) = channel();
    std::thread::scope(|scope| {
        let failed = finished.clone();
        scope.spawn(|| {
            // Moved in, because a sender that outlives its stage would keep the next one waiting.
            let (loaded, failed) = (loaded, failed);
            for index in 0..count {
                let mut claim = budget.claim();
                let sent = match resources.reading.install(|| work.read(index)) {
                    Ok(frame) => {
                        claim.resize(work.memory_bytes(&frame));
                        loaded.send((index, frame, claim)).is_ok()
                    }
                    Err(error) => failed.send((index, Err(error.into()))).is_ok(),
                };
                if !sent {
                    break;
                }
            }
        });
        let failed = finished.clone();
        scope.spawn(|| {
            let (to_process, processed, failed) = (to_process, processed, failed);
            for (index, frame, claim) in to_process {
                let warnings = work.warnings(&frame);
                let sent = match (resources.processing).install(|| work.process(index, frame)) {
                    Ok(frame) => processed.send((index, frame, claim)).is_ok(),
                    Err(error) => {
                        let frame = FailedFrame { error, warnings };
                        failed.send((index, Err(frame))).is_ok()
                    }
                };
                if !sent {
                    break;
                }
            }
        });
        for _ in 0..WRITERS {
            let finished = finished.clone();
            scope.spawn(|| write_frames(&write, &to_write, finished));
        }
        drop(finished);
        let mut early = BTreeMap::new();
        let mut next = 0;
        for (index, result) in results {
            early.insert(index, result);
            while let Some(result) = early.remove(&next) {
                report(next, result);
                next += 1;
            }
        }
    });
}

/// Writes frames until no more come.
fn write_frames<F>(
    write: &impl Fn(usize, F) -> FrameResult,
    to_write: &Mutex<Receiver<(usize, F, Claim)>>,
    finished: Sender<(usize, FrameResult)>,
) {
    loop {
        let next = to_write
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .recv();
        let Ok((index, frame, claim)) = next else {
            return;
        };
        let result = write(index, frame);
        drop(claim);
        if finished.send((index, result)).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU64, Ordering::SeqCst};
    use std::time::Duration;

    use rayon::ThreadPoolBuilder;

    use super::*;

    /// Bytes of the frames in flight, now and at most. Frames of 10 bytes take longer to write the earlier they are;
    /// every fifth fails, each time at a later stage.
    #[derive(Default)]
    struct MemoryCount {
        now: AtomicU64,
        largest: AtomicU64,
    }

    fn fail_at(stage: usize, index: usize) -> Result<(), CommandError> {
        if index % 5 == 4 && index / 5 == stage {
            return Err(CommandError::Usage(format!("{index} fails")));
        }
        Ok(())
    }

    /// A frame, which is counted until it is dropped.
    struct CountedFrame<'a>(&'a MemoryCount);

    impl Drop for CountedFrame<'_> {
        fn drop(&mut self) {
            self.0.now.fetch_sub(10, SeqCst);
        }
    }

    impl<'a> FrameWork for &'a MemoryCount {
        type Loaded = CountedFrame<'a>;
        type Processed = CountedFrame<'a>;

        fn read(&self, index: usize) -> Result<CountedFrame<'a>, CommandError> {
            let now = self.now.fetch_add(10, SeqCst) + 10;
            self.largest.fetch_max(now, SeqCst);
            let frame = CountedFrame(self);
            fail_at(0, index).map(|()| frame)
        }

        fn memory_bytes(&self, _: &CountedFrame) -> u64 {
            10
        }

        fn warnings(&self, _: &CountedFrame) -> Vec<String> {
            vec!["read, but ".to_owned()]
        }

        fn process(
            &self,
            index: usize,
            frame: CountedFrame<'a>,
        ) -> Result<CountedFrame<'a>, CommandError> {
            fail_at(1, index).map(|()| frame)
        }
    }

    fn write(index: usize, _frame: CountedFrame) -> FrameResult {
        std::thread::sleep(Duration::from_millis(20 - index.min(20) as u64));
        fail_at(2, index)?;
        Ok(vec![format!("{index} done")])
    }

    #[test]
    fn frames_are_reported_in_order_within_the_memory_limit() {
        let pool = || ThreadPoolBuilder::new().num_threads(1).build();
        for (memory, most) in [(1, 10), (10, 10), (25, 20), (1000, 1000)] {
            let resources = Resources {
                reading: pool().expect("a thread"),
                processing: pool().expect("a thread"),
                memory,
            };
            let count = MemoryCount::default();
            let mut reports = Vec::new();
            run_pipeline(&&count, write, 20, &resources, |index, result| {
                let message = match result {
                    Ok(warnings) => warnings.concat(),
                    Err(frame) => format!("{}{}", frame.warnings.concat(), frame.error),
                };
                reports.push((index, message));
            });
            let want = (0..20).map(|index| {
                let fails = index % 5 == 4 && index < 15;
                let end = if fails { "fails" } else { "done" };
                // Every fifth frame fails, the second of them when it is processed.
                let before = if index == 9 { "read, but " } else { "" };
                (index, format!("{before}{index} {end}"))
            });
            assert!(reports.into_iter().eq(want));
            assert!(count.largest.load(SeqCst) <= most, "{memory}");
            assert_eq!(count.now.load(SeqCst), 0);
        }
    }
}
