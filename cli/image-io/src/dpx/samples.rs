//! How the samples of a line lie in a DPX file.

/// Which end of its word a sample, or a group of them, lies at; the rest is padding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Justified {
    /// At the most significant bits: method A, what nearly all programs write.
    High,
    /// At the least significant bits: method B.
    Low,
}

/// How samples are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Packing {
    /// One byte each.
    Bits8,
    /// Three to a 32-bit word.
    Bits10(Justified),
    /// A 16-bit word each.
    Bits12(Justified),
    /// A 16-bit word each.
    Bits16,
    /// So many bits each, one after the other across 32-bit words from their low bits up: what OpenImageIO writes of 12
    /// bits.
    Across(u8),
}

impl Packing {
    /// Bits a sample.
    pub(crate) fn bits(self) -> u8 {
        match self {
            Self::Bits8 => 8,
            Self::Bits10(_) => 10,
            Self::Bits12(_) => 12,
            Self::Bits16 => 16,
            Self::Across(bits) => bits,
        }
    }

    /// The largest code.
    pub(crate) fn full_scale(self) -> u16 {
        u16::MAX >> (16 - self.bits())
    }
}

/// How lines of pixels lie in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Pixels a line.
    pub(crate) width: usize,
    /// Samples a pixel.
    pub(crate) components: usize,
    /// Whether the samples of a pixel come last first.
    pub(crate) reversed: bool,
    pub(crate) packing: Packing,
    pub(crate) big_endian: bool,
}

impl Layout {
    /// Samples a line.
    pub(crate) fn samples(&self) -> usize {
        self.width * self.components
    }

    /// Bytes that the samples of a line take, without padding at its end.
    pub(crate) fn line_bytes(&self) -> usize {
        let samples = self.samples();
        match self.packing {
            Packing::Bits8 => samples,
            Packing::Bits10(_) => samples.div_ceil(3) * 4,
            Packing::Bits12(_) | Packing::Bits16 => samples * 2,
            Packing::Across(bits) => self.bits_across(bits).div_ceil(32) * 4,
        }
    }

    fn bits_across(&self, bits: u8) -> usize {
        self.samples().saturating_mul(usize::from(bits))
    }

    /// By how many bits each of three 10-bit samples is shifted up in its word.
    ///
    /// Colours come first in the high bits. A single component comes first in the low bits (SMPTE 268M-2003, table 1,
    /// note 2, as GraphicsMagick and FFmpeg read it).
    fn shifts(&self, justified: Justified) -> [u32; 3] {
        let padding = match justified {
            Justified::High => 2,
            Justified::Low => 0,
        };
        match self.components {
            1 => [padding, padding + 10, padding + 20],
            _ => [padding + 20, padding + 10, padding],
        }
    }

    fn word32(&self, bytes: &[u8]) -> u32 {
        let bytes = [bytes[0], bytes[1], bytes[2], bytes[3]];
        match self.big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        }
    }

    fn bytes32(&self, word: u32) -> [u8; 4] {
        match self.big_endian {
            true => word.to_be_bytes(),
            false => word.to_le_bytes(),
        }
    }

    fn word16(&self, pair: &[u8]) -> u16 {
        let pair = [pair[0], pair[1]];
        match self.big_endian {
            true => u16::from_be_bytes(pair),
            false => u16::from_le_bytes(pair),
        }
    }

    /// Takes a line of [`Layout::line_bytes`] apart into codes, in the order of the file.
    pub(crate) fn unpack(&self, line: &[u8], codes: &mut [u16]) {
        match self.packing {
            Packing::Bits8 => {
                for (code, byte) in codes.iter_mut().zip(line) {
                    *code = u16::from(*byte);
                }
            }
            Packing::Bits16 => {
                for (code, pair) in codes.iter_mut().zip(line.chunks_exact(2)) {
                    *code = self.word16(pair);
                }
            }
            Packing::Bits12(justified) => {
                for (code, pair) in codes.iter_mut().zip(line.chunks_exact(2)) {
                    let word = self.word16(pair);
                    *code = match justified {
                        Justified::High => word >> 4,
                        Justified::Low => word & 0xfff,
                    };
                }
            }
            Packing::Bits10(justified) => {
                let shifts = self.shifts(justified);
                for (codes, bytes) in codes.chunks_mut(3).zip(line.chunks_exact(4)) {
                    let word = self.word32(bytes);
                    for (code, shift) in codes.iter_mut().zip(shifts) {
                        *code = (word >> shift & 0x3ff) as u16;
                    }
                }
            }
            Packing::Across(bits) => {
                let mut words = line.chunks_exact(4);
                let (mut held, mut count) = (0_u64, 0);
                for code in codes {
                    if count < u32::from(bits) {
                        held |=
                            u64::from(words.next().map_or(0, |word| self.word32(word))) << count;
                        count += 32;
                    }
                    *code = held as u16 & self.packing.full_scale();
                    held >>= bits;
                    count -= u32::from(bits);
                }
            }
        }
    }

    /// Adds the codes of a line, none above full scale, to `out`; the inverse of [`Layout::unpack`].
    pub(crate) fn pack(&self, codes: &[u16], out: &mut Vec<u8>) {
        let bytes16 = |word: u16| match self.big_endian {
            true => word.to_be_bytes(),
            false => word.to_le_bytes(),
        };
        match self.packing {
            Packing::Bits8 => out.extend(codes.iter().map(|&code| code as u8)),
            Packing::Bits16 => out.extend(codes.iter().flat_map(|&code| bytes16(code))),
            Packing::Bits12(justified) => {
                let shift = match justified {
                    Justified::High => 4,
                    Justified::Low => 0,
                };
                out.extend(codes.iter().flat_map(|&code| bytes16(code << shift)));
            }
            Packing::Bits10(justified) => {
                let shifts = self.shifts(justified);
                for codes in codes.chunks(3) {
                    let pairs = codes.iter().zip(shifts);
                    let word =
                        pairs.fold(0, |word, (&code, shift)| word | u32::from(code) << shift);
                    out.extend(self.bytes32(word));
                }
            }
            Packing::Across(bits) => {
                let (mut held, mut count) = (0_u64, 0);
                for &code in codes {
                    held |= u64::from(code) << count;
                    count += u32::from(bits);
                    if count >= 32 {
                        out.extend(self.bytes32(held as u32));
                        held >>= 32;
                        count -= 32;
                    }
                }
                if count > 0 {
                    out.extend(self.bytes32(held as u32));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(components: usize, packing: Packing, big_endian: bool) -> Layout {
        Layout {
            width: 2,
            components,
            reversed: false,
            packing,
            big_endian,
        }
    }

    #[test]
    fn words_are_as_the_standard_draws_them() {
        let rgb = [0x3ff, 0, 1, 2, 3, 4];
        let packed = |components, packing, big_endian, codes: &[u16]| {
            let mut out = Vec::new();
            layout(components, packing, big_endian).pack(codes, &mut out);
            out
        };
        let (high, low) = (Justified::High, Justified::Low);
        let words = packed(3, Packing::Bits10(high), true, &rgb);
        assert_eq!(words, [0xff, 0xc0, 0x00, 0x04, 0x00, 0x80, 0x30, 0x10]);
        let words = packed(3, Packing::Bits10(high), false, &rgb);
        assert_eq!(words, [0x04, 0x00, 0xc0, 0xff, 0x10, 0x30, 0x80, 0x00]);
        let words = packed(3, Packing::Bits10(low), true, &rgb);
        assert_eq!(words, [0x3f, 0xf0, 0x00, 0x01, 0x00, 0x20, 0x0c, 0x04]);
        let words = packed(1, Packing::Bits10(high), true, &[0x3ff, 1]);
        assert_eq!(words, [0x00, 0x00, 0x1f, 0xfc]);
        assert_eq!(
            packed(1, Packing::Bits12(high), true, &[0xabc]),
            [0xab, 0xc0]
        );
        assert_eq!(
            packed(1, Packing::Bits12(low), false, &[0xabc]),
            [0xbc, 0x0a]
        );
        // 1, 2, 3 from the low bits up, the third in two words.
        let words = packed(1, Packing::Across(12), true, &[1, 2, 3]);
        assert_eq!(words, [0x03, 0x00, 0x20, 0x01, 0, 0, 0, 0]);
        let words = packed(1, Packing::Across(10), false, &[1, 2, 3, 0x3ff]);
        assert_eq!(words, [0x01, 0x08, 0x30, 0xc0, 0xff, 0, 0, 0]);
    }

    #[test]
    fn lines_unpack_to_what_was_packed() {
        for packing in [
            Packing::Bits8,
            Packing::Bits10(Justified::High),
            Packing::Bits10(Justified::Low),
            Packing::Bits12(Justified::High),
            Packing::Bits12(Justified::Low),
            Packing::Bits16,
            Packing::Across(10),
            Packing::Across(12),
        ] {
            for (components, big_endian) in [(1, true), (3, false), (4, true), (4, false)] {
                let layout = Layout {
                    width: 7,
                    ..layout(components, packing, big_endian)
                };
                let codes: Vec<u16> = (0..layout.samples() as u32)
                    .map(|i| ((i * 40_503) >> 3) as u16 & packing.full_scale())
                    .collect();
                let mut line = Vec::new();
                layout.pack(&codes, &mut line);
                assert_eq!(line.len(), layout.line_bytes());
                let mut back = vec![0; codes.len()];
                layout.unpack(&line, &mut back);
                assert_eq!(back, codes, "{layout:?}");
            }
        }
    }
}
