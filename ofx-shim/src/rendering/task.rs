//! The computation of a render, by the core.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use seidel_core::{
    Image, LensSession, Margins, NoiseGain, Plate, PreparedPlate, Progress, Rectangle, RenderWindow,
};

use super::coc_map::coc_map;
use super::results::{KeptResult, kept_or_rendered};
use crate::host::{Effect, Result};
use crate::interleaved::Interleaved;
use crate::remarks::{Remark, remarks};
use crate::threads;

/// The result that is computed from a plate.
pub(crate) enum Task {
    /// The plate with the blur of its lens.
    Apply,
    /// The plate without the blur of its lens.
    Remove,
    /// The plate without the colour fringes of its lens.
    MatchColours,
    /// The confidence of a removal.
    Confidence,
    /// The amplification of noise by a removal.
    NoiseGain,
    /// The circle of confusion of each pixel in false colour.
    CocMap,
    /// The plate with the blur of this lens in place of its own.
    Relens(Arc<LensSession>),
}

/// The end of a render: complete with remarks on its inputs, or aborted by the host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Outcome {
    Done { remarks: Vec<Remark> },
    Aborted,
}

impl Outcome {
    /// A complete render that leaves nothing to say.
    pub(crate) const DONE: Self = Self::Done {
        remarks: Vec::new(),
    };
}

/// The pixels of a render, and remarks on its inputs.
pub(crate) struct Rendered {
    pub(crate) image: Interleaved,
    pub(crate) remarks: Vec<Remark>,
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
    pub(crate) fn run(self, effect: &Effect) -> Result<Option<Rendered>> {
        let Self {
            task,
            session,
            plate,
            margins,
            window,
        } = self;
        let extent = plate.geometry.data;
        let is_map = matches!(task, Task::Confidence | Task::NoiseGain);
        let strength = session.settings().removal.strength;
        if is_map && (session.is_neutral() || strength == 0.0) {
            // The plate stays as it is: it is certain everywhere, and so is its noise.
            let channels = plate.image.colours.len() + plate.image.alpha.iter().len();
            let image = Interleaved::new(window, channels, |_, row| row.fill(1.0))?;
            return Ok(Some(Rendered {
                image,
                remarks: Vec::new(),
            }));
        }
        // The whole plate, but for `apply`, which renders what is asked for.
        let target = match task {
            Task::Apply => window,
            _ => extent,
        };
        // On the threads of the plugin, so that the host is asked to abort meanwhile.
        let result = threads::run(effect, move |progress| {
            let mut hasher = DefaultHasher::new();
            session.fingerprint(&plate).hash(&mut hasher);
            if let Task::Relens(other) = &task {
                (other.lens().to_json(), format!("{:?}", other.settings())).hash(&mut hasher);
            }
            format!("{} {margins:?} {target:?}", task.name()).hash(&mut hasher);
            kept_or_rendered(hasher.finish(), || {
                let prepared = session.prepare(plate)?;
                task.compute(prepared, margins, window, progress)
            })
        })?;
        let Some(result) = result else {
            return Ok(None);
        };
        Ok(Some(Rendered {
            image: interleave(&result.image, target, window)?,
            remarks: result.remarks.clone(),
        }))
    }
}

impl Task {
    /// Name of the computation.
    fn name(&self) -> &'static str {
        match self {
            Self::Apply => "apply",
            Self::Remove => "remove",
            Self::MatchColours => "match colours",
            Self::Confidence => "confidence",
            Self::NoiseGain => "noise gain",
            Self::CocMap => "coc map",
            Self::Relens(_) => "relens",
        }
    }

    /// Computes the result from `plate`: of the `window` of it with `margins`, in plate pixels, for [`Task::Apply`], and of the whole for
    /// others.
    ///
    /// # Errors
    /// A plate that cannot be expanded or rendered through the other lens, and those of the core's functions of the same names.
    fn compute(
        self,
        plate: PreparedPlate,
        margins: Margins,
        window: Rectangle,
        progress: &Progress,
    ) -> seidel_core::Result<KeptResult> {
        let image = match self {
            Self::Apply => {
                let expanded = (!margins.is_none()).then(|| plate.expanded(margins));
                let expanded = expanded.transpose()?;
                let target = expanded.as_ref().unwrap_or(&plate);
                let extent = target.geometry().data;
                let part = RenderWindow {
                    column: (window.x - extent.x) as usize,
                    row: (window.y - extent.y) as usize,
                    width: window.width,
                    height: window.height,
                };
                let planes = target.apply_window(part, progress)?;
                target.to_image_of_window(part, planes)?
            }
            Self::Relens(other) => {
                let other = plate.for_session(&other)?;
                plate.relens(&other, progress)?
            }
            Self::CocMap => coc_map(&plate)?,
            Self::MatchColours => plate.to_image(plate.match_colours(progress)?)?,
            Self::Confidence => removal_map(&plate, NoiseGain::Skip, progress)?,
            Self::NoiseGain => removal_map(&plate, NoiseGain::Measure, progress)?,
            Self::Remove => plate
                .remove(NoiseGain::Skip, progress)?
                .sharp_image(&plate)?,
        };
        Ok(KeptResult {
            image,
            // The depth of added margins repeats that of the border.
            remarks: remarks_on(&plate)?,
        })
    }
}

/// Returns remarks on the depth input and the focus settings of `plate`.
///
/// # Errors
/// Focus settings that cannot be followed.
fn remarks_on(plate: &PreparedPlate) -> seidel_core::Result<Vec<Remark>> {
    let mut all = Vec::new();
    if let Some(pass) = plate.depth().pass() {
        let findings = plate.depth_findings()?;
        let width = plate.placement().width;
        all = remarks(&findings, pass.meaning.convention, width);
    }
    all.extend(plate.focus_warning()?.map(Remark::warning));
    let of_frame = plate.frame_warning();
    let of_frame = of_frame.map(|warning| format!("Film Back, Lens Scale: {warning}."));
    all.extend(of_frame.map(Remark::warning));
    Ok(all)
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
    let count = planes.len();
    Interleaved::new(window, count, |(x, y), row| {
        let (left, above) = ((x - rectangle.x) as usize, (y - rectangle.y) as usize);
        let first = above * rectangle.width + left;
        for (channel, plane) in planes.iter().enumerate() {
            let samples = &plane[first..first + window.width];
            for (pixel, sample) in row.chunks_exact_mut(count).zip(samples) {
                pixel[channel] = *sample;
            }
        }
    })
}
