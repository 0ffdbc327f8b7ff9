//! Lossless JPEG (ITU-T T.81, process 14, SOF3) as DNG files use it: Huffman-coded differences to a predictor.

/// The samples of a lossless JPEG stream.
#[derive(Debug, PartialEq)]
pub(super) struct LosslessJpeg {
    /// Columns of a component.
    pub(super) width: usize,
    /// Rows.
    pub(super) height: usize,
    /// Number of interleaved components.
    pub(super) components: usize,
    /// Samples, row by row, components interleaved.
    pub(super) samples: Vec<u16>,
}

/// Bits of the codes that are looked up at once.
const LONGEST_CODE: usize = 16;

/// A Huffman table: the category (number of difference bits) and length of every 16-bit prefix.
struct Huffman {
    lookup: Vec<(u8, u8)>,
}

impl Huffman {
    fn new(counts: &[u8], values: &[u8]) -> Option<Self> {
        let mut lookup = vec![(0, 0); 1 << LONGEST_CODE];
        let (mut code, mut next) = (0_usize, 0);
        for (k, &count) in counts.iter().enumerate() {
            let length = k + 1;
            for _ in 0..count {
                let value = *values.get(next)?;
                if value > 16 {
                    return None;
                }
                next += 1;
                let shift = LONGEST_CODE - length;
                lookup
                    .get_mut(code << shift..(code + 1) << shift)?
                    .fill((value, length as u8));
                code += 1;
            }
            code <<= 1;
        }
        Some(Self { lookup })
    }
}

/// Bits of entropy-coded data, without the zero bytes stuffed after 0xFF.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    buffer: u64,
    count: u32,
    /// Zero bits in the buffer that are not from the data.
    padding: u32,
}

impl Bits<'_> {
    /// Fills the buffer; beyond the end of the data or a marker with zeros.
    fn fill(&mut self) {
        while self.count <= 48 {
            let byte = match self.bytes.get(self.at) {
                Some(0xFF) if self.bytes.get(self.at + 1) == Some(&0) => {
                    self.at += 2;
                    0xFF
                }
                Some(0xFF) | None => {
                    self.padding += 8;
                    0
                }
                Some(byte) => {
                    self.at += 1;
                    *byte
                }
            };
            self.buffer |= u64::from(byte) << (56 - self.count);
            self.count += 8;
        }
    }

    fn take(&mut self, count: u32) -> u32 {
        if count == 0 {
            return 0;
        }
        let value = (self.buffer >> (64 - count)) as u32;
        self.buffer <<= count;
        self.count -= count;
        value
    }

    /// Decodes a difference; `None` for an invalid code.
    fn difference(&mut self, table: &Huffman) -> Option<i32> {
        self.fill();
        let (category, length) = table.lookup[(self.buffer >> 48) as usize];
        if length == 0 {
            return None;
        }
        self.take(u32::from(length));
        if category == 16 {
            return Some(32768);
        }
        let value = self.take(u32::from(category)) as i32;
        let half = 1_i32 << category >> 1;
        Some(if value < half {
            value - (1 << category) + 1
        } else {
            value
        })
    }

    /// Skips to after the next marker; for restart intervals.
    fn restart(&mut self) {
        self.buffer = 0;
        self.count = 0;
        self.padding = 0;
        while self.at + 1 < self.bytes.len() {
            let is_marker = self.bytes[self.at] == 0xFF && self.bytes[self.at + 1] != 0;
            self.at += 1;
            if is_marker {
                self.at += 1;
                return;
            }
        }
    }
}

struct Header {
    precision: u32,
    width: usize,
    height: usize,
    components: usize,
}

/// Decodes `bytes` of at most `most` samples.
///
/// # Errors
/// The fault, in words: damage, another process of JPEG, more samples than allowed.
pub(super) fn decode(bytes: &[u8], most: usize) -> Result<LosslessJpeg, String> {
    let damaged = || "its lossless JPEG data are damaged".to_owned();
    let short = |at: usize| -> Result<usize, String> {
        let pair = bytes.get(at..at + 2).ok_or_else(damaged)?;
        Ok(usize::from(pair[0]) << 8 | usize::from(pair[1]))
    };
    if short(0)? != 0xFFD8 {
        return Err(damaged());
    }
    let mut tables: [Option<Huffman>; 4] = [const { None }; 4];
    let mut header: Option<Header> = None;
    let mut restart = 0;
    let mut at = 2;
    loop {
        let marker = short(at)?;
        let length = short(at + 2)?;
        let body = bytes.get(at + 4..at + 2 + length).ok_or_else(damaged)?;
        match marker {
            0xFFC3 => {
                let [precision, h1, h0, w1, w0, components, ..] = *body else {
                    return Err(damaged());
                };
                header = Some(Header {
                    precision: u32::from(precision),
                    height: usize::from(h1) << 8 | usize::from(h0),
                    width: usize::from(w1) << 8 | usize::from(w0),
                    components: usize::from(components),
                });
            }
            0xFFC0..=0xFFC2 | 0xFFC5..=0xFFC7 | 0xFFC9..=0xFFCF => {
                return Err("its JPEG data are not lossless".to_owned());
            }
            0xFFC4 => {
                let mut rest = body;
                while let [id, tail @ ..] = rest {
                    let counts = tail.get(..16).ok_or_else(damaged)?;
                    let total: usize = counts.iter().map(|c| usize::from(*c)).sum();
                    let values = tail.get(16..16 + total).ok_or_else(damaged)?;
                    let table = tables.get_mut(usize::from(id & 15)).ok_or_else(damaged)?;
                    *table = Some(Huffman::new(counts, values).ok_or_else(damaged)?);
                    rest = &tail[16 + total..];
                }
            }
            0xFFDD => restart = short(at + 4)?,
            0xFFDA => {
                let header = header.ok_or_else(damaged)?;
                let data = &bytes[at + 2 + length..];
                return scan(&header, body, &tables, data, restart, most);
            }
            0xFFD9 => return Err(damaged()),
            _ => {}
        }
        at += 2 + length;
    }
}

fn scan(
    header: &Header,
    body: &[u8],
    tables: &[Option<Huffman>; 4],
    data: &[u8],
    restart: usize,
    most: usize,
) -> Result<LosslessJpeg, String> {
    let damaged = || "its lossless JPEG data are damaged".to_owned();
    let Header {
        precision,
        width,
        height,
        components,
    } = *header;
    let count = width * height * components;
    let sound = (2..=16).contains(&precision) && (1..=4).contains(&components) && count > 0;
    if !sound || count > most {
        return Err("its lossless JPEG data claim another size than the tile".to_owned());
    }
    if body.first().map(|n| usize::from(*n)) != Some(components) || body.len() < 4 + 2 * components
    {
        return Err(damaged());
    }
    let mut of_component = Vec::new();
    for k in 0..components {
        let id = usize::from(body[2 + 2 * k] >> 4);
        let table = tables.get(id).and_then(Option::as_ref);
        of_component.push(table.ok_or_else(damaged)?);
    }
    let predictor = body[1 + 2 * components];
    let transform = u32::from(body[3 + 2 * components] & 15);
    if !(1..=7).contains(&predictor) || transform >= precision {
        return Err(damaged());
    }
    let start = 1_i32 << (precision - transform - 1);
    let mut bits = Bits {
        bytes: data,
        at: 0,
        buffer: 0,
        count: 0,
        padding: 0,
    };
    let row_length = width * components;
    let mut samples = vec![0_u16; count];
    // The first row after a restart is predicted like that of the image.
    let mut first_row = 0;
    for row in 0..height {
        for column in 0..width {
            if restart > 0
                && (row * width + column).is_multiple_of(restart)
                && (row, column) != (0, 0)
            {
                bits.restart();
                first_row = row;
            }
            for (component, table) in of_component.iter().enumerate() {
                let index = row * row_length + column * components + component;
                let at = |offset: usize| i32::from(samples[index - offset]);
                let prediction = match (row == first_row, column == 0) {
                    (true, true) => start,
                    (true, false) => at(components),
                    (false, true) => at(row_length),
                    (false, false) => {
                        let (a, b) = (at(components), at(row_length));
                        let c = at(row_length + components);
                        match predictor {
                            1 => a,
                            2 => b,
                            3 => c,
                            4 => a + b - c,
                            5 => a + ((b - c) >> 1),
                            6 => b + ((a - c) >> 1),
                            _ => (a + b) >> 1,
                        }
                    }
                };
                let difference = bits.difference(table).ok_or_else(damaged)?;
                samples[index] = (prediction + difference) as u16;
            }
        }
    }
    if bits.padding > bits.count {
        return Err(damaged());
    }
    if transform > 0 {
        samples.iter_mut().for_each(|s| *s <<= transform);
    }
    Ok(LosslessJpeg {
        width,
        height,
        components,
        samples,
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Encodes samples with predictor 1 and codes of five bits for every category.
    pub(crate) fn encode(samples: &[u16], width: usize, components: usize) -> Vec<u8> {
        let height = samples.len() / (width * components);
        let mut out = vec![0xFF, 0xD8, 0xFF, 0xC4, 0, 19 + 17, 0];
        out.extend([0, 0, 0, 0, 17, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        out.extend(0..17_u8);
        out.extend([0xFF, 0xC3, 0, (8 + 3 * components) as u8, 16]);
        out.extend([
            (height >> 8) as u8,
            height as u8,
            (width >> 8) as u8,
            width as u8,
        ]);
        out.push(components as u8);
        for k in 0..components {
            out.extend([k as u8, 0x11, 0]);
        }
        out.extend([0xFF, 0xDA, 0, (6 + 2 * components) as u8, components as u8]);
        for k in 0..components {
            out.extend([k as u8, 0]);
        }
        out.extend([1, 0, 0]);
        let (mut buffer, mut count) = (0_u64, 0);
        let mut put = |value: u64, bits: u32, out: &mut Vec<u8>| {
            buffer = buffer << bits | value;
            count += bits;
            while count >= 8 {
                let byte = (buffer >> (count - 8)) as u8;
                out.push(byte);
                if byte == 0xFF {
                    out.push(0);
                }
                count -= 8;
                buffer &= (1 << count) - 1;
            }
        };
        let row = width * components;
        for (k, &sample) in samples.iter().enumerate() {
            let prediction = match (k / row, k % row / components) {
                (0, 0) => 32768,
                (_, 0) => i32::from(samples[k - row]),
                _ => i32::from(samples[k - components]),
            };
            let difference = i32::from((i32::from(sample) - prediction) as i16);
            let category = 32 - difference.unsigned_abs().leading_zeros();
            put(u64::from(category), 5, &mut out);
            if category < 16 {
                let bits = if difference < 0 {
                    difference - 1
                } else {
                    difference
                };
                put(
                    u64::from(bits as u32) & ((1 << category) - 1),
                    category,
                    &mut out,
                );
            }
        }
        put(0x7F, 7, &mut out);
        out.extend([0xFF, 0xD9]);
        out
    }

    fn samples() -> Vec<u16> {
        let mut state = 7_u32;
        (0..24 * 10)
            .map(|k| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if k % 17 == 0 {
                    (state >> 16) as u16
                } else {
                    500 + (state >> 28) as u16
                }
            })
            .collect()
    }

    #[test]
    fn decoding_inverts_encoding() {
        let samples = samples();
        for components in [1, 2] {
            let bytes = encode(&samples, 24 / components, components);
            let decoded = decode(&bytes, samples.len()).expect("valid");
            assert_eq!(decoded.samples, samples);
            assert_eq!((decoded.width, decoded.height), (24 / components, 10));
        }
    }

    #[test]
    fn damage_and_other_sizes_are_refused() {
        let samples = samples();
        let bytes = encode(&samples, 24, 1);
        assert!(decode(&bytes, samples.len() - 1).is_err());
        for length in [0, 1, 5, 30, 60, 70] {
            assert!(decode(&bytes[..length], samples.len()).is_err(), "{length}");
        }
        let mut baseline = bytes.clone();
        let at = baseline
            .windows(2)
            .position(|w| w == [0xFF, 0xC3])
            .expect("there");
        baseline[at + 1] = 0xC0;
        assert!(
            decode(&baseline, samples.len())
                .expect_err("not lossless")
                .contains("lossless")
        );
    }
}
