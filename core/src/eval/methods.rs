//! The ways of predicting a PSF that are compared, and their scores.

use rayon::prelude::*;

use super::average::Averages;
use super::forward_blur::BlurScorer;
use super::tiles::{PlacedTile, to_unit_sum};
use crate::lens::MomentCoefficients;
use crate::moments::CentralMoments;
use crate::moments::pixels::PIXEL_VARIANCE_PX2;
use crate::psf::{
    Gaussian, LocalBlur, MirroredPair, PsfModel, SkewNormal, SkewNormalEq43, SkewNormalGeneral,
};

/// How well one way of predicting PSFs does over the tiles of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MethodScore {
    /// Stable identifier.
    pub id: &'static str,
    /// What it is, in words.
    pub title: &'static str,
    /// Mean over tiles of M_FB, dB.
    pub mean_db: f64,
    /// Standard deviation of M_FB over tiles (of the population), dB.
    pub std_db: f64,
    /// M_FB of the worst tile, dB.
    pub worst_db: f64,
}

/// Least variance (px², the pixel's included) along any direction with which measured moments are
/// drawn by the Gaussian and the general skew-normals: noise can leave them none.
const LEAST_MEASURED_PX2: f64 = 0.03;

/// Whose moments a kernel is drawn from.
#[derive(Clone, Copy)]
enum From {
    /// The tile's own.
    Tile,
    /// The tile's own, no variance below [`LEAST_MEASURED_PX2`].
    TileFloored,
    /// The lens's prediction.
    Lens,
}

#[derive(Clone, Copy)]
enum Way {
    AverageAligned,
    AverageUnaligned,
    Psf(&'static dyn PsfModel, From),
}

struct Method {
    id: &'static str,
    title: &'static str,
    way: Way,
}

const fn method(id: &'static str, title: &'static str, way: Way) -> Method {
    Method { id, title, way }
}

static METHODS: [Method; 10] = [
    method(
        "average-aligned",
        "average PSF, centroids aligned",
        Way::AverageAligned,
    ),
    method(
        "average-unaligned",
        "average PSF, tiles as they lie",
        Way::AverageUnaligned,
    ),
    method(
        "gaussian-raw",
        "Gaussian, measured moments",
        Way::Psf(&Gaussian, From::TileFloored),
    ),
    method(
        "gaussian-model",
        "Gaussian, lens",
        Way::Psf(&Gaussian, From::Lens),
    ),
    method(
        "skew-normal-general-raw",
        "skew-normal (weights 1, 3, 3, 1), measured moments",
        Way::Psf(&SkewNormalGeneral, From::TileFloored),
    ),
    method(
        "skew-normal-eq43-raw",
        "skew-normal (Eq 43), measured moments",
        Way::Psf(&SkewNormalEq43, From::TileFloored),
    ),
    method(
        "skew-normal-model",
        "skew-normal (meridional), lens",
        Way::Psf(&SkewNormal, From::Lens),
    ),
    method(
        "skew-normal-eq43-model",
        "skew-normal (Eq 43), lens",
        Way::Psf(&SkewNormalEq43, From::Lens),
    ),
    method(
        "mirrored-pair-raw",
        "mirrored pair, measured moments",
        Way::Psf(&MirroredPair, From::Tile),
    ),
    method(
        "mirrored-pair-model",
        "mirrored pair, lens",
        Way::Psf(&MirroredPair, From::Lens),
    ),
];

/// Moments that a kernel sampled at pixel centres must have for the lens `s` at the tile's place.
pub(super) fn lens_moments(s: &MomentCoefficients, tile: &PlacedTile) -> CentralMoments {
    s.moments(tile.field)
        .with_added_variance(PIXEL_VARIANCE_PX2)
}

/// The kernel of `model` with `moments` about the tile's centroid, unit sum over the square.
pub(super) fn draw(
    model: &dyn PsfModel,
    moments: CentralMoments,
    tile: &PlacedTile,
    side: usize,
) -> Vec<f64> {
    let blur = LocalBlur::of_moments(moments, tile.field.meridian());
    let mut kernel = vec![0.0; side * side];
    model.sample(&blur, &tile.window(side), &mut kernel);
    let sum: f64 = kernel.iter().sum();
    if sum > 0.0 && sum.is_finite() {
        to_unit_sum(&mut kernel);
    } else {
        // So narrow that no pixel centre sees it: all light goes to the pixel of the centroid.
        let pixel = |at: f64| at.floor().clamp(0.0, (side - 1) as f64) as usize;
        kernel.fill(0.0);
        kernel[pixel(tile.centroid.1) * side + pixel(tile.centroid.0)] = 1.0;
    }
    kernel
}

/// Scores every method on `tiles`; `squares` are V(P) of each, `s` the lens at their distance.
pub(super) fn score(
    tiles: &[PlacedTile],
    squares: &[f64],
    s: &MomentCoefficients,
    scorer: &BlurScorer,
) -> Vec<MethodScore> {
    let side = scorer.side();
    let averages = Averages::of(tiles, side);
    let scores: Vec<[f64; METHODS.len()]> = tiles
        .par_iter()
        .zip(squares)
        .map(|(tile, &square)| {
            std::array::from_fn(|k| {
                let against = |kernel: &[f64]| scorer.decibels(&tile.truth, square, kernel);
                match METHODS[k].way {
                    Way::AverageAligned => against(&averages.aligned_to(tile, side)),
                    Way::AverageUnaligned => against(averages.unaligned()),
                    Way::Psf(model, from) => {
                        let moments = match from {
                            From::Tile => tile.plain,
                            From::TileFloored => tile.plain.with_least_variance(LEAST_MEASURED_PX2),
                            From::Lens => lens_moments(s, tile),
                        };
                        against(&draw(model, moments, tile, side))
                    }
                }
            })
        })
        .collect();
    METHODS
        .iter()
        .enumerate()
        .map(|(k, method)| {
            let of_method = || scores.iter().map(|tile| tile[k]);
            let count = scores.len() as f64;
            let mean = of_method().sum::<f64>() / count;
            let variance = of_method().map(|db| (db - mean).powi(2)).sum::<f64>() / count;
            MethodScore {
                id: method.id,
                title: method.title,
                mean_db: mean,
                std_db: variance.sqrt(),
                worst_db: of_method().fold(f64::INFINITY, f64::min),
            }
        })
        .collect()
}
