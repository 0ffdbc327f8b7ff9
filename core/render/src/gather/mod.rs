//! The fast renderer: tiles of an image pyramid, gathered with interpolated stencils.
//!
//! The scatter O(x) = sum over x' of I(x') P_x'(x - x') equals the gather O(x) = sum over d of Q_x(d) I(x - d) with
//! the stencil Q_x(d) = P_{x-d}(d). Q changes slowly over the plate. It is computed at the corners of square tiles
//! (`corner_stencils`, on a `tile_grid`) and interpolated bilinearly between them (`fir`). Wide blur is gathered on a
//! coarser level of an image `pyramid` and upsampled; a `plan` assigns each tile its level. Small `highlights` far
//! brighter than their surroundings are subtracted first and scattered exactly.
//!
//! Light that fills little of a plate, as that of a depth layer does, is scattered instead: lit tiles (`source_tiles`) spread
//! their light (`spread`) with kernels interpolated between their own corners, level by level (`scatter_pass`). The
//! layers of a plate share what `layer_context` keeps; a `kernel_store` keeps kernels from one render to the next.

mod adjoint;
mod corner_stencils;
mod edges;
mod fir;
mod gather_pass;
mod highlight_search;
mod highlights;
mod image;
mod kernel_store;
mod layer_context;
mod lens_probe;
mod operator;
mod passband;
mod plan;
mod pyramid;
mod scatter_pass;
mod side_store;
mod source_tiles;
mod spread;
mod stencil;
#[cfg(test)]
mod tests;
mod tile_grid;
mod tolerance;
mod window;

pub(crate) use highlight_search::{
    HighlightBlock, HighlightCriterion, SearchArea, find_highlights,
};
pub use kernel_store::KernelStore;
pub use layer_context::LayerContext;
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
use scatter_pass::ScatterPass;
use seidel_optics::error::Result;
use source_tiles::source_levels;
use std::collections::BTreeSet;
use tile_grid::GridIndex;
use window::prune_to_window;

/// Largest share of lit blocks whose light is scattered tile by tile instead of gathered.
const SPARSE_SHARE: f64 = 0.6;

/// The fast renderer: gathers light tile by tile.
///
/// The result is the same to the bit for any number of threads. [`Quality`] states its error against the exact
/// renderer. Plates of varying vergence, and those too small for how fast their blur changes, are rendered exactly.
#[derive(Debug, Clone, Copy, Default)]
pub struct Gather<'a> {
    /// Accuracy.
    pub quality: Quality,
    /// Kernels of earlier renders, which the renderer uses and adds to; `None` to draw all. They change no result.
    pub kernels: Option<&'a KernelStore>,
}

impl Renderer for Gather<'_> {
    fn id(&self) -> &'static str {
        match self.quality {
            Quality::Draft => "draft",
            Quality::Final => "final",
        }
    }

    fn overshoot(&self) -> f32 {
        self.quality.tolerance().overshoot
    }

    fn is_preview(&self) -> bool {
        self.quality == Quality::Draft
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
        let VergencePass::Constant(vergence) = scene.vergence else {
            return Scatter.render_window(scene, planes, window, progress);
        };
        self.with_job(scene, planes, vergence, progress, |job| {
            let job = Job { window, ..job };
            let Some(sides) = job.tile_sides()? else {
                return Scatter.render_window(scene, planes, window, progress);
            };
            let split = if job.lens.is_wider_than(job.size()) {
                HighlightSplit::none(planes)
            } else {
                HighlightSplit::new(planes, scene.width)
            };
            let views = job.views(&split);
            let lit = LitBlocks::new(&views);
            if lit.share() < SPARSE_SHARE || job.lens.has_line_in_focus(job.size()) {
                return job.scatter(planes, &sides, &split);
            }
            job.gather(planes, &sides, &lit, &split)
        })
    }

    fn layer_context(&self, scene: &Scene) -> LayerContext {
        LayerContext::new(scene)
    }

    fn render_layer(
        &self,
        scene: &Scene,
        planes: &[Plane],
        context: &LayerContext,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        scene.check(planes)?;
        let VergencePass::Constant(vergence) = scene.vergence else {
            return Scatter.render(scene, planes, progress);
        };
        self.with_job(scene, planes, vergence, progress, |job| {
            let sides = context.tile_sides(scene, &job.lens)?;
            if !job.fits(&sides) {
                return Scatter.render(scene, planes, progress);
            }
            job.scatter(planes, &sides, &HighlightSplit::none(planes))
        })
    }
}

impl Gather<'_> {
    /// Runs `work` on a render of the whole of `planes` at `vergence`.
    fn with_job(
        &self,
        scene: &Scene,
        planes: &[Plane],
        vergence: f64,
        progress: &(dyn Fn(f64) -> bool + Sync),
        work: impl FnOnce(Job) -> Result<Rendered>,
    ) -> Result<Rendered> {
        let sources = Sources::new(scene);
        let mixes = ChannelMixes::new(planes.iter().map(|plane| plane.weights));
        work(Job {
            scene,
            lens: LensProbe {
                sources: &sources,
                model: scene.model,
                vergence,
                mixes: &mixes.weights,
                tolerance: &self.quality.tolerance(),
                kernels: self.kernels,
                progress,
            },
            mix_of: mixes.mix_of.clone(),
            window: RenderWindow::whole(scene),
            progress,
        })
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
    /// Returns the planes without their highlights.
    fn views<'s>(&self, split: &'s HighlightSplit) -> Vec<View<'s>> {
        let rest = split.rest.iter();
        rest.map(|samples| View::whole(self.size(), samples))
            .collect()
    }

    /// Renders dense light: gathers `planes` without the highlights of `split` tile by tile where `lit` blocks are near.
    fn gather(
        &self,
        planes: &[Plane],
        sides: &TileSides,
        lit: &LitBlocks,
        split: &HighlightSplit,
    ) -> Result<Rendered> {
        let pass = self.pass(lit, sides)?;
        let mut plates = pass.forward(&self.views(split), self.window, self.progress)?;
        split.scatter(self.scene, self.window, &self.lens, planes, &mut plates)?;
        let levels = pass.levels.iter().map(|level| LevelStatistics {
            gathered: level.gathered.len(),
            scattered: 0,
            upsampled: level.upsampled.len(),
            min_tile_px: level.grid.tile,
            max_tile_px: level.grid.tile,
        });
        Ok(rendered(plates, levels.collect(), split))
    }

    /// Renders sparse light: scatters `planes` without the highlights of `split` tile by tile.
    fn scatter(
        &self,
        planes: &[Plane],
        sides: &TileSides,
        split: &HighlightSplit,
    ) -> Result<Rendered> {
        let (distinct, light_of) = distinct(&self.views(split));
        let pass = ScatterPass {
            levels: source_levels(&self.lens, &distinct, self.scene, sides)?,
            light_of: &light_of,
            mix_of: &self.mix_of,
            size: self.size(),
            edges: self.scene.edges,
        };
        let levels = pass.levels.iter().map(|level| LevelStatistics {
            gathered: 0,
            scattered: level.tile_count(),
            upsampled: 0,
            min_tile_px: level.parts.last().map_or(0, |part| part.grid.tile),
            max_tile_px: level.parts.first().map_or(0, |part| part.grid.tile),
        });
        let levels = levels.collect();
        let mut plates = pass.render(self.progress)?;
        let whole = RenderWindow::whole(self.scene);
        split.scatter(self.scene, whole, &self.lens, planes, &mut plates)?;
        let plates = self.window.cut_planes(self.scene, plates);
        Ok(rendered(plates, levels, split))
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
        let sides = self.lens.probed_sides(self.size())?;
        let sides = sides.in_window(RenderWindow::whole(self.scene));
        Ok(self.fits(&sides).then_some(sides))
    }

    fn fits(&self, sides: &TileSides) -> bool {
        sides.at(0) >= self.min_tile() || self.lens.model.needs_rays()
    }

    fn min_tile(&self) -> usize {
        self.lens.tolerance.min_tile_for(self.lens.model)
    }

    /// Plans the render of planes lit in the blocks `lit` and computes its stencils.
    fn pass(&self, lit: &LitBlocks, sides: &TileSides) -> Result<GatherPass> {
        let plan = self.plan(lit, sides)?;
        let stencils = plan.levels.iter().map(|level| {
            let corners = corners_of(&level.gathered);
            let (reach, edges) = (plan.reach, self.scene.edges);
            corner_stencils::compute(&self.lens, &level.grid, &corners, reach, edges)
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

/// Returns a render of one vergence with the work of its levels.
fn rendered(
    planes: Vec<Vec<f32>>,
    levels: Vec<LevelStatistics>,
    split: &HighlightSplit,
) -> Rendered {
    Rendered {
        planes,
        statistics: RenderStatistics {
            layers: 1,
            renders: 1,
            exact: 0,
            levels,
            highlights: split.pixel_count(),
        },
    }
}

/// Returns `views` without those of the same samples as an earlier one, as presence has them for each channel, and the place of each view
/// among these.
fn distinct<'a>(views: &[View<'a>]) -> (Vec<View<'a>>, Vec<usize>) {
    let mut distinct: Vec<View> = Vec::new();
    let places = views.iter().map(|view| {
        let known = (distinct.iter()).position(|other| std::ptr::eq(other.samples, view.samples));
        known.unwrap_or_else(|| {
            distinct.push(*view);
            distinct.len() - 1
        })
    });
    let places = places.collect();
    (distinct, places)
}

/// Returns the corners of tiles.
fn corners_of(tiles: &BTreeSet<GridIndex>) -> BTreeSet<GridIndex> {
    tiles.iter().flat_map(|tile| tile.corners()).collect()
}
