//! Options about the plate, and the image in a plate file.

use std::path::Path;

use clap::{Args, ValueEnum};
use seidel_colour::Alphas;
use seidel_core::render::MAX_PIXEL_ASPECT;
use seidel_core::{AlphaKind, Image, PlateGeometry, Rectangle};

use super::colour::{ColourArgs, PlateColour};
use crate::commands::CommandError;
use seidel_image_io::error::FileError;
use seidel_image_io::exr::ExrCompression;
use seidel_image_io::format::Format;
use seidel_image_io::plate::{Plate, PlateOptions};
use seidel_image_io::samples::Encoding;
use seidel_image_io::windows::PixelWindow;

/// Options about the plate.
#[derive(Debug, Args)]
pub(crate) struct PlateArgs {
    /// EXR layer or part to blur; the root R, G, B (or Y) and A if left out
    #[arg(long)]
    layer: Option<String>,
    /// What integer samples mean, in IN and in an OUT of another format: srgb if left out, in DPX what its header says
    /// and linear where it says nothing known; floats are linear
    #[arg(long, value_enum, conflicts_with_all = ["in_space", "out_space", "working_space", "ocio"])]
    encoding: Option<EncodingChoice>,
    /// How colour and alpha go together; as the file says if left out (EXR and DPX
    /// premultiplied, PNG unpremultiplied, TIFF by its tag)
    #[arg(long, value_enum)]
    alpha: Option<AlphaChoice>,
    /// Write the blurred alpha of each colour as alpha.R, alpha.G, alpha.B beside A, so that colour fringes
    /// survive a merge: each is blurred as its colour is. Where the plate has such channels they are taken as
    /// the alpha of their colours. EXR only
    #[arg(long)]
    alpha_per_channel: bool,
    /// How an EXR that is written is packed. If left out as the plate was, but ZIP where that loses quality. dwaa, dwab, b44 and
    /// b44a lose quality, pxr24 that of floats: parts that hold more than colour and alpha are packed with zip then
    #[arg(long, value_enum)]
    compression: Option<ExrCompression>,
    /// Replace NaN and infinite samples by zero, and say how many, instead of stopping
    #[arg(long)]
    scrub: bool,
    /// Plate pixels per pixel of the lens's frame, counted along y; if left out the plate's display window is as
    /// wide as the lens's full frame, pixel aspect included
    #[arg(long, value_name = "RATIO", value_parser = parse_ratio)]
    pub(crate) lens_scale: Option<f64>,
    /// Width of a plate pixel over its height, such as 2 for an anamorphic plate not yet desqueezed; if left out
    /// as the EXR's pixelAspectRatio or the DPX header says, else 1. The lens sees the plate as wide as its pixels make
    /// it: blur and displacement along x are 1/P as many pixels
    #[arg(long, value_name = "P", value_parser = parse_ratio)]
    pixel_aspect: Option<f64>,
    #[command(flatten)]
    pub(super) colour: ColourArgs,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum EncodingChoice {
    /// Proportional to light
    Linear,
    /// The sRGB transfer function
    Srgb,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AlphaChoice {
    /// Colour is multiplied by alpha
    Premultiplied,
    /// Colour is not multiplied by alpha
    Unpremultiplied,
}

fn parse_ratio(text: &str) -> std::result::Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|v| v.is_finite() && *v > 0.0)
        .ok_or_else(|| "give a number greater than zero".to_owned())
}

impl PlateArgs {
    pub(crate) fn options(&self) -> PlateOptions {
        PlateOptions {
            layer: self.layer.clone(),
            encoding: match self.encoding {
                Some(EncodingChoice::Linear) => Some(Encoding::Linear),
                Some(EncodingChoice::Srgb) => Some(Encoding::Srgb),
                // The config says what codes mean.
                None if self.colour.is_given() => Some(Encoding::Linear),
                None => None,
            },
            premultiplied: self
                .alpha
                .map(|choice| choice == AlphaChoice::Premultiplied),
            colour_managed: self.colour.is_given(),
            alpha_per_channel: self.alpha_per_channel,
            compression: self.compression,
        }
    }

    /// Refuses options that an output of this name cannot follow.
    ///
    /// # Errors
    /// --compression of what is no EXR.
    pub(crate) fn check_output(&self, output: &str) -> std::result::Result<(), CommandError> {
        let is_exr = Format::from_path(Path::new(output)) == Some(Format::Exr);
        match self.compression.is_some() && !is_exr {
            true => Err(CommandError::Usage(format!(
                "--compression is of EXR files, which {output} is not named like"
            ))),
            false => Ok(()),
        }
    }

    /// Width of the plate's pixels over their height.
    ///
    /// # Errors
    /// One that no renderer follows.
    pub(crate) fn pixel_aspect(&self, plate: &Plate) -> std::result::Result<f64, CommandError> {
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

    /// Returns the image of `plate`, converted to scene-linear light by `colour`. Adds to `warnings`.
    pub(crate) fn image(
        &self,
        plate: &Plate,
        colour: Option<&PlateColour>,
        warnings: &mut Vec<String>,
    ) -> std::result::Result<Image, CommandError> {
        warnings.extend(plate.read_warnings());
        let bad = plate.non_finite();
        if let Some(first) = bad.first()
            && !self.scrub
        {
            return Err(FileError::new(
                plate.path(),
                "",
                first.to_string(),
                "mend the plate, or give --scrub to replace such samples by zero",
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
        let own_alphas = plate.channel_alphas();
        if let Some(colour) = colour {
            let alphas = alphas_of(kind, alpha.as_deref(), &own_alphas);
            let unheld = colour.read(plate, &mut colours, alphas)?;
            self.check_unheld(plate, unheld, warnings)?;
        }
        let names = plate.colour_names().to_vec();
        let mut image = Image::new(plate.width(), plate.height(), names, colours)?
            .with_alpha(alpha, own_alphas, kind);
        // Reported above.
        image.replace_non_finite();
        Ok(image)
    }

    /// Refuses codes without light, unless they are to be replaced.
    fn check_unheld(
        &self,
        plate: &Plate,
        unheld: usize,
        warnings: &mut Vec<String>,
    ) -> std::result::Result<(), CommandError> {
        let problem = format!("{unheld} samples are codes of no finite light");
        match unheld {
            0 => {}
            _ if self.scrub => warnings.push(format!("{problem}; replaced by zero")),
            _ => {
                let remedy = "check --in-space, or give --scrub to replace such samples by zero";
                return Err(FileError::new(plate.path(), "colour", problem, remedy).into());
            }
        }
        Ok(())
    }
}

/// The alphas that colours in a file are multiplied by.
fn alphas_of<'a>(
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

/// Puts `image` into `plate`, in the colour space that it is written in.
pub(super) fn put_image(
    plate: &mut Plate,
    mut image: Image,
    colour: Option<&PlateColour>,
) -> std::result::Result<(), CommandError> {
    if let Some(colour) = colour {
        let alphas = alphas_of(
            image.alpha_kind,
            image.alpha.as_deref(),
            &image.channel_alphas,
        );
        colour.write(plate, &mut image.colours, alphas)?;
        if let Some(space) = colour.other_space() {
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

/// The geometry of `plate` with these pixels and scale.
pub(super) fn plate_geometry(
    plate: &Plate,
    lens_scale: Option<f64>,
    pixel_aspect: f64,
) -> PlateGeometry {
    let rectangle = |window: PixelWindow| Rectangle {
        x: window.x,
        y: window.y,
        width: window.width,
        height: window.height,
    };
    PlateGeometry {
        display: rectangle(plate.display_window()),
        data: rectangle(plate.data_window()),
        pixel_aspect,
        lens_scale,
    }
}
