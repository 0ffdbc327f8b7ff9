//! A cause of a gap: an error of the lens as built, or of the capture.

use super::assembly::Assembly;
use super::lens::GlassLens;
use crate::perturb::{Change, Perturbation};

/// A function that builds an error of given strength into an assembly.
type Build = Box<dyn Fn(f64, &GlassLens, &mut Assembly) + Send + Sync>;

/// The part that a cause acts on.
pub(super) enum Action {
    /// The lens.
    Build(Build),
    /// The blades and the transmission of the stop, or the sensor.
    Capture(Perturbation),
}

/// A cause with all parameters drawn except its strength.
pub(super) struct GlassChange {
    /// The identifier.
    pub(super) id: &'static str,
    /// Smallest and largest strength.
    pub(super) range: [f64; 2],
    /// Parameters independent of the strength, for the answer.
    pub(super) fixed: Vec<(&'static str, f64)>,
    /// Parameters proportional to the strength, at strength 1, for the answer.
    pub(super) scaled: Vec<(&'static str, f64)>,
    pub(super) action: Action,
}

impl GlassChange {
    pub(super) fn new(
        id: &'static str,
        range: [f64; 2],
        build: impl Fn(f64, &GlassLens, &mut Assembly) + Send + Sync + 'static,
    ) -> Self {
        Self {
            id,
            range,
            fixed: Vec::new(),
            scaled: Vec::new(),
            action: Action::Build(Box::new(build)),
        }
    }

    pub(super) fn fixed(mut self, name: &'static str, value: f64) -> Self {
        self.fixed.push((name, value));
        self
    }

    pub(super) fn scaled(mut self, name: &'static str, value: f64) -> Self {
        self.scaled.push((name, value));
        self
    }
}

impl From<Change> for GlassChange {
    fn from(change: Change) -> Self {
        Self {
            id: change.id,
            range: change.range,
            fixed: change.fixed,
            scaled: change.scaled,
            action: Action::Capture(change.apply),
        }
    }
}

/// A cause of given strength.
pub(super) struct GlassCause {
    pub(super) change: GlassChange,
    pub(super) strength: f64,
}
