//! What a render would be made of: its plan, without the work.

use super::Job;
use super::lights::Split;
use super::plan::Lit;
use crate::{LevelMethods, Methods, Plane, Renderer, Scatter};
use seidel_optics::error::Result;

impl Job<'_> {
    /// The levels, tiles and lights that [`Job::render`] would draw.
    pub(super) fn methods(&self, planes: &[Plane]) -> Result<Methods> {
        let Some(sides) = self.sides()? else {
            return Scatter.methods(self.scene, planes);
        };
        let split = Split::of(planes, self.scene.width);
        let (levels, _, _) = self.planned(&Lit::of(&self.views(&split)), &sides)?;
        let of_level = levels.iter().map(|level| LevelMethods {
            gathered: level.gathered.len(),
            doubled: level.doubled.len(),
            sides_px: (level.grid.tile, level.grid.tile),
        });
        Ok(Methods::gathered(of_level.collect(), split.count()))
    }
}
