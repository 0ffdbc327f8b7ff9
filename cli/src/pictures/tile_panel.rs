//! Single PSFs as small pictures, with pixels enlarged by an integer.

use image::{Rgb, RgbImage};
use seidel_core::Tile;

use super::shapes::{difference, grey};

/// Share of the peak from which a pixel counts as lit when the crop is chosen.
const LIT_SHARE: f32 = 0.004;
/// Margin around the lit pixels, px, besides a quarter of their reach; observed light may exceed the predictions.
const ROOM_PX: usize = 3;

/// A centred crop of tiles of equal size that contains the light of all of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TilePart {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
}

impl TilePart {
    /// Returns the crop that contains the lit pixels of all `tiles`, which have equal sizes and no noise.
    pub fn around(tiles: &[&Tile]) -> Self {
        let (width, height) = tiles
            .first()
            .map_or((1, 1), |tile| (tile.width(), tile.height()));
        let mut reach = 0;
        for tile in tiles {
            let peak = tile.samples().iter().copied().fold(0.0, f32::max);
            for (at, &light) in tile.samples().iter().enumerate() {
                if light > LIT_SHARE * peak {
                    let off = |v: usize, size: usize| (2 * v + 1).abs_diff(size).div_ceil(2);
                    let far = off(at % width, width).max(off(at / width, height));
                    reach = reach.max(far);
                }
            }
        }
        let half = reach + reach / 4 + ROOM_PX;
        let span = |size: usize| {
            let start = (size / 2).saturating_sub(half);
            (start, size - 2 * start)
        };
        let ((left, width), (top, height)) = (span(width), span(height));
        Self {
            left,
            top,
            width,
            height,
        }
    }

    /// Returns the longer side, px.
    pub fn side(&self) -> usize {
        self.width.max(self.height)
    }

    /// Returns the largest `f` over the sample indices of the crop in a tile `tile_width` px wide.
    pub fn greatest(&self, tile_width: usize, f: impl Fn(usize) -> f32) -> f32 {
        self.indices(tile_width).map(f).fold(0.0, f32::max)
    }

    fn indices(&self, tile_width: usize) -> impl Iterator<Item = usize> {
        let Self {
            left,
            top,
            width,
            height,
        } = *self;
        (top..top + height).flat_map(move |y| (left..left + width).map(move |x| y * tile_width + x))
    }

    /// Returns the crop as a picture, with pixels enlarged `times` and coloured by their sample index.
    fn picture(
        &self,
        tile_width: usize,
        times: u32,
        colour: impl Fn(usize) -> [u8; 3],
    ) -> RgbImage {
        let size = |v: usize| v as u32 * times;
        RgbImage::from_fn(size(self.width), size(self.height), |x, y| {
            let (x, y) = ((x / times) as usize, (y / times) as usize);
            Rgb(colour((self.top + y) * tile_width + self.left + x))
        })
    }

    /// Returns the light of `tile` in tones of the square root of its share of `brightest`.
    pub fn light(&self, tile: &Tile, brightest: f32, times: u32) -> RgbImage {
        let share = |at: usize| f64::from(tile.samples()[at] / brightest);
        self.picture(tile.width(), times, |at| grey(share(at)))
    }

    /// Returns the residual `tile` - `observed`, from blue (too little light) through white to red (too much),
    /// with full colour at `full`.
    pub fn residual(&self, tile: &Tile, observed: &Tile, full: f32, times: u32) -> RgbImage {
        let share = |at: usize| f64::from((tile.samples()[at] - observed.samples()[at]) / full);
        self.picture(tile.width(), times, |at| difference(share(at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_contain_the_light() {
        let mut samples = vec![0.0; 15 * 11];
        samples[5 * 15 + 9] = 4.0;
        let tile = Tile::new(15, 11, samples).expect("sound");
        let part = TilePart::around(&[&tile]);
        assert_eq!((part.width, part.height), (11, 11));
        let shown = part.light(&tile, 4.0, 3);
        assert_eq!(shown.dimensions(), (33, 33));
        assert_eq!(shown.get_pixel(3 * 7 + 1, 3 * 5 + 1).0, [255; 3]);
        assert_eq!(shown.get_pixel(0, 0).0, [0; 3]);
        let empty = Tile::new(15, 11, vec![0.0; 15 * 11]).expect("sound");
        let less = part.residual(&empty, &tile, 4.0, 1);
        assert_eq!(less.get_pixel(7, 5).0, difference(-1.0));
        assert_eq!(less.get_pixel(0, 0).0, [255; 3]);
        assert_eq!(part.greatest(15, |at| tile.samples()[at]), 4.0);
    }
}
