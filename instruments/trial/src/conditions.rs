//! Conditions of a case: how many tiles, how large, how noisy, and what the set states.

use super::recipe::Kind;
use super::rng::Rng;

/// The number of positions in each set and the size of the tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Size {
    /// Positions in the design set, each at every distance.
    pub design: usize,
    /// Positions in the real set, each at every distance.
    pub real: usize,
    /// Positions in the held-out set, each at every distance.
    pub holdout: usize,
    /// Width and height of every tile, pixels; odd, at least 25.
    pub tile: usize,
}

impl Default for Size {
    fn default() -> Self {
        Self {
            design: 25,
            real: 30,
            holdout: 12,
            tile: 33,
        }
    }
}

/// Conditions under which a case is captured.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Conditions {
    /// Number of object distances: 1, 2 or 5.
    pub distances: usize,
    /// Number of positions and size of tiles.
    pub size: Size,
    /// Peak of a tile of the real set over the standard deviation of its noise.
    pub snr: f64,
    /// True if the real set states its noise.
    pub noise_stated: bool,
    /// True if tiles hold exposed values instead of shares of the light.
    pub raw: bool,
    /// True if the real and the held-out set state ideal positions.
    pub ideal_positions: bool,
    /// The wanted gap between the weakest (0) and the strongest (1) of cases, in logarithms.
    pub strength: f64,
}

/// Range of the signal-to-noise ratio of the real set.
const SNR: [f64; 2] = [30.0, 2000.0];
/// Shares of cases with one, and with five distances; the others have two.
const ONE_DISTANCE: f64 = 0.15;
const FIVE_DISTANCES: f64 = 0.15;
/// Shares of cases with tiles of 49 and of 65 px; the others have 33 px.
const TILE_49: f64 = 0.2;
const TILE_65: f64 = 0.1;
/// Share of cases that state their noise, and of those that state ideal positions.
const NOISE_STATED: f64 = 0.7;
const IDEAL_STATED: f64 = 0.8;

impl Conditions {
    /// Draws conditions for a case of `kind`, with `size` if it is given.
    pub(super) fn draw(kind: Kind, size: Option<Size>, rng: &mut Rng) -> Self {
        let distances = match rng.unit() {
            u if u < ONE_DISTANCE => 1,
            u if u < ONE_DISTANCE + FIVE_DISTANCES => 5,
            _ => 2,
        };
        let tile = match rng.unit() {
            u if u < TILE_65 => 65,
            u if u < TILE_65 + TILE_49 => 49,
            _ => 33,
        };
        // Five distances have fewer positions each, so that sets have a similar number of tiles.
        let (design, most) = if distances == 5 { (16, 18) } else { (25, 30) };
        let real = 12 + rng.below(most - 12 + 1);
        let drawn = Size {
            design,
            real,
            holdout: 8,
            tile,
        };
        let snr = rng.between_log(SNR[0], SNR[1]);
        // Tone curves act on exposed values; distortion only moves PSFs. Negative lobes need a stated noise.
        let noise_stated = rng.chance(NOISE_STATED) || kind.holds("sharpening");
        let raw = rng.chance(0.5) || kind.holds("tone_curve");
        let ideal_positions = rng.chance(IDEAL_STATED) || kind.holds("distortion");
        Self {
            distances,
            size: size.unwrap_or(drawn),
            snr,
            noise_stated,
            raw,
            ideal_positions,
            strength: rng.unit(),
        }
    }
}
