//! The atlas of a page: tiles of PSFs in one picture.

use image::{Rgb, RgbImage};
use serde::Serialize;

use crate::report::data_uri;

/// Largest number of pixels of an atlas, which bounds the size of a page: some 6 MB at most.
pub(super) const MAX_PIXELS: usize = 5_000_000;
/// Sides of tiles to choose from, px.
const SIDES: [usize; 6] = [96, 80, 64, 48, 40, 32];
/// Largest width of an atlas, px, which every browser can draw.
const MAX_WIDTH: usize = 4096;

/// A PSF of three colours in linear light, row-major.
pub(super) type Light = Vec<[f64; 3]>;

/// The atlas as the script reads it.
#[derive(Serialize)]
pub(super) struct Atlas {
    /// Side of a tile, px.
    side: usize,
    /// Tiles in a row.
    columns: usize,
    /// The picture as a PNG in a `data:` URI.
    png: String,
}

/// Returns the largest side of tiles of which `count` fit into an atlas.
pub(super) fn tile_side(count: usize) -> usize {
    let fits = |side: &usize| side * side * count <= MAX_PIXELS;
    SIDES
        .into_iter()
        .find(fits)
        .unwrap_or(SIDES[SIDES.len() - 1])
}

/// Returns the largest number of tiles of the smallest side that fit into an atlas.
pub(super) fn most_tiles() -> usize {
    let side = SIDES[SIDES.len() - 1];
    MAX_PIXELS / (side * side)
}

impl Atlas {
    /// Returns the atlas of `tiles` with this side. The tone is the square root of light over the peak of the tile.
    pub(super) fn new(side: usize, tiles: &[Light]) -> Self {
        let columns = (MAX_WIDTH / side).min(tiles.len().max(1));
        let rows = tiles.len().div_ceil(columns).max(1);
        let mut picture = RgbImage::new((columns * side) as u32, (rows * side) as u32);
        for (index, tile) in tiles.iter().enumerate() {
            let (left, top) = ((index % columns) * side, (index / columns) * side);
            let values = tile.iter().flatten();
            let peak = values.fold(f64::MIN_POSITIVE, |peak, value| peak.max(*value));
            for (k, light) in tile.iter().enumerate() {
                let tone = light.map(|v| (255.0 * (v.max(0.0) / peak).sqrt()).round() as u8);
                let at = ((left + k % side) as u32, (top + k / side) as u32);
                picture.put_pixel(at.0, at.1, Rgb(tone));
            }
        }
        Self {
            side,
            columns,
            png: data_uri(&picture),
        }
    }
}

/// The channels that a page shows: red, green and blue together, or one as grey.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ShownChannels {
    /// Index of the channel of each colour.
    pub(super) of_colour: [usize; 3],
    /// In words.
    pub(super) words: String,
}

impl ShownChannels {
    /// Chooses R, G and B where the lens or set has them, otherwise its first channel.
    pub(super) fn of(names: &[String]) -> Self {
        let find = |name: &str| names.iter().position(|own| own.eq_ignore_ascii_case(name));
        match (find("R"), find("G"), find("B")) {
            (Some(r), Some(g), Some(b)) => Self {
                of_colour: [r, g, b],
                words: "channels R, G, B".to_owned(),
            },
            _ => Self {
                of_colour: [0; 3],
                words: match names {
                    [only] => format!("channel {only}"),
                    [first, ..] => format!("channel {first} of {}", names.join(", ")),
                    [] => String::new(),
                },
            },
        }
    }

    /// Returns the indices of the channels, each once.
    pub(super) fn indices(&self) -> Vec<usize> {
        let mut all = self.of_colour.to_vec();
        all.dedup();
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_an_atlas_is_bounded() {
        for count in [1, 100, 1000, most_tiles()] {
            let side = tile_side(count);
            assert!(side * side * count <= MAX_PIXELS, "{count}");
        }
        assert_eq!(tile_side(1), SIDES[0]);
    }

    #[test]
    fn the_peak_of_each_tile_is_white() {
        let tiles = [vec![[0.2; 3]; 32 * 32], vec![[0.0, 3.0, 0.0]; 32 * 32]];
        let atlas = Atlas::new(32, &tiles);
        assert_eq!((atlas.side, atlas.columns), (32, 2));
        assert!(atlas.png.starts_with("data:image/png;base64,"));
    }
}
