//! Causes of a gap of traced lenses: errors of the lens as built, or of the capture.

use super::assembly::Assembly;
use super::lens::GlassLens;
use crate::change::{Cause, Change};
use crate::perturb::{self, Perturbation};

/// A function that builds an error of given strength into an assembly.
type Build = Box<dyn Fn(f64, &GlassLens, &mut Assembly) + Send + Sync>;

/// The part that a cause acts on.
pub(crate) enum Action {
    /// The lens.
    Build(Build),
    /// The blades and the transmission of the stop, or the sensor.
    Capture(Perturbation),
}

/// A cause with all parameters drawn except its strength.
pub(super) type GlassChange = Change<Action>;

/// A cause of given strength.
pub(super) type GlassCause = Cause<Action>;

impl GlassChange {
    pub(super) fn new(
        id: &'static str,
        range: [f64; 2],
        build: impl Fn(f64, &GlassLens, &mut Assembly) + Send + Sync + 'static,
    ) -> Self {
        Self::with_action(id, range, Action::Build(Box::new(build)))
    }
}

impl From<perturb::Change> for GlassChange {
    fn from(change: perturb::Change) -> Self {
        Self {
            id: change.id,
            range: change.range,
            fixed: change.fixed,
            scaled: change.scaled,
            action: Action::Capture(change.action),
            moves_far: change.moves_far,
        }
    }
}
