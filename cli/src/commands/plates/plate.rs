//! Options about the plate, and the image in a plate file.

use std::path::Path;

use clap::{Args, ValueEnum};
use seidel_colour::{Alphas, ConversionReport};
use seidel_core::{AlphaKind, Image, LensScale, PlateGeometry};
use seidel_render::MAX_PIXEL_ASPECT;

use super::colour::{ColourArgs, PlateColour, unrepresentable};
use crate::commands::{CommandError, EncodingChoice};
use seidel_image_io::error::FileError;
use seidel_image_io::formats::exr::{self, ExrCompression, ViewChoice};
use seidel_image_io::plate::{PlateFile, PlateOptions};
use seidel_image_io::samples::Encoding;

/// Options about the plate.
#[derive(Debug, Args)]
pub(crate) struct PlateArgs {
    /// EXR layer or part to process; if omitted the root R, G, B (or Y) and A, or those of a beauty pass
    #[arg(long, help_heading = "Input")]
    layer: Option<String>,
    /// View of a stereo EXR to process: left, right or another name; all of them if omitted
    ///
    /// Each view is rendered with its own depth. The others stay as they are.
    #[arg(long, help_heading = "Input", value_name = "VIEW", default_value = "all", value_parser = parse_view)]
    view: ViewChoice,
    /// Replace NaN and infinite samples by zero, with a warning, instead of stopping
    #[arg(long, help_heading = "Input")]
    scrub: bool,
    /// Width of a plate pixel over its height in the scene, such as 2 for an anamorphic plate before desqueezing
    ///
    /// If omitted: the EXR's pixelAspectRatio or the value of the DPX header, else 1. Blur and displacement along x are
    /// 1/P as many pixels; S/P for an anamorphic lens of squeeze S. A plate of such a lens with P = 1 counts as squeezed if its
    /// shape is nearer to that of the sensor than to that of the desqueezed picture.
    #[arg(long, help_heading = "Input", value_name = "P", value_parser = parse_ratio)]
    pixel_aspect: Option<f64>,
    /// Encoding of integer samples, in IN and in an OUT of another format; floats are linear
    ///
    /// If omitted: sRGB, except in DPX, where the header decides and unknown values are read as linear.
    #[arg(long, help_heading = "Colour", value_enum, conflicts_with_all = ["in_space", "out_space", "working_space", "ocio"])]
    encoding: Option<EncodingChoice>,
    /// Relation of colour and alpha; from the file if omitted (EXR and DPX premultiplied, PNG unpremultiplied, TIFF by
    /// its tag)
    #[arg(long, help_heading = "Colour", value_enum)]
    alpha: Option<AlphaChoice>,
    #[command(flatten)]
    pub(super) colour: ColourArgs,
    /// Write the blurred alpha of each colour as alpha.R, alpha.G, alpha.B beside A, so that colour fringes survive a
    /// merge (EXR only)
    ///
    /// Each alpha is blurred as its colour is. If the plate has such channels, they are read as the alphas of its colours.
    #[arg(long, help_heading = "Output")]
    alpha_per_channel: bool,
    /// Extend identifiers, masks, normals and all other channels by their edge pixels where the data window grows; they are zero
    /// there if omitted
    #[arg(long, help_heading = "Output")]
    extend_channels: bool,
    /// Compression of an EXR output; that of the plate if omitted, or ZIP if that is lossy
    ///
    /// dwaa, dwab, b44 and b44a are lossy; pxr24 is lossy for floats. With these, parts that hold more than colour and
    /// alpha are compressed with zip.
    #[arg(long, help_heading = "Output", value_enum)]
    compression: Option<ExrCompression>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AlphaChoice {
    /// Colour is multiplied by alpha
    Premultiplied,
    /// Colour is not multiplied by alpha
    Unpremultiplied,
}

fn parse_view(text: &str) -> Result<ViewChoice, String> {
    match text {
        "" => Err("give the name of a view, or all".to_owned()),
        "all" => Ok(ViewChoice::All),
        name => Ok(ViewChoice::Named(name.to_owned())),
    }
}

fn parse_ratio(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|v| v.is_finite() && *v > 0.0)
        .ok_or_else(|| "give a number greater than zero".to_owned())
}

impl PlateArgs {
    /// Returns the options for reading a plate file.
    pub(super) fn options(&self) -> PlateOptions {
        PlateOptions {
            layer: self.layer.clone(),
            view: self.view.clone(),
            extend_channels: self.extend_channels,
            encoding: match self.encoding {
                Some(choice) => Some(choice.into()),
                // The config defines the encoding.
                None if self.colour.is_used() => Some(Encoding::Linear),
                None => None,
            },
            premultiplied: self
                .alpha
                .map(|choice| choice == AlphaChoice::Premultiplied),
            colour_managed: self.colour.is_used(),
            alpha_per_channel: self.alpha_per_channel,
            compression: self.compression,
        }
    }

    /// Rejects `--compression` for an `output` that is not an EXR file.
    pub(super) fn check_output(&self, output: &Path) -> Result<(), CommandError> {
        if self.compression.is_none() || exr::FORMAT.check_name(output).is_ok() {
            return Ok(());
        }
        Err(CommandError::Usage(format!(
            "--compression applies to EXR files, but {} has another extension; leave it out or name OUT .exr",
            output.display()
        )))
    }

    /// Returns the width of the plate's pixels over their height.
    ///
    /// # Errors
    /// A ratio outside the range of the renderers.
    pub(super) fn pixel_aspect(&self, plate: &PlateFile) -> Result<f64, CommandError> {
        let aspect = self.pixel_aspect.unwrap_or_else(|| plate.pixel_aspect());
        if (1.0 / MAX_PIXEL_ASPECT..=MAX_PIXEL_ASPECT).contains(&aspect) {
            return Ok(aspect);
        }
        let source = match self.pixel_aspect {
            Some(_) => "--pixel-aspect",
            None => "pixelAspectRatio",
        };
        Err(FileError::new(
            plate.path(),
            source,
            format!("is {aspect}"),
            format!(
                "give --pixel-aspect from 1/{MAX_PIXEL_ASPECT} to {MAX_PIXEL_ASPECT}, 1 for square pixels"
            ),
        )
        .into())
    }

    /// Returns the place of `plate` in the frame of the lens, whose scale on it is `lens_scale`.
    ///
    /// # Errors
    /// Those of [`Self::pixel_aspect`].
    pub(super) fn geometry(
        &self,
        plate: &PlateFile,
        lens_scale: LensScale,
    ) -> Result<PlateGeometry, CommandError> {
        Ok(PlateGeometry {
            display: plate.display_window(),
            data: plate.data_window(),
            pixel_aspect: self.pixel_aspect(plate)?,
            lens_scale,
        })
    }

    /// Returns the image of `plate`, converted to scene-linear values by `colour`. Adds to `warnings`.
    ///
    /// # Errors
    /// Samples that are not finite before or after the conversion, unless `--scrub` replaces them.
    pub(super) fn image(
        &self,
        plate: &PlateFile,
        colour: Option<&PlateColour>,
        warnings: &mut Vec<String>,
    ) -> Result<Image, CommandError> {
        warnings.extend(plate.read_warnings());
        let bad = plate.non_finite();
        if let Some(first) = bad.first()
            && !self.scrub
        {
            return Err(FileError::new(
                plate.path(),
                "",
                first.to_string(),
                "correct the plate, or give --scrub to replace such samples by zero",
            )
            .into());
        }
        warnings.extend(bad.iter().map(|b| format!("{b}; replaced by zero")));
        let alpha = plate.alpha();
        let premultiplied = match self.alpha {
            Some(choice) => choice == AlphaChoice::Premultiplied,
            None => plate.is_premultiplied(),
        };
        let kind = if alpha.is_none() || premultiplied {
            AlphaKind::Premultiplied
        } else {
            AlphaKind::Unpremultiplied
        };
        let mut colours = plate.colour();
        let channel_alphas = plate.channel_alphas();
        if let Some(colour) = colour {
            let alphas = alphas(kind, alpha.as_deref(), &channel_alphas);
            let report = colour.decode(plate, &mut colours, alphas)?;
            self.check_unrepresentable(plate, &report, warnings)?;
        }
        let names = plate.colour_names().to_vec();
        let mut image = Image::new(plate.width(), plate.height(), names, colours)?.with_alpha(
            alpha,
            channel_alphas,
            kind,
        );
        // Reported above.
        image.replace_non_finite();
        Ok(image)
    }

    /// Rejects samples without a finite scene-linear value unless `--scrub` replaces them.
    fn check_unrepresentable(
        &self,
        plate: &PlateFile,
        report: &ConversionReport,
        warnings: &mut Vec<String>,
    ) -> Result<(), CommandError> {
        let Some(problem) = unrepresentable(report, plate, "scene-linear value") else {
            return Ok(());
        };
        if self.scrub {
            warnings.push(format!("{problem}; replaced by zero"));
            return Ok(());
        }
        let remedy = "check --in-space, or give --scrub to replace such samples by zero";
        Err(FileError::new(plate.path(), "colour", problem, remedy).into())
    }
}

/// Returns the alphas that colours of the given `kind` are multiplied by.
fn alphas<'a>(
    kind: AlphaKind,
    alpha: Option<&'a [f32]>,
    channel_alphas: &'a [Vec<f32>],
) -> Alphas<'a> {
    match alpha {
        Some(_) if kind == AlphaKind::Unpremultiplied => Alphas::Straight,
        Some(_) if !channel_alphas.is_empty() => Alphas::PerPlane(channel_alphas),
        Some(alpha) => Alphas::Shared(alpha),
        None => Alphas::Straight,
    }
}

/// Puts `image` into `plate`, in the colour space of the output.
pub(super) fn put_image(
    plate: &mut PlateFile,
    mut image: Image,
    colour: Option<&PlateColour>,
) -> Result<(), CommandError> {
    if let Some(colour) = colour {
        let alphas = alphas(
            image.alpha_kind,
            image.alpha.as_deref(),
            &image.channel_alphas,
        );
        colour.encode(plate, &mut image.colours, alphas)?;
        if let Some(space) = colour.new_space() {
            plate.set_colour_space(space);
        }
    }
    plate.set_colour(&image.colours)?;
    if let Some(alpha) = &image.alpha {
        plate.set_alpha(alpha)?;
    }
    plate.set_channel_alphas(&image.channel_alphas)?;
    Ok(())
}
