//! Render: the picture of a frame, or of a part of it.

use std::sync::Arc;

use super::identity::is_identity;
use super::{Answer, Call, untell};
use crate::clips::MASK;
use crate::colour::Codes;
use crate::depth::Reading;
use crate::host::{Clip, Failure, Image, Result};
use crate::knobs::{Knob, Knobs, depth, focus, lens, output};
use crate::lens::{Choice, Lens, built_in};
use crate::pixels::Pixels;
use crate::rendering::{
    Copied, Frame, InFocus, Inputs, Lenses, Mixing, Outcome, Task, focal_plane, is_unpremultiplied,
    mix, perform, picture, psf_grid, window_of,
};
use crate::setup::{Circumstances, Setup, focus_vergence};
use crate::sys::effect::{CLIP_OUTPUT, CLIP_SOURCE, QUALITY_DRAFT, THUMBNAIL};
use crate::sys::plugin::STATUS_ERR_IMAGE_FORMAT;
use crate::sys::property::TIME;

/// Renders.
pub(super) fn render(call: &Call) -> Result<Answer> {
    let time = call.arguments.double(TIME, 0).unwrap_or(0.0);
    let knobs = Knobs::at(&call.effect, time);
    let output = call.effect.clip(CLIP_OUTPUT);
    let Some(target) = output.map_or(Ok(None), |clip| clip.image(time))? else {
        if call.effect.is_aborted() {
            return Ok(Answer::Done);
        }
        return Err(Failure::failed(
            "The host gave no picture to render to; render again.",
        ));
    };
    let clip = call.effect.clip(CLIP_SOURCE);
    let source = match &clip {
        Some(clip) => clip.image(time)?,
        None => None,
    };
    let (Some(clip), Some(source)) = (&clip, &source) else {
        return blank(call, &target).map(|()| Answer::Done);
    };
    if source.channels != target.channels {
        return Err(Failure::new(
            STATUS_ERR_IMAGE_FORMAT,
            format!(
                "The host wants {} channels of a source that has {}; give both the same.",
                target.channels, source.channels
            ),
        ));
    }
    let window = window_of(call)?;
    let frame = Frame::new(call, &knobs, (clip, source), (time, target.bounds), window);
    let one = Render {
        call,
        time,
        knobs: &knobs,
        frame: &frame,
    };
    if one.picture((clip, source), &target)? == Outcome::Done {
        untell(call.host, call.effect.handle);
    }
    Ok(Answer::Done)
}

/// Without a source there is nothing: transparent black.
fn blank(call: &Call, target: &Image) -> Result<()> {
    let window = crate::geometry::meet(window_of(call)?, target.bounds);
    let field = crate::rendering::field_of(call);
    let plane = crate::geometry::Plane::new(window, field);
    if let Some(view) = plane.image(target, 0, target.channels) {
        // SAFETY: the picture is held.
        let pixels = unsafe { Pixels::new(view) };
        let nothing = seidel_c::SeidelRect {
            left: 0,
            top: 0,
            width: 0,
            height: 0,
        };
        pixels.clear(plane.rect(window), nothing);
    }
    Ok(())
}

/// The lens that two knobs choose.
///
/// # Errors
/// A file that is not chosen, or cannot be read.
pub(crate) fn chosen_lens(knobs: &Knobs, (choice, file): (&Knob, &Knob)) -> Result<Arc<Lens>> {
    let chosen = match knobs.choice(choice) {
        built_in::FILE => Choice::File(knobs.text(file).trim().to_owned()),
        index => Choice::BuiltIn(index),
    };
    if chosen == Choice::File(String::new()) {
        let label = file.label.to_string_lossy();
        return Err(Failure::failed(format!(
            "{label}: none is chosen; choose one, or a lens that comes with Seidel."
        )));
    }
    crate::lens::lens(&chosen, knobs.hidden(&lens::RELOADS))
}

/// A render under way.
struct Render<'a, 'h> {
    call: &'a Call<'h>,
    time: f64,
    knobs: &'a Knobs<'h>,
    frame: &'a Frame,
}

impl Render<'_, '_> {
    fn picture(&self, (clip, source): (&Clip, &Image), target: &Image) -> Result<Outcome> {
        let frame = self.frame;
        let whole = |image: &Image| frame.plane.image(image, 0, image.channels);
        let (Some(from), Some(to)) = (whole(source), whole(target)) else {
            // A field without a row in the pictures.
            return Ok(Outcome::Done);
        };
        // SAFETY: the pictures are held.
        let (result, original) = unsafe { (Pixels::new(to), Pixels::new(from)) };
        if is_identity(self.knobs) {
            result.copy(&original, frame.window);
            return Ok(Outcome::Done);
        }
        let Some(within) = frame.within() else {
            result.clear(frame.window, frame.extent);
            return Ok(Outcome::Done);
        };
        let lenses = self.lenses()?;
        let inputs = Inputs::new(
            self.call,
            self.knobs,
            (&lenses.lens.info, &frame.plane),
            self.time,
        )?;
        let output = self.knobs.choice(&output::OUTPUT);
        let mode = self.knobs.choice(&lens::MODE);
        if output == output::FOCAL_PLANE {
            result.clear(frame.window, within);
            self.focus((&result, &original), within, (&inputs, &lenses.lens))?;
            return Ok(Outcome::Done);
        }
        let about = Circumstances {
            scale: frame.scale,
            field: frame.field,
            unpremultiplied: is_unpremultiplied(self.knobs, clip, source),
            draft: self.is_draft(),
            threads: self.call.host.threads(),
        };
        let setup = Setup::new(self.knobs, &lenses.lens.info, &about)?;
        if output == output::PSF_GRID {
            result.clear(frame.window, within);
            let drawn = (&self.call.effect, &*lenses.lens, setup.settings());
            let sight = self.vergences(&inputs);
            return psf_grid(drawn, &result, (frame.format, within), sight);
        }
        let codes = match output == output::RESULT || mode == lens::REMOVE {
            true => Codes::of(self.knobs, !about.unpremultiplied, about.threads)?,
            false => None,
        };
        let light = codes.as_ref();
        let light = light.map(|codes| codes.light(&original, from.rect));
        let mut light = light.transpose()?;
        let source = light.as_mut().map_or(from, Copied::image);
        // Maps are no colour.
        let coded = codes.as_ref().filter(|_| output == output::RESULT);
        let made = coded.map(|_| Copied::new(within, result.channels()));
        let mut made = made.transpose()?;
        let part = result.part(within);
        let outcome = perform(
            &Task {
                effect: self.call.effect,
                mode,
                output,
                frame,
                inputs: &inputs,
                setup: &setup,
                source,
                target: made.as_mut().map_or(part, Copied::image),
            },
            &lenses,
        )?;
        if outcome == Outcome::Done {
            if let Some((codes, made)) = coded.zip(made.as_mut()) {
                codes.coded(made)?;
                made.put_into(&result);
            }
            result.clear(frame.window, within);
            if output == output::RESULT {
                self.mix((&result, &original), within)?;
            }
        }
        Ok(outcome)
    }

    fn is_draft(&self) -> bool {
        let arguments = &self.call.arguments;
        arguments.int(QUALITY_DRAFT, 0).unwrap_or(0) != 0 || arguments.equals(THUMBNAIL, c"true")
    }

    fn lenses(&self) -> Result<Lenses> {
        let lens = chosen_lens(self.knobs, (&lens::LENS, &lens::PROFILE))?;
        let relens = self.knobs.choice(&lens::MODE) == lens::RELENS;
        let to = relens.then(|| chosen_lens(self.knobs, (&lens::TO_LENS, &lens::TO_PROFILE)));
        Ok(Lenses {
            lens,
            to: to.transpose()?,
        })
    }

    fn focus(
        &self,
        (result, original): (&Pixels, &Pixels),
        rect: seidel_c::SeidelRect,
        (inputs, lens): (&Inputs, &Lens),
    ) -> Result<()> {
        let focus = focus_vergence(self.knobs, &lens.info)?;
        let range = InFocus::about(focus, self.knobs.number(&focus::DEPTH_OF_FIELD));
        focal_plane((result, original), rect, range, self.vergences(inputs));
        Ok(())
    }

    /// What tells 1/m of a pixel.
    fn vergences(&self, inputs: &Inputs) -> impl Fn((i32, i32)) -> f64 {
        let reading = Reading::new(self.knobs);
        let even = 1.0 / self.knobs.number(&depth::DISTANCE);
        // SAFETY: inputs hold their pictures.
        let pass = (inputs.depth.as_ref()).map(|made| unsafe { Pixels::new(made.image) });
        move |place| match &pass {
            None => even,
            Some(pass) => {
                let held = pass.nearest(place);
                pass.get(held, 0).map_or(0.0, |v| reading.vergence(v))
            }
        }
    }

    fn mix(
        &self,
        (result, original): (&Pixels, &Pixels),
        rect: seidel_c::SeidelRect,
    ) -> Result<()> {
        let mask = picture(self.call, self.knobs, (MASK, &output::USE_MASK), self.time)?;
        let view = |image: &Image| self.frame.plane.image(image, 0, image.channels);
        let view = mask.as_ref().and_then(view);
        let mixing = Mixing {
            mix: self.knobs.number(&output::MIX) as f32,
            // SAFETY: the mask is held.
            mask: view.map(|view| unsafe { Pixels::new(view) }),
            invert: self.knobs.is_on(&output::MASK_INVERT),
        };
        mix(result, original, rect, &mixing);
        Ok(())
    }
}
