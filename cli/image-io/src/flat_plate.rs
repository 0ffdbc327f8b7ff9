//! Plates of one picture (PNG, TIFF, DPX, HDR, JPEG): planes of floats in memory, the file's own sample type on disk.

use std::fmt;
use std::path::{Path, PathBuf};

use half::f16;

use crate::description::time;
use crate::error::{FileError, Result};
use crate::exr::key_code;
use crate::facts::rate;
use crate::format::{Format, detect};
use crate::limits::Limits;
use crate::provenance::{Texts, is_ours};
use crate::{dpx, hdr, jpeg, png, tiff};

/// How one sample is stored in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleDepth {
    /// 8-bit unsigned integer; 255 is 1.0.
    U8,
    /// 10-bit unsigned integer; 1023 is 1.0. DPX only.
    U10,
    /// 12-bit unsigned integer; 4095 is 1.0. DPX only.
    U12,
    /// 16-bit unsigned integer; 65535 is 1.0.
    U16,
    /// 16-bit float. TIFF only.
    F16,
    /// 32-bit float.
    F32,
    /// Eight bits and an exponent for the three samples of a pixel, none negative. HDR only.
    Rgbe,
}

impl SampleDepth {
    /// Whether the format holds whole numbers from 0 to 1 only.
    pub fn is_integer(self) -> bool {
        self.full_scale().is_some()
    }

    /// The integer that is 1.0; `None` for floats.
    pub fn full_scale(self) -> Option<u16> {
        match self {
            Self::U8 => Some(255),
            Self::U10 => Some(1023),
            Self::U12 => Some(4095),
            Self::U16 => Some(65535),
            Self::F16 | Self::F32 | Self::Rgbe => None,
        }
    }
}

impl fmt::Display for SampleDepth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::U8 => "8-bit",
            Self::U10 => "10-bit",
            Self::U12 => "12-bit",
            Self::U16 => "16-bit",
            Self::F16 => "half float",
            Self::F32 => "float",
            Self::Rgbe => "RGBE",
        })
    }
}

/// What the numbers of a file of one picture mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Proportional to light.
    Linear,
    /// The sRGB transfer function (IEC 61966-2-1), its two pieces extended beyond 0 and 1.
    Srgb,
}

impl Encoding {
    /// Scene-linear value of a code value, 0 to 1 for the range of the format.
    pub fn decode(self, code: f32) -> f32 {
        match self {
            Self::Linear => code,
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => ((f64::from(code) + 0.055) / 1.055).powf(2.4) as f32,
        }
    }

    /// Code value of a scene-linear value; the inverse of [`Encoding::decode`].
    pub fn encode(self, linear: f32) -> f32 {
        match self {
            Self::Linear => linear,
            Self::Srgb if linear <= 0.003_130_8 => linear * 12.92,
            Self::Srgb => (1.055 * f64::from(linear).powf(1.0 / 2.4) - 0.055) as f32,
        }
    }
}

/// The format of a [`FlatPlate`].
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Container {
    /// PNG with its chunks and colour profile.
    Png(Box<png::Carried>),
    /// TIFF with the tags that are carried over and the meaning of its alpha.
    Tiff(tiff::tags::Carried),
    /// DPX with all that it holds beside the pixels.
    Dpx(Box<dpx::Carried>),
    /// Radiance HDR with the lines of its header.
    Hdr { lines: Vec<Vec<u8>> },
    /// JPEG with its colour profile; whether the camera noted anything, and that it is to be turned.
    Jpeg {
        icc: Option<Vec<u8>>,
        exif: bool,
        turned: bool,
    },
}

/// A picture of a format that holds one. Samples are code values: integers scaled to 0..1, floats as they are.
#[derive(Debug, Clone)]
pub struct FlatPlate {
    pub(crate) path: PathBuf,
    pub(crate) container: Container,
    pub(crate) depth: SampleDepth,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) names: Vec<String>,
    pub(crate) planes: Vec<Vec<f32>>,
    /// Texts that the file holds, each with its name.
    pub(crate) texts: Texts,
    /// Whether samples were put in place of those that were read.
    pub(crate) changed: bool,
    /// What is told of the file beside what its format does not hold, a sentence each.
    pub(crate) notes: Vec<String>,
}

impl FlatPlate {
    /// Reads a PNG (8 or 16 bit), TIFF (8 or 16 bit, half or float), DPX (8 to 16 bit), HDR or JPEG file, told apart by
    /// content.
    ///
    /// # Errors
    /// A file that cannot be read, is damaged, or of another kind.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_within(path, Limits::PLATE)
    }

    pub(crate) fn open_within(path: &Path, limits: Limits) -> Result<Self> {
        match detect(path)? {
            Format::Png => png::read(path, limits),
            Format::Tiff => tiff::read(path, limits),
            Format::Dpx => dpx::read(path, limits),
            Format::Hdr => hdr::read(path, limits),
            Format::Jpeg => jpeg::read(path, limits),
            Format::Exr => Err(FileError::new(
                path,
                "",
                "is an OpenEXR file",
                "give a PNG, TIFF, DPX, HDR or JPEG file here",
            )),
        }
    }

    /// The format it was read in.
    pub fn format(&self) -> Format {
        match self.container {
            Container::Png(_) => Format::Png,
            Container::Tiff(_) => Format::Tiff,
            Container::Dpx(_) => Format::Dpx,
            Container::Hdr { .. } => Format::Hdr,
            Container::Jpeg { .. } => Format::Jpeg,
        }
    }

    /// The file it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Width, pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Texts that the file holds beside the picture, each with its name.
    pub fn texts(&self) -> &[(String, String)] {
        &self.texts
    }

    /// How samples are stored.
    pub fn depth(&self) -> SampleDepth {
        self.depth
    }

    /// Channel names, in the order of the planes: `Y` or `R`, `G`, `B`, and `A` last where there is alpha.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The code values of the channel called `name`, row-major.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        let index = self.names.iter().position(|n| n == name)?;
        Some(&self.planes[index])
    }

    /// Puts other code values in place of a channel's.
    ///
    /// # Errors
    /// A channel that the file has not, and a sample count that does not fill it.
    pub fn replace(&mut self, name: &str, samples: Vec<f32>) -> Result<()> {
        let index = self.names.iter().position(|n| n == name);
        let (Some(index), true) = (index, samples.len() == self.width * self.height) else {
            return Err(FileError::new(
                &self.path,
                format!("channel {name}"),
                format!("cannot take {} samples", samples.len()),
                format!(
                    "give {} x {} samples for one of {}",
                    self.width,
                    self.height,
                    self.names.join(", ")
                ),
            ));
        };
        self.planes[index] = samples;
        self.changed = true;
        Ok(())
    }

    /// Rounds the code values to what the file will hold.
    pub(crate) fn round(&mut self) {
        if let Some(full_scale) = self.depth.full_scale() {
            let steps = f32::from(full_scale);
            for code in self.planes.iter_mut().flatten() {
                *code = f32::from(to_integer(*code, full_scale)) / steps;
            }
        }
        if self.depth == SampleDepth::F16 {
            for sample in self.planes.iter_mut().flatten() {
                *sample = f16::from_f32(to_half(*sample)).to_f32();
            }
        }
        if let (SampleDepth::Rgbe, [red, green, blue]) = (self.depth, &mut self.planes[..]) {
            for ((red, green), blue) in red.iter_mut().zip(green).zip(blue) {
                [*red, *green, *blue] = hdr::held([*red, *green, *blue]);
            }
        }
    }

    /// What codes are taken to mean where nobody says: as the file says in DPX; else integers are sRGB, floats linear.
    pub(crate) fn own_encoding(&self) -> Encoding {
        match &self.container {
            Container::Dpx(carried) => carried.encoding(),
            _ if self.depth.is_integer() => Encoding::Srgb,
            _ => Encoding::Linear,
        }
    }

    /// Width of a pixel over its height: as DPX says, else one.
    pub(crate) fn pixel_aspect(&self) -> f64 {
        match &self.container {
            Container::Dpx(carried) => carried.pixel_aspect(),
            _ => 1.0,
        }
    }

    /// Whether colour comes premultiplied by alpha: never in PNG, as the file says in TIFF, always in DPX.
    pub(crate) fn is_premultiplied(&self) -> bool {
        match &self.container {
            Container::Png(_) => false,
            Container::Tiff(carried) => carried.is_premultiplied(),
            Container::Dpx(_) | Container::Hdr { .. } | Container::Jpeg { .. } => true,
        }
    }

    /// The colour profile of the file.
    pub(crate) fn icc(&self) -> Option<Vec<u8>> {
        match &self.container {
            Container::Png(carried) => carried.icc(),
            Container::Jpeg { icc, .. } => icc.clone(),
            Container::Tiff(carried) => carried.icc(),
            Container::Dpx(_) | Container::Hdr { .. } => None,
        }
    }

    /// Takes away what says of what colour space codes are; the names of that.
    pub(crate) fn drop_colour(&mut self) -> Vec<String> {
        match &mut self.container {
            Container::Png(carried) => carried.drop_colour(),
            Container::Tiff(carried) => carried.drop_colour(),
            Container::Jpeg { icc, .. } => {
                let profile = icc.take();
                let named = profile.map(|_| "the colour profile (ICC)".to_owned());
                named.into_iter().collect()
            }
            Container::Dpx(carried) => carried.drop_colour(),
            Container::Hdr { lines } => {
                let says = |line: &Vec<u8>| line.starts_with(b"PRIMARIES=");
                let named = lines.iter().any(says).then(|| "PRIMARIES".to_owned());
                lines.retain(|line| !says(line));
                named.into_iter().collect()
            }
        }
    }

    /// What the header says of the samples, by name.
    pub(crate) fn storage(&self) -> Texts {
        let named = |name: &str, value: String| (name.to_owned(), value);
        match &self.container {
            Container::Dpx(carried) => {
                let facts = carried.facts();
                let mut all = vec![
                    named("transfer characteristic", carried.transfer_name()),
                    named("pixel aspect", carried.pixel_aspect().to_string()),
                ];
                all.extend(facts.time_code.map(|code| named("time code", time(&code))));
                let rate = facts.frame_rate.and_then(rate);
                all.extend(rate.map(|rate| named("frame rate", rate.to_string())));
                let angle = facts.shutter_angle;
                all.extend(angle.map(|angle| named("shutter angle", angle.to_string())));
                all.extend(
                    facts
                        .key_code
                        .map(|code| named("film edge code", key_code::in_words(&code))),
                );
                all.extend(carried.texts());
                all
            }
            Container::Tiff(carried) => carried.texts(),
            Container::Png(carried) => match carried.names() {
                names if names.is_empty() => Texts::new(),
                names => vec![named("chunks", names.join(", "))],
            },
            _ => Texts::new(),
        }
    }

    /// What the user should know of the file. `taken` is what codes are taken to mean, `None` where a colour space says
    /// so; `told` is whether the user said it.
    pub(crate) fn remarks(&self, taken: Option<Encoding>, told: bool) -> Vec<String> {
        let mut remarks = Vec::new();
        match &self.container {
            Container::Dpx(carried) => {
                let Some(taken) = taken else {
                    return remarks;
                };
                let taken = match taken {
                    Encoding::Linear => "proportional to light",
                    Encoding::Srgb => "sRGB",
                };
                let said = carried.transfer_name();
                let known = told || said == "linear" || carried.encoding() == Encoding::Srgb;
                let doubt = match known {
                    true => "",
                    false => ": if they are not, give --encoding, or convert the plate to linear light first",
                };
                remarks.push(format!(
                    "the DPX header names {said} as transfer characteristic; codes are taken to be {taken}{doubt}"
                ));
            }
            Container::Hdr { lines } => {
                let exposure = hdr::exposure(lines);
                if exposure != 1.0 {
                    remarks.push(format!(
                        "the HDR header says that samples were multiplied by {exposure} (EXPOSURE); they stay so"
                    ));
                }
            }
            Container::Png(carried) => {
                let unheeded = carried.says_linear();
                let unheeded = unheeded.filter(|_| taken == Some(Encoding::Srgb) && !told);
                remarks.extend(unheeded.map(|chunk| {
                    format!(
                        "the PNG says ({chunk}) that its codes are proportional to light, but they are taken to be sRGB; give --encoding linear to go by it"
                    )
                }));
            }
            Container::Jpeg { turned: true, .. } => remarks.push(
                "the JPEG is to be turned or mirrored for show (EXIF orientation); it is taken as its pixels lie"
                    .to_owned(),
            ),
            _ => {}
        }
        remarks
    }

    /// Writes the picture whole or not at all, in the format and sample type it was read in. Returns a sentence for each thing that the format could not hold.
    ///
    /// # Errors
    /// A target that cannot be written, and JPEG, which never is.
    pub fn write(&self, path: &Path) -> Result<Vec<String>> {
        match &self.container {
            Container::Png(carried) => png::write(path, self, carried)?,
            Container::Tiff(carried) => tiff::write::write(path, self, carried)?,
            Container::Dpx(carried) => dpx::write(path, self, carried)?,
            Container::Hdr { lines } => hdr::write(path, self, lines)?,
            Container::Jpeg { .. } => {
                return Err(FileError::new(
                    path,
                    "",
                    "would be JPEG, which loses quality and is never written",
                    "write it as PNG or TIFF",
                ));
            }
        }
        Ok(self.unheld())
    }

    /// What is told where the file has more pictures than the one that is read.
    pub(crate) fn only_first(&self) -> Option<String> {
        let what = match &self.container {
            Container::Tiff(carried) if carried.more_pages => "page of the TIFF",
            Container::Png(carried) if carried.animated => "picture of the animated PNG",
            _ => return None,
        };
        Some(format!("only the first {what} is kept"))
    }

    fn unheld(&self) -> Vec<String> {
        let mut notes = self.notes.clone();
        notes.extend(self.only_first());
        let left_out = match &self.container {
            Container::Png(carried) => ("chunks", carried.left_out(self.changed)),
            Container::Tiff(carried) => ("tags", carried.left_out()),
            _ => ("", Vec::new()),
        };
        if let (what, [_, ..]) = (left_out.0, &left_out.1[..]) {
            notes.push(format!(
                "{what} that do not hold for the new file are left out: {}",
                left_out.1.join(", ")
            ));
        }
        if matches!(&self.container, Container::Dpx(carried) if carried.has_no_room())
            && self.texts.iter().any(|(name, _)| is_ours(name))
        {
            notes.push(
                "the DPX holds user data of others, so what made it is not written into it"
                    .to_owned(),
            );
        }
        let (most, over, samples, better) = match self.depth {
            SampleDepth::F32 => return notes,
            SampleDepth::F16 => (MOST_HALF, "over 65504", "samples", "EXR as float"),
            SampleDepth::Rgbe => (hdr::MOST, "over 1.7e38", "RGBE samples", "EXR"),
            _ => (1.0, "over 1", "integers", "EXR or float TIFF"),
        };
        for (name, plane) in self.names.iter().zip(&self.planes) {
            let count = |is: &dyn Fn(f32) -> bool| plane.iter().filter(|v| is(**v)).count();
            let signed = self.depth == SampleDepth::F16;
            for (what, count) in [
                ("below 0", count(&|v| v < 0.0 && !signed)),
                (over, count(&|v| v > most && !(signed && v.is_infinite()))),
                (
                    "below -65504",
                    count(&|v| signed && v < -most && v.is_finite()),
                ),
                ("not a number", count(&|v| v.is_nan() && !signed)),
            ] {
                if count > 0 {
                    let samples = match self.depth {
                        SampleDepth::Rgbe => samples.to_owned(),
                        depth => format!("{depth} {samples}"),
                    };
                    notes.push(format!(
                        "channel {name}: {count} samples {what} do not fit {samples} and are clipped; write {better} to keep them"
                    ));
                }
            }
        }
        notes
    }

    /// The planes interleaved into integers of full range `max`, clipped; NaN becomes 0.
    pub(crate) fn interleaved<T>(&self, convert: impl Fn(f32) -> T) -> Vec<T> {
        let mut samples = Vec::with_capacity(self.width * self.height * self.planes.len());
        for index in 0..self.width * self.height {
            for plane in &self.planes {
                samples.push(convert(plane[index]));
            }
        }
        samples
    }

    /// Takes interleaved samples apart into planes.
    pub(crate) fn planes_of<T: Copy>(
        samples: &[T],
        channels: usize,
        convert: impl Fn(T) -> f32,
    ) -> Vec<Vec<f32>> {
        (0..channels)
            .map(|channel| {
                let own = samples.iter().skip(channel).step_by(channels);
                own.map(|&s| convert(s)).collect()
            })
            .collect()
    }
}

/// A code value as an integer that is `full_scale` for 1.0: rounded, clipped, NaN as 0.
pub(crate) fn to_integer(code: f32, full_scale: u16) -> u16 {
    let full_scale = f32::from(full_scale);
    // A float cast turns NaN into 0.
    (code * full_scale).round().clamp(0.0, full_scale) as u16
}

/// A code value as an 8-bit integer: rounded, clipped, NaN as 0.
pub(crate) fn to_u8(code: f32) -> u8 {
    (code * 255.0).round() as u8
}

/// A code value as a 16-bit integer: rounded, clipped, NaN as 0.
pub(crate) fn to_u16(code: f32) -> u16 {
    (code * 65535.0).round() as u16
}

/// The largest half float.
pub(crate) const MOST_HALF: f32 = 65_504.0;

/// A sample that a half float holds: no finite one becomes infinite.
pub(crate) fn to_half(sample: f32) -> f32 {
    match sample.is_finite() {
        true => sample.clamp(-MOST_HALF, MOST_HALF),
        false => sample,
    }
}

/// Channel names of a picture with or without colour and alpha.
pub(crate) fn names(colour: bool, alpha: bool) -> Vec<String> {
    let names: &[&str] = match (colour, alpha) {
        (false, false) => &["Y"],
        (false, true) => &["Y", "A"],
        (true, false) => &["R", "G", "B"],
        (true, true) => &["R", "G", "B", "A"],
    };
    names.iter().map(|&n| n.to_owned()).collect()
}
