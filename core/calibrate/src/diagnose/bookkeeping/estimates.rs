//! Mistakes with an amount: how much is estimated from the tiles and their predictions, without a fit of an effect.

use seidel_optics::numeric::{dot, median};
use seidel_optics::observations::ObservationSet;
use seidel_optics::psf::pupil::Detail;

use super::super::hypothesis::Hypothesis;
use super::super::prediction::TilePredictor;
use super::super::registration::Registration;
use super::super::tiles::TileData;
use super::denoising;
use super::mistakes::{Change, LEFT_OF_IMITATED, Mistake};
use super::sharpening::{UnsharpMask, blurred};

/// Least displacement of tiles that is a mistake of positions, and how near it is to whole or half pixels, px: windows of pictures are
/// shifted by pixels, and lenses by any amount.
const MIN_OFFSET_PX: f64 = 0.9;
const OFFSET_ERROR_PX: f64 = 0.08;
/// Least black level, in its scatter from tile to tile, and as a share of the light of a tile.
const MIN_LEVEL_RATIO: f64 = 4.0;
const MIN_LEVEL_SHARE: f64 = 0.01;
/// Ratio of the relative scatters of the level in stored units and as a share of the light, below which it is a level and no glare.
const LEVEL_OR_GLARE: f64 = 0.6;
/// Largest share of the gap that the blur of denoised tiles leaves: a filter that follows edges is no blur.
const LEFT_OF_DENOISED: f64 = 0.5;
/// Least amount of an unsharp mask, and the blurs tried, px.
const MIN_SHARPENING: f64 = 0.15;
const BLURS_PX: [f64; 6] = [0.5, 0.7, 1.0, 1.5, 2.0, 3.0];

/// A tile with its prediction, both of unit sum.
struct Pair<'a> {
    tile: &'a TileData,
    predicted: Vec<f64>,
}

/// Returns the mistakes with an amount that `tiles` of `set` show, if `nothing` is missing.
pub(super) fn of(nothing: &Hypothesis, tiles: &[TileData], set: &ObservationSet) -> Vec<Mistake> {
    let mut predictor = TilePredictor::default();
    let pairs: Vec<Pair> = (tiles.iter())
        .map(|tile| {
            let mut predicted = Vec::new();
            predictor.predict(nothing, &[], tile, Detail::COARSE, &mut predicted);
            Pair { tile, predicted }
        })
        .collect();
    let mut all = Vec::new();
    all.extend(offset(tiles));
    all.extend(black_level(&pairs, set.channels.len()));
    all.extend(sharpening(&pairs));
    all.extend(denoised(&pairs));
    all
}

/// Returns the blur of tiles whose noise was blurred with them; `None` where noise is as stated.
fn denoised(pairs: &[Pair]) -> Option<Mistake> {
    let each = pairs
        .iter()
        .map(|pair| (pair.tile, pair.predicted.as_slice()));
    let sigma_px = denoising::find(each)?;
    Some(Mistake {
        id: "denoising",
        words: format!(
            "tiles were denoised or resampled: their noise is blurred too, by about {sigma_px} px"
        ),
        remedy: "Take PSFs from pictures without noise reduction and at their own size: from raw files, developed without either."
            .to_owned(),
        largest_share: LEFT_OF_DENOISED,
        change: Change::Denoising(sigma_px),
    })
}

/// Returns the median of `values` and their median absolute deviation from it; `None` without any.
pub(super) fn median_and_scatter(values: &[f64]) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    let middle = median(&mut values.to_vec());
    let mut off: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    Some((middle, median(&mut off)))
}

/// Returns the offset of all tiles by the displacement of their centroids, in half pixels; `None` where there is none.
fn offset(tiles: &[TileData]) -> Option<Mistake> {
    let placed = tiles
        .iter()
        .filter(|t| matches!(t.registration, Registration::Ideal));
    let moved: Vec<[f64; 2]> = placed
        .filter_map(|tile| {
            let (at, expected) = (tile.centroid?, tile.pupil.centroid());
            Some([at[0] - expected[0], at[1] - expected[1]])
        })
        .collect();
    let along = |axis: usize| {
        let each: Vec<f64> = moved.iter().map(|m| m[axis]).collect();
        let (middle, _) = median_and_scatter(&each)?;
        let halves = (2.0 * middle).round() / 2.0;
        ((middle - halves).abs() < OFFSET_ERROR_PX).then_some(halves)
    };
    let [x, y] = [along(0)?, along(1)?];
    (x.hypot(y) > MIN_OFFSET_PX).then(|| Mistake {
        id: "offset",
        words: format!("tiles lie ({x}, {y}) px off their ideal positions, all of them"),
        remedy: "State centre and ideal position of each observation in the same frame: that of the whole picture, not of a crop.".to_owned(),
        largest_share: LEFT_OF_IMITATED,
        change: Change::Shift([-x, -y]),
    })
}

/// Returns the constant that all tiles hold beside their light; `None` where there is none, or where it may be glare, which grows with the
/// light.
fn black_level(pairs: &[Pair], channels: usize) -> Option<Mistake> {
    let levels: Vec<(f64, f64)> = pairs
        .iter()
        .map(|pair| (level(pair), pair.tile.exposure))
        .collect();
    let stored: Vec<f64> = levels.iter().map(|(level, _)| *level).collect();
    let shares: Vec<f64> = (levels.iter().zip(pairs))
        .map(|((level, exposure), pair)| level * pair.tile.valid_pixels() as f64 / exposure)
        .collect();
    let (level, scatter) = median_and_scatter(&stored)?;
    let (share, of_shares) = median_and_scatter(&shares)?;
    let is_level = level > MIN_LEVEL_RATIO * scatter
        && share > MIN_LEVEL_SHARE
        && scatter / level < LEVEL_OR_GLARE * of_shares / share;
    is_level.then(|| Mistake {
        id: "black_level",
        words: format!("tiles hold a constant of {level:.3} beside their light: a black level"),
        remedy: "Subtract the black level of the camera before PSFs are cut out, or state it as background.".to_owned(),
        largest_share: LEFT_OF_IMITATED,
        change: Change::BlackLevel(vec![level; channels]),
    })
}

/// Returns the constant of a tile, in its stored unit: its pixels are a multiple of the prediction and this constant, by least squares.
fn level(pair: &Pair) -> f64 {
    let (light, predicted) = (&pair.tile.light, &pair.predicted);
    let count = light.len() as f64;
    let [of_light, of_predicted] = [light, predicted].map(|v| v.iter().sum::<f64>());
    let (pp, lp) = (dot(predicted, predicted), dot(light, predicted));
    let determinant = count * pp - of_predicted * of_predicted;
    if determinant <= 0.0 {
        return 0.0;
    }
    (pp * of_light - of_predicted * lp) / determinant * pair.tile.exposure
}

/// Returns the unsharp mask that describes the tiles best; `None` where none does.
fn sharpening(pairs: &[Pair]) -> Option<Mistake> {
    let with_blur = |sigma_px: f64| {
        let (mut product, mut power, mut before) = (0.0, 0.0, 0.0);
        for Pair { tile, predicted } in pairs {
            let soft = blurred(predicted, tile.size.0, tile.size.1, sigma_px);
            let detail: Vec<f64> = predicted.iter().zip(soft).map(|(p, s)| p - s).collect();
            let residual = tile.residual(predicted);
            product += dot(&detail, &residual) / tile.norm;
            power += dot(&detail, &detail) / tile.norm;
            before += dot(&residual, &residual) / tile.norm;
        }
        let amount = product / power.max(f64::MIN_POSITIVE);
        (before - amount * product, UnsharpMask { amount, sigma_px })
    };
    let best = BLURS_PX.into_iter().map(with_blur);
    let (_, mask) = best.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (mask.amount > MIN_SHARPENING).then(|| Mistake {
        id: "sharpening",
        words: format!(
            "tiles were sharpened, with an unsharp mask of {:.1} and a radius of {} px",
            mask.amount, mask.sigma_px
        ),
        remedy: "Take PSFs from pictures without sharpening: from raw files, developed without it."
            .to_owned(),
        largest_share: LEFT_OF_IMITATED,
        change: Change::Sharpening(mask),
    })
}
