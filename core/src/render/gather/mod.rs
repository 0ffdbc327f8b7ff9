//! The fast renderer: every output pixel gathers the light of the sources about it.
//!
//! The scatter O(x) = sum over x' of I(x') P_x'(x - x') is the gather O(x) = sum over d of Q_x(d) I(x - d)
//! with Q_x(d) = P_{x-d}(d). Q changes slowly over the plate: it is made at the corners of square tiles
//! (`corners`, on a `grid`) and is bilinear between (`fir`). Where the blur is wide the same is done on
//! a coarser level of a `pyramid`; a `plan` says which tile is gathered where. Small `lights` far brighter than
//! what is about them are taken off first and scattered exactly.

mod corners;
mod edges;
mod fir;
mod grid;
mod image;
mod lights;
#[cfg(test)]
mod lights_tests;
mod methods;
mod narrow;
mod optics;
mod passband;
mod plan;
#[cfg(test)]
mod property_tests;
mod pyramid;
#[cfg(test)]
mod random_lens_tests;
mod stencil;
#[cfg(test)]
mod tests;
mod tolerance;
#[cfg(test)]
mod window_tests;

pub use tolerance::Quality;

use super::sources::Sources;
use super::{Edges, Methods, Plane, Renderer, Scatter, Scene, VergencePass, Window, stopped};
use crate::error::Result;
use corners::{Mixed, Places};
use edges::{cut, fold_early, mirrored};
use fir::{Blend, LANES, ROWS};
use image::{Image, View};
use lights::Split;
use narrow::narrow;
use optics::{Optics, Sides};
use plan::{Brief, Level, Lit, plan};
use pyramid::{Doubling, doubled, halved};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};
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

    fn render(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        self.render_window(scene, planes, Window::whole(scene), progress)
    }

    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: Window,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        scene.check(planes)?;
        window.check(scene)?;
        let vergence = match scene.vergence {
            VergencePass::Constant(vergence) => vergence,
            VergencePass::PerPixel(_) => {
                return Scatter.render_window(scene, planes, window, progress);
            }
        };
        let place = (window, vergence);
        self.with_job(scene, planes, place, progress, |job| job.render(planes))
    }

    fn methods(&self, scene: &Scene, planes: &[Plane]) -> Result<Methods> {
        scene.check(planes)?;
        let VergencePass::Constant(vergence) = scene.vergence else {
            return Scatter.methods(scene, planes);
        };
        let place = (Window::whole(scene), vergence);
        self.with_job(scene, planes, place, &|_| true, |job| job.methods(planes))
    }
}

impl Gather {
    /// Does `work` with the render of `planes`, all at one vergence.
    fn with_job<T>(
        &self,
        scene: &Scene,
        planes: &[Plane],
        (window, vergence): (Window, f64),
        progress: &(dyn Fn(f64) -> bool + Sync),
        work: impl FnOnce(&Job) -> Result<T>,
    ) -> Result<T> {
        let sources = Sources::new(scene);
        let (mixes, mix_of) = mixes(planes);
        let tolerance = self.quality.tolerance();
        let optics = Optics {
            sources: &sources,
            model: scene.model,
            vergence,
            mixes: &mixes,
            tolerance: &tolerance,
        };
        work(&Job {
            scene,
            optics,
            mix_of,
            window,
            progress,
        })
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
    window: Window,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
}

impl Job<'_> {
    fn render(&self, planes: &[Plane]) -> Result<Vec<Vec<f32>>> {
        let Scene { width, height, .. } = *self.scene;
        let Some(sides) = self.sides()? else {
            return Scatter.render_window(self.scene, planes, self.window, self.progress);
        };
        let split = Split::of(planes, width);
        let views = self.views(&split);
        let (levels, folded, reach) = self.planned(&views, &sides)?;
        let out = self.levels(&views, &levels, folded, reach)?;
        let edges = match folded {
            0 => self.scene.edges,
            _ => Edges::Black,
        };
        let plates = out
            .par_iter()
            .map(|image| cut(image, (width, height), edges, self.window));
        let mut plates: Vec<_> = plates.collect();
        let place = (self.scene, self.window);
        split.scatter(place, &self.optics, planes, self.progress, &mut plates)?;
        Ok(plates)
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

    /// The work of all levels, the level at which light beyond the edges is folded back, and how far light goes.
    fn planned(&self, views: &[View], sides: &Sides) -> Result<(Vec<Level>, usize, i32)> {
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
            lit: &Lit::of(views),
        });
        let folded = fold_early((width, height), self.scene.edges, &mut levels);
        if self.window != Window::whole(self.scene) {
            let plate = ((width, height), self.scene.edges);
            narrow(&mut levels, folded, plate, self.window);
        }
        Ok((levels, folded, reach))
    }

    /// All levels, coarsest first; the finest is left. Light beyond the plate's edges is folded back at
    /// level `folded`, unless that is the finest.
    fn levels(
        &self,
        planes: &[View],
        levels: &[Level],
        folded: usize,
        reach: i32,
    ) -> Result<Vec<Image>> {
        let mut pyramid: Vec<Vec<Image>> = Vec::new();
        for level in 1..levels.len() {
            let above = match level {
                1 => planes.iter().map(halved).collect(),
                _ => pyramid[level - 2]
                    .iter()
                    .map(|image| halved(&image.view()))
                    .collect(),
            };
            pyramid.push(above);
        }
        let total: usize = levels
            .iter()
            .map(|level| level.extent().0.len() * planes.len())
            .sum();
        let done = AtomicUsize::new(0);
        let mut coarser: Vec<Image> = vec![Image::default(); planes.len()];
        for level in levels.iter().rev() {
            let views: Vec<View> = match level.grid.level {
                0 => planes.to_vec(),
                above => pyramid[above as usize - 1]
                    .iter()
                    .map(Image::view)
                    .collect(),
            };
            let corners = corners_of(&level.gathered);
            let stencils = corners::stencils(&self.optics, &level.grid, &corners, reach)?;
            let (rows, columns) = level.extent();
            let side = level.grid.tile;
            let place = (columns.start * side as i32, rows.start * side as i32);
            let size = (columns.len() * side, rows.len() * side);
            let mut images = vec![Image::zeros(place, size); planes.len()];
            let mut bands = Vec::new();
            for (plane, image) in images.iter_mut().enumerate() {
                let width = image.width.max(1);
                for (row, band) in rows
                    .clone()
                    .zip(image.samples.chunks_exact_mut(side * width))
                {
                    bands.push((plane, row, band));
                }
            }
            bands.into_par_iter().try_for_each_init(
                Space::default,
                |space, (plane, row, band)| {
                    let work = Work {
                        level,
                        stencils: &stencils,
                        mix: self.mix_of[plane],
                        sources: &views[plane],
                        coarser: &coarser[plane].view(),
                    };
                    work.band(row, columns.clone(), band, space);
                    let share = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / total as f64;
                    if (self.progress)(share) {
                        Ok(())
                    } else {
                        Err(stopped())
                    }
                },
            )?;
            coarser = self.closed(images, level.grid.level as usize, folded);
        }
        Ok(coarser)
    }

    /// The images of a level as the next finer one needs them: whole as they are, or where light has
    /// been folded back, the plate and its mirror.
    fn closed(&self, images: Vec<Image>, level: usize, folded: usize) -> Vec<Image> {
        if level == 0 || level > folded {
            return images;
        }
        let size = (self.scene.width >> level, self.scene.height >> level);
        let edges = if level == folded {
            self.scene.edges
        } else {
            Edges::Black
        };
        let all = Window {
            column: 0,
            row: 0,
            width: size.0,
            height: size.1,
        };
        let close = |image: &Image| mirrored(&cut(image, size, edges, all), size);
        images.par_iter().map(close).collect()
    }
}

/// Columns and rows that are gathered for a tile of `side`: whole vectors and blocks.
fn gathered_size(side: usize) -> (usize, usize) {
    (side.next_multiple_of(LANES), side.next_multiple_of(ROWS))
}

/// The corners (row, column) of tiles.
fn corners_of(tiles: &BTreeSet<(i32, i32)>) -> BTreeSet<(i32, i32)> {
    let about = |&(y, x): &(i32, i32)| [(y, x), (y, x + 1), (y + 1, x), (y + 1, x + 1)];
    tiles.iter().flat_map(about).collect()
}

/// What one plane's tiles at one level are made of.
struct Work<'a> {
    level: &'a Level,
    stencils: &'a Places<Mixed>,
    mix: usize,
    sources: &'a View<'a>,
    coarser: &'a View<'a>,
}

/// Buffers of one thread.
#[derive(Default)]
struct Space {
    blend: Blend,
    window: Vec<f32>,
    tile: Vec<f32>,
    doubling: Doubling,
}

impl Work<'_> {
    /// The tiles of `row` into `band`, which holds the tile columns `columns`.
    fn band(&self, row: i32, columns: std::ops::Range<i32>, band: &mut [f32], space: &mut Space) {
        let side = self.level.grid.tile;
        let stride = columns.len() * side;
        for (slot, column) in columns.enumerate() {
            let place = (row, column);
            // Gathered tiles are whole blocks and vectors.
            let mut width = side;
            if self.level.gathered.contains(&place) {
                self.gather(place, space);
                width = gathered_size(side).0;
            } else if self.level.doubled.contains(&place) {
                let corner = (column * side as i32, row * side as i32);
                space.tile.resize(side * side, 0.0);
                doubled(
                    self.coarser,
                    corner,
                    side,
                    &mut space.doubling,
                    &mut space.tile,
                );
            } else {
                continue;
            }
            for (y, line) in space.tile.chunks_exact(width).take(side).enumerate() {
                band[y * stride + slot * side..][..side].copy_from_slice(&line[..side]);
            }
        }
    }

    fn gather(&self, (row, column): (i32, i32), space: &mut Space) {
        let side = self.level.grid.tile;
        let corners = [
            (row, column),
            (row, column + 1),
            (row + 1, column),
            (row + 1, column + 1),
        ];
        let Some(stencils) = corners
            .map(|corner| self.stencils.at(corner).map(|mixed| &mixed[self.mix]))
            .into_iter()
            .collect::<Option<Vec<_>>>()
        else {
            unreachable!("the corners of all tiles to gather were made");
        };
        let blend = &mut space.blend;
        blend.set([stencils[0], stencils[1], stencils[2], stencils[3]], side);
        let corner = (
            column * side as i32 + blend.columns.start,
            row * side as i32 + blend.rows.start,
        );
        let (width, height) = gathered_size(side);
        let size = (
            width + blend.columns.len().max(1) - 1,
            height + blend.rows.len().max(1) - 1,
        );
        let stride = size.0 + LANES;
        space.tile.resize(width * height, 0.0);
        if blend.len() > 0 && self.sources.copy(corner, size, stride, &mut space.window) {
            blend.gather(&space.window, stride, width, &mut space.tile);
        } else {
            space.tile.fill(0.0);
        }
    }
}
