//! Colour spaces of OpenColorIO configs, converted by the engine that the command uses.

use std::ops::Add;
use std::sync::Arc;

use seidel_colour::{ColourError, Config, ConversionReport, PixelLayout, Processor, Source};

use super::{AlphaHandling, NonFinite};
use crate::file_cache::FileCache;
use crate::file_reference;
use crate::host::{Failure, Result};
use crate::interleaved::Interleaved;
use crate::knobs::{Knobs, colour, lens};

/// Configs by their source. All instances share them.
static CONFIGS: FileCache<String, Config> = FileCache::new();

/// Empties the cache of configs. Configs in use live on until they are dropped.
pub(crate) fn clear() {
    CONFIGS.clear();
}

/// Conversions between the space of a source and the working space.
pub(super) struct Spaces {
    to_working: Arc<Processor>,
    from_working: Arc<Processor>,
}

fn failure(error: ColourError) -> Failure {
    Failure::failed(format!("{error}."))
}

/// Returns the config that the parameters name, or else the environment variable OCIO, or else Seidel's own.
fn chosen_config(knobs: &Knobs) -> Result<Arc<Config>> {
    let name = knobs.text(&colour::CONFIG);
    let name = file_reference::config(name.trim());
    let name = Some(&*name).filter(|name| !name.is_empty());
    let environment = std::env::var("OCIO").ok();
    let source = Source::chosen(name, environment.as_deref());
    let file = match &source {
        Source::File(path) => Some(path.as_path()),
        _ => None,
    };
    let reloads = knobs.hidden(&lens::RELOADS);
    CONFIGS.get(&source.to_string(), file, reloads, || {
        Config::load(&source).map_err(failure)
    })
}

impl Spaces {
    /// Returns the conversions between the spaces that the parameters name.
    ///
    /// # Errors
    /// A config that cannot be read, a space that is not named or that the config lacks, and transforms that cannot be
    /// built.
    pub(super) fn chosen(knobs: &Knobs) -> Result<Self> {
        let source = knobs.text(&colour::SOURCE_SPACE);
        let source = source.trim();
        if source.is_empty() {
            return Err(Failure::failed(
                "Source Space: none is given; name the colour space of the source as the config does.",
            ));
        }
        let config = chosen_config(knobs)?;
        let working = knobs.text(&colour::WORKING_SPACE);
        let working = match working.trim() {
            "" => config.scene_linear().map_err(failure)?.name,
            name => name.to_owned(),
        };
        Ok(Self {
            to_working: config.processor(source, &working).map_err(failure)?,
            from_working: config.processor(&working, source).map_err(failure)?,
        })
    }

    /// Converts `source` to the working space.
    ///
    /// # Errors
    /// Samples that are not finite or have no finite value there, if they are rejected. Otherwise they become zero.
    pub(super) fn decode(
        &self,
        source: &mut Interleaved,
        alpha: AlphaHandling,
        threads: u32,
        non_finite: NonFinite,
    ) -> Result<()> {
        let count = convert(&self.to_working, source, alpha, threads)?;
        if count == 0 || non_finite == NonFinite::BecomeZero {
            return Ok(());
        }
        Err(Failure::failed(format!(
            "Source: {}, or without a finite value for its code in `{}`; repair the source, or switch Scrub on.",
            if count == 1 {
                "1 sample is not finite".to_owned()
            } else {
                format!("{count} samples are not finite")
            },
            self.to_working.from()
        )))
    }

    /// Converts `light` from the working space to that of the source.
    ///
    /// # Errors
    /// Values that have no finite code there.
    pub(super) fn encode(
        &self,
        light: &mut Interleaved,
        alpha: AlphaHandling,
        threads: u32,
    ) -> Result<()> {
        let count = convert(&self.from_working, light, alpha, threads)?;
        if count == 0 {
            return Ok(());
        }
        Err(Failure::failed(format!(
            "Source Space: {count} samples of the result cannot be represented in `{}`; give the space that the source is in.",
            self.from_working.to()
        )))
    }
}

/// Converts `image` and returns the number of samples without a finite value, before or after.
fn convert(
    processor: &Processor,
    image: &mut Interleaved,
    alpha: AlphaHandling,
    threads: u32,
) -> Result<usize> {
    let layout = match (image.channels(), alpha) {
        (3, _) => PixelLayout::Rgb,
        (_, AlphaHandling::Straight) => PixelLayout::RgbaStraight,
        (_, AlphaHandling::Premultiplied) => PixelLayout::RgbaPremultiplied,
    };
    let reports = image.for_each_part(threads, |part| {
        processor.convert_pixels_serial(part, layout)
    });
    let report = reports
        .into_iter()
        .map(|report| report.map_err(failure))
        .try_fold(ConversionReport::default(), |sum, part| {
            Ok::<_, Failure>(sum.add(part?))
        })?;
    Ok(report.non_finite + report.unrepresentable)
}
