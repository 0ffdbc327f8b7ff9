//! A rendering request: scene, planes, occlusion, edges and renderer.

use seidel_optics::Progress;
use seidel_optics::error::Result;
use seidel_render::{
    EdgeReplicatingRenderer, LayeredRenderer, LightBeyond, MirroringRenderer, Occlusion, Plane,
    RenderWindow, Rendered, Renderer, Scene, VergencePass,
};

use crate::settings::{Edges, Quality};
use crate::undershoot::remove_undershoot;

/// A rendering request: scene, planes, occlusion, edges and renderer.
#[derive(Clone, Copy)]
pub struct Rendering<'a> {
    /// The optics of the plate.
    pub scene: &'a Scene<'a>,
    /// Premultiplied planes with their channel weights.
    pub planes: &'a [Plane<'a>],
    /// Occlusion of far surfaces by near ones; `None` adds the light of all depths.
    pub occlusion: Option<Occlusion<'a>>,
    /// Light beyond the edges of the plate.
    pub edges: Edges,
    /// The renderer of each depth layer, or of the whole plate where there is no occlusion.
    pub renderer: &'a dyn Renderer,
    /// The accuracy of `renderer`, within which negative results of planes without negative light are set to zero.
    pub quality: Quality,
}

impl Rendering<'_> {
    /// Renders the `window` of the planes, or all of them; a window is to the bit the same part of the whole.
    ///
    /// # Errors
    /// Those of [`Renderer::render_window`].
    pub fn render(&self, window: Option<RenderWindow>, progress: &Progress) -> Result<Rendered> {
        let layered = self.occlusion.map(|settings| LayeredRenderer {
            inner: self.renderer,
            settings,
        });
        let replicating = |light| EdgeReplicatingRenderer {
            light,
            inner: self.renderer,
            occlusion: self.occlusion,
        };
        let repeated = replicating(LightBeyond::Nearest);
        let black = replicating(LightBeyond::Black);
        let mirroring = MirroringRenderer {
            inner: self.renderer,
        };
        let depth_varies = matches!(self.scene.vergence, VergencePass::PerPixel(_));
        let renderer: &dyn Renderer = match (self.edges, &layered) {
            (Edges::Extend, _) => &repeated,
            (Edges::Black, Some(_)) if depth_varies => &black,
            (Edges::Mirror | Edges::Black, Some(layered)) => layered,
            (Edges::Mirror, None) => &mirroring,
            (Edges::Black, None) => self.renderer,
        };
        let Scene { width, height, .. } = *self.scene;
        let window = window.unwrap_or(RenderWindow {
            column: 0,
            row: 0,
            width,
            height,
        });
        let mut rendered = renderer.render_window(self.scene, self.planes, window, progress)?;
        for (out, plane) in rendered.planes.iter_mut().zip(self.planes) {
            remove_undershoot(self.scene, plane.samples, out, window, self.quality);
        }
        Ok(rendered)
    }
}
