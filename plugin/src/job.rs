//! What a call works with: everything read, checked and owned, so that the work needs nothing of the caller's.

use std::sync::Arc;

use seidel_core::plate::{LensUse, Light, Placed, Returned, Seen, Vergences};
use seidel_core::predict::Predictor;
use seidel_core::psf::PsfModel;
use seidel_core::render::FocusControls;

use crate::image::{SeidelRect, View};
use crate::lens::Lens;
use crate::plate::Plate;
use crate::settings::Settings;
use crate::status::{Failure, Result, SeidelStatus};

/// A lens set and adjusted for a plate.
pub(crate) struct Sight {
    pub(crate) predictor: Predictor,
    model: &'static dyn PsfModel,
    channel_scales: Vec<f64>,
    focus: FocusControls,
    settings: Settings,
    pub(crate) placed: Placed,
}

impl Sight {
    pub(crate) fn new(
        lens: &Arc<Lens>,
        settings: &Settings,
        place: impl FnOnce(&Predictor) -> Result<Placed>,
    ) -> Result<Self> {
        let predictor = lens.set(settings)?;
        let sight = Self {
            model: settings.model(&predictor)?,
            channel_scales: settings.channel_scales(&predictor),
            focus: settings.focus()?,
            settings: settings.clone(),
            placed: place(&predictor)?,
            predictor,
        };
        // What cannot be is refused before any work.
        let nowhere = |_: &Seen| Ok::<(), Failure>(());
        sight
            .lens_use()
            .seen(&sight.placed, Vergences::Constant(0.0), nowhere)?;
        Ok(sight)
    }

    pub(crate) fn lens_use(&self) -> LensUse<'_> {
        let raw = &self.settings.raw;
        LensUse {
            lens: &self.predictor,
            model: self.model,
            amount: raw.amount,
            channel_scales: self.channel_scales.clone(),
            axis_offset_px: (raw.axis_offset_x, raw.axis_offset_y),
            focus: self.focus,
            displacement: self.settings.displacement(),
        }
    }

    /// Whether what draws the lens needs its rays.
    pub(crate) fn needs_rays(&self) -> bool {
        self.model.needs_rays()
    }
}

/// A plate read, and its lens.
pub(crate) struct Job {
    pub(crate) sight: Sight,
    pub(crate) light: Light,
    pub(crate) weights: Vec<Vec<f64>>,
    pub(crate) vergence: Vergences,
    pub(crate) settings: Settings,
}

impl Job {
    pub(crate) fn new(lens: &Arc<Lens>, plate: &Plate, settings: &Settings) -> Result<Self> {
        let sight = Sight::new(lens, settings, |lens| plate.placed(lens, settings))?;
        let weights = plate.weights(&sight.predictor, settings)?;
        Ok(Self {
            vergence: plate.vergence((&sight.predictor, &sight.placed), settings)?,
            light: plate.light(settings)?,
            sight,
            weights,
            settings: settings.clone(),
        })
    }

    /// The light that fell on the sensor, before its tone.
    pub(crate) fn undeveloped(&self) -> Light {
        let mut light = self.light.clone();
        light.undevelop(&self.sight.predictor, &self.weights);
        light
    }

    /// Does `work` with the lens as it sees the plate.
    pub(crate) fn seen<T>(&self, work: impl FnOnce(&Seen) -> Result<T>) -> Result<T> {
        let lens_use = self.sight.lens_use();
        lens_use.seen(&self.sight.placed, self.vergence.clone(), work)
    }
}

/// Refuses work that needs more memory than the settings allow.
pub(crate) fn check_memory(needed: u64, settings: &Settings) -> Result<()> {
    let most = settings.raw.memory;
    if most == 0 || needed <= most {
        return Ok(());
    }
    Err(Failure::new(
        SeidelStatus::Memory,
        format!(
            "settings.memory: is {most} bytes, {needed} are needed; allow more, or give a smaller extent"
        ),
    ))
}

/// Writes planes over `rect` to the caller's pictures.
pub(crate) fn write_back(
    back: &Returned,
    rect: SeidelRect,
    (output, alphas): (&View, Option<&View>),
) {
    let planes = back.colours.iter().chain(&back.alpha);
    for (channel, plane) in planes.enumerate().take(output.channels) {
        output.write(channel, rect, plane);
    }
    if let Some(alphas) = alphas {
        for (channel, plane) in back.own_alphas.iter().enumerate().take(alphas.channels) {
            alphas.write(channel, rect, plane);
        }
    }
}
