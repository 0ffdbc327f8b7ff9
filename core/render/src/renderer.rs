//! The trait of renderers.

use crate::{LayerContext, Plane, RenderWindow, Rendered, Scene};
use seidel_optics::error::Result;

/// Blurs planes with a lens.
pub trait Renderer: Sync {
    /// Stable identifier, as the command line names it.
    fn id(&self) -> &'static str;

    /// Largest distance of a result beyond the range of its plate and black, as a share of the plate's brightest light.
    ///
    /// Every PSF is non-negative and sums to one, so that this is an error of the renderer.
    fn overshoot(&self) -> f32;

    /// Returns whether a preview is enough.
    fn is_preview(&self) -> bool {
        false
    }

    /// Renders the pixels of `window` from all light of the plate.
    ///
    /// The planes come back in the order given, row-major and as large as the window. They equal the same part of
    /// [`Renderer::render`]'s planes to the bit.
    ///
    /// `progress` is called with the share done, from 0 to 1, from any thread. Calls from different threads can
    /// arrive slightly out of order. The render stops when it returns false.
    ///
    /// # Errors
    /// - those of [`Scene::check`];
    /// - a window that is empty or not wholly on the plate;
    /// - a lens whose blur is not finite or too large to draw at some pixel;
    /// - a cancelled operation, if `progress` returned false.
    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered>;

    /// Renders the whole plate: [`Renderer::render_window`] with a window as large as the plate.
    ///
    /// # Errors
    /// Those of [`Renderer::render_window`].
    fn render(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        self.render_window(scene, planes, RenderWindow::whole(scene), progress)
    }

    /// Prepares the renders of the depth layers of a plate by [`Renderer::render_layer`].
    fn layer_context(&self, _scene: &Scene) -> LayerContext {
        LayerContext::default()
    }

    /// Renders a part of a plate's light that lies at one vergence. `scene` is that of a crop of the plate that `context` was made for.
    ///
    /// # Errors
    /// Those of [`Renderer::render_window`].
    fn render_layer(
        &self,
        scene: &Scene,
        planes: &[Plane],
        _context: &LayerContext,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        self.render(scene, planes, progress)
    }
}
