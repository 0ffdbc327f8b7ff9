//! The knowledge of a plate that the renders of its depth layers share: the tile sides at each vergence.

use super::image::Size;
use super::lens_probe::{LensProbe, ProbedSides, TileSides};
use crate::scatter::Sources;
use crate::{PlateMap, RenderWindow, Scene};
use seidel_optics::error::Result;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The knowledge that a renderer keeps of a plate while it renders the plate's depth layers one by one.
///
/// The tile sides are measured once for each vergence, not for each crop.
#[derive(Default)]
pub struct LayerContext {
    plate: Option<(PlateMap, Size)>,
    /// By the bits of the vergence.
    sides: Arc<Mutex<BTreeMap<u64, Arc<ProbedSides>>>>,
}

impl LayerContext {
    /// The context of the plate of `scene`, without knowledge yet.
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            plate: Some((
                scene.map,
                Size {
                    width: scene.width,
                    height: scene.height,
                },
            )),
            sides: Arc::default(),
        }
    }

    /// Returns the tile sides of `lens` on the whole plate. `scene` is the scene of the crop.
    ///
    /// Sides of the crop alone would change as the crop moves, and with them the light of surfaces that stand still.
    ///
    /// # Errors
    /// A lens that cannot be drawn at some point.
    pub(super) fn tile_sides(&self, scene: &Scene, lens: &LensProbe) -> Result<TileSides> {
        let Some((map, size)) = self.plate else {
            let size = Size {
                width: scene.width,
                height: scene.height,
            };
            return Ok(lens
                .probed_sides(size)?
                .in_window(RenderWindow::whole(scene)));
        };
        let whole = RenderWindow::from_size(size.width, size.height);
        let key = lens.vergence.to_bits();
        let known = self.known_sides().get(&key).map(Arc::clone);
        if let Some(known) = known {
            return Ok(known.in_window(whole));
        }
        let plate = Scene {
            width: size.width,
            height: size.height,
            map,
            ..*scene
        };
        let sources = Sources::new(&plate);
        let probe = LensProbe {
            sources: &sources,
            ..*lens
        };
        let found = match lens.kernels {
            Some(store) => store.sides.sides(&probe, size)?,
            None => Arc::new(probe.probed_sides(size)?),
        };
        let sides = found.in_window(whole);
        self.known_sides().insert(key, found);
        Ok(sides)
    }

    fn known_sides(&self) -> MutexGuard<'_, BTreeMap<u64, Arc<ProbedSides>>> {
        self.sides.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
