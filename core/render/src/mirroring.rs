//! A renderer that mirrors a plate at its edges, but for its small lights.

use crate::gather::{HighlightBlock, HighlightCriterion, SearchArea, find_highlights};
use crate::{Edges, Plane, RenderWindow, Rendered, Renderer, Scene};
use seidel_optics::error::Result;

/// The criterion by which pixels are small lights. A block of 32 x 32 px holds up to half of its pixels; their light stands out from
/// its median.
pub(crate) const SMALL_LIGHTS: HighlightCriterion = HighlightCriterion {
    most: 500,
    contrast: 8.0,
    worthwhile: 2.0,
};

/// A renderer for which the plate goes on beyond its edges as its mirror image, and small lights do not: a lamp beside an edge would
/// meet its own image, as two discs.
///
/// Light of small lights that leaves the plate is lost. The scene's own [`Edges`] are ignored.
#[derive(Clone, Copy)]
pub struct MirroringRenderer<'r> {
    /// The renderer of the plate, and of its lights near the edges.
    pub inner: &'r dyn Renderer,
}

impl Renderer for MirroringRenderer<'_> {
    fn id(&self) -> &'static str {
        self.inner.id()
    }

    fn overshoot(&self) -> f32 {
        self.inner.overshoot()
    }

    fn is_preview(&self) -> bool {
        self.inner.is_preview()
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
        let mirrored = Scene {
            edges: Edges::Mirror,
            ..*scene
        };
        let lights = lights_near_edges(scene, planes);
        if lights.is_empty() {
            return (self.inner).render_window(&mirrored, planes, window, progress);
        }
        let [rest, lights] = split(scene, planes, &lights);
        let black = Scene {
            edges: Edges::Black,
            ..*scene
        };
        let mut rendered = (self.inner).render_window(
            &mirrored,
            &with_samples(planes, &rest),
            window,
            &|done| progress(0.9 * done),
        )?;
        let of_lights = (self.inner).render_window(
            &black,
            &with_samples(planes, &lights),
            window,
            &|done| progress(0.9 + 0.1 * done),
        )?;
        for (out, light) in rendered.planes.iter_mut().zip(&of_lights.planes) {
            out.iter_mut().zip(light).for_each(|(o, l)| *o += l);
        }
        rendered.statistics.add_part(&of_lights.statistics);
        Ok(rendered)
    }
}

/// Returns the small lights whose blur may reach beyond the edges of the plate.
fn lights_near_edges(scene: &Scene, planes: &[Plane]) -> Vec<HighlightBlock> {
    let (reach_x, reach_y) = scene.reach_px();
    let is_near = |at: usize, size: usize, reach: f64| {
        let to_edge = at.min(size - 1 - at);
        (to_edge as f64) < reach
    };
    let mut blocks = find_highlights(planes, &SearchArea::whole(scene.width), &SMALL_LIGHTS);
    blocks.retain(|block| {
        block.pixels.iter().any(|&(row, column)| {
            is_near(column, scene.width, reach_x) || is_near(row, scene.height, reach_y)
        })
    });
    blocks
}

/// Returns the samples of each plane without the lights, and the lights alone.
fn split(scene: &Scene, planes: &[Plane], lights: &[HighlightBlock]) -> [Vec<Vec<f32>>; 2] {
    let mut rest: Vec<Vec<f32>> = planes.iter().map(|plane| plane.samples.to_vec()).collect();
    let mut own = vec![vec![0.0; scene.width * scene.height]; planes.len()];
    for block in lights {
        let excess = block.excess.chunks_exact(planes.len());
        for (&(row, column), excess) in block.pixels.iter().zip(excess) {
            let index = row * scene.width + column;
            for (plane, light) in excess.iter().enumerate() {
                rest[plane][index] -= light;
                own[plane][index] += light;
            }
        }
    }
    [rest, own]
}

/// Returns `planes` with other samples.
fn with_samples<'s>(planes: &[Plane<'s>], samples: &'s [Vec<f32>]) -> Vec<Plane<'s>> {
    let pairs = samples.iter().zip(planes);
    pairs
        .map(|(samples, plane)| Plane {
            samples,
            weights: plane.weights,
        })
        .collect()
}
