//! Transfer curves that tiles of light never have.

use seidel_optics::observations::ObservationSet;
use seidel_optics::tile::Tile;

/// Largest codes of 8, 10, 12 and 16 bits.
const LARGEST_CODES: [f64; 4] = [255.0, 1023.0, 4095.0, 65_535.0];
/// Largest sample of values of which 1 is white: highlights may exceed it.
const MAX_OF_UNIT: f64 = 2.0;

/// A curve from light to stored values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Encoding {
    /// Light to the power 1 / gamma, in units of the peak of a tile.
    Gamma(f64),
    /// IEC 61966-2-1, of values up to 1.
    Srgb,
    /// ARRI LogC3 at EI 800, of values up to 1.
    LogC3,
    /// Sony S-Log3, of values up to 1.
    SLog3,
}

/// Encodings with their words, the commonest first.
pub(super) const ENCODINGS: [(Encoding, &str); 6] = [
    (
        Encoding::Gamma(2.2),
        "tiles are encoded for display, with a gamma near 2.2",
    ),
    (
        Encoding::Srgb,
        "tiles are encoded for display, by the curve of sRGB",
    ),
    (
        Encoding::Gamma(2.4),
        "tiles are encoded for display, with a gamma of 2.4",
    ),
    (Encoding::LogC3, "tiles are encoded as LogC3"),
    (Encoding::SLog3, "tiles are encoded as S-Log3"),
    (
        Encoding::Gamma(1.0 / 2.2),
        "tiles were decoded from a gamma near 2.2 which they did not have",
    ),
];

/// Returns the value of white in the tiles of `set`: 1, or the least largest code that no sample exceeds.
pub(super) fn white(set: &ObservationSet) -> f64 {
    let tiles = set.observations.iter().flat_map(|o| &o.tiles);
    let samples = tiles.flat_map(|tile| tile.samples().iter().copied());
    let largest = f64::from(samples.fold(0.0, f32::max));
    let mut codes = LARGEST_CODES.into_iter();
    let code = codes.find(|code| largest > MAX_OF_UNIT && largest <= *code);
    code.unwrap_or(1.0)
}

impl Encoding {
    /// Returns the light of `code`, a value of a tile whose largest value is `peak`.
    fn light(self, code: f64, peak: f64) -> f64 {
        match self {
            Self::Gamma(gamma) => peak * (code.max(0.0) / peak).powf(gamma),
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => ((code + 0.055) / 1.055).powf(2.4),
            // The linear part below the cut continues the curve.
            Self::LogC3 if code < 0.149_658 => (code - 0.092_809) / 5.367_655,
            Self::LogC3 => (10_f64.powf((code - 0.385_537) / 0.247_190) - 0.052_272) / 5.555_556,
            Self::SLog3 if code < 171.210_294_6 / 1023.0 => {
                (code * 1023.0 - 95.0) * 0.011_25 / (171.210_294_6 - 95.0)
            }
            Self::SLog3 => 10_f64.powf((code * 1023.0 - 420.0) / 261.5) * 0.19 - 0.01,
        }
    }

    /// Returns the tile of light of one of codes, of which `white` is white.
    pub(super) fn decoded(self, tile: &Tile, white: f64) -> Option<Tile> {
        let peak = tile.samples().iter().copied().fold(0.0, f32::max);
        let peak = f64::from(peak) / white;
        let codes = tile.samples().iter().map(|code| f64::from(*code) / white);
        let light = codes.map(|code| self.light(code, peak) as f32);
        Tile::new(tile.width(), tile.height(), light.collect()).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middle_grey_and_black_are_those_of_the_published_curves() {
        for (encoding, code, light) in [
            (Encoding::LogC3, 0.391_007, 0.18),
            (Encoding::LogC3, 0.092_809, 0.0),
            (Encoding::SLog3, 420.0 / 1023.0, 0.18),
            (Encoding::SLog3, 95.0 / 1023.0, 0.0),
            (Encoding::Srgb, 0.461_356, 0.18),
            (Encoding::Gamma(2.2), 0.5, 0.5_f64.powf(2.2)),
        ] {
            let got = encoding.light(code, 1.0);
            assert!((got - light).abs() < 1e-5, "{encoding:?}: {got}");
        }
    }
}
