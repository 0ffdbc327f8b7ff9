//! Colour spaces of plates: that of the input, the working space, and that of the output.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;
use seidel_colour::{Alphas, ColourError, Config, ConversionReport, Processor, Source, Space};

use crate::commands::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::format::Format;
use seidel_image_io::plate::PlateFile;
use seidel_image_io::samples::SampleFormat;

/// The value of `--in-space` that selects the space by the file's metadata or name.
pub(crate) const AUTO: &str = "auto";

/// Names of sRGB-encoded Rec.709, the usual encoding of integer images: aliases and names in OpenColorIO's own configs.
const SRGB: [&str; 5] = [
    "srgb_tx",
    "srgb_rec709_scene",
    "sRGB - Texture",
    "sRGB Encoded Rec.709 (sRGB)",
    "sRGB",
];

/// Options about the config.
#[derive(Debug, Args)]
#[command(next_help_heading = "Colour")]
pub(crate) struct ConfigArgs {
    /// OpenColorIO config: a file, ocio://NAME for one built into OpenColorIO, or seidel for Seidel's own; if omitted,
    /// that of the environment variable OCIO, else Seidel's own
    #[arg(long, value_name = "CONFIG")]
    ocio: Option<String>,
}

/// Options about colour spaces.
#[derive(Debug, Args)]
#[command(next_help_heading = "Colour")]
pub(crate) struct ColourArgs {
    #[command(flatten)]
    config: ConfigArgs,
    /// Colour space of the plate: a name, alias or role of the config, or auto for the space that the file's metadata or
    /// the config's file rules state
    ///
    /// Without any option about colour nothing is converted: EXR is scene-linear, integers are sRGB.
    #[arg(long, value_name = "SPACE")]
    in_space: Option<String>,
    /// Colour space of the output; that of the plate if omitted
    ///
    /// If omitted, the output is in the working space where integers become EXR or HDR. Where scene-linear values become
    /// integers, it is in the space of the config's file rules for OUT, else sRGB.
    #[arg(long, value_name = "SPACE")]
    out_space: Option<String>,
    /// Working space, which must be scene-linear; the config's role scene_linear if omitted
    #[arg(long, value_name = "SPACE")]
    working_space: Option<String>,
}

impl ConfigArgs {
    /// Reads the selected config.
    pub(crate) fn load(&self) -> Result<Config, CommandError> {
        let environment = std::env::var("OCIO").ok();
        let source = Source::chosen(self.ocio.as_deref(), environment.as_deref());
        Ok(Config::load(&source)?)
    }
}

impl From<ColourError> for CommandError {
    fn from(e: ColourError) -> Self {
        Self::File(FileError::new(e.config, e.field, e.problem, e.remedy))
    }
}

impl ColourArgs {
    /// Returns whether any option about colour is used.
    pub(super) fn is_used(&self) -> bool {
        let spaces = [&self.in_space, &self.out_space, &self.working_space];
        self.config.ocio.is_some() || spaces.iter().any(|space| space.is_some())
    }

    /// Returns the colour pipeline of a run that writes `output`; `None`, without reading a config, if no option about
    /// colour is used. Adds to `warnings`.
    pub(super) fn pipeline<'a>(
        &self,
        output: &'a Path,
        warnings: &mut Vec<String>,
    ) -> Result<Option<ColourPipeline<'a>>, CommandError> {
        if !self.is_used() {
            return Ok(None);
        }
        let config = self.config.load()?;
        let find = |name: Option<&String>| -> Result<Option<Space>, CommandError> {
            let space = name.map(|name| config.space(name));
            Ok(space.transpose()?)
        };
        let working = match find(self.working_space.as_ref())? {
            Some(space) => space,
            None => config.scene_linear()?,
        };
        if !working.is_scene_linear() {
            warnings.push(format!(
                "the config does not state that the working space `{}` is scene-linear: blur is correct in linear light only",
                working.name
            ));
        }
        Ok(Some(ColourPipeline {
            output_space: find(self.out_space.as_ref())?,
            input_space: find(self.in_space.as_ref().filter(|name| *name != AUTO))?,
            working,
            output,
            config,
            reported: ChangeFilter::default(),
        }))
    }
}

/// A filter of messages that repeat from frame to frame.
#[derive(Default)]
pub(crate) struct ChangeFilter(Mutex<String>);

impl ChangeFilter {
    /// Returns whether `message` differs from that of the last call.
    pub(crate) fn is_new(&self, message: &str) -> bool {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_new = *last != message;
        if is_new {
            message.clone_into(&mut last);
        }
        is_new
    }
}

/// The colour conversion of the plates of a run.
pub(super) struct ColourPipeline<'a> {
    config: Config,
    /// The space of plates; by each file if `None`.
    input_space: Option<Space>,
    working: Space,
    /// The space of the output; by [`ColourPipeline::default_output_space`] if `None`.
    output_space: Option<Space>,
    /// The name of OUT, which may be a frame pattern.
    output: &'a Path,
    reported: ChangeFilter,
}

/// The colour conversion of one plate.
#[derive(Clone)]
pub(super) struct PlateColour {
    /// From the plate's space to the working space.
    decoder: Arc<Processor>,
    /// From the working space to that of the output.
    encoder: Arc<Processor>,
    /// From the space of the output back to the working space.
    result_decoder: Arc<Processor>,
}

impl ColourPipeline<'_> {
    /// Returns the name of the working space.
    pub(super) fn working_space(&self) -> &str {
        &self.working.name
    }

    /// Returns the conversion of `plate`. Adds its spaces to `warnings`, unless they are those of the plate before.
    pub(super) fn of_plate(
        &self,
        plate: &PlateFile,
        warnings: &mut Vec<String>,
    ) -> Result<PlateColour, CommandError> {
        let (space, source) = match &self.input_space {
            Some(space) => (space.clone(), "--in-space".to_owned()),
            None => space_of(&self.config, plate)?,
        };
        let (out, reason) = match &self.output_space {
            Some(out) => (out.clone(), ""),
            None => self.default_output_space(plate, &space)?,
        };
        let message = format!(
            "colour: the plate is in `{}` ({source}), processed in `{}`, written in `{}`{reason}, by {}",
            space.name,
            self.working.name,
            out.name,
            self.config.name(),
        );
        if self.reported.is_new(&message) {
            for data in [&space, &out].iter().filter(|space| space.is_data) {
                warnings.push(format!("`{}` is for data: nothing is converted", data.name));
            }
            warnings.push(message);
        }
        Ok(PlateColour {
            decoder: self.config.processor(&space.name, &self.working.name)?,
            encoder: self.config.processor(&self.working.name, &out.name)?,
            result_decoder: self.config.processor(&out.name, &self.working.name)?,
        })
    }

    /// Returns the space in which `plate`, which is in `space`, is written without `--out-space`, and the reason if it
    /// is another one.
    ///
    /// EXR and HDR made from integers are scene-linear, as compositors expect. Integers are never linear: shadows would
    /// have hardly a code.
    fn default_output_space(
        &self,
        plate: &PlateFile,
        space: &Space,
    ) -> Result<(Space, &str), CommandError> {
        let target = Format::from_path(self.output).unwrap_or(plate.format());
        if target == plate.format() || space.is_data {
            return Ok((space.clone(), ""));
        }
        let samples = plate.sample_format_in(target);
        let (was_integer, becomes_integer) = (plate.has_integer_samples(), samples.is_integer());
        let becomes_float = was_integer && !becomes_integer || samples == SampleFormat::Rgbe;
        if becomes_float && !space.is_scene_linear() {
            return Ok((self.working.clone(), " (OUT is scene-linear)"));
        }
        if was_integer || !becomes_integer || !space.is_scene_linear() {
            return Ok((space.clone(), ""));
        }
        let by_rule = self.config.file_space(self.output);
        let by_rule = by_rule.filter(|rule| !rule.is_default);
        let by_rule = by_rule.and_then(|rule| self.config.find(&rule.space));
        let known = SRGB.iter().filter_map(|name| self.config.find(name));
        let mut candidates = by_rule.into_iter().chain(known);
        let encoded = candidates.find(|space| !space.is_scene_linear() && !space.is_data);
        encoded
            .map(|space| (space, " (OUT holds integers)"))
            .ok_or_else(|| {
                let problem = format!(
                    "integers would hold scene-linear `{}`, and the config has no sRGB space for textures",
                    space.name
                );
                FileError::new(self.output, "colour space", problem, "give --out-space").into()
            })
    }
}

/// Returns the space of a plate by the metadata of its file, else by the config's file rules; and which of the two.
///
/// # Errors
/// A file whose space neither its metadata nor a rule states.
pub(crate) fn space_of(
    config: &Config,
    plate: &PlateFile,
) -> Result<(Space, String), CommandError> {
    let attributes = plate.colour_space_attributes();
    let known = attributes
        .iter()
        .find_map(|(name, value)| Some((config.find(value)?, format!("its {name}"))));
    if let Some(known) = known {
        return Ok(known);
    }
    let by_rule = config.file_space(plate.path()).and_then(|rule| {
        let rules = if rule.is_default {
            "the config's rule for all files"
        } else {
            "the config's file rules"
        };
        let unknown = attributes
            .first()
            .map_or_else(String::new, |(name, value)| {
                format!("; its {name} `{value}` is not a space of the config")
            });
        Some((config.find(&rule.space)?, format!("{rules}{unknown}")))
    });
    by_rule.ok_or_else(|| {
        let problem = "is stated neither by the file nor by the rules of the config";
        FileError::new(plate.path(), "colour space", problem, "give --in-space").into()
    })
}

impl PlateColour {
    /// Returns the conversion of a result, which is in the space of the output.
    pub(super) fn of_result(&self) -> Self {
        Self {
            decoder: Arc::clone(&self.result_decoder),
            ..self.clone()
        }
    }

    /// Returns the space of the output if it is not that of the plate.
    pub(super) fn new_space(&self) -> Option<&str> {
        (self.decoder.from() != self.encoder.to()).then(|| self.encoder.to())
    }

    /// Converts colours of `plate` to the working space. Returns the number of samples without a finite value there.
    pub(super) fn decode(
        &self,
        plate: &PlateFile,
        colours: &mut [Vec<f32>],
        alphas: Alphas,
    ) -> Result<ConversionReport, CommandError> {
        convert(&self.decoder, plate, colours, alphas)
    }

    /// Converts colours of the working space to the space of the output.
    ///
    /// # Errors
    /// Samples without a finite value in that space.
    pub(super) fn encode(
        &self,
        plate: &PlateFile,
        colours: &mut [Vec<f32>],
        alphas: Alphas,
    ) -> Result<(), CommandError> {
        let report = convert(&self.encoder, plate, colours, alphas)?;
        let space = format!("value in `{}`", self.encoder.to());
        match unrepresentable(&report, plate, &space) {
            Some(problem) => {
                let remedy = "give another --out-space";
                Err(FileError::new(plate.path(), "colour", problem, remedy).into())
            }
            None => Ok(()),
        }
    }
}

/// Describes the samples of `plate` without a finite `value`, such as `value in ACEScg`; `None` if there are none.
pub(crate) fn unrepresentable(
    report: &ConversionReport,
    plate: &PlateFile,
    value: &str,
) -> Option<String> {
    let first = report.first_unrepresentable?;
    let names = plate.colour_names();
    let name = names.get(first.channel).or(names.first());
    Some(format!(
        "{} samples have no finite {value}, the first in channel {}, pixel ({}, {})",
        report.unrepresentable,
        name.map_or("", String::as_str),
        first.pixel % plate.width(),
        first.pixel / plate.width()
    ))
}

/// Converts colours in place.
fn convert(
    processor: &Processor,
    plate: &PlateFile,
    colours: &mut [Vec<f32>],
    alphas: Alphas,
) -> Result<ConversionReport, CommandError> {
    let report = processor.convert_planes(colours, alphas);
    Ok(report.map_err(|e| FileError::new(plate.path(), e.field, e.problem, e.remedy))?)
}
