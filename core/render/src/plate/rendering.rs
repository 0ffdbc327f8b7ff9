//! What a frame is rendered with: a renderer within occlusion and extended edges, as far as asked for.

use crate::{
    EdgeReplicatingRenderer, LayeredRenderer, Occlusion, Plane, RenderWindow, Rendered, Renderer,
    Scene,
};
use seidel_optics::error::Result;

/// A frame to be rendered, by whatever is given for the innermost renderer.
#[derive(Clone, Copy)]
pub struct Rendering<'a> {
    /// Its optics.
    pub scene: &'a Scene<'a>,
    /// Its light.
    pub planes: &'a [Plane<'a>],
    /// How near things hide far ones, where they do.
    pub occlusion: Option<Occlusion<'a>>,
    /// Whether the plate goes on beyond its edges.
    pub extended: bool,
}

impl Rendering<'_> {
    /// The planes as `inner` renders what it is asked for; `progress` is told the share done, and says whether to go on.
    ///
    /// # Errors
    /// Those of [`Renderer::render`].
    pub fn by(
        &self,
        inner: &dyn Renderer,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        self.with(inner, |renderer| {
            renderer.render(self.scene, self.planes, progress)
        })
    }

    /// The same for a `window` of the plate alone, to the bit.
    ///
    /// # Errors
    /// Those of [`Renderer::render_window`].
    pub fn window_by(
        &self,
        inner: &dyn Renderer,
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        self.with(inner, |renderer| {
            renderer.render_window(self.scene, self.planes, window, progress)
        })
    }

    fn with<T>(&self, inner: &dyn Renderer, render: impl FnOnce(&dyn Renderer) -> T) -> T {
        let layered = self
            .occlusion
            .map(|settings| LayeredRenderer { inner, settings });
        let renderer: &dyn Renderer = match &layered {
            Some(layered) => layered,
            None => inner,
        };
        let extended = EdgeReplicatingRenderer { inner: renderer };
        render(if self.extended { &extended } else { renderer })
    }
}
