//! The blur of a prepared plate as numbers, without rendering it.

use seidel_optics::error::Result;
use seidel_render::BlurMap;

use crate::prepared::PreparedPlate;

impl PreparedPlate {
    /// Returns the circle of confusion, the side of focus and the depth slice of every pixel.
    ///
    /// # Errors
    /// Focus settings that cannot be followed.
    pub fn blur_map(&self) -> Result<BlurMap> {
        let weights = self.mean_colour_weights();
        self.with_optics(|optics| Ok(BlurMap::new(&optics.scene, &weights)))
    }
}
