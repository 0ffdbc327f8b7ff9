//! The result of a diagnosis. Its serialised form is the body of `report.json`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::effects::FittedValue;
use seidel_optics::field::ImagePoint;
use seidel_optics::profile::LensProfile;
use seidel_optics::tile::Tile;
use serde::{Serialize, Serializer};

use super::bookkeeping::Bookkeeping;
use super::capture::Capture;
use super::cause_words::{CauseWords, cause_words};
use super::model_share::ModelShare;
use crate::depth_json;

/// The diagnosis of a gap: which effect the lens lacks, how far adding it closes the gap, and where the gap
/// lies.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Diagnosis {
    /// The verdict.
    pub verdict: Verdict,
    /// The mistake in the books of the set, which is corrected for all other figures; left out where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bookkeeping: Option<Bookkeeping>,
    /// Effects added to the lens in `corrected.json`, the stronger first; with the verdict `unexplained`,
    /// those that explain a part of the gap.
    pub added: Vec<&'static str>,
    /// Size of the gap before and after the correction.
    pub gap: Gap,
    /// Every effect tried and `unknown`, most probable first; probabilities sum to one.
    pub causes: Vec<Cause>,
    /// Sets of effects that these data cannot distinguish.
    pub equivalents: Vec<Vec<&'static str>>,
    /// Parts of field, channel and depth where the gap lies, largest first.
    #[serde(rename = "where")]
    pub places: Vec<Place>,
    /// The capture that would settle what is still open, with what each cause makes of it.
    pub next_capture: String,
    /// Identifier of that capture.
    pub next_capture_id: Capture,
    /// Posterior probability that nothing is missing; those of `causes` are conditional on a gap.
    pub no_gap_probability: f64,
    /// Pairs of effects tried, and three effects together where they were, best first.
    pub pairs: Vec<Pair>,
    /// The part of the PSFs in which the gap lies.
    pub shape: Shape,
    /// Share of the gap that a free-form model of the residual closes on held-out zones of the field: a lower
    /// bound of the share that any model could explain.
    pub explainable: f64,
    /// The gap between the lens and the set that it was fitted to.
    pub model: ModelShare,
    /// The gap in three parts.
    pub shares: Shares,
    /// Gap, less noise, up to which an effect may be missing without being seen.
    pub detection_limit: f64,
    /// Description of the remaining residual; empty where it is below the detection limit.
    pub residual: String,
    /// Parts of field, channel and depth where that residual lies, largest first; empty where `residual` is.
    #[serde(rename = "where_left")]
    pub places_left: Vec<Place>,
    /// Remarks about the data and the fits.
    pub remarks: Vec<String>,
    /// The lens with the effects in `added`.
    #[serde(skip)]
    pub corrected: LensProfile,
    /// The gap of every tile.
    #[serde(skip)]
    pub tiles: Vec<TileGap>,
    /// Tiles with the largest and with typical gaps.
    #[serde(skip)]
    pub examples: Vec<Example>,
}

/// The verdict of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The lens explains the data to within their noise and its own misfit.
    NoGap,
    /// The effects in `added` close the gap.
    Explained,
    /// Several causes close the gap that these data cannot distinguish (`equivalents`).
    Ambiguous,
    /// No known effect closes the gap.
    Unexplained,
    /// The model of the lens is too simple: it does not describe the set that it was fitted to, and the effects in `added` do
    /// not close that gap too.
    ModelTooSimple,
    /// The books of the set hold a mistake: a frame, a unit or a label.
    Bookkeeping,
}

impl Diagnosis {
    /// Returns the verdict on the effects that the lens lacks, where the books of the set are corrected.
    pub fn verdict_on_effects(&self) -> Verdict {
        let corrected = self.bookkeeping.as_ref();
        corrected.map_or(self.verdict, |found| found.verdict)
    }
}

impl Verdict {
    /// Returns the identifier used in reports.
    pub fn id(self) -> &'static str {
        match self {
            Self::NoGap => "no_gap",
            Self::Explained => "explained",
            Self::Ambiguous => "ambiguous",
            Self::Unexplained => "unexplained",
            Self::ModelTooSimple => "model_too_simple",
            Self::Bookkeeping => "bookkeeping",
        }
    }
}

/// The mean over tiles of |o - p|² / |o|² on held-out observations, with o the observed and p the predicted
/// tile of unit sum, less the contribution of noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Gap {
    /// Gap of the given lens.
    pub before: f64,
    /// Gap of the corrected lens, fitted without the zone of the field that it is scored on.
    pub after: f64,
    /// 1 - after / before.
    pub closed: f64,
    /// 95 % interval of `closed`.
    pub closed_ci95: [f64; 2],
    /// Contribution of noise alone.
    pub noise_floor: f64,
}

/// The gap in three parts, each as a share of the energy of a PSF.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Shares {
    /// Noise of these observations; not part of the gap.
    pub noise: f64,
    /// The part that the lens's own model leaves, at most the gap.
    pub model: f64,
    /// The part by a change between the set that the lens was fitted to and these observations.
    pub change: f64,
}

/// An effect tried alone.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Cause {
    /// Identifier of the effect, or `unknown`.
    #[serde(flatten, serialize_with = "with_words")]
    #[schemars(with = "CauseWords<'static>")]
    pub effect: &'static str,
    /// Posterior probability that this is the missing effect, given a gap.
    pub probability: f64,
    /// Share of the gap closed on held-out zones; with the best partner where two effects were added.
    pub gap_closed: f64,
    /// 95 % interval of `gap_closed`.
    pub gap_closed_ci95: [f64; 2],
    /// Fitted values in the user's units, in words; empty where no few words describe them.
    pub amount: String,
    /// Parameters of the best fit.
    #[serde(flatten, serialize_with = "by_name")]
    #[schemars(with = "NamedParameters")]
    pub parameters: Vec<FittedValue>,
}

fn with_words<S: Serializer>(effect: &&'static str, serializer: S) -> Result<S::Ok, S::Error> {
    cause_words(effect).serialize(serializer)
}

/// Parameters by name; `name.channel` where channels do not share them.
#[derive(Serialize, JsonSchema)]
struct NamedParameters {
    /// Parameters of the best fit, by name.
    parameters: BTreeMap<String, f64>,
    /// Their standard errors.
    parameters_sigma: BTreeMap<String, f64>,
}

fn by_name<S: Serializer>(values: &[FittedValue], serializer: S) -> Result<S::Ok, S::Error> {
    NamedParameters {
        parameters: values.iter().map(|v| (v.key(), v.value)).collect(),
        parameters_sigma: values.iter().map(|v| (v.key(), v.sigma)).collect(),
    }
    .serialize(serializer)
}

/// Two or three effects tried together.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Pair {
    /// Identifiers of the effects.
    pub effects: Vec<&'static str>,
    /// Posterior probability that these are missing, given a gap.
    pub probability: f64,
    /// Share of the gap that they close together on held-out zones.
    pub gap_closed: f64,
}

/// A part of the field in one channel at one object distance.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Place {
    /// Channel name.
    pub channel: String,
    /// Object distance in metres; null is infinity, left out is unknown.
    #[serde(
        rename = "depth_m",
        serialize_with = "depth_json::serialize",
        skip_serializing_if = "depth_json::is_unknown"
    )]
    #[schemars(with = "Option<f64>")]
    pub distance: ObjectDistance,
    /// Part of the field.
    pub zone: Zone,
    /// Mean gap in the zone.
    pub excess: f64,
    /// The mean gap in its standard errors.
    pub z: f64,
    /// Number of tiles in the zone.
    pub tiles: usize,
}

/// A ring sector of the field about the optical axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Zone {
    /// Least and largest distance from the axis, in units of the farthest tile's.
    pub radius: [f64; 2],
    /// Least and largest angle, degrees from image x towards y.
    pub angle_deg: [f64; 2],
}

/// Shares of the residual's energy by part of the PSF and by kind of change.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Shape {
    /// Share within the circle about the centroid that holds half the light.
    pub core: f64,
    /// Share outside that circle.
    pub skirt: f64,
    /// Kinds of change, each fitted after those before it.
    pub orders: Vec<Order>,
}

/// A kind of change of a PSF.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Order {
    /// `position`, `size`, `ellipticity`, `skew` or `finer`.
    pub name: &'static str,
    /// Share of the residual's energy.
    pub share: f64,
    /// Significance in standard errors of the noise.
    pub z: f64,
}

/// The gap of one tile.
#[derive(Debug, Clone, PartialEq)]
pub struct TileGap {
    /// Index of the observation in its set.
    pub observation: usize,
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Centre of the tile.
    pub at: ImagePoint,
    /// Gap of the given lens, less the contribution of noise.
    pub before: f64,
    /// Gap of the corrected lens fitted without the tile's zone, less the contribution of noise.
    pub after: f64,
    /// Contribution of noise.
    pub noise: f64,
}

/// A tile as observed and as predicted, all of unit sum.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// Index into [`Diagnosis::tiles`].
    pub tile: usize,
    /// Observed light, background subtracted.
    pub observed: Tile,
    /// Prediction of the given lens.
    pub predicted: Tile,
    /// Prediction of the corrected lens.
    pub corrected: Tile,
}
