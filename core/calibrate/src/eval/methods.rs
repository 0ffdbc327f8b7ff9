//! The compared PSF predictors and their scores (Table 2).

use rayon::prelude::*;

use super::LensAtDistance;
use super::average::Averages;
use crate::score::{
    BlurScorer, PreparedTile, misplaced_light, render_kernel, with_pixel_integration,
};
use seidel_optics::predict::Predictor;
use seidel_optics::psf::{
    Gaussian, LocalBlur, MirroredPair, PsfModel, Pupil, SkewNormal, SkewNormalEq43,
    SkewNormalGeneral,
};

/// Score of one predictor over the tiles of a group.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct MethodScore {
    /// Stable identifier.
    pub id: &'static str,
    /// Description.
    pub title: &'static str,
    /// Mean over tiles of M_FB, dB.
    pub mean_db: f64,
    /// Population standard deviation of M_FB over tiles, dB.
    pub std_db: f64,
    /// M_FB of the worst tile, dB.
    pub worst_db: f64,
    /// Mean over tiles of the share of a tile's light that the kernel puts into the wrong pixels
    /// ([`crate::score::misplaced_light`]).
    pub misplaced_light: f64,
}

/// Lower bound of measured variances along any direction, px², with pixel integration. Used for the Gaussian
/// and the general skew-normals, because noise can make measured variances vanish.
const MIN_MEASURED_VARIANCE_PX2: f64 = 0.03;

/// Source of the moments of a kernel.
#[derive(Clone, Copy)]
enum MomentSource {
    /// Measured moments of the tile.
    Tile,
    /// Measured moments, variances at least [`MIN_MEASURED_VARIANCE_PX2`].
    TileFloored,
    /// Predicted by the lens.
    Lens,
}

#[derive(Clone, Copy)]
enum Predicted {
    AverageAligned,
    AverageUnaligned,
    Psf(&'static dyn PsfModel, MomentSource),
}

struct Method {
    id: &'static str,
    title: &'static str,
    way: Predicted,
}

const fn method(id: &'static str, title: &'static str, way: Predicted) -> Method {
    Method { id, title, way }
}

impl Method {
    /// Returns whether the predictor works with `lens`.
    fn serves(&self, lens: &Predictor) -> bool {
        match self.way {
            Predicted::Psf(model, _) => lens.check_model(model).is_ok(),
            Predicted::AverageAligned | Predicted::AverageUnaligned => true,
        }
    }
}

/// All predictors. Those that trace pupils are skipped for lenses described by moments.
static METHODS: &[Method] = &[
    method(
        "average-aligned",
        "average PSF, centroids aligned",
        Predicted::AverageAligned,
    ),
    method(
        "average-unaligned",
        "average PSF, tiles as they lie",
        Predicted::AverageUnaligned,
    ),
    method(
        "gaussian-raw",
        "Gaussian, measured moments",
        Predicted::Psf(&Gaussian, MomentSource::TileFloored),
    ),
    method(
        "gaussian-model",
        "Gaussian, lens",
        Predicted::Psf(&Gaussian, MomentSource::Lens),
    ),
    method(
        "skew-normal-general-raw",
        "skew-normal (weights 1, 3, 3, 1), measured moments",
        Predicted::Psf(&SkewNormalGeneral, MomentSource::TileFloored),
    ),
    method(
        "skew-normal-eq43-raw",
        "skew-normal (Eq 43), measured moments",
        Predicted::Psf(&SkewNormalEq43, MomentSource::TileFloored),
    ),
    method(
        "skew-normal-model",
        "skew-normal (meridional), lens",
        Predicted::Psf(&SkewNormal, MomentSource::Lens),
    ),
    method(
        "skew-normal-eq43-model",
        "skew-normal (Eq 43), lens",
        Predicted::Psf(&SkewNormalEq43, MomentSource::Lens),
    ),
    method(
        "mirrored-pair-raw",
        "mirrored pair, measured moments",
        Predicted::Psf(&MirroredPair, MomentSource::Tile),
    ),
    method(
        "mirrored-pair-model",
        "mirrored pair, lens",
        Predicted::Psf(&MirroredPair, MomentSource::Lens),
    ),
    method(
        "pupil-model",
        "pupil, lens",
        Predicted::Psf(&Pupil, MomentSource::Lens),
    ),
];

/// Scores every applicable predictor on `tiles`; `signal_powers` holds V(P) of each tile.
pub(super) fn score(
    tiles: &[PreparedTile],
    signal_powers: &[f64],
    lens: LensAtDistance,
    scorer: &BlurScorer,
) -> Vec<MethodScore> {
    let side = scorer.side();
    let averages = Averages::of(tiles, side);
    let methods: Vec<&Method> = METHODS
        .iter()
        .filter(|method| method.serves(lens.predictor))
        .collect();
    let scores: Vec<Vec<[f64; 2]>> = tiles
        .par_iter()
        .zip(signal_powers)
        .map(|(tile, &square)| {
            let predicted = with_pixel_integration(lens.blur(tile.field));
            let measured = |moments| LocalBlur::from_moments(moments, tile.field.meridian());
            let against = |kernel: &[f64]| {
                [
                    tile.snr_db(scorer, square, kernel),
                    misplaced_light(&tile.compared_with(kernel), kernel),
                ]
            };
            let of_method = |method: &&Method| match method.way {
                Predicted::AverageAligned => against(&averages.aligned_to(tile, side)),
                Predicted::AverageUnaligned => against(averages.unaligned()),
                Predicted::Psf(model, from) => {
                    let blur = match from {
                        MomentSource::Tile => measured(tile.moments),
                        MomentSource::TileFloored => {
                            measured(tile.moments.with_least_variance(MIN_MEASURED_VARIANCE_PX2))
                        }
                        MomentSource::Lens => predicted.clone(),
                    };
                    against(&render_kernel(model, &blur, tile, side))
                }
            };
            methods.iter().map(of_method).collect()
        })
        .collect();
    methods
        .iter()
        .enumerate()
        .map(|(k, method)| {
            let of_method = || scores.iter().map(|tile| tile[k][0]);
            let count = scores.len() as f64;
            let mean = of_method().sum::<f64>() / count;
            let variance = of_method().map(|db| (db - mean).powi(2)).sum::<f64>() / count;
            MethodScore {
                id: method.id,
                title: method.title,
                mean_db: mean,
                std_db: variance.sqrt(),
                worst_db: of_method().fold(f64::INFINITY, f64::min),
                misplaced_light: scores.iter().map(|tile| tile[k][1]).sum::<f64>() / count,
            }
        })
        .collect()
}
