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
    /// The camera transfer function of ITU-R BT.709.
    Rec709,
    /// A power function.
    Gamma {
        /// The exponent from codes to linear values, in thousandths.
        thousandths: u16,
    },
    /// Perceptual quantisation (SMPTE ST 2084). A linear value of 1 is 203 cd/m2, the reference white of ITU-R BT.2408.
    Pq,
    /// Hybrid log-gamma (ITU-R BT.2100). A linear value of 1 is the scene light of the code 0.75, the reference white of ITU-R
    /// BT.2408.
    Hlg,
}

/// Luminance of a linear value of 1 in [`Encoding::Pq`], cd/m2.
const PQ_WHITE: f64 = 203.0;
/// The largest luminance of [`Encoding::Pq`], cd/m2.
const PQ_PEAK: f64 = 10_000.0;
/// Scene light of the code 0.75 in [`Encoding::Hlg`].
const HLG_WHITE: f64 = 0.264_962_56;

impl Encoding {
    /// Returns the power function of an exponent; `None` beyond 0.1 to 10.
    pub(crate) fn of_power(exponent: f64) -> Option<Self> {
        let thousandths = (exponent * 1000.0).round();
        let is_usual = (100.0..=10_000.0).contains(&thousandths);
        match thousandths {
            1000.0 => Some(Self::Linear),
            _ => is_usual.then_some(Self::Gamma {
                thousandths: thousandths as u16,
            }),
        }
    }

    /// Returns the scene-linear value of a code value. Integer codes are scaled to 0..1.
    pub fn decode(self, code: f32) -> f32 {
        let wide = f64::from(code);
        let linear = match self {
            Self::Linear => return code,
            Self::Srgb if code <= 0.040_45 => return code / 12.92,
            Self::Srgb => ((wide + 0.055) / 1.055).powf(2.4),
            Self::Rec709 if code < 0.081 => wide / 4.5,
            Self::Rec709 => ((wide + 0.099) / 1.099).powf(1.0 / 0.45),
            Self::Gamma { thousandths } => {
                wide.signum() * wide.abs().powf(f64::from(thousandths) / 1000.0)
            }
            Self::Pq => PQ_PEAK / PQ_WHITE * pq::decode(wide),
            Self::Hlg => hlg::decode(wide) / HLG_WHITE,
        };
        linear as f32
    }

    /// Returns the code value of a scene-linear value; the inverse of [`Encoding::decode`].
    pub fn encode(self, linear: f32) -> f32 {
        let wide = f64::from(linear);
        let code = match self {
            Self::Linear => return linear,
            Self::Srgb if linear <= 0.003_130_8 => return linear * 12.92,
            Self::Srgb => 1.055 * wide.powf(1.0 / 2.4) - 0.055,
            Self::Rec709 if wide < 0.018 => wide * 4.5,
            Self::Rec709 => 1.099 * wide.powf(0.45) - 0.099,
            Self::Gamma { thousandths } => {
                wide.signum() * wide.abs().powf(1000.0 / f64::from(thousandths))
            }
            Self::Pq => pq::encode(wide * PQ_WHITE / PQ_PEAK),
            Self::Hlg => hlg::encode(wide * HLG_WHITE),
        };
        code as f32
    }
}

/// SMPTE ST 2084: codes and luminance over 10,000 cd/m2.
mod pq {
    const M1: f64 = 2610.0 / 16_384.0;
    const M2: f64 = 2523.0 / 32.0;
    const C1: f64 = 3424.0 / 4096.0;
    const C2: f64 = 2413.0 / 128.0;
    const C3: f64 = 2392.0 / 128.0;

    pub(super) fn decode(code: f64) -> f64 {
        let power = code.max(0.0).powf(1.0 / M2);
        ((power - C1).max(0.0) / (C2 - C3 * power)).powf(1.0 / M1)
    }

    pub(super) fn encode(linear: f64) -> f64 {
        let power = linear.max(0.0).powf(M1);
        ((C1 + C2 * power) / (1.0 + C3 * power)).powf(M2)
    }
}

/// ITU-R BT.2100, table 5: codes and scene light, 0 to 1.
mod hlg {
    const A: f64 = 0.178_832_77;
    const B: f64 = 0.284_668_92;
    const C: f64 = 0.559_910_73;

    pub(super) fn decode(code: f64) -> f64 {
        if code <= 0.5 {
            code * code.abs() / 3.0
        } else {
            (((code - C) / A).exp() + B) / 12.0
        }
    }

    pub(super) fn encode(linear: f64) -> f64 {
        if linear <= 1.0 / 12.0 {
            linear.signum() * (3.0 * linear.abs()).sqrt()
        } else {
            A * (12.0 * linear - B).ln() + C
        }
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Linear => "linear",
            Self::Srgb => "sRGB-encoded",
            Self::Rec709 => "BT.709-encoded",
            Self::Pq => "PQ-encoded",
            Self::Hlg => "HLG-encoded",
            Self::Gamma { thousandths } => {
                return write!(
                    f,
                    "encoded with a gamma of {}",
                    f64::from(*thousandths) / 1000.0
                );
            }
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
