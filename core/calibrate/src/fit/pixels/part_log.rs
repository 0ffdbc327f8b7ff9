//! Record of the parts that the extended model tried, each with its gain and its time.

use super::part_trial::Tried;
use super::parts::Part;

/// A part of the extended model that was tried on a lens.
#[derive(Debug, Clone, PartialEq)]
pub struct PartTrial {
    /// Identifier of the effect.
    pub effect: &'static str,
    /// Decrease of the mean logarithm of the misfit of held-out zones, at best; `None` where no start lowered the misfit.
    pub gain: Option<f64>,
    /// Time of all its trials, s; `None` without [`super::PupilSettings::clock`].
    pub seconds: Option<f64>,
    /// Number of trials.
    pub trials: usize,
}

/// The parts tried so far, in the order of their first trials.
#[derive(Debug)]
pub(super) struct PartLog {
    clock: Option<fn() -> f64>,
    parts: Vec<PartTrial>,
}

impl PartLog {
    pub(super) fn new(clock: Option<fn() -> f64>) -> Self {
        Self {
            clock,
            parts: Vec::new(),
        }
    }

    /// Records a `trial` of `part` on a lens whose held-out zones have the mean log misfit `before`.
    pub(super) fn timed(
        &mut self,
        part: Part,
        before: f64,
        trial: impl FnOnce() -> Option<Tried>,
    ) -> Option<Tried> {
        let start = self.clock.map(|clock| clock());
        let tried = trial();
        let end = self.clock.map(|clock| clock());
        let record = self.of(part.effect.id());
        if let (Some(start), Some(end)) = (start, end) {
            record.seconds = Some(record.seconds.unwrap_or(0.0) + end - start);
        }
        record.trials += 1;
        if let Some(tried) = &tried {
            let gain = before - tried.missed;
            record.gain = Some(record.gain.map_or(gain, |most| most.max(gain)));
        }
        tried
    }

    fn of(&mut self, effect: &'static str) -> &mut PartTrial {
        let at = self.parts.iter().position(|p| p.effect == effect);
        let at = at.unwrap_or_else(|| {
            self.parts.push(PartTrial {
                effect,
                gain: None,
                seconds: None,
                trials: 0,
            });
            self.parts.len() - 1
        });
        &mut self.parts[at]
    }

    pub(super) fn into_parts(self) -> Vec<PartTrial> {
        self.parts
    }
}
