//! Progress of work in stages.

use seidel_optics::Progress;
use seidel_optics::error::{Error, Result};

/// A part of long work, from one share of it to another.
#[derive(Clone, Copy)]
pub(crate) struct Stage<'a> {
    progress: &'a Progress<'a>,
    /// Name of the whole work, for the error of a cancellation.
    work: &'static str,
    from: f64,
    to: f64,
}

impl<'a> Stage<'a> {
    /// Creates the stage that is all of the work called `work`.
    pub(crate) fn whole(progress: &'a Progress<'a>, work: &'static str) -> Self {
        Self {
            progress,
            work,
            from: 0.0,
            to: 1.0,
        }
    }

    /// Returns the part of this stage between two shares of it.
    pub(crate) fn part(&self, from: f64, to: f64) -> Self {
        let share = |at: f64| self.from + (self.to - self.from) * at;
        Self {
            from: share(from),
            to: share(to),
            ..*self
        }
    }

    /// Returns part `index` of `count` equal ones.
    pub(crate) fn part_of(&self, index: usize, count: usize) -> Self {
        let share = |k: usize| k as f64 / count.max(1) as f64;
        self.part(share(index), share(index + 1))
    }

    /// Reports that `share` (0 to 1) of the stage is done.
    ///
    /// # Errors
    /// Cancellation by the caller.
    pub(crate) fn reach(&self, share: f64) -> Result<()> {
        if (self.progress)(self.from + (self.to - self.from) * share) {
            Ok(())
        } else {
            Err(Error::cancelled(self.work))
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn parts_cover_the_whole_and_cancellation_is_an_error() {
        let seen = Mutex::new(Vec::new());
        let progress = |share: f64| {
            seen.lock().expect("one thread").push(share);
            share < 0.8
        };
        let whole = Stage::whole(&progress, "fit");
        let second = whole.part(0.5, 1.0);
        whole.reach(0.0).expect("goes on");
        second.part_of(0, 4).reach(1.0).expect("goes on");
        second.reach(0.5).expect("goes on");
        let error = second.part_of(3, 4).reach(0.5).expect_err("cancelled");
        assert!(error.is_cancelled() && error.to_string().contains("fit"));
        drop(error);
        assert_eq!(
            seen.into_inner().expect("one thread"),
            [0.0, 0.625, 0.75, 0.9375]
        );
    }
}
