//! A rendering request: scene, planes, occlusion, edges and quality.

use seidel_optics::error::Result;
use seidel_render::{
    EdgeReplicatingRenderer, LayeredRenderer, Occlusion, Plane, RenderWindow, Rendered, Renderer,
    Scene,
};

use crate::settings::{Edges, Quality};
use seidel_optics::Progress;

/// A rendering request: scene, planes, occlusion, edges and quality.
#[derive(Clone, Copy)]
pub struct Rendering<'a> {
    /// The optics of the plate.
    pub scene: &'a Scene<'a>,
    /// Premultiplied planes with their channel weights.
    pub planes: &'a [Plane<'a>],
    /// How near surfaces occlude far ones; `None` adds the light of all depths.
    pub occlusion: Option<Occlusion<'a>>,
    /// Light beyond the edges of the plate.
    pub edges: Edges,
    /// Accuracy.
    pub quality: Quality,
}

impl Rendering<'_> {
    /// Renders the planes.
    ///
    /// # Errors
    /// Those of [`Renderer::render`].
    pub fn render(&self, progress: &Progress) -> Result<Rendered> {
        self.with_renderer(&*self.quality.renderer(), |renderer| {
            renderer.render(self.scene, self.planes, progress)
        })
    }

    /// Renders the `window` of the planes alone, to the bit.
    ///
    /// # Errors
    /// Those of [`Renderer::render_window`].
    pub fn render_window(&self, window: RenderWindow, progress: &Progress) -> Result<Rendered> {
        self.with_renderer(&*self.quality.renderer(), |renderer| {
            renderer.render_window(self.scene, self.planes, window, progress)
        })
    }

    /// Renders the planes by `inner` in place of the renderer of [`Self::quality`].
    ///
    /// # Errors
    /// Those of [`Renderer::render`].
    pub fn render_by(&self, inner: &dyn Renderer, progress: &Progress) -> Result<Rendered> {
        self.with_renderer(inner, |renderer| {
            renderer.render(self.scene, self.planes, progress)
        })
    }

    fn with_renderer<T>(&self, inner: &dyn Renderer, render: impl FnOnce(&dyn Renderer) -> T) -> T {
        let layered = self
            .occlusion
            .map(|settings| LayeredRenderer { inner, settings });
        let renderer: &dyn Renderer = match &layered {
            Some(layered) => layered,
            None => inner,
        };
        if self.edges == Edges::Extend {
            render(&EdgeReplicatingRenderer { inner: renderer })
        } else {
            render(renderer)
        }
    }
}
