//! The types of samples that images may have.

use std::ffi::CStr;

use openfx::sys::generic::core::{kOfxBitDepthByte, kOfxBitDepthFloat, kOfxBitDepthShort};

use crate::picture::{Picture, noise};

/// The initial bits of float output samples: a quiet NaN that no arithmetic produces.
const POISON: u32 = 0x7fc0_dead;

/// The type of the samples of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SampleType {
    /// 32-bit floats.
    #[default]
    Float,
    /// 16-bit integers, 65535 for 1.
    Short,
    /// Bytes, 255 for 1.
    Byte,
}

impl SampleType {
    /// All types, those that keep more first.
    pub const ALL: [Self; 3] = [Self::Float, Self::Short, Self::Byte];

    /// Returns the name of the bit depth in OpenFX.
    #[must_use]
    pub fn bit_depth(self) -> &'static CStr {
        match self {
            Self::Float => kOfxBitDepthFloat,
            Self::Short => kOfxBitDepthShort,
            Self::Byte => kOfxBitDepthByte,
        }
    }

    /// Returns the bytes of a sample.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Float => 4,
            Self::Short => 2,
            Self::Byte => 1,
        }
    }

    /// Returns the value that stands for 1; `None` for floats.
    #[must_use]
    pub fn white(self) -> Option<f32> {
        match self {
            Self::Float => None,
            Self::Short => Some(65535.0),
            Self::Byte => Some(255.0),
        }
    }

    /// Returns the nearest value that a sample can hold.
    pub(crate) fn rounded(self, value: f32) -> f32 {
        (self.white()).map_or(value, |white| {
            (value.clamp(0.0, 1.0) * white).round() / white
        })
    }

    /// Returns the picture as samples of this type hold it.
    pub(crate) fn picture(self, picture: &Picture) -> Picture {
        Picture {
            samples: picture.samples.iter().map(|v| self.rounded(*v)).collect(),
            ..*picture
        }
    }

    /// Returns the bits of a sample; the first [`Self::bytes`] of them are stored.
    pub(crate) fn bits(self, value: f32) -> [u8; 4] {
        match self.white() {
            None => value.to_bits().to_ne_bytes(),
            Some(white) => self.integer((value.clamp(0.0, 1.0) * white).round() as u16),
        }
    }

    /// Returns the value of stored bytes.
    pub(crate) fn value(self, bytes: &[u8]) -> f32 {
        match (self, bytes) {
            (Self::Float, [a, b, c, d]) => f32::from_ne_bytes([*a, *b, *c, *d]),
            (Self::Short, [a, b]) => f32::from(u16::from_ne_bytes([*a, *b])) / 65535.0,
            (Self::Byte, [a]) => f32::from(*a) / 255.0,
            _ => f32::NAN,
        }
    }

    /// Returns the bits of an output sample before a render. Integers have no value that a render cannot give: theirs differ from
    /// sample to sample and between the two `rounds` in which such images are rendered.
    pub(crate) fn poison(self, x: i32, y: i32, c: usize, round: u32) -> [u8; 4] {
        match self.white() {
            None => POISON.to_ne_bytes(),
            Some(white) => {
                let first = (noise(x, y, c, 11) * (white + 1.0)) as u16;
                self.integer(if round == 0 { first } else { !first })
            }
        }
    }

    fn integer(self, value: u16) -> [u8; 4] {
        let mut bits = [0; 4];
        match self {
            Self::Byte => bits[0] = value as u8,
            _ => bits[..2].copy_from_slice(&value.to_ne_bytes()),
        }
        bits
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_survive_to_the_nearest_step() {
        for kind in SampleType::ALL {
            for value in [0.0, 0.2, 0.5, 1.0, 1.5, -0.25] {
                let bits = kind.bits(value);
                let read = kind.value(&bits[..kind.bytes()]);
                assert_eq!(read.to_bits(), kind.rounded(value).to_bits(), "{kind:?}");
            }
            let stored = |round| kind.poison(3, 5, 1, round)[..kind.bytes()].to_vec();
            assert_eq!(stored(0) == stored(1), kind == SampleType::Float);
        }
        assert_eq!(SampleType::Byte.rounded(1.5), 1.0);
        assert_eq!(SampleType::Byte.rounded(0.5), 128.0 / 255.0);
    }
}
