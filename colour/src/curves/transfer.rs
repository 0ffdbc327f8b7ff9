//! Transfer functions between codes and scene-linear values.

use serde::Deserialize;

/// A transfer function. Outside the range of its document it continues with its outer pieces, so that it stays
/// invertible.
///
/// Codes run from 0 to 1; a linear value of 0.18 is an 18 % grey card.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum TransferFunction {
    /// A logarithm with a linear segment below `break`.
    CameraLog(CameraLog),
    /// A camera logarithm mirrored at black, as Canon Log 3.
    MirroredLog {
        /// The half above black.
        #[serde(flatten)]
        half: CameraLog,
        /// The code of black.
        centre: f64,
    },
    /// ACEScc (S-2014-003), which has a single code for all values at or below zero.
    Acescc {},
    /// A power with a linear segment near black, as in IEC 61966-2-1 (sRGB).
    PowerWithLine {
        /// The exponent of the decoding power.
        gamma: f64,
        /// Offset a of ((code + a) / (1 + a))^gamma.
        offset: f64,
    },
    /// A power, mirrored at black.
    MirroredPower {
        /// The exponent of the decoding power.
        gamma: f64,
    },
}

/// Constants of a logarithm with a linear segment, as in OpenColorIO's LogCameraTransform:
/// code = `log_slope` log_`base`(`lin_slope` x + `lin_offset`) + `log_offset`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct CameraLog {
    /// Base of the logarithm.
    pub base: f64,
    /// Factor of the logarithm.
    pub log_slope: f64,
    /// Code where the logarithm is zero.
    pub log_offset: f64,
    /// Factor of the linear value within the logarithm.
    pub lin_slope: f64,
    /// Offset of the linear value within the logarithm.
    pub lin_offset: f64,
    /// Linear value below which the linear segment applies.
    pub r#break: f64,
    /// Slope of the linear segment, in codes per linear value; by default that of the logarithm at `break`.
    pub linear_slope: Option<f64>,
}

impl CameraLog {
    fn log(&self, linear: f64) -> f64 {
        let inner = self.lin_slope * linear + self.lin_offset;
        self.log_slope * inner.ln() / self.base.ln() + self.log_offset
    }

    fn inverse_log(&self, code: f64) -> f64 {
        let inner = ((code - self.log_offset) / self.log_slope * self.base.ln()).exp();
        (inner - self.lin_offset) / self.lin_slope
    }

    /// Returns the slope of the linear segment, in codes per linear value.
    pub fn segment_slope(&self) -> f64 {
        let inner = self.lin_slope * self.r#break + self.lin_offset;
        let tangent = || self.log_slope * self.lin_slope / (inner * self.base.ln());
        self.linear_slope.unwrap_or_else(tangent)
    }

    fn encode(&self, linear: f64) -> f64 {
        if linear > self.r#break {
            self.log(linear)
        } else {
            self.log(self.r#break) + self.segment_slope() * (linear - self.r#break)
        }
    }

    fn decode(&self, code: f64) -> f64 {
        let break_code = self.log(self.r#break);
        if code > break_code {
            self.inverse_log(code)
        } else {
            self.r#break + (code - break_code) / self.segment_slope()
        }
    }
}

/// Constants of ACEScc, from S-2014-003: code = (log2(x) + `LOG_OFFSET`) / `STOPS`.
mod acescc {
    /// Stops per unit of code.
    pub(super) const STOPS: f64 = 17.52;
    pub(super) const LOG_OFFSET: f64 = 9.72;
    /// log2 of the linear value below which the function bends towards black.
    pub(super) const BREAK_STOPS: f64 = -15.0;
    /// log2 of the value that stands for black.
    pub(super) const BLACK_STOPS: f64 = -16.0;
}

impl TransferFunction {
    /// Returns the code of a linear value.
    pub fn encode(&self, linear: f64) -> f64 {
        match self {
            Self::CameraLog(log) => log.encode(linear),
            Self::MirroredLog { half, centre } => {
                if linear < 0.0 {
                    2.0 * centre - half.encode(-linear)
                } else {
                    half.encode(linear)
                }
            }
            Self::Acescc {} => {
                let black = acescc::BLACK_STOPS.exp2();
                let stops = if linear < acescc::BREAK_STOPS.exp2() {
                    (black + linear.max(0.0) / 2.0).log2()
                } else {
                    linear.log2()
                };
                (stops + acescc::LOG_OFFSET) / acescc::STOPS
            }
            Self::PowerWithLine { gamma, offset } => {
                let segment = PowerSegment::new(*gamma, *offset);
                if linear < segment.break_code * segment.slope {
                    linear / segment.slope
                } else {
                    linear.powf(1.0 / gamma) * (1.0 + offset) - offset
                }
            }
            Self::MirroredPower { gamma } => linear.abs().powf(1.0 / gamma).copysign(linear),
        }
    }

    /// Returns the linear value of a code.
    pub fn decode(&self, code: f64) -> f64 {
        match self {
            Self::CameraLog(log) => log.decode(code),
            Self::MirroredLog { half, centre } => {
                if code < *centre {
                    -half.decode(2.0 * centre - code)
                } else {
                    half.decode(code)
                }
            }
            Self::Acescc {} => {
                let stops = code * acescc::STOPS - acescc::LOG_OFFSET;
                if stops < acescc::BREAK_STOPS {
                    (stops.exp2() - acescc::BLACK_STOPS.exp2()) * 2.0
                } else {
                    stops.exp2()
                }
            }
            Self::PowerWithLine { gamma, offset } => {
                let segment = PowerSegment::new(*gamma, *offset);
                if code < segment.break_code {
                    code * segment.slope
                } else {
                    ((code + offset) / (1.0 + offset)).powf(*gamma)
                }
            }
            Self::MirroredPower { gamma } => code.abs().powf(*gamma).copysign(code),
        }
    }

    /// Returns the codes where one piece meets the next.
    pub fn break_codes(&self) -> Vec<f64> {
        match self {
            Self::CameraLog(log) => vec![log.log(log.r#break)],
            Self::MirroredLog { half, centre } => {
                let code = half.log(half.r#break);
                vec![2.0 * centre - code, code]
            }
            Self::Acescc {} => vec![(acescc::BREAK_STOPS + acescc::LOG_OFFSET) / acescc::STOPS],
            Self::PowerWithLine { gamma, offset } => {
                vec![PowerSegment::new(*gamma, *offset).break_code]
            }
            Self::MirroredPower { .. } => vec![0.0],
        }
    }
}

/// The linear segment of [`TransferFunction::PowerWithLine`]: the tangent of the power through the origin.
struct PowerSegment {
    /// Code below which the segment applies.
    break_code: f64,
    /// Its slope, in linear values per code.
    slope: f64,
}

impl PowerSegment {
    fn new(gamma: f64, offset: f64) -> Self {
        let break_code = offset / (gamma - 1.0);
        let slope = ((break_code + offset) / (1.0 + offset)).powf(gamma) / break_code;
        Self { break_code, slope }
    }
}
