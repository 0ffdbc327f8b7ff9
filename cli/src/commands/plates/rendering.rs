//! What a frame is rendered with: a renderer within occlusion and extended edges, as far as asked for.

use seidel_core::Result;
use seidel_core::render::{Extended, Layered, Occlusion, Plane, Renderer, Scene};

/// A frame to be rendered, by whatever is given for the innermost renderer.
pub(crate) struct Rendering<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) planes: &'a [Plane<'a>],
    /// How near things hide far ones, where they do.
    pub(crate) occlusion: Option<Occlusion<'a>>,
    /// Whether the plate goes on beyond its edges.
    pub(crate) extended: bool,
}

impl Rendering<'_> {
    /// The planes as `inner` renders what it is asked for.
    pub(crate) fn by(
        &self,
        inner: &dyn Renderer,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        let layered = self.occlusion.map(|settings| Layered { inner, settings });
        let renderer: &dyn Renderer = match &layered {
            Some(layered) => layered,
            None => inner,
        };
        let extended = Extended { inner: renderer };
        let renderer: &dyn Renderer = if self.extended { &extended } else { renderer };
        renderer.render(self.scene, self.planes, progress)
    }
}
