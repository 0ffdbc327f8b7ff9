//! A plate through a lens that is used as settings say: adjusted, on the plate's own pixels, focused.

use super::{Placed, Vergences};
use crate::{
    AdjustedLens, BlurField, Displacement, Edges, FocusControls, NonSquarePixelLens, Scene,
};
use seidel_optics::error::{Error, Result};
use seidel_optics::predict::Predictor;
use seidel_optics::psf::PsfModel;

/// How a lens is used.
#[derive(Clone)]
pub struct LensUse<'a> {
    /// The lens, its controls set.
    pub lens: &'a Predictor,
    /// What draws it.
    pub model: &'a dyn PsfModel,
    /// How strong blur and displacement are: 1 is as the lens says.
    pub amount: f64,
    /// The same of the blur of each channel alone.
    pub channel_scales: Vec<f64>,
    /// How far the axis is moved, plate pixels (x, y).
    pub axis_offset_px: (f64, f64),
    /// What is in focus, and how fast blur grows about it.
    pub focus: FocusControls,
    /// Which displacement is drawn.
    pub displacement: Displacement,
}

/// A plate as a lens sees it.
pub struct Seen<'a> {
    /// With mirrored edges.
    pub scene: Scene<'a>,
    /// What the settings about focus make of vergences.
    pub refocused: &'a dyn Fn(Vergences) -> Result<Vergences>,
}

impl LensUse<'_> {
    /// Does `then` with what there is to draw of the plate `placed`, at some vergences.
    ///
    /// # Errors
    /// Settings that cannot be: those of [`AdjustedLens::new`], [`NonSquarePixelLens::new`] and
    /// [`FocusRemap::new`](crate::FocusRemap::new); and those of `then`.
    pub fn seen<T, E: From<Error>>(
        &self,
        placed: &Placed,
        vergences: Vergences,
        then: impl FnOnce(&Seen) -> std::result::Result<T, E>,
    ) -> std::result::Result<T, E> {
        let (map, aspect) = (placed.map, placed.pixel_aspect);
        let offset = self.axis_offset_px;
        let adjusted = AdjustedLens::new(
            self.lens,
            self.amount,
            self.channel_scales.clone(),
            (offset.0 / (map.scale / aspect), offset.1 / map.scale),
        )?;
        let non_square = match aspect == 1.0 {
            true => None,
            false => Some(NonSquarePixelLens::new(&adjusted, aspect)?),
        };
        let lens: &dyn BlurField = match &non_square {
            Some(lens) => lens,
            None => &adjusted,
        };
        let refocused = |v: Vergences| v.refocused(lens, placed.extent(), &self.focus);
        let vergences = refocused(vergences)?;
        then(&Seen {
            scene: Scene {
                lens,
                model: self.model,
                width: placed.width,
                height: placed.height,
                map,
                vergence: vergences.pass(),
                edges: Edges::Mirror,
                displacement: self.displacement,
            },
            refocused: &refocused,
        })
    }
}
