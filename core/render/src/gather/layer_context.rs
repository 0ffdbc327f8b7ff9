//! The knowledge of a plate that the renders of its depth layers share: its highlights, and the tile sides at each vergence.

use super::highlights::PlateHighlights;
use super::image::Size;
use super::lens_probe::{LensProbe, ProbedSides, TileSides};
use crate::scatter::Sources;
use crate::{Plane, PlateMap, RenderWindow, Scene};
use seidel_optics::error::Result;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Largest number of highlight pixels of a block in each plane, for plates in depth; further bright pixels are rendered like the rest.
const MAX_HIGHLIGHTS: usize = 256;

/// The knowledge that a renderer keeps of a plate while it renders the plate's depth layers one by one.
///
/// A highlight stands out from the plate; in a layer, which is mostly dark, every pixel would. The tile sides are measured once for each
/// vergence, not for each crop.
#[derive(Default)]
pub struct LayerContext {
    pub(super) highlights: PlateHighlights,
    plate: Option<(PlateMap, Size)>,
    /// By the bits of the vergence.
    sides: Arc<Mutex<BTreeMap<u64, Arc<ProbedSides>>>>,
}

impl LayerContext {
    /// Measures the plate `planes` of `scene`.
    pub(super) fn new(scene: &Scene, planes: &[Plane]) -> Self {
        Self {
            highlights: PlateHighlights::find(planes, scene.width, MAX_HIGHLIGHTS),
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

    /// Returns the size of the plate that `scene` is a crop of.
    pub(super) fn size(&self, scene: &Scene) -> Size {
        self.plate.map_or(
            Size {
                width: scene.width,
                height: scene.height,
            },
            |(_, size)| size,
        )
    }

    /// Returns the context for planes without highlights.
    pub(crate) fn without_highlights(&self) -> Self {
        Self {
            highlights: PlateHighlights::default(),
            plate: self.plate,
            sides: Arc::clone(&self.sides),
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
