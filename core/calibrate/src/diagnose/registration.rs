//! The position of an observed tile against its prediction.

use seidel_optics::effects::ScenePoint;
use seidel_optics::lens::LocalPupil;

/// The knowledge of where the chief ray of a tile lies.
#[derive(Debug, Clone)]
pub(super) enum Registration {
    /// The ideal image point is stated, so every shift shows.
    Ideal,
    /// The observation is placed by the centroid of the reference channel: only shifts between channels show.
    Reference(Box<ReferencePupil>),
    /// The tile is placed by its own centroid: no shift shows.
    Centroid,
}

/// The pupil of the reference channel at an observation.
#[derive(Debug, Clone)]
pub(super) struct ReferencePupil {
    /// Scene point, for effects.
    pub(super) point: ScenePoint,
    /// Local pupil of the given lens.
    pub(super) pupil: LocalPupil,
    /// Its centroid relative to the chief ray, px.
    pub(super) centroid: [f64; 2],
}

impl Registration {
    /// Returns whether the tile is placed by its own centroid.
    pub(super) fn is_own_centroid(&self) -> bool {
        matches!(self, Self::Centroid)
    }
}
