//! The button Check Lens: a comparison of the plate's blur with that of its lens.

use std::sync::Arc;

use seidel_core::{LensSession, Plate, RelensSide};

use crate::host::{Call, Failure, ParameterValue, Result, show_information};
use crate::knobs::{Knobs, lens, named};
use crate::plate_image::PlateImage;
use crate::rendering::{Frame, Inputs, Source};
use crate::settings::{HostQuality, chosen_lens, plate_geometry, settings};
use crate::threads;

/// Compares the blur of the source with that of the lens and reports the result to the user. Reduces Amount to what the
/// source shows where that is less. Called on the main thread only, since it changes parameters.
pub(super) fn check(call: &Call) {
    let text = match result(call) {
        Ok(Some(text)) => text,
        Ok(None) => return,
        Err(failure) => failure.text,
    };
    show_information(call.host, call.effect.handle, &text);
}

/// Returns the message with the result, or `None` if the host aborted.
fn result(call: &Call) -> Result<Option<String>> {
    let knobs = Knobs::at(&call.effect, call.time());
    let Some(source) = Source::fetch(call)? else {
        return Err(Failure::failed(
            "Check Lens: there is no source; connect the plate.",
        ));
    };
    let profile = chosen_lens(&knobs, &lens::LENS, &lens::PROFILE)?;
    let bounds = source.image.bounds;
    let frame = Frame::new(call, &knobs, &source, bounds, bounds);
    let inputs = Inputs::fetch(call, &knobs, &profile, frame.map)?;
    let settings = settings(
        &knobs,
        &profile,
        frame.scale,
        HostQuality::Full,
        RelensSide::From,
    )?;
    if settings.amount == 0.0 {
        return Err(Failure::failed(
            "Amount: is 0, so that the lens has no blur to compare; give another.",
        ));
    }
    let session = Arc::new(LensSession::new(&profile, &settings)?);
    if PlateImage::new(&source.image, frame.map).is_none() {
        return Ok(None);
    }
    let encoding = source.encoding(call, &knobs)?;
    let image = source.read(&knobs, frame.map, frame.extent, encoding.as_ref())?;
    let geometry = plate_geometry(&settings, frame.scale, frame.format, frame.extent);
    let plate = Plate::new(image)
        .with_geometry(geometry)
        .with_depth(inputs.depth(&knobs, &profile, frame.scale, &geometry)?);
    let prepared = session.prepare(plate)?;
    let share = threads::run(&call.effect, move |progress| prepared.blur_share(progress))?;
    Ok(share.map(|share| conclusion(call, &knobs, share)))
}

/// Returns the message for a plate that shows this `share` of the lens's blur, and reduces Amount if it is below 1.
fn conclusion(call: &Call, knobs: &Knobs, share: f64) -> String {
    let percent = 100.0 * share;
    if share < 1.0 {
        let amount = knobs.number(named("amount")) * share;
        let change = (named("amount").name, ParameterValue::Double(amount));
        call.effect.parameters().set(c"Check Lens", &[change]);
        format!(
            "The plate shows about {percent:.0} % of the lens's blur, so Amount is {amount:.3} now: to remove more would \
             ring. Undo this if the lens is right."
        )
    } else if share > 1.0 {
        format!(
            "The plate shows about {percent:.0} % of the lens's blur. Is it the plate's lens, and at the plate's distance?"
        )
    } else {
        "Nothing in the plate speaks against the lens.".to_owned()
    }
}
