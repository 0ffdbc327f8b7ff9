//! The fast renderer: tiles of an image pyramid, gathered with interpolated stencils.
//!
//! The scatter O(x) = sum over x' of I(x') P_x'(x - x') equals the gather O(x) = sum over d of Q_x(d) I(x - d) with
//! the stencil Q_x(d) = P_{x-d}(d). Q changes slowly over the plate. It is computed at the corners of square tiles
//! (`corner_stencils`, on a `tile_grid`) and interpolated bilinearly between them (`fir`). Wide blur is gathered on a
//! coarser level of an image `pyramid` and upsampled; a `plan` assigns each tile its level. Small `highlights` far
//! brighter than their surroundings are subtracted first and scattered exactly.

mod adjoint;
mod corner_stencils;
mod edges;
mod fir;
mod gather_pass;
mod highlights;
mod image;
mod lens_probe;
mod operator;
mod passband;
mod plan;
mod pyramid;
mod stencil;
#[cfg(test)]
mod tests;
mod tile_grid;
mod tolerance;
mod window;

pub use operator::Operator;
pub use tolerance::Quality;

use crate::scatter::Sources;
use crate::{
    Edges, LevelStatistics, Plane, RenderStatistics, RenderWindow, Rendered, Renderer, Scatter,
    Scene, VergencePass,
};
use edges::fold_early;
use gather_pass::GatherPass;
use highlights::HighlightSplit;
use image::{Size, View};
use lens_probe::{LensProbe, TileSides};
use plan::{Level, LitBlocks, PlanInputs, plan};
use seidel_optics::error::Result;
use std::collections::BTreeSet;
use tile_grid::GridIndex;
use window::prune_to_window;

/// The fast renderer: gathers light tile by tile.
///
/// The result is the same to the bit for any number of threads. [`Quality`] states its error against the exact
/// renderer. Plates of varying vergence, and those too small for how fast their blur changes, are rendered exactly.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gather {
    /// Accuracy.
    pub quality: Quality,
}

impl Renderer for Gather {
    fn id(&self) -> &'static str {
        match self.quality {
            Quality::Draft => "draft",
            Quality::Final => "final",
        }
    }

    fn overshoot(&self) -> f32 {
        self.quality.tolerance().overshoot
    }

    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        scene.check(planes)?;
        window.check(scene)?;
        let vergence = match scene.vergence {
            VergencePass::Constant(vergence) => vergence,
            VergencePass::PerPixel(_) => {
                return Scatter.render_window(scene, planes, window, progress);
            }
        };
        let sources = Sources::new(scene);
        let mixes = ChannelMixes::new(planes.iter().map(|plane| plane.weights));
        let job = Job {
            scene,
            lens: LensProbe {
                sources: &sources,
                model: scene.model,
                vergence,
                mixes: &mixes.weights,
                tolerance: &self.quality.tolerance(),
                progress,
            },
            mix_of: mixes.mix_of.clone(),
            window,
            progress,
        };
        job.render(planes)
    }
}

/// The distinct channel weights of planes. Planes with the same weights share their stencils.
struct ChannelMixes {
    /// One weight per lens channel for each mix.
    weights: Vec<Vec<f64>>,
    /// Index of each plane's mix.
    mix_of: Vec<usize>,
}

impl ChannelMixes {
    /// Collects the mixes of planes with these channel weights.
    fn new<'a>(planes: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut weights: Vec<Vec<f64>> = Vec::new();
        let mix_of = planes
            .map(|plane| {
                let known = weights.iter().position(|mix| mix == plane);
                known.unwrap_or_else(|| {
                    weights.push(plane.to_vec());
                    weights.len() - 1
                })
            })
            .collect();
        Self { weights, mix_of }
    }
}

/// A render in progress.
struct Job<'a> {
    scene: &'a Scene<'a>,
    lens: LensProbe<'a>,
    /// Index of each plane's channel mix.
    mix_of: Vec<usize>,
    window: RenderWindow,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
}

/// The work of a render at all levels.
struct Plan {
    /// Finest first.
    levels: Vec<Level>,
    /// Level at which light beyond the plate's edges is folded back.
    fold_level: usize,
    /// Upper bound of how far light travels, px.
    reach: i32,
}

impl Job<'_> {
    fn render(&self, planes: &[Plane]) -> Result<Rendered> {
        let Some(sides) = self.tile_sides()? else {
            return Scatter.render_window(self.scene, planes, self.window, self.progress);
        };
        let split = HighlightSplit::new(planes, self.scene.width);
        let size = self.size();
        let rest = split.rest.iter();
        let views: Vec<View> = rest.map(|samples| View::whole(size, samples)).collect();
        let pass = self.pass(&LitBlocks::new(&views), &sides)?;
        let mut plates = pass.forward(&views, self.window, self.progress)?;
        split.scatter(self.scene, self.window, &self.lens, planes, &mut plates)?;
        let levels = pass.levels.iter().map(|level| LevelStatistics {
            gathered: level.gathered.len(),
            upsampled: level.upsampled.len(),
            min_tile_px: level.grid.tile,
            max_tile_px: level.grid.tile,
        });
        Ok(Rendered {
            planes: plates,
            statistics: RenderStatistics {
                layers: 1,
                renders: 1,
                exact: 0,
                levels: levels.collect(),
                highlights: split.pixel_count(),
            },
        })
    }

    fn size(&self) -> Size {
        Size {
            width: self.scene.width,
            height: self.scene.height,
        }
    }

    /// Returns the largest tiles allowed; `None` where the blur changes too much from pixel to pixel for any, as it
    /// can on small plates only.
    fn tile_sides(&self) -> Result<Option<TileSides>> {
        let sides = self.lens.tile_sides(self.size())?;
        let fits = sides.at(0) >= self.min_tile() || self.lens.model.needs_rays();
        Ok(fits.then_some(sides))
    }

    fn min_tile(&self) -> usize {
        self.lens.tolerance.min_tile_for(self.lens.model)
    }

    /// Plans the render of planes lit in the blocks `lit` and computes its stencils.
    fn pass(&self, lit: &LitBlocks, sides: &TileSides) -> Result<GatherPass> {
        let plan = self.plan(lit, sides)?;
        let stencils = plan.levels.iter().map(|level| {
            let corners = corners_of(&level.gathered);
            corner_stencils::compute(&self.lens, &level.grid, &corners, plan.reach)
        });
        Ok(GatherPass {
            stencils: stencils.collect::<Result<_>>()?,
            levels: plan.levels,
            fold_level: plan.fold_level,
            mix_of: self.mix_of.clone(),
            size: self.size(),
            edges: self.scene.edges,
        })
    }

    fn plan(&self, lit: &LitBlocks, sides: &TileSides) -> Result<Plan> {
        let size = self.size();
        let reach = self.lens.reach(size)?;
        let beyond = match self.scene.edges {
            Edges::Mirror => reach,
            Edges::Black => 0,
        };
        let span = |size: usize| -beyond..size as i32 + beyond;
        let sigma = |at: (f64, f64)| self.lens.min_sigma(at);
        let mut levels = plan(&PlanInputs {
            size,
            sides,
            min_tile: self.min_tile(),
            columns: span(size.width),
            rows: span(size.height),
            reach,
            sigma: &sigma,
            min_sigma: self.lens.tolerance.min_sigma_for(self.lens.model),
            lit,
        });
        let fold_level = fold_early(size, self.scene.edges, &mut levels);
        if self.window != RenderWindow::whole(self.scene) {
            prune_to_window(&mut levels, fold_level, size, self.scene.edges, self.window);
        }
        Ok(Plan {
            levels,
            fold_level,
            reach,
        })
    }
}

/// Returns the corners of tiles.
fn corners_of(tiles: &BTreeSet<GridIndex>) -> BTreeSet<GridIndex> {
    tiles.iter().flat_map(|tile| tile.corners()).collect()
}
