//! Transfer functions of photographs that are not raw: linear, sRGB, and the log curves of cameras in `luts/curves.toml`.

use std::path::Path;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use seidel_colour::curves::{CurveTable, TransferFunction};
use seidel_image_io::FileError;
use seidel_image_io::photograph::{PhotographFile, Precision};
use seidel_image_io::samples::Encoding;

use crate::commands::{EncodingChoice, value_name};

/// The transfer function of a photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::commands) enum PhotographEncoding {
    /// Linear or sRGB.
    Plain(EncodingChoice),
    /// A curve of a camera.
    Log(&'static TransferFunction),
}

/// The choices of the other commands.
const PLAIN: [EncodingChoice; 2] = [EncodingChoice::Linear, EncodingChoice::Srgb];

/// Returns the curves that are not in [`PLAIN`], by name.
fn curves() -> impl Iterator<Item = (&'static str, &'static TransferFunction)> {
    let table = CurveTable::embedded().into_iter();
    let curves = table.flat_map(|table| &table.curves);
    let curves = curves.filter(|(name, _)| *name != "srgb");
    curves.map(|(name, curve)| (name.as_str(), &curve.transfer))
}

/// Returns the parser of `--encoding`.
pub(super) fn parser() -> impl TypedValueParser<Value = PhotographEncoding> {
    let plain = PLAIN.map(value_name);
    let names: Vec<&'static str> = curves().map(|(name, _)| name).collect();
    let names = ["linear", "srgb"].into_iter().chain(names);
    PossibleValuesParser::new(names).map(move |name| {
        let log = curves().find(|(curve, _)| *curve == name);
        log.map_or_else(
            || {
                let index = plain.iter().position(|plain| *plain == name);
                PhotographEncoding::Plain(PLAIN[index.unwrap_or(0)])
            },
            |(_, curve)| PhotographEncoding::Log(curve),
        )
    })
}

impl PhotographEncoding {
    /// Returns the encoding by which samples are read: codes as they are for a log curve, which [`Self::decode_log`] decodes.
    pub(super) fn of_codes(self) -> Encoding {
        match self {
            Self::Plain(choice) => choice.into(),
            Self::Log(_) => Encoding::Linear,
        }
    }

    /// Decodes the codes of `file` by a log curve, with 1 of linear light at the scale of its codes.
    ///
    /// # Errors
    /// A raw photograph, whose samples are linear.
    pub(super) fn decode_log(
        self,
        path: &Path,
        file: &mut PhotographFile,
    ) -> Result<(), FileError> {
        let Self::Log(curve) = self else {
            return Ok(());
        };
        let Some(scale) = file.code_scale else {
            return Err(FileError::new(
                path,
                "",
                "is a raw photograph, whose samples are linear",
                "leave --encoding out",
            ));
        };
        let decode = |code: f32| (curve.decode(f64::from(code / scale)) * f64::from(scale)) as f32;
        for sample in file.planes.iter_mut().flatten() {
            *sample = decode(*sample);
        }
        file.white = if file.white.is_finite() {
            decode(file.white)
        } else {
            file.white
        };
        if file.precision == Precision::Linear {
            file.precision = Precision::Developed;
        }
        file.warnings.push(format!(
            "{}: footage with a log curve. Its colours were interpolated, and noise reduction or sharpening of the camera change the PSF, so errors are stated larger; give a raw frame where there is one",
            path.display()
        ));
        Ok(())
    }
}
