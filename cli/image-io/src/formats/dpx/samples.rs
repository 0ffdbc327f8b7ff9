//! The layout of samples in a line of a DPX file.

use super::byte_order::ByteOrder;

/// The end of a word at which samples are stored; the rest is padding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WordEnd {
    /// The most significant bits: packing method A, which nearly all programs write.
    High,
    /// The least significant bits: packing method B.
    Low,
}

/// The packing of samples into words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packing {
    /// One byte each.
    Bits8,
    /// Three to a 32-bit word.
    Bits10(WordEnd),
    /// A 16-bit word each.
    Bits12(WordEnd),
    /// A 16-bit word each.
    Bits16,
    /// This many bits each, contiguous across 32-bit words from their low bits up. OpenImageIO writes 12 bits so.
    Contiguous(u8),
}

impl Packing {
    /// Returns the bits per sample.
    pub(super) fn bits(self) -> u8 {
        match self {
            Self::Bits8 => 8,
            Self::Bits10(_) => 10,
            Self::Bits12(_) => 12,
            Self::Bits16 => 16,
            Self::Contiguous(bits) => bits,
        }
    }

    /// Returns the largest code.
    pub(super) fn full_scale(self) -> u16 {
        u16::MAX >> (16 - self.bits())
    }
}

/// The layout of a line of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// Pixels per line.
    pub(super) width: usize,
    /// Samples per pixel.
    pub(super) components: usize,
    /// Whether the samples of a pixel are stored in reverse order.
    pub(super) reversed: bool,
    pub(super) packing: Packing,
    pub(super) order: ByteOrder,
}

impl Layout {
    /// Returns the samples per line.
    pub(super) fn samples(&self) -> usize {
        self.width * self.components
    }

    /// Returns the bytes of a line, without padding at its end.
    pub(super) fn line_bytes(&self) -> usize {
        let samples = self.samples();
        match self.packing {
            Packing::Bits8 => samples,
            Packing::Bits10(_) => samples.div_ceil(3) * 4,
            Packing::Bits12(_) | Packing::Bits16 => samples * 2,
            Packing::Contiguous(bits) => self.contiguous_bits(bits).div_ceil(32) * 4,
        }
    }

    fn contiguous_bits(&self, bits: u8) -> usize {
        self.samples().saturating_mul(usize::from(bits))
    }

    /// Returns the index in a stored pixel of the sample of plane `index`.
    pub(super) fn component(&self, index: usize) -> usize {
        if self.reversed {
            self.components - 1 - index
        } else {
            index
        }
    }

    /// Returns the position of each of three 10-bit samples in its word, bits.
    ///
    /// The first sample of a colour is in the high bits. That of a single component is in the low bits (SMPTE
    /// 268M-2003, table 1, note 2, as GraphicsMagick and FFmpeg read it).
    fn shifts(&self, end: WordEnd) -> [u32; 3] {
        let padding = match end {
            WordEnd::High => 2,
            WordEnd::Low => 0,
        };
        match self.components {
            1 => [padding, padding + 10, padding + 20],
            _ => [padding + 20, padding + 10, padding],
        }
    }

    fn word32(&self, bytes: &[u8]) -> u32 {
        self.order.u32([bytes[0], bytes[1], bytes[2], bytes[3]])
    }

    fn word16(&self, pair: &[u8]) -> u16 {
        self.order.u16([pair[0], pair[1]])
    }

    /// Unpacks a line of [`Layout::line_bytes`] into codes in the order of the file.
    pub(super) fn unpack(&self, line: &[u8], codes: &mut [u16]) {
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
            Packing::Bits12(end) => {
                for (code, pair) in codes.iter_mut().zip(line.chunks_exact(2)) {
                    let word = self.word16(pair);
                    *code = match end {
                        WordEnd::High => word >> 4,
                        WordEnd::Low => word & 0xfff,
                    };
                }
            }
            Packing::Bits10(end) => {
                let shifts = self.shifts(end);
                for (codes, bytes) in codes.chunks_mut(3).zip(line.chunks_exact(4)) {
                    let word = self.word32(bytes);
                    for (code, shift) in codes.iter_mut().zip(shifts) {
                        *code = (word >> shift & 0x3ff) as u16;
                    }
                }
            }
            Packing::Contiguous(bits) => {
                let mut words = line.chunks_exact(4);
                let (mut buffer, mut count) = (0_u64, 0);
                for code in codes {
                    if count < u32::from(bits) {
                        buffer |=
                            u64::from(words.next().map_or(0, |word| self.word32(word))) << count;
                        count += 32;
                    }
                    *code = buffer as u16 & self.packing.full_scale();
                    buffer >>= bits;
                    count -= u32::from(bits);
                }
            }
        }
    }

    /// Appends the codes of a line, none above full scale, to `out`; the inverse of [`Layout::unpack`].
    pub(super) fn pack(&self, codes: &[u16], out: &mut Vec<u8>) {
        let bytes16 = |word: u16| self.order.bytes16(word);
        match self.packing {
            Packing::Bits8 => out.extend(codes.iter().map(|&code| code as u8)),
            Packing::Bits16 => out.extend(codes.iter().flat_map(|&code| bytes16(code))),
            Packing::Bits12(end) => {
                let shift = match end {
                    WordEnd::High => 4,
                    WordEnd::Low => 0,
                };
                out.extend(codes.iter().flat_map(|&code| bytes16(code << shift)));
            }
            Packing::Bits10(end) => {
                let shifts = self.shifts(end);
                for codes in codes.chunks(3) {
                    let pairs = codes.iter().zip(shifts);
                    let word =
                        pairs.fold(0, |word, (&code, shift)| word | u32::from(code) << shift);
                    out.extend(self.order.bytes32(word));
                }
            }
            Packing::Contiguous(bits) => {
                let (mut buffer, mut count) = (0_u64, 0);
                for &code in codes {
                    buffer |= u64::from(code) << count;
                    count += u32::from(bits);
                    if count >= 32 {
                        out.extend(self.order.bytes32(buffer as u32));
                        buffer >>= 32;
                        count -= 32;
                    }
                }
                if count > 0 {
                    out.extend(self.order.bytes32(buffer as u32));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ByteOrder::{Big, Little};
    use super::*;

    fn layout(components: usize, packing: Packing, order: ByteOrder) -> Layout {
        Layout {
            width: 2,
            components,
            reversed: false,
            packing,
            order,
        }
    }

    #[test]
    fn words_match_the_figures_of_the_standard() {
        let rgb = [0x3ff, 0, 1, 2, 3, 4];
        let packed = |components, packing, order, codes: &[u16]| {
            let mut out = Vec::new();
            layout(components, packing, order).pack(codes, &mut out);
            out
        };
        let (high, low) = (WordEnd::High, WordEnd::Low);
        let words = packed(3, Packing::Bits10(high), Big, &rgb);
        assert_eq!(words, [0xff, 0xc0, 0x00, 0x04, 0x00, 0x80, 0x30, 0x10]);
        let words = packed(3, Packing::Bits10(high), Little, &rgb);
        assert_eq!(words, [0x04, 0x00, 0xc0, 0xff, 0x10, 0x30, 0x80, 0x00]);
        let words = packed(3, Packing::Bits10(low), Big, &rgb);
        assert_eq!(words, [0x3f, 0xf0, 0x00, 0x01, 0x00, 0x20, 0x0c, 0x04]);
        let words = packed(1, Packing::Bits10(high), Big, &[0x3ff, 1]);
        assert_eq!(words, [0x00, 0x00, 0x1f, 0xfc]);
        assert_eq!(
            packed(1, Packing::Bits12(high), Big, &[0xabc]),
            [0xab, 0xc0]
        );
        assert_eq!(
            packed(1, Packing::Bits12(low), Little, &[0xabc]),
            [0xbc, 0x0a]
        );
        // 1, 2, 3 from the low bits up; the third spans two words.
        let words = packed(1, Packing::Contiguous(12), Big, &[1, 2, 3]);
        assert_eq!(words, [0x03, 0x00, 0x20, 0x01, 0, 0, 0, 0]);
        let words = packed(1, Packing::Contiguous(10), Little, &[1, 2, 3, 0x3ff]);
        assert_eq!(words, [0x01, 0x08, 0x30, 0xc0, 0xff, 0, 0, 0]);
    }

    #[test]
    fn unpacking_inverts_packing() {
        for packing in [
            Packing::Bits8,
            Packing::Bits10(WordEnd::High),
            Packing::Bits10(WordEnd::Low),
            Packing::Bits12(WordEnd::High),
            Packing::Bits12(WordEnd::Low),
            Packing::Bits16,
            Packing::Contiguous(10),
            Packing::Contiguous(12),
        ] {
            for (components, order) in [(1, Big), (3, Little), (4, Big), (4, Little)] {
                let layout = Layout {
                    width: 7,
                    ..layout(components, packing, order)
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
