//! Choice of the windows from which tiles are estimated: spread over the frame, in the best-textured places.

use super::PairImage;
use super::depth::DepthPlane;
use super::patch::{Window, taper};
use seidel_optics::error::{Error, Result};
use seidel_optics::field::ImagePoint;

/// Side of the window from which a tile is estimated, in tiles.
const WINDOW_TILES: usize = 4;
/// Windows of neighbouring blocks overlap by at most this share, so that their noise is nearly independent.
const MOST_OVERLAP: f64 = 0.5;
/// Steps between the places tried in a block, as a share of the window's side.
const STEP: f64 = 1.0 / 8.0;

/// Windows, and the number of blocks without one.
pub(super) struct Chosen {
    pub(super) windows: Vec<Window>,
    /// Blocks in which no window is at one distance.
    pub(super) uneven: usize,
}

/// Returns at most `most` windows for tiles of side `tile`: the frame is divided into blocks, and each gets one where the
/// sharp picture has the largest gradients that are not clipped.
///
/// # Errors
/// Pictures too small for the tiles.
pub(super) fn choose(
    sharp: &PairImage<'_>,
    tile: usize,
    most: usize,
    clip: Option<f32>,
    depth: Option<&DepthPlane>,
) -> Result<Chosen> {
    let (side, margin) = (WINDOW_TILES * tile, tile / 2);
    let (width, height) = (sharp.width, sharp.height);
    let room = |size: usize| size.checked_sub(side + 2 * margin);
    let (Some(wide), Some(high)) = (room(width), room(height)) else {
        return Err(Error::new(
            "pictures",
            format!(
                "are {width} x {height} px, too small for tiles of {tile} px, which need {} px each way",
                side + 2 * margin
            ),
            "give smaller tiles, or larger pictures",
        ));
    };
    let texture = Texture::new(sharp, clip);
    let (columns, rows) = blocks(wide, high, (1.0 - MOST_OVERLAP) * side as f64, most);
    // Corners of windows lie in `margin..=margin + room`; each block has its own interval of them.
    let interval = |index: usize, count: usize, room: usize| {
        let at = |k: usize| margin + room * k / count;
        (at(index), at(index + 1))
    };
    let step = ((STEP * side as f64) as usize).max(1);
    // Places tried keep their distance from those of the next block.
    let distance = (1.0 - MOST_OVERLAP) * side as f64 / 2.0;
    let tried = |(first, last): (usize, usize), count: usize| {
        let keep = (distance as usize).min((last - first) / 2);
        let keep = if count > 1 { keep } else { 0 };
        let (first, last) = (first + keep, last - keep);
        (first..=last).step_by(step).collect::<Vec<_>>()
    };
    // The light of a window comes from its margins too.
    let vergence_at = |left: usize, top: usize| {
        let corner = [left - margin, top - margin];
        depth.map_or(Some(None), |d| {
            d.of_square(corner, side + 2 * margin).map(Some)
        })
    };
    let mut windows = Vec::with_capacity(columns * rows);
    let mut uneven = 0;
    for row in 0..rows {
        for column in 0..columns {
            let lefts = tried(interval(column, columns, wide), columns);
            let tops = tried(interval(row, rows, high), rows);
            let places = tops
                .iter()
                .flat_map(|&top| lefts.iter().map(move |&left| (left, top)));
            let at_one_distance = places.filter_map(|(left, top)| {
                let vergence = vergence_at(left, top)?;
                Some((texture.inside(left, top, side), left, top, vergence))
            });
            let best = at_one_distance.max_by(|a, b| a.0.total_cmp(&b.0));
            uneven += usize::from(best.is_none());
            if let Some((_, left, top, vergence)) = best {
                windows.push(Window {
                    left,
                    top,
                    side,
                    tile,
                    centre: texture_centroid(sharp, clip, [left, top], side),
                    vergence,
                });
            }
        }
    }
    if windows.is_empty() {
        return Err(Error::new(
            "depth",
            format!("changes within every window of {} px", side + 2 * margin),
            "give smaller tiles, or pictures of a scene whose parts are each at one distance",
        ));
    }
    if let Some(depth) = depth {
        let own: Vec<f64> = windows.iter().filter_map(|w| w.vergence).collect();
        for (window, level) in windows.iter_mut().zip(depth.levels(&own)) {
            window.vergence = Some(level);
        }
    }
    Ok(Chosen { windows, uneven })
}

/// Returns the numbers of columns and rows of blocks: at least `step` px each, at most `most` in all, nearly square.
fn blocks(wide: usize, high: usize, step: f64, most: usize) -> (usize, usize) {
    let count = |room: usize, step: f64| ((room as f64 / step) as usize + 1).max(1);
    let mut step = step.max(1.0);
    while count(wide, step) * count(high, step) > most.max(1) {
        step *= 1.05;
    }
    (count(wide, step), count(high, step))
}

/// Returns the squared gradient at a pixel, summed over channels; `None` where a sample is clipped or unknown.
fn squared_gradient(picture: &PairImage<'_>, clip: Option<f32>, x: usize, y: usize) -> Option<f64> {
    let (width, height) = (picture.width, picture.height);
    let at = y * width + x;
    let mut energy = 0.0;
    for plane in picture.planes {
        let here = plane[at];
        let right = plane[if x + 1 < width { at + 1 } else { at }];
        let below = plane[if y + 1 < height { at + width } else { at }];
        let gradient = (right - here).powi(2) + (below - here).powi(2);
        if !gradient.is_finite() || clip.is_some_and(|clip| here >= clip) {
            return None;
        }
        energy += f64::from(gradient);
    }
    Some(energy)
}

/// Returns the centroid of the squared gradients in a square, weighted as the estimate weights its pixels; the middle of an
/// even square.
fn texture_centroid(
    picture: &PairImage<'_>,
    clip: Option<f32>,
    [left, top]: [usize; 2],
    side: usize,
) -> ImagePoint {
    let (mut sum, mut moments) = (0.0, [0.0; 2]);
    for y in 0..side {
        for x in 0..side {
            let gradient = squared_gradient(picture, clip, left + x, top + y).unwrap_or(0.0);
            let weight = taper(x, side) * taper(y, side) * gradient;
            sum += weight;
            moments[0] += weight * (x as f64 + 0.5);
            moments[1] += weight * (y as f64 + 0.5);
        }
    }
    let [x, y] = if sum > 0.0 {
        moments.map(|m| m / sum)
    } else {
        [side as f64 / 2.0; 2]
    };
    ImagePoint::new(left as f64 + x, top as f64 + y)
}

/// Sums of squared gradients over rectangles.
struct Texture {
    stride: usize,
    /// Sums over all pixels above and left.
    sums: Vec<f64>,
    /// The same of pixels that are clipped or unknown.
    lost: Vec<f64>,
}

impl Texture {
    fn new(picture: &PairImage<'_>, clip: Option<f32>) -> Self {
        let (width, height) = (picture.width, picture.height);
        let stride = width + 1;
        let mut texture = Self {
            stride,
            sums: vec![0.0; stride * (height + 1)],
            lost: vec![0.0; stride * (height + 1)],
        };
        for y in 0..height {
            let (mut sum, mut lost) = (0.0, 0.0);
            for x in 0..width {
                match squared_gradient(picture, clip, x, y) {
                    Some(energy) => sum += energy,
                    None => lost += 1.0,
                }
                let (to, above) = ((y + 1) * stride + x + 1, y * stride + x + 1);
                texture.sums[to] = texture.sums[above] + sum;
                texture.lost[to] = texture.lost[above] + lost;
            }
        }
        texture
    }

    /// Returns the sum of squared gradients in a square, lowered by its share of lost pixels.
    fn inside(&self, left: usize, top: usize, side: usize) -> f64 {
        let of = |sums: &[f64]| {
            let at = |x: usize, y: usize| sums[y * self.stride + x];
            at(left + side, top + side) - at(left, top + side) - at(left + side, top)
                + at(left, top)
        };
        let kept = 1.0 - of(&self.lost) / (side * side) as f64;
        of(&self.sums) * kept.powi(4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose_in(planes: &[Vec<f32>], most: usize) -> Vec<Window> {
        let picture = PairImage {
            width: 400,
            height: 300,
            planes,
            quantisation: None,
        };
        let chosen = choose(&picture, 9, most, Some(0.99), None);
        chosen.expect("large enough").windows
    }

    #[test]
    fn the_centre_of_a_window_is_that_of_its_texture() {
        // Stripes in the lower right quarter.
        let plane: Vec<f32> = (0..400 * 300)
            .map(|k| {
                let is_textured = k % 400 >= 220 && k / 400 >= 170;
                if is_textured {
                    (k % 2) as f32 * 0.5
                } else {
                    0.3
                }
            })
            .collect();
        let picture = PairImage {
            width: 400,
            height: 300,
            planes: &[plane],
            quantisation: None,
        };
        let at = texture_centroid(&picture, None, [200, 150], 40);
        // The centroid of half a raised cosine lies 1/2 - 2 / pi² of half its width from its peak: 6 px here.
        assert!((at.x_px - 226.0).abs() < 0.5, "{at:?}");
        assert!((at.y_px - 176.0).abs() < 0.5, "{at:?}");
        let even = texture_centroid(&picture, None, [20, 30], 40);
        assert_eq!((even.x_px, even.y_px), (40.0, 50.0));
    }

    #[test]
    fn windows_lie_where_the_texture_is() {
        // Stripes in the left third of each 100 px, and clipped ones in the right third.
        let plane: Vec<f32> = (0..400 * 300)
            .map(|k| match k % 100 {
                x if x < 40 => (k % 2) as f32 * 0.5,
                x if x > 60 => (k % 2) as f32,
                _ => 0.3,
            })
            .collect();
        let windows = choose_in(&[plane], 40);
        assert!((20..=40).contains(&windows.len()), "{}", windows.len());
        let textured = |w: &Window| {
            let inside = (w.left..w.left + w.side).filter(|x| x % 100 < 40).count();
            inside as f64 / w.side as f64
        };
        let mean = windows.iter().map(textured).sum::<f64>() / windows.len() as f64;
        // Windows on a regular grid would have 0.4.
        assert!(mean > 0.5, "{mean}");
        for w in &windows {
            assert!(w.left >= 4 && w.left + w.side + 4 <= 400);
            assert!(w.top >= 4 && w.top + w.side + 4 <= 300);
        }
    }
}
