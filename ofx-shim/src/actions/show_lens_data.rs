//! The button Show Lens Data: the values that *Lens Data* sets, with their sources.

use crate::host::{Call, Result, show_information};
use crate::knobs::{Knobs, lens};
use crate::lens_data::LensData;
use crate::settings::chosen_lens;

/// Shows the values of the frame. Called on the main thread only.
pub(super) fn show(call: &Call) {
    let text = text(call).unwrap_or_else(|failure| failure.text);
    show_information(call.host, call.effect.handle, &text);
}

fn text(call: &Call) -> Result<String> {
    let knobs = Knobs::at(&call.effect, call.time());
    let profile = chosen_lens(&knobs, &lens::LENS, &lens::PROFILE)?;
    let data = LensData::read(&knobs, &profile)?;
    let lines = data.map(|data| data.lines()).unwrap_or_default();
    Ok(match lines.is_empty() {
        true => "Lens Data sets nothing at this frame.".to_owned(),
        false => lines.join("\n"),
    })
}
