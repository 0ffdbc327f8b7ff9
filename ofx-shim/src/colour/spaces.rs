//! Colour spaces of OpenColorIO configs: the engine that the command has too.

use std::ops::Add;
use std::sync::Arc;

use seidel_colour::{ColourError, Config, ConversionReport, PixelLayout, Processor, Source};

use crate::host::{Failure, Result};
use crate::kept::Shelf;
use crate::knobs::{Knobs, colour, lens};
use crate::rendering::Copied;

/// Configs by what they are called. All instances share them.
static CONFIGS: Shelf<String, Config> = Shelf::new();

/// Lets go of all configs; those in use live on until they are not.
pub(crate) fn forget() {
    CONFIGS.forget();
}

/// What goes between the space of a source and that of light.
pub(super) struct Spaces {
    incoming: Arc<Processor>,
    outgoing: Arc<Processor>,
}

fn said(why: ColourError) -> Failure {
    Failure::failed(format!("{why}."))
}

/// The config that the knobs say, else the environment, else Seidel's own.
fn config(knobs: &Knobs) -> Result<Arc<Config>> {
    let given = knobs.text(&colour::CONFIG);
    let given = Some(given.trim()).filter(|name| !name.is_empty());
    let environment = std::env::var("OCIO").ok();
    let source = Source::chosen(given, environment.as_deref());
    let file = match &source {
        Source::File(path) => Some(path.as_path()),
        _ => None,
    };
    let reloads = knobs.hidden(&lens::RELOADS);
    CONFIGS.get(&source.to_string(), file, reloads, || {
        Config::load(&source).map_err(said)
    })
}

impl Spaces {
    /// Those that are set.
    ///
    /// # Errors
    /// A config that cannot be read, a space that it does not have or none, transforms that cannot be made.
    pub(super) fn of(knobs: &Knobs) -> Result<Self> {
        let from = knobs.text(&colour::SOURCE_SPACE);
        let from = from.trim();
        if from.is_empty() {
            return Err(Failure::failed(
                "Source Space: none is given; name the colour space that the source is in, as the config calls it.",
            ));
        }
        let config = config(knobs)?;
        let working = knobs.text(&colour::WORKING_SPACE);
        let working = match working.trim() {
            "" => config.scene_linear().map_err(said)?.name,
            name => name.to_owned(),
        };
        Ok(Self {
            incoming: config.processor(from, &working).map_err(said)?,
            outgoing: config.processor(&working, from).map_err(said)?,
        })
    }

    /// Turns a source to light. What is not finite, or has no finite light, counts as zero where that is wanted.
    pub(super) fn light(
        &self,
        source: &mut Copied,
        premultiplied: bool,
        threads: u32,
        scrub: bool,
    ) -> Result<()> {
        let report = through(&self.incoming, source, premultiplied, threads)?;
        let without = report.non_finite + report.unrepresentable;
        if without == 0 || scrub {
            return Ok(());
        }
        Err(Failure::failed(format!(
            "Source: {without} samples that are not finite, or have no light in `{}`; mend them before, or switch Scrub on.",
            self.incoming.from()
        )))
    }

    /// Turns light to what the source is in.
    pub(super) fn coded(
        &self,
        light: &mut Copied,
        premultiplied: bool,
        threads: u32,
    ) -> Result<()> {
        let report = through(&self.outgoing, light, premultiplied, threads)?;
        let without = report.non_finite + report.unrepresentable;
        if without == 0 {
            return Ok(());
        }
        Err(Failure::failed(format!(
            "Source Space: {without} samples of the result have no number in `{}`; give the space that the source is in.",
            self.outgoing.to()
        )))
    }
}

fn through(
    processor: &Processor,
    picture: &mut Copied,
    premultiplied: bool,
    threads: u32,
) -> Result<ConversionReport> {
    let layout = match (picture.channels(), premultiplied) {
        (3, _) => PixelLayout::Rgb,
        (_, false) => PixelLayout::RgbaStraight,
        (_, true) => PixelLayout::RgbaPremultiplied,
    };
    let parts = picture.parts(threads, |part| {
        processor.convert_pixels_serial(part, layout)
    });
    let parts = parts.into_iter();
    parts
        .map(|report| report.map_err(said))
        .try_fold(ConversionReport::default(), |all, part| Ok(all.add(part?)))
}
