//! Colour spaces of plates: which they are in, which light is worked on in, which they are written in.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;
use seidel_colour::{Alphas, ColourError, Config, Processor, Source, Space};

use crate::commands::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::format::Format;
use seidel_image_io::plate::Plate;

/// What asks for the space that a file is in to be told by the file.
const AUTO: &str = "auto";

/// What configs call sRGB-encoded Rec.709, as pictures in integers are: aliases and names of OpenColorIO's own configs.
const SRGB: [&str; 5] = [
    "srgb_tx",
    "srgb_rec709_scene",
    "sRGB - Texture",
    "sRGB Encoded Rec.709 (sRGB)",
    "sRGB",
];

/// Options about the config.
#[derive(Debug, Args)]
pub(crate) struct ConfigArgs {
    /// OpenColorIO config: a file, ocio://NAME for one that comes with OpenColorIO, or seidel for Seidel's own; if left
    /// out the one that the environment variable OCIO names, else Seidel's own
    #[arg(long, value_name = "CONFIG")]
    ocio: Option<String>,
}

/// Options about colour spaces.
#[derive(Debug, Args)]
pub(crate) struct ColourArgs {
    #[command(flatten)]
    config: ConfigArgs,
    /// Colour space that the plate is in: a name, alias or role of the config, or auto for what the file says of
    /// itself, else the config's file rules. If no option on colour is given nothing is converted: EXR is scene-linear,
    /// integers are sRGB
    #[arg(long, value_name = "SPACE")]
    in_space: Option<String>,
    /// Colour space to write the plate in; if left out that which it was in, but the working space where integers become
    /// EXR or HDR, and where light becomes integers the space of the config's file rules for OUT, else sRGB
    #[arg(long, value_name = "SPACE")]
    out_space: Option<String>,
    /// Colour space to work in, which must be proportional to light; the config's role scene_linear if left out
    #[arg(long, value_name = "SPACE")]
    working_space: Option<String>,
}

impl ConfigArgs {
    /// Reads the config that is asked for.
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
    /// Whether any colour is to be converted.
    pub(crate) fn is_given(&self) -> bool {
        let spaces = [&self.in_space, &self.out_space, &self.working_space];
        self.config.ocio.is_some() || spaces.iter().any(|space| space.is_some())
    }

    /// What converts plates, where anything is to be; otherwise no config is looked at. Remarks go to `said`.
    /// OUT has the name `output`.
    pub(crate) fn room<'a>(
        &self,
        output: &'a str,
        said: &mut Vec<String>,
    ) -> Result<Option<ColourRoom<'a>>, CommandError> {
        if !self.is_given() {
            return Ok(None);
        }
        let config = self.config.load()?;
        let named = |name: &Option<String>| -> Result<Option<Space>, CommandError> {
            let space = name.as_ref().map(|name| config.space(name));
            Ok(space.transpose()?)
        };
        let working = match named(&self.working_space)? {
            Some(space) => space,
            None => config.scene_linear()?,
        };
        if !working.is_scene_linear() {
            said.push(format!(
                "light is worked on in `{}`, which the config does not call scene-linear: blur is right in linear light only",
                working.name
            ));
        }
        let out = named(&self.out_space)?;
        let asked = self.in_space.clone().filter(|name| name != AUTO);
        Ok(Some(ColourRoom {
            asked: named(&asked)?,
            working,
            out,
            output: Path::new(output),
            config,
            told: Mutex::default(),
        }))
    }
}

/// What converts the plates of a run.
pub(crate) struct ColourRoom<'a> {
    config: Config,
    /// The space that plates are in; as they say if none.
    asked: Option<Space>,
    working: Space,
    /// The space that they are written in; as [`ColourRoom::left_out`] has it if none.
    out: Option<Space>,
    /// The name of OUT, which may hold a frame pattern.
    output: &'a Path,
    /// What was said of the last plate's colour.
    told: Mutex<String>,
}

/// What converts one plate.
#[derive(Clone)]
pub(crate) struct PlateColour {
    /// From the plate's space to that of light.
    incoming: Arc<Processor>,
    /// From there to that of the file to be written.
    outgoing: Arc<Processor>,
    /// From that of the file written to that of light.
    returning: Arc<Processor>,
}

impl ColourRoom<'_> {
    /// The name of the space that light is worked on in.
    pub(crate) fn working(&self) -> &str {
        &self.working.name
    }

    /// What converts `plate`; what its space was taken to be goes to `said`, unless it is as for the plate before.
    pub(crate) fn of(
        &self,
        plate: &Plate,
        said: &mut Vec<String>,
    ) -> Result<PlateColour, CommandError> {
        let (space, from) = match &self.asked {
            Some(space) => (space.clone(), "--in-space".to_owned()),
            None => space_of(&self.config, plate)?,
        };
        let (out, why) = match &self.out {
            Some(out) => (out.clone(), ""),
            None => self.left_out(plate, &space)?,
        };
        let told = format!(
            "colour: the plate is in `{}` ({from}), worked on in `{}`, written in `{}`{why}, by {}",
            space.name,
            self.working.name,
            out.name,
            self.config.name(),
        );
        let mut last = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if *last != told {
            for data in [&space, &out].iter().filter(|space| space.is_data) {
                said.push(format!("`{}` is for data: nothing is converted", data.name));
            }
            said.push(told.clone());
            *last = told;
        }
        drop(last);
        Ok(PlateColour {
            incoming: self.config.processor(&space.name, &self.working.name)?,
            outgoing: self.config.processor(&self.working.name, &out.name)?,
            returning: self.config.processor(&out.name, &self.working.name)?,
        })
    }

    /// The space that `plate`, which is in `space`, is written in where none is asked for; and why, where it is another.
    /// EXR and HDR of what was integers hold light, as whoever composites takes them to; integers hold no light as it is,
    /// which would leave shadows hardly a code.
    fn left_out(&self, plate: &Plate, space: &Space) -> Result<(Space, &str), CommandError> {
        let target = Format::from_path(self.output).unwrap_or(plate.format());
        if target == plate.format() || space.is_data {
            return Ok((space.clone(), ""));
        }
        let (was, becomes) = (plate.has_integer_samples(), plate.is_integer_in(target));
        let light = was && !becomes || target == Format::Hdr;
        if light && !space.is_scene_linear() {
            return Ok((self.working.clone(), " (OUT holds light)"));
        }
        if was || !becomes || !space.is_scene_linear() {
            return Ok((space.clone(), ""));
        }
        let by_rule = self.config.file_space(self.output);
        let by_rule = by_rule.filter(|rule| !rule.is_default);
        let by_rule = by_rule.and_then(|rule| self.config.find(&rule.space));
        let known = SRGB.iter().filter_map(|name| self.config.find(name));
        let mut codes = by_rule.into_iter().chain(known);
        let codes = codes.find(|space| !space.is_scene_linear() && !space.is_data);
        codes
            .map(|codes| (codes, " (OUT holds integers)"))
            .ok_or_else(|| {
                let problem = format!(
                    "would be light of `{}` in integers, and the config has no sRGB for textures",
                    space.name
                );
                FileError::new(self.output, "colour space", problem, "give --out-space").into()
            })
    }
}

/// The space that a plate is in by what its file says, else by its name; and which of them said so.
///
/// # Errors
/// A file of which neither its attributes nor the config's rules say anything.
pub(crate) fn space_of(config: &Config, plate: &Plate) -> Result<(Space, String), CommandError> {
    let attributes = plate.colour_space_attributes();
    let known = attributes
        .iter()
        .find_map(|(name, value)| Some((config.find(value)?, format!("its {name}"))));
    if let Some(known) = known {
        return Ok(known);
    }
    let by_rule = config.file_space(plate.path()).and_then(|rule| {
        let rules = match rule.is_default {
            true => "the config's rule for all files",
            false => "the config's file rules",
        };
        let unknown = attributes
            .first()
            .map_or_else(String::new, |(name, value)| {
                format!("; its {name} `{value}` is no space of the config")
            });
        Some((config.find(&rule.space)?, format!("{rules}{unknown}")))
    });
    by_rule.ok_or_else(|| {
        let problem = "is not said by the file, nor by the rules of the config";
        FileError::new(plate.path(), "colour space", problem, "give --in-space").into()
    })
}

impl PlateColour {
    /// What converts the plate once it is written.
    pub(crate) fn written(&self) -> Self {
        Self {
            incoming: Arc::clone(&self.returning),
            ..self.clone()
        }
    }

    /// The space that the plate is written in, where that is another than it was in.
    pub(crate) fn other_space(&self) -> Option<&str> {
        (self.incoming.from() != self.outgoing.to()).then(|| self.outgoing.to())
    }

    /// Turns colours of `plate` into light; how many samples have no light.
    pub(crate) fn read(
        &self,
        plate: &Plate,
        colours: &mut [Vec<f32>],
        alphas: Alphas,
    ) -> Result<usize, CommandError> {
        converted(&self.incoming, plate, colours, alphas)
    }

    /// Turns light into colours of `plate`.
    ///
    /// # Errors
    /// Light that the space has no number for.
    pub(crate) fn write(
        &self,
        plate: &Plate,
        colours: &mut [Vec<f32>],
        alphas: Alphas,
    ) -> Result<(), CommandError> {
        let unheld = converted(&self.outgoing, plate, colours, alphas)?;
        if unheld == 0 {
            return Ok(());
        }
        Err(FileError::new(
            plate.path(),
            "colour",
            format!(
                "{unheld} samples have no number in `{}`",
                self.outgoing.to()
            ),
            "give another --out-space",
        )
        .into())
    }
}

/// Turns colours in place; how many samples the other space has no number for.
fn converted(
    processor: &Processor,
    plate: &Plate,
    colours: &mut [Vec<f32>],
    alphas: Alphas,
) -> Result<usize, CommandError> {
    let report = processor.convert_planes(colours, alphas);
    let report = report.map_err(|e| FileError::new(plate.path(), e.field, e.problem, e.remedy))?;
    Ok(report.unrepresentable)
}
