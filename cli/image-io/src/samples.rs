//! Sample formats and encodings: how samples are stored and what code values mean.

use std::fmt;

/// The type of a stored sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SampleFormat {
    /// 8-bit unsigned integer; 255 is 1.0.
    U8,
    /// 10-bit unsigned integer; 1023 is 1.0. DPX only.
    U10,
    /// 12-bit unsigned integer; 4095 is 1.0. DPX only.
    U12,
    /// 16-bit unsigned integer; 65535 is 1.0.
    U16,
    /// 16-bit float. EXR and TIFF only.
    F16,
    /// 32-bit float.
    F32,
    /// Eight bits for each of three colours with a common exponent; not negative. HDR only.
    Rgbe,
}

impl SampleFormat {
    /// Returns whether samples are integers, which represent 0 to 1 only.
    pub fn is_integer(self) -> bool {
        self.full_scale().is_some()
    }

    /// Returns the integer that represents 1.0; `None` for floats.
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

impl fmt::Display for SampleFormat {
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

/// The transfer function between code values and scene-linear values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// Code values are scene-linear.
    Linear,
    /// The sRGB transfer function (IEC 61966-2-1), both segments extended beyond 0 and 1.
    Srgb,
}

impl Encoding {
    /// Returns the scene-linear value of a code value. Integer codes are scaled to 0..1.
    pub fn decode(self, code: f32) -> f32 {
        match self {
            Self::Linear => code,
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => ((f64::from(code) + 0.055) / 1.055).powf(2.4) as f32,
        }
    }

    /// Returns the code value of a scene-linear value; the inverse of [`Encoding::decode`].
    pub fn encode(self, linear: f32) -> f32 {
        match self {
            Self::Linear => linear,
            Self::Srgb if linear <= 0.003_130_8 => linear * 12.92,
            Self::Srgb => (1.055 * f64::from(linear).powf(1.0 / 2.4) - 0.055) as f32,
        }
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Srgb => "sRGB-encoded",
        })
    }
}

/// Quantises a code value to an integer that is `full_scale` for 1.0: rounded and clipped, NaN as 0.
pub(crate) fn quantise(code: f32, full_scale: u16) -> u16 {
    let full_scale = f32::from(full_scale);
    // A cast from float turns NaN into 0.
    (code * full_scale).round().clamp(0.0, full_scale) as u16
}

/// The largest finite half float.
pub(crate) const MAX_HALF: f32 = 65_504.0;

/// Clips a finite sample to the range of half floats, so that it does not become infinite.
pub(crate) fn clip_to_half(sample: f32) -> f32 {
    if sample.is_finite() {
        sample.clamp(-MAX_HALF, MAX_HALF)
    } else {
        sample
    }
}
