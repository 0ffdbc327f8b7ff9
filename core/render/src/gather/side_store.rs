//! Tile sides kept from one render to the next.

use super::image::Size;
use super::lens_probe::{LensProbe, PROBES, ProbedSides};
use super::tolerance::Tolerance;
use crate::scatter::Source;
use seidel_optics::error::Result;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most vergences whose sides are kept; the oldest make room.
const MOST: usize = 512;

/// The blur at the places where tile sides are measured, and the accuracy.
#[derive(Debug, Clone, PartialEq)]
struct SidesKey {
    size: Size,
    model: &'static str,
    tolerance: Tolerance,
    /// The sources of all channels at each place.
    sources: Vec<Option<Source>>,
}

/// Tile sides that renders have measured, kept for the next ones.
#[derive(Default)]
pub(super) struct SideStore {
    known: Mutex<VecDeque<(SidesKey, Arc<ProbedSides>)>>,
}

impl SideStore {
    /// Returns the tile sides of `lens` on a plate of `size`, known or measured.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn sides(&self, lens: &LensProbe, size: Size) -> Result<Arc<ProbedSides>> {
        let key = SidesKey::new(lens, size)?;
        let found = self.find(&key);
        if let Some(found) = found {
            return Ok(found);
        }
        let sides = Arc::new(lens.probed_sides(size)?);
        let mut known = self.known();
        if known.len() == MOST {
            known.pop_front();
        }
        known.push_back((key, Arc::clone(&sides)));
        Ok(sides)
    }

    fn find(&self, key: &SidesKey) -> Option<Arc<ProbedSides>> {
        let known = self.known();
        let found = known.iter().find(|(known, _)| known == key);
        found.map(|(_, sides)| Arc::clone(sides))
    }

    fn known(&self) -> MutexGuard<'_, VecDeque<(SidesKey, Arc<ProbedSides>)>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl SidesKey {
    fn new(lens: &LensProbe, size: Size) -> Result<Self> {
        let (mut sources, mut found) = (Vec::new(), Vec::new());
        for (x, y) in PROBES {
            lens.sources_at((x * size.width as f64, y * size.height as f64), &mut found)?;
            sources.append(&mut found);
        }
        Ok(Self {
            size,
            model: lens.model.id(),
            tolerance: *lens.tolerance,
            sources,
        })
    }
}
