//! The tone curve of an ICC profile (ICC.1:2022).

use crate::samples::Encoding;

/// Codes at which curves are compared.
const PROBES: usize = 64;
/// The largest difference of equal curves, in linear values; that of rounded tables of sRGB is below it.
const TOLERANCE: f32 = 1.5e-3;

/// A tone curve.
enum Curve {
    Power(f64),
    /// Values at equal steps, 0 to 1.
    Table(Vec<f64>),
    /// The function types 1 to 4 of the standard, as `g, a, b, c, d, e, f`.
    Parametric([f64; 7]),
}

/// Returns the encoding that the curves of the profile stand for, the same for all colours; `None` if it is not known.
pub(super) fn encoding(profile: &[u8]) -> Option<Encoding> {
    let tags: &[&[u8; 4]] = match profile.get(16..20)? {
        b"RGB " => &[b"rTRC", b"gTRC", b"bTRC"],
        b"GRAY" => &[b"kTRC"],
        _ => return None,
    };
    let curves: Vec<Curve> = tags
        .iter()
        .map(|tag| curve(profile, tag))
        .collect::<Option<_>>()?;
    let power = match curves.first()? {
        Curve::Power(power) => *power,
        other => other.at(0.5).ln() / 0.5_f64.ln(),
    };
    let known = [Encoding::Srgb, Encoding::Linear, Encoding::Rec709];
    let power = Encoding::of_power(power);
    known
        .into_iter()
        .chain(power)
        .find(|encoding| curves.iter().all(|curve| curve.is(*encoding)))
}

impl Curve {
    fn at(&self, x: f64) -> f64 {
        match self {
            Self::Power(power) => x.powf(*power),
            Self::Table(values) => {
                let place = x * (values.len() - 1) as f64;
                let below = (place as usize).min(values.len() - 2);
                let share = place - below as f64;
                values[below] * (1.0 - share) + values[below + 1] * share
            }
            Self::Parametric([g, a, b, c, d, e, f]) => {
                if x >= *d {
                    (a * x + b).max(0.0).powf(*g) + e
                } else {
                    c * x + f
                }
            }
        }
    }

    fn is(&self, encoding: Encoding) -> bool {
        (0..=PROBES).all(|k| {
            let x = k as f64 / PROBES as f64;
            (self.at(x) as f32 - encoding.decode(x as f32)).abs() <= TOLERANCE
        })
    }
}

fn number(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_be_bytes(four.try_into().ok()?))
}

/// Returns the curve of a tag.
fn curve(profile: &[u8], tag: &[u8; 4]) -> Option<Curve> {
    let count = number(profile, 128)? as usize;
    let entry = (0..count.min(100)).map(|k| 132 + 12 * k);
    let entry = entry
        .clone()
        .find(|&at| profile.get(at..at + 4) == Some(tag))?;
    let data = profile.get(number(profile, entry + 4)? as usize..)?;
    match data.get(..4)? {
        b"curv" => table(data),
        b"para" => parametric(data),
        _ => None,
    }
}

fn table(data: &[u8]) -> Option<Curve> {
    let count = number(data, 8)? as usize;
    let bytes = data.get(12..12_usize.checked_add(count.checked_mul(2)?)?)?;
    let (pairs, _) = bytes.as_chunks::<2>();
    let values = pairs
        .iter()
        .map(|pair| f64::from(u16::from_be_bytes(*pair)));
    Some(match count {
        0 => Curve::Power(1.0),
        1 => Curve::Power(values.sum::<f64>() / 256.0),
        _ => Curve::Table(values.map(|v| v / 65535.0).collect()),
    })
}

fn parametric(data: &[u8]) -> Option<Curve> {
    let kind = u16::from_be_bytes(data.get(8..10)?.try_into().ok()?);
    let value = |k: usize| Some(f64::from(number(data, 12 + 4 * k)?.cast_signed()) / 65536.0);
    let (g, no) = (value(0)?, 0.0);
    let values = match kind {
        0 => return Some(Curve::Power(g)),
        1 => [g, value(1)?, value(2)?, no, -value(2)? / value(1)?, no, no],
        2 => [
            g,
            value(1)?,
            value(2)?,
            no,
            -value(2)? / value(1)?,
            value(3)?,
            value(3)?,
        ],
        3 => [g, value(1)?, value(2)?, value(3)?, value(4)?, no, no],
        4 => [
            g,
            value(1)?,
            value(2)?,
            value(3)?,
            value(4)?,
            value(5)?,
            value(6)?,
        ],
        _ => return None,
    };
    Some(Curve::Parametric(values))
}
