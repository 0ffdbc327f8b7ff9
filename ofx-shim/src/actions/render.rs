//! Render: the image of a frame, or of a part of it.

use std::sync::Arc;

use seidel_core::{AperturePicture, Lens, LensSession, Plate, Rectangle, RelensSide, Settings};

use super::identity::is_identity;
use super::{Answer, persistent_message};
use crate::clips::MASK;
use crate::geometry::{PixelMap, intersection};
use crate::host::{Call, Failure, Image, Result};
use crate::interleaved::Interleaved;
use crate::knobs::{Knobs, lens, named, output, remove};
use crate::lens::KernelSource;
use crate::plate_image::{PlateImage, collect_rows};
use crate::rendering::{
    FocusRange, Frame, Inputs, MixedChannels, Mixing, Outcome, RenderJob, Source, Task,
    aperture_picture, draw_psf_grid, field, gap_map, image_of_input, in_host_pixels, render_window,
    tint_by_focus,
};
use crate::settings::{
    HostQuality, chosen_lens, focus_vergence_per_m, mask_scales_blur, plate_geometry, put_look,
    settings,
};
use crate::sys::effect::{CLIP_OUTPUT, QUALITY_DRAFT, THUMBNAIL};
use crate::sys::plugin::STATUS_ERR_IMAGE_FORMAT;

/// Renders the window that the host asks for.
pub(super) fn render(call: &Call) -> Result<Answer> {
    let time = call.time();
    let output = call.effect.clip(CLIP_OUTPUT);
    let Some(target) = output.map_or(Ok(None), |clip| clip.image(time))? else {
        if call.effect.is_aborted() {
            return Ok(Answer::Done);
        }
        return Err(Failure::failed(
            "The host gave no image to render to; render again.",
        ));
    };
    // Hosts copy or compute an image when it is fetched.
    if call.effect.is_aborted() {
        return Ok(Answer::Done);
    }
    let Some(source) = Source::fetch(call)? else {
        return clear_window(call, &target).map(|()| Answer::Done);
    };
    if source.image.channels != target.channels {
        return Err(Failure::new(
            STATUS_ERR_IMAGE_FORMAT,
            format!(
                "The host wants {} channels of a source that has {}; give both the same.",
                target.channels, source.image.channels
            ),
        ));
    }
    let knobs = Knobs::at(&call.effect, time);
    let frame = Frame::new(call, &knobs, &source, target.bounds, render_window(call)?);
    let result = PlateImage::new(&target, frame.map);
    let original = PlateImage::new(&source.image, frame.map);
    let (Some(result), Some(original)) = (result, original) else {
        // A field that has no row in the images.
        return Ok(Answer::Done);
    };
    let render = Render {
        call,
        knobs: &knobs,
        frame: &frame,
        source: &source,
        original,
        result,
    };
    if let Outcome::Done { remarks } = render.run()? {
        persistent_message::clear(call.host, call.effect.handle);
        persistent_message::remark(call.host, call.effect.handle, &remarks);
    }
    Ok(Answer::Done)
}

/// Sets the window to transparent black, which is the result without a source.
fn clear_window(call: &Call, target: &Image) -> Result<()> {
    let window = intersection(render_window(call)?, target.bounds);
    let map = PixelMap::new(window, field(call));
    if let Some(result) = PlateImage::new(target, map) {
        let nothing = Rectangle {
            x: 0,
            y: 0,
            width: 0,
            height: 0,
        };
        result.clear_outside(nothing, map.rectangle(window));
    }
    Ok(())
}

/// A render under way.
struct Render<'a, 'h> {
    call: &'a Call<'h>,
    knobs: &'a Knobs<'h>,
    frame: &'a Frame,
    source: &'a Source<'h>,
    /// The source in plate coordinates.
    original: PlateImage<'a>,
    /// The output in plate coordinates.
    result: PlateImage<'a>,
}

impl Render<'_, '_> {
    fn run(&self) -> Result<Outcome> {
        let (knobs, frame, effect) = (self.knobs, self.frame, &self.call.effect);
        if is_identity(knobs) {
            self.result.copy(&self.original, frame.window);
            return Ok(Outcome::DONE);
        }
        let Some(window) = frame.covered_window() else {
            self.result.clear_outside(frame.extent, frame.window);
            return Ok(Outcome::DONE);
        };
        let profile = chosen_lens(knobs, &lens::LENS, &lens::PROFILE)?;
        if effect.is_aborted() {
            return Ok(Outcome::Aborted);
        }
        let inputs = Inputs::fetch(self.call, knobs, &profile, frame.map)?;
        let output = knobs.choice(&output::OUTPUT);
        if output == output::FOCAL_PLANE {
            let focus = focus_vergence_per_m(knobs, &profile)?;
            let range = FocusRange::new(focus, knobs.number(named("depth-of-field")));
            let vergences = inputs.vergences_per_m(knobs);
            let (result, source) = (&self.result, &self.original);
            let outcome = tint_by_focus(effect, result, source, window, range, vergences)?;
            return Ok(self.clear_beside(window, outcome));
        }
        let session = self.session(&profile)?;
        if output == output::PSF_GRID {
            let lens = KernelSource {
                geometry: plate_geometry(
                    session.settings(),
                    frame.scale,
                    frame.format,
                    frame.format,
                ),
                session,
            };
            let vergence = inputs.vergence_per_m(knobs);
            let outcome = draw_psf_grid(effect, &lens, &self.result, window, vergence)?;
            return Ok(self.clear_beside(window, outcome));
        }
        let task = self.task(output)?;
        if effect.is_aborted() {
            return Ok(Outcome::Aborted);
        }
        let encoding = self.source.encoding(self.call, knobs)?;
        let in_host = |failure| in_host_pixels(failure, frame.map, frame.extent);
        let image = self
            .source
            .read(knobs, frame.map, frame.extent, encoding.as_ref())
            .map_err(in_host)?;
        if effect.is_aborted() {
            return Ok(Outcome::Aborted);
        }
        let geometry = plate_geometry(session.settings(), frame.scale, frame.format, frame.extent);
        let depth = inputs.depth(knobs, &profile, frame.scale, &geometry)?;
        if effect.is_aborted() {
            return Ok(Outcome::Aborted);
        }
        let mut plate = Plate::new(image)
            .with_geometry(geometry)
            .with_depth(depth)
            .with_holdout(inputs.holdout(knobs, frame.scale, &geometry)?);
        if mask_scales_blur(knobs) {
            plate.mask = self.blur_mask(frame.extent)?;
        }
        let job = RenderJob {
            task,
            session,
            plate,
            margins: frame.margins,
            // Blocks of the gap are the same for every window.
            window: if output == output::GAP {
                frame.extent
            } else {
                window
            },
        };
        let Some(rendered) = job.run(effect).map_err(in_host)? else {
            return Ok(Outcome::Aborted);
        };
        let mut image = rendered.image;
        // Maps are not colours.
        if let Some(encoding) = encoding.filter(|_| output == output::RESULT) {
            encoding.encode(&mut image)?;
        }
        if output == output::RESULT {
            self.mix(&mut image)?;
        }
        if output == output::GAP {
            let Some(inner) = window.intersection(&frame.extent) else {
                return Ok(self.clear_beside(frame.extent, Outcome::DONE));
            };
            gap_map(self.call, knobs, frame.map, &image, inner)?.write_to(&self.result);
            return Ok(self.clear_beside(
                inner,
                Outcome::Done {
                    remarks: rendered.remarks,
                },
            ));
        }
        image.write_to(&self.result);
        let remarks = rendered.remarks;
        Ok(self.clear_beside(window, Outcome::Done { remarks }))
    }

    /// Sets the pixels to render that do not lie in `window` to zero, unless the render was aborted.
    fn clear_beside(&self, window: Rectangle, outcome: Outcome) -> Outcome {
        if outcome != Outcome::Aborted {
            self.result.clear_outside(window, self.frame.window);
        }
        outcome
    }

    /// Returns the computation that the parameters ask for.
    fn task(&self, output: i32) -> Result<Task> {
        let mode = self.knobs.choice(&lens::MODE);
        match output {
            output::COC_MAP if self.original.channels() < 3 => Err(Failure::failed(
                "Output: CoC Map needs a source with R, G and B; connect one, or set Output to Result.",
            )),
            output::COC_MAP => Ok(Task::CocMap),
            output::CONFIDENCE if mode == lens::REMOVE => Ok(Task::Confidence),
            output::NOISE_GAIN if mode == lens::REMOVE => Ok(Task::NoiseGain),
            output::CONFIDENCE | output::NOISE_GAIN => Err(Failure::failed(
                "Output: Confidence and Noise Gain are of removal; set Mode to Remove, or Output to Result.",
            )),
            _ if mode == lens::REMOVE && self.knobs.is_on(&remove::ONLY_CHROMA) => {
                if self.original.channels() < 3 {
                    return Err(Failure::failed(
                        "Only Chroma: needs a source with R, G and B; connect one, or switch it off.",
                    ));
                }
                Ok(Task::MatchColours)
            }
            _ if mode == lens::REMOVE => Ok(Task::Remove),
            _ if mode == lens::RELENS => {
                let profile = chosen_lens(self.knobs, &lens::TO_LENS, &lens::TO_PROFILE)?;
                let mut settings = self.settings(&profile, RelensSide::To)?;
                put_look(self.knobs, &profile, self.frame.scale, &mut settings)?;
                settings.look.picture = self.aperture()?;
                let session = LensSession::new(&profile, &settings)?;
                Ok(Task::Relens(Arc::new(session)))
            }
            _ => Ok(Task::Apply),
        }
    }

    /// Sets a lens as the parameters say.
    fn session(&self, profile: &Lens) -> Result<Arc<LensSession>> {
        let mut settings = self.settings(profile, RelensSide::From)?;
        if self.knobs.choice(&lens::MODE) == lens::APPLY {
            settings.look.picture = self.aperture()?;
        }
        Ok(Arc::new(LensSession::new(profile, &settings)?))
    }

    /// Reads the picture of the aperture, if it is switched on.
    fn aperture(&self) -> Result<Option<AperturePicture>> {
        aperture_picture(self.call, self.knobs, self.frame.map)
    }

    fn settings(&self, profile: &Lens, side: RelensSide) -> Result<Settings> {
        let arguments = &self.call.arguments;
        let is_draft = arguments.int(QUALITY_DRAFT, 0).unwrap_or(0) != 0
            || arguments.equals(THUMBNAIL, c"true");
        let quality = if is_draft {
            HostQuality::Draft
        } else {
            HostQuality::Full
        };
        settings(self.knobs, profile, self.frame.scale, quality, side)
    }

    /// Reads the image of the mask, if it is connected and used.
    fn mask_image(&self) -> Result<Option<Image<'_>>> {
        image_of_input(self.call, self.knobs, MASK, &output::USE_MASK)
    }

    /// Reads the mask over `extent` as factors of the blur, if it is connected and used.
    fn blur_mask(&self, extent: Rectangle) -> Result<Option<Vec<f32>>> {
        let Some(image) = self.mask_image()? else {
            return Ok(None);
        };
        let factors = self.mixing(1.0, Some(&image));
        let factors = collect_rows(extent, 1, |pixel, row| factors.read_weights(pixel, row));
        factors.map(Some)
    }

    /// Mixes the result with the source.
    fn mix(&self, result: &mut Interleaved) -> Result<()> {
        let mask = if mask_scales_blur(self.knobs) {
            None
        } else {
            self.mask_image()?
        };
        let mix = self.knobs.number(&output::MIX) as f32;
        (self.mixing(mix, mask.as_ref())).apply(result, &self.original);
        Ok(())
    }

    /// Returns the weights of `mix` and a `mask`.
    fn mixing<'m>(&self, mix: f32, mask: Option<&'m Image>) -> Mixing<'m> {
        Mixing {
            mix,
            mask: mask.and_then(|image| PlateImage::new(image, self.frame.map)),
            invert_mask: self.knobs.is_on(&output::MASK_INVERT),
            channels: match self.knobs.choice(&output::CHANNELS) {
                output::COLOURS => MixedChannels::Colours,
                output::ALPHA => MixedChannels::Alpha,
                _ => MixedChannels::All,
            },
        }
    }
}
