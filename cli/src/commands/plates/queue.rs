//! Frames in flight: while one is blurred the next is read and those before are written.
//!
//! Frames are blurred one after the other, each on all threads; reading and writing go on beside.
//! What is said of them comes in their order.

use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel, sync_channel};
use std::sync::{Mutex, PoisonError};

use rayon::ThreadPool;

use super::memory::{Budget, Claim};
use crate::commands::CommandError;

/// Frames that wait between two stages. More would not make the slowest stage faster.
const WAITING: usize = 1;

/// Frames written at once: packing one goes on while the disk takes in the other.
const WRITERS: usize = 2;

/// What is done to each frame, known by its place in the run.
pub(crate) trait Stages: Sync {
    /// A frame that was read.
    type Read: Send;
    /// A frame to be written.
    type Done: Send;

    /// Reads a frame.
    fn read(&self, index: usize) -> Result<Self::Read, CommandError>;

    /// Memory that the frame will take at most, bytes.
    fn bytes(&self, frame: &Self::Read) -> u64;

    /// Blurs it.
    fn blur(&self, index: usize, frame: Self::Read) -> Result<Self::Done, CommandError>;

    /// Writes it; returns what the user should know of it.
    fn write(&self, index: usize, frame: Self::Done) -> Result<Vec<String>, CommandError>;
}

/// What became of a frame: what the user should know of it, or why it failed.
pub(crate) type Outcome = Result<Vec<String>, CommandError>;

/// The threads that read frames, and those that blur them.
pub(crate) struct Pools {
    pub(crate) reading: ThreadPool,
    pub(crate) blurring: ThreadPool,
}

/// Takes `count` frames through `stages`, as many at once as fit into `limit` bytes, at least one.
/// Calls `report` for each frame in their order, as soon as those before are done.
pub(crate) fn run_all<S: Stages>(
    stages: &S,
    pools: &Pools,
    count: usize,
    limit: u64,
    mut report: impl FnMut(usize, Outcome),
) {
    let budget = Budget::new(limit);
    let (read, to_blur) = sync_channel(WAITING);
    let (blurred, to_write) = sync_channel(WAITING);
    let to_write = Mutex::new(to_write);
    let (finished, outcomes) = channel();
    std::thread::scope(|scope| {
        let failed = finished.clone();
        scope.spawn(|| {
            // Everything that a stage holds on to must end with it, or the next waits for ever.
            let (read, failed) = (read, failed);
            for index in 0..count {
                let mut claim = budget.claim();
                let sent = match pools.reading.install(|| stages.read(index)) {
                    Ok(frame) => {
                        claim.settle(stages.bytes(&frame));
                        read.send((index, frame, claim)).is_ok()
                    }
                    Err(error) => failed.send((index, Err(error))).is_ok(),
                };
                if !sent {
                    break;
                }
            }
        });
        let failed = finished.clone();
        scope.spawn(|| {
            let (to_blur, blurred, failed) = (to_blur, blurred, failed);
            for (index, frame, claim) in to_blur {
                let sent = match pools.blurring.install(|| stages.blur(index, frame)) {
                    Ok(done) => blurred.send((index, done, claim)).is_ok(),
                    Err(error) => failed.send((index, Err(error))).is_ok(),
                };
                if !sent {
                    break;
                }
            }
        });
        for _ in 0..WRITERS {
            let finished = finished.clone();
            scope.spawn(|| write_each(stages, &to_write, finished));
        }
        drop(finished);
        let mut early = BTreeMap::new();
        let mut next = 0;
        for (index, outcome) in outcomes {
            early.insert(index, outcome);
            while let Some(outcome) = early.remove(&next) {
                report(next, outcome);
                next += 1;
            }
        }
    });
}

/// Writes frames as long as any come.
fn write_each<S: Stages>(
    stages: &S,
    to_write: &Mutex<Receiver<(usize, S::Done, Claim)>>,
    finished: Sender<(usize, Outcome)>,
) {
    loop {
        let next = to_write
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .recv();
        let Ok((index, done, claim)) = next else {
            return;
        };
        let outcome = stages.write(index, done);
        drop(claim);
        if finished.send((index, outcome)).is_err() {
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

    /// Frames of 10 bytes that take longer the earlier they are; every fifth fails at one stage.
    #[derive(Default)]
    struct Made {
        held: AtomicU64,
        most: AtomicU64,
    }

    fn bad(index: usize, stage: usize) -> Result<(), CommandError> {
        if index % 5 == 4 && index / 5 == stage {
            return Err(CommandError::Usage(format!("{index} fails")));
        }
        Ok(())
    }

    /// A frame that knows when it is let go.
    struct Held<'a>(&'a Made);

    impl Drop for Held<'_> {
        fn drop(&mut self) {
            self.0.held.fetch_sub(10, SeqCst);
        }
    }

    impl<'a> Stages for &'a Made {
        type Read = Held<'a>;
        type Done = Held<'a>;

        fn read(&self, index: usize) -> Result<Held<'a>, CommandError> {
            let now = self.held.fetch_add(10, SeqCst) + 10;
            self.most.fetch_max(now, SeqCst);
            let frame = Held(self);
            bad(index, 0).map(|()| frame)
        }

        fn bytes(&self, _: &Held) -> u64 {
            10
        }

        fn blur(&self, index: usize, frame: Held<'a>) -> Result<Held<'a>, CommandError> {
            bad(index, 1).map(|()| frame)
        }

        fn write(&self, index: usize, frame: Held<'a>) -> Outcome {
            let _frame = frame;
            std::thread::sleep(Duration::from_millis(20 - index.min(20) as u64));
            bad(index, 2).map(|()| vec![format!("{index} done")])
        }
    }

    #[test]
    fn frames_come_in_order_within_the_memory_given() {
        let pool = || ThreadPoolBuilder::new().num_threads(1).build();
        let pools = Pools {
            reading: pool().expect("a thread"),
            blurring: pool().expect("a thread"),
        };
        for (limit, most) in [(1, 10), (10, 10), (25, 20), (1000, 1000)] {
            let made = Made::default();
            let mut reports = Vec::new();
            run_all(&&made, &pools, 20, limit, |index, outcome| {
                let words = match outcome {
                    Ok(warnings) => warnings.concat(),
                    Err(error) => error.to_string(),
                };
                reports.push((index, words));
            });
            let want = (0..20).map(|index| {
                let fails = index % 5 == 4 && index < 15;
                let what = if fails { "fails" } else { "done" };
                (index, format!("{index} {what}"))
            });
            assert!(reports.into_iter().eq(want));
            assert!(made.most.load(SeqCst) <= most, "{limit}");
            assert_eq!(made.held.load(SeqCst), 0);
        }
    }
}
