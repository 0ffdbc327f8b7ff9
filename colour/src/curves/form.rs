//! Kinds of curves between codes and linear values.

use serde::Deserialize;

/// A curve. Values outside its document's range go on as its pieces do, so that they come back.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case")]
pub enum Form {
    /// A logarithm, and a straight line below `break`.
    CameraLog(CameraLog),
    /// The same for both signs, about the code `centre`.
    MirroredLog {
        /// The half above black.
        #[serde(flatten)]
        half: CameraLog,
        /// The code of black.
        centre: f64,
    },
    /// ACEScc: flat for black and less.
    Acescc {},
    /// The power of IEC 61966-2-1 with its line near black.
    PowerWithLine {
        /// The exponent.
        gamma: f64,
        /// What moves the power's zero below black.
        offset: f64,
    },
    /// A power, the same for both signs.
    MirroredPower {
        /// The exponent.
        gamma: f64,
    },
}

/// The constants of a logarithm with a line, as OpenColorIO's LogCameraTransform has them.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct CameraLog {
    /// Base of the logarithm.
    pub base: f64,
    /// Codes for one base.
    pub log_slope: f64,
    /// Code where the logarithm is zero.
    pub log_offset: f64,
    /// What linear values are multiplied by within it.
    pub lin_slope: f64,
    /// What is added to them.
    pub lin_offset: f64,
    /// The linear value below which the line takes over.
    pub r#break: f64,
    /// Slope of the line; that of the logarithm there if not given.
    pub linear_slope: Option<f64>,
}

impl CameraLog {
    fn log(&self, linear: f64) -> f64 {
        let inner = self.lin_slope * linear + self.lin_offset;
        self.log_slope * inner.ln() / self.base.ln() + self.log_offset
    }

    fn power(&self, code: f64) -> f64 {
        let inner = ((code - self.log_offset) / self.log_slope * self.base.ln()).exp();
        (inner - self.lin_offset) / self.lin_slope
    }

    /// Slope of the line, codes for one.
    pub fn line_slope(&self) -> f64 {
        let at = self.lin_slope * self.r#break + self.lin_offset;
        let own = || self.log_slope * self.lin_slope / (at * self.base.ln());
        self.linear_slope.unwrap_or_else(own)
    }

    fn code(&self, linear: f64) -> f64 {
        if linear > self.r#break {
            self.log(linear)
        } else {
            self.log(self.r#break) + self.line_slope() * (linear - self.r#break)
        }
    }

    fn linear(&self, code: f64) -> f64 {
        let at = self.log(self.r#break);
        if code > at {
            self.power(code)
        } else {
            self.r#break + (code - at) / self.line_slope()
        }
    }
}

/// Codes for a stop of ACEScc, stops of its zero, and where it bends, as its document has them.
mod acescc {
    pub(super) const STOPS: f64 = 17.52;
    pub(super) const ZERO: f64 = 9.72;
    pub(super) const BEND_STOPS: f64 = -15.0;
    pub(super) const BLACK_STOPS: f64 = -16.0;
}

impl Form {
    /// The code of a linear value.
    pub fn code(&self, linear: f64) -> f64 {
        match self {
            Self::CameraLog(log) => log.code(linear),
            Self::MirroredLog { half, centre } => match linear < 0.0 {
                true => 2.0 * centre - half.code(-linear),
                false => half.code(linear),
            },
            Self::Acescc {} => {
                let black = acescc::BLACK_STOPS.exp2();
                let stops = match linear {
                    x if x < acescc::BEND_STOPS.exp2() => (black + x.max(0.0) / 2.0).log2(),
                    x => x.log2(),
                };
                (stops + acescc::ZERO) / acescc::STOPS
            }
            Self::PowerWithLine { gamma, offset } => {
                let (at, slope) = line(*gamma, *offset);
                match linear < at * slope {
                    true => linear / slope,
                    false => linear.powf(1.0 / gamma) * (1.0 + offset) - offset,
                }
            }
            Self::MirroredPower { gamma } => linear.abs().powf(1.0 / gamma).copysign(linear),
        }
    }

    /// The linear value of a code.
    pub fn linear(&self, code: f64) -> f64 {
        match self {
            Self::CameraLog(log) => log.linear(code),
            Self::MirroredLog { half, centre } => match code < *centre {
                true => -half.linear(2.0 * centre - code),
                false => half.linear(code),
            },
            Self::Acescc {} => {
                let stops = code * acescc::STOPS - acescc::ZERO;
                match stops < acescc::BEND_STOPS {
                    true => (stops.exp2() - acescc::BLACK_STOPS.exp2()) * 2.0,
                    false => stops.exp2(),
                }
            }
            Self::PowerWithLine { gamma, offset } => {
                let (at, slope) = line(*gamma, *offset);
                match code < at {
                    true => code * slope,
                    false => ((code + offset) / (1.0 + offset)).powf(*gamma),
                }
            }
            Self::MirroredPower { gamma } => code.abs().powf(*gamma).copysign(code),
        }
    }

    /// Codes where one piece meets the next.
    pub fn joints(&self) -> Vec<f64> {
        match self {
            Self::CameraLog(log) => vec![log.log(log.r#break)],
            Self::MirroredLog { half, centre } => {
                let at = half.log(half.r#break);
                vec![2.0 * centre - at, at]
            }
            Self::Acescc {} => vec![(acescc::BEND_STOPS + acescc::ZERO) / acescc::STOPS],
            Self::PowerWithLine { gamma, offset } => vec![line(*gamma, *offset).0],
            Self::MirroredPower { .. } => vec![0.0],
        }
    }
}

/// The code below which the line takes over, and its slope: where it touches the power.
fn line(gamma: f64, offset: f64) -> (f64, f64) {
    let at = offset / (gamma - 1.0);
    (at, ((at + offset) / (1.0 + offset)).powf(gamma) / at)
}
