//! The header of a part of a FITS file.

/// Length of a block of the file, and of a header card, bytes.
pub(super) const BLOCK: usize = 2880;
const CARD: usize = 80;
/// Cards of a header that are read.
const MAX_CARDS: usize = 36 * 1000;
/// Largest number of axes that the standard allows.
const MAX_AXES: usize = 999;
/// Largest sample of 16 bits, the clipping level where the caller states none.
pub(super) const FULL_SCALE: f32 = 65535.0;

/// The cards of a header.
pub(super) struct Header {
    cards: Vec<(String, String)>,
    /// Length of the header with its padding, bytes.
    pub(super) length: usize,
}

impl Header {
    /// Reads the header at the start of `bytes`; `None` if it does not end.
    pub(super) fn parse(bytes: &[u8]) -> Option<Self> {
        let mut cards = Vec::new();
        for (k, card) in bytes.chunks_exact(CARD).take(MAX_CARDS).enumerate() {
            let text = String::from_utf8_lossy(card);
            let key = text.get(..8).unwrap_or_default().trim().to_owned();
            if key == "END" {
                let length = ((k + 1) * CARD).div_ceil(BLOCK) * BLOCK;
                return Some(Self { cards, length });
            }
            let value = text.get(10..).unwrap_or_default();
            let value = value.split('/').next().unwrap_or_default().trim();
            cards.push((key, value.to_owned()));
        }
        None
    }

    /// Returns the value of card `name` without quotation marks.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        let (_, value) = self.cards.iter().find(|(key, _)| key == name)?;
        Some(value.trim_matches('\'').trim())
    }

    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.text(name)?.parse().ok()
    }

    /// Returns the value of card `name` as a count; zero if there is none.
    pub(super) fn count(&self, name: &str) -> usize {
        self.number(name)
            .filter(|v| *v >= 0.0)
            .map_or(0, |v| v as usize)
    }

    /// Returns the length of the data behind the header without padding, bytes; `None` if it is too large to count.
    pub(super) fn data_length(&self) -> Option<usize> {
        let axes = self.count("NAXIS");
        if axes > MAX_AXES {
            return None;
        }
        let mut length = usize::from(axes > 0);
        for axis in 1..=axes {
            length = length.checked_mul(self.count(&format!("NAXIS{axis}")))?;
        }
        let sample = self.number("BITPIX").unwrap_or(0.0).abs() as usize / 8;
        length
            .checked_mul(sample)?
            .checked_add(self.count("PCOUNT"))
    }

    /// Returns the function from stored values to samples.
    pub(super) fn scale(&self) -> impl Fn(f64) -> f32 + use<> {
        let zero = self.number("BZERO").unwrap_or(0.0);
        let scale = self.number("BSCALE").unwrap_or(1.0);
        move |value| (zero + scale * value) as f32
    }
}
