//! The fast renderer: every output pixel gathers the light of the sources about it.
//!
//! The scatter O(x) = sum over x' of I(x') P_x'(x - x') is the gather O(x) = sum over d of Q_x(d) I(x - d)
//! with Q_x(d) = P_{x-d}(d). Q changes slowly over the plate: it is made at the corners of square tiles
//! (`corners`, on a `grid`) and is bilinear between (`fir`). Where the blur is wide the same is done on
//! a coarser level of a `pyramid`; a `plan` says which tile is gathered where. Small `lights` far brighter than
//! what is about them are taken off first and scattered exactly.

mod adjoint;
mod corners;
mod edges;
mod fir;
mod grid;
mod image;
mod lights;
mod narrow;
mod operator;
mod optics;
mod pass;
mod passband;
mod plan;
mod pyramid;
mod stencil;
#[cfg(test)]
mod tests;
mod tolerance;

pub use operator::Operator;
pub use tolerance::Quality;

use crate::scatter::Sources;
use crate::{
    Edges, LevelStatistics, Plane, RenderStatistics, RenderWindow, Rendered, Renderer, Scatter,
    Scene, VergencePass, cancelled,
};
use edges::fold_early;
use image::View;
use lights::Split;
use narrow::narrow;
use optics::{Optics, Sides};
use pass::Pass;
use plan::{Brief, Level, Lit, plan};
use seidel_optics::error::Result;
use std::collections::BTreeSet;
use tolerance::Tolerance;

/// Gathers light tile by tile. The result is the same to the bit for any number of threads. How far it
/// is from the exact renderer's is said by its [`Quality`].
#[derive(Debug, Clone, Copy, Default)]
pub struct Gather {
    /// How exact.
    pub quality: Quality,
}

impl Renderer for Gather {
    fn id(&self) -> &'static str {
        match self.quality {
            Quality::Draft => "draft",
            Quality::Final => "final",
        }
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
        let (mixes, mix_of) = mixes(planes);
        let tolerance = self.quality.tolerance();
        let optics = Optics {
            sources: &sources,
            model: scene.model,
            vergence,
            mixes: &mixes,
            tolerance: &tolerance,
            progress,
        };
        let job = Job {
            scene,
            optics,
            mix_of,
            window,
            progress,
        };
        job.render(planes)
    }
}

/// The distinct channel weights of `planes`, and which of them each plane has.
fn mixes(planes: &[Plane]) -> (Vec<Vec<f64>>, Vec<usize>) {
    let mut mixes: Vec<Vec<f64>> = Vec::new();
    let mix_of = planes
        .iter()
        .map(|plane| {
            let known = mixes.iter().position(|mix| mix == plane.weights);
            known.unwrap_or_else(|| {
                mixes.push(plane.weights.to_vec());
                mixes.len() - 1
            })
        })
        .collect();
    (mixes, mix_of)
}

/// A render under way.
struct Job<'a> {
    scene: &'a Scene<'a>,
    optics: Optics<'a>,
    mix_of: Vec<usize>,
    window: RenderWindow,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
}

impl Job<'_> {
    fn render(&self, planes: &[Plane]) -> Result<Rendered> {
        let Some(sides) = self.sides()? else {
            return Scatter.render_window(self.scene, planes, self.window, self.progress);
        };
        let split = Split::of(planes, self.scene.width);
        let views = self.views(&split);
        let pass = self.pass(&Lit::of(&views), &sides)?;
        let mut plates = pass.forward(&views, self.window, self.progress)?;
        let place = (self.scene, self.window);
        split.scatter(place, &self.optics, planes, self.progress, &mut plates)?;
        let levels = pass.levels.iter().map(|level| LevelStatistics {
            gathered: level.gathered.len(),
            upsampled: level.doubled.len(),
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
                highlights: split.count(),
            },
        })
    }

    /// How wide tiles may be; none where blur changes by too much of itself from pixel to pixel, as only a
    /// small plate's can.
    fn sides(&self) -> Result<Option<Sides>> {
        let Scene { width, height, .. } = *self.scene;
        let sides = self.optics.sides((width, height))?;
        let fits = sides.at(0) >= self.least_tile() || self.optics.model.needs_rays();
        Ok(fits.then_some(sides))
    }

    fn least_tile(&self) -> usize {
        self.optics.tolerance.least_tile_for(self.optics.model)
    }

    /// What is gathered: planes with their lights taken off.
    fn views<'s>(&self, split: &'s Split) -> Vec<View<'s>> {
        let Scene { width, height, .. } = *self.scene;
        let view = |samples| View {
            left: 0,
            top: 0,
            width,
            height,
            samples,
        };
        split.rest.iter().map(|samples| view(&**samples)).collect()
    }

    /// All that the render of light in these places needs but the light.
    fn pass(&self, lit: &Lit, sides: &Sides) -> Result<Pass> {
        let (levels, folded, reach) = self.planned(lit, sides)?;
        let stencils = levels.iter().map(|level| {
            let corners = corners_of(&level.gathered);
            corners::stencils(&self.optics, &level.grid, &corners, reach)
        });
        Ok(Pass {
            stencils: stencils.collect::<Result<_>>()?,
            levels,
            folded,
            mix_of: self.mix_of.clone(),
            size: (self.scene.width, self.scene.height),
            edges: self.scene.edges,
        })
    }

    /// The work of all levels, the level at which light beyond the edges is folded back, and how far light goes.
    fn planned(&self, lit: &Lit, sides: &Sides) -> Result<(Vec<Level>, usize, i32)> {
        let Scene { width, height, .. } = *self.scene;
        let reach = self.optics.reach((width, height))?;
        let beyond = match self.scene.edges {
            Edges::Mirror => reach,
            Edges::Black => 0,
        };
        let span = |size: usize| -beyond..size as i32 + beyond;
        let sigma = |at: (f64, f64)| self.optics.least_sigma(at);
        let mut levels = plan(&Brief {
            size: (width, height),
            sides,
            least_tile: self.least_tile(),
            wanted: (span(width), span(height)),
            reach,
            sigma: &sigma,
            least_sigma: self.optics.tolerance.least_sigma_for(self.optics.model),
            lit,
        });
        let folded = fold_early((width, height), self.scene.edges, &mut levels);
        if self.window != RenderWindow::whole(self.scene) {
            let plate = ((width, height), self.scene.edges);
            narrow(&mut levels, folded, plate, self.window);
        }
        Ok((levels, folded, reach))
    }
}

/// The corners (row, column) of tiles.
fn corners_of(tiles: &BTreeSet<(i32, i32)>) -> BTreeSet<(i32, i32)> {
    let about = |&(y, x): &(i32, i32)| [(y, x), (y, x + 1), (y + 1, x), (y + 1, x + 1)];
    tiles.iter().flat_map(about).collect()
}
