//! Object vergence of a plate, owned, and what settings about focus make of it.

use crate::{BlurField, FocusControls, FocusRemap, PlateExtent, VergencePass};
use seidel_optics::error::Result;

/// Object vergence of a plate's pixels, 1/m.
#[derive(Debug, Clone, PartialEq)]
pub enum Vergences {
    /// All at one.
    Constant(f64),
    /// One a pixel, row-major.
    PerPixel(Vec<f32>),
}

impl Vergences {
    /// As renderers are given it.
    pub fn pass(&self) -> VergencePass<'_> {
        match self {
            Self::Constant(v) => VergencePass::Constant(*v),
            Self::PerPixel(pass) => VergencePass::PerPixel(pass),
        }
    }

    /// The vergences to draw in place of these on `plate` by `controls`.
    ///
    /// # Errors
    /// Those of [`FocusRemap::new`].
    pub fn refocused(
        self,
        lens: &dyn BlurField,
        plate: PlateExtent,
        controls: &FocusControls,
    ) -> Result<Self> {
        if controls.is_neutral() {
            return Ok(self);
        }
        let range = FocusRemap::new(lens, plate, controls)?;
        Ok(match self {
            Self::Constant(v) => Self::Constant(range.vergence(v)),
            Self::PerPixel(mut pass) => {
                for v in &mut pass {
                    *v = range.vergence(f64::from(*v)) as f32;
                }
                Self::PerPixel(pass)
            }
        })
    }
}
