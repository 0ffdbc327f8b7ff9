//! The computation of a render, by the core.

use std::sync::Arc;

use seidel_core::render::RenderWindow;
use seidel_core::{
    Image, LensSession, Margins, NoiseGain, Plate, PreparedPlate, Progress, Rectangle,
};

use crate::host::{Effect, Result};
use crate::interleaved::Interleaved;
use crate::threads;

/// The result that is computed from a plate.
pub(crate) enum Task {
    /// The plate with the blur of its lens.
    Apply,
    /// The plate without the blur of its lens.
    Remove,
    /// The confidence of a removal.
    Confidence,
    /// The amplification of noise by a removal.
    NoiseGain,
    /// The plate with the blur of this lens in place of its own.
    Relens(Arc<LensSession>),
}

/// The end of a render: complete, or aborted by the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done,
    Aborted,
}

/// A computation and the plate that it is for.
pub(crate) struct RenderJob {
    pub(crate) task: Task,
    pub(crate) session: Arc<LensSession>,
    pub(crate) plate: Plate,
    /// Pixels by which the result is larger than the plate.
    pub(crate) margins: Margins,
    /// Pixels of the plate that are needed.
    pub(crate) window: Rectangle,
}

impl RenderJob {
    /// Computes the window, or returns `None` if the host of `effect` aborts.
    ///
    /// # Errors
    /// Those of [`LensSession::prepare`] and of the core's functions of the same names; not enough memory.
    pub(crate) fn run(self, effect: &Effect) -> Result<Option<Interleaved>> {
        let Self {
            task,
            session,
            plate,
            margins,
            window,
        } = self;
        let extent = plate.geometry.data;
        let map = match task {
            Task::Confidence => Some(NoiseGain::Skip),
            Task::NoiseGain => Some(NoiseGain::Measure),
            _ => None,
        };
        let strength = session.settings().removal.strength;
        if map.is_some() && (session.is_neutral() || strength == 0.0) {
            // The plate stays as it is: it is certain everywhere, and so is its noise.
            let channels = plate.image.colours.len() + plate.image.alpha.iter().len();
            return Interleaved::new(window, channels, |_, _| 1.0).map(Some);
        }
        let prepared = session.prepare(plate)?;
        let (image, origin) = match task {
            Task::Apply => {
                let (prepared, extent) = if margins.is_none() {
                    (prepared, extent)
                } else {
                    (prepared.expanded(margins)?, margins.around(extent))
                };
                let part = RenderWindow {
                    column: (window.x - extent.x) as usize,
                    row: (window.y - extent.y) as usize,
                    width: window.width,
                    height: window.height,
                };
                let work = move |progress: &Progress<'_>| {
                    let planes = prepared.apply_window(part, progress)?;
                    prepared.to_image_of_size(part.width, part.height, planes)
                };
                (threads::run(effect, work)?, window)
            }
            Task::Relens(other) => {
                let other = prepared.for_session(&other)?;
                let work = move |progress: &Progress<'_>| prepared.relens(&other, progress);
                (threads::run(effect, work)?, extent)
            }
            Task::Remove | Task::Confidence | Task::NoiseGain => {
                let work = move |progress: &Progress<'_>| match map {
                    Some(noise_gain) => removal_map(&prepared, noise_gain, progress),
                    None => prepared
                        .remove(NoiseGain::Skip, progress)?
                        .sharp_image(&prepared),
                };
                (threads::run(effect, work)?, extent)
            }
        };
        image
            .map(|image| interleave(&image, origin, window))
            .transpose()
    }
}

/// Returns a map of the removal of blur, one plane a colour, with an alpha of 1 where the plate has one: the noise gain if
/// it is measured, or else the confidence.
fn removal_map(
    plate: &PreparedPlate,
    noise_gain: NoiseGain,
    progress: &Progress,
) -> seidel_core::Result<Image> {
    let removed = plate.remove(noise_gain, progress)?;
    let planes = match noise_gain {
        NoiseGain::Measure => removed.noise_gain().to_vec(),
        NoiseGain::Skip => removed.confidence(),
    };
    let placement = plate.placement();
    let (width, height) = (placement.width, placement.height);
    let mut names = plate.names();
    let has_alpha = names.len() > plate.colour_count();
    names.truncate(plate.colour_count());
    let alpha = has_alpha.then(|| vec![1.0; width * height]);
    let image = Image::new(width, height, names, planes)?;
    Ok(image.with_alpha(alpha, Vec::new(), Default::default()))
}

/// Returns the pixels `window` of an image that covers `rectangle`.
fn interleave(image: &Image, rectangle: Rectangle, window: Rectangle) -> Result<Interleaved> {
    let planes: Vec<_> = image.colours.iter().chain(&image.alpha).collect();
    Interleaved::new(window, planes.len(), |(x, y), channel| {
        let (column, row) = (x - rectangle.x, y - rectangle.y);
        planes[channel][row as usize * rectangle.width + column as usize]
    })
}
