//! The ways of predicting a PSF that are compared, and their scores.

use rayon::prelude::*;

use super::LensHere;
use super::average::Averages;
use crate::score::BlurScorer;
use crate::score::{PlacedTile, draw, on_pixels};
use seidel_optics::predict::Predictor;
use seidel_optics::psf::{
    Gaussian, LocalBlur, MirroredPair, PsfModel, Pupil, SkewNormal, SkewNormalEq43,
    SkewNormalGeneral,
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

/// Whose blur a kernel is drawn from.
#[derive(Clone, Copy)]
enum From {
    /// The tile's own moments.
    Tile,
    /// The tile's own moments, no variance below [`LEAST_MEASURED_PX2`].
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

impl Method {
    /// Whether it can be asked of `lens`.
    fn serves(&self, lens: &Predictor) -> bool {
        match self.way {
            Way::Psf(model, _) => lens.check_model(model).is_ok(),
            Way::AverageAligned | Way::AverageUnaligned => true,
        }
    }
}

/// Every method; those that draw rays are left out where the lens is not known so.
static METHODS: &[Method] = &[
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
    method("pupil-model", "pupil, lens", Way::Psf(&Pupil, From::Lens)),
];

/// Scores every method that `lens` has on `tiles`; `squares` are V(P) of each.
pub(super) fn score(
    tiles: &[PlacedTile],
    squares: &[f64],
    lens: LensHere,
    scorer: &BlurScorer,
) -> Vec<MethodScore> {
    let side = scorer.side();
    let averages = Averages::of(tiles, side);
    let methods: Vec<&Method> = METHODS
        .iter()
        .filter(|method| method.serves(lens.predictor))
        .collect();
    let scores: Vec<Vec<f64>> = tiles
        .par_iter()
        .zip(squares)
        .map(|(tile, &square)| {
            let predicted = on_pixels(lens.blur(tile.field));
            let measured = |moments| LocalBlur::from_moments(moments, tile.field.meridian());
            let against = |kernel: &[f64]| scorer.decibels(&tile.truth, square, kernel);
            let of_method = |method: &&Method| match method.way {
                Way::AverageAligned => against(&averages.aligned_to(tile, side)),
                Way::AverageUnaligned => against(averages.unaligned()),
                Way::Psf(model, from) => {
                    let blur = match from {
                        From::Tile => measured(tile.plain),
                        From::TileFloored => {
                            measured(tile.plain.with_least_variance(LEAST_MEASURED_PX2))
                        }
                        From::Lens => predicted,
                    };
                    against(&draw(model, &blur, tile, side))
                }
            };
            methods.iter().map(of_method).collect()
        })
        .collect();
    methods
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
