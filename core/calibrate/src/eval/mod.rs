//! Evaluation of a lens on a set of PSFs: the tables and figure of section 4 of the paper.
//!
//! Protocol:
//! - Every channel at every distance is a data set of its own (a *group*).
//! - A tile is its light over the support ([`seidel_optics::moments::support`]), scaled to unit sum. Its
//!   moments are plain sums over pixels; predictions gain the pixel's 1/12 px².
//! - Table 1: variance of each moment over the field explained by the lens ([`VarianceExplained`]).
//! - Table 2: forward-blur SNR M_FB ([`crate::score`]) of each predictor, mean over tiles. Tiles and kernels
//!   lie on squares 8 px wider on each side than the group's largest tile, or exactly as large where noise
//!   masks tiles. Kernels are sampled at pixel centres about the measured centroid and have unit sum.
//! - Averages include the tile under test. Aligned averages are shifted by cubic B-splines.
//! - Figure 13: M_FB against the number of training PSFs ([`SparseCurve`]).
//! - [`shapes()`] returns some tiles with their predictions for display.

mod average;
mod methods;
mod remarks;
mod shapes;
mod sparse;
mod spline;
mod split_mean;
mod variance_explained;

pub use methods::MethodScore;
pub use shapes::{SHOWN_RADII, ShapePrediction, ShapeRow, shapes};
pub use sparse::{SparseCurve, SparsePoint, SparseSettings};
pub use split_mean::SplitMean;
pub use variance_explained::VarianceExplained;

use rayon::prelude::*;
use serde::{Serialize, Serializer};

use crate::depth_json;
use crate::measure::{MeasuredTile, measure};
use crate::score::{ImageAutocorrelation, TestImage, prepare_tiles};
use crate::stage::Stage;
use seidel_optics::Progress;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::error::{Error, Result};
use seidel_optics::field::FieldPoint;
use seidel_optics::moments::CentralMoments;
use seidel_optics::moments::pixels::PIXEL_VARIANCE_PX2;
use seidel_optics::moments::support::Support;
use seidel_optics::observations::ObservationSet;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::LensProfile;
use seidel_optics::psf::LocalBlur;
use seidel_render::BlurField;

/// Shares of the progress of a group at which its tiles are prepared, and at which Table 2 is computed where Figure 13
/// follows.
const PREPARED_SHARE: f64 = 0.1;
const METHODS_SHARE: f64 = 0.3;

/// Settings of [`evaluate`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EvalSettings {
    /// Channel names; all channels of the set if empty.
    pub channels: Vec<String>,
    /// Distances; all distances of the set if empty.
    pub distances: Vec<ObjectDistance>,
    /// Pixels of a tile that count.
    pub support: Support,
    /// Settings of Figure 13, which is computed if given.
    pub sparse: Option<SparseSettings>,
}

/// Evaluation of a lens on a set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Evaluation {
    /// One entry per channel and distance: channels in the set's order, nearest distance first.
    pub groups: Vec<GroupEvaluation>,
    /// Limits of the figures, such as excluded tiles.
    pub remarks: Vec<String>,
}

/// Evaluation of one channel at one distance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupEvaluation {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    #[serde(
        rename = "depth_m",
        serialize_with = "depth_json::serialize",
        skip_serializing_if = "depth_json::is_unknown"
    )]
    pub distance: ObjectDistance,
    /// Number of tiles.
    pub tiles: usize,
    /// Smallest and largest measured mu20 with pixel integration (1/12 px²), px².
    pub mu20_px2: (f64, f64),
    /// Table 1, in the order of [`seidel_optics::moments::CentralMoments::NAMES`].
    #[serde(rename = "variance_explained", serialize_with = "by_moment")]
    pub explained: [VarianceExplained; 7],
    /// Table 2.
    #[serde(rename = "forward_blur_snr")]
    pub methods: Vec<MethodScore>,
    /// Figure 13, if requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sparse: Option<SparseCurve>,
    /// Side of the squares on which kernels were compared, px.
    pub square_px: usize,
}

/// Serialises the moments of Table 1 as an object by name.
fn by_moment<S: Serializer>(
    explained: &[VarianceExplained; 7],
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_map(CentralMoments::NAMES.iter().zip(explained))
}

/// Evaluates `lens` on `set` with the test image `z`. Field positions are relative to the lens's axis.
///
/// # Errors
/// Frames of different sizes; channels missing in the set or the lens; an unknown distance where the lens
/// depends on it; settings that select no usable tile; cancellation by `progress`.
pub fn evaluate(
    lens: &LensProfile,
    set: &ObservationSet,
    z: &TestImage,
    settings: &EvalSettings,
    progress: &Progress,
) -> Result<Evaluation> {
    let whole = Stage::whole(progress, "evaluation");
    whole.reach(0.0)?;
    one_frame(lens, set)?;
    let predictor = Predictor::new(lens)?;
    let channels = chosen_channels(lens, set, settings)?;
    let distances: Vec<ObjectDistance> = set
        .distances()
        .into_iter()
        .filter(|d| settings.distances.is_empty() || settings.distances.contains(d))
        .collect();
    let mut rejected = Vec::new();
    let measured = measure(std::slice::from_ref(set), settings.support, &mut rejected);
    let mut remarks = remarks::left_out(set, &rejected, &channels, &distances);
    let correlation = ImageAutocorrelation::new(z);
    let mut groups = Vec::new();
    let count = channels.len() * distances.len();
    for (k, &(in_set, in_lens)) in channels.iter().enumerate() {
        for (d, &distance) in distances.iter().enumerate() {
            let stage = whole.part_of(k * distances.len() + d, count);
            stage.reach(0.0)?;
            let tiles: Vec<&MeasuredTile> = measured
                .iter()
                .filter(|t| t.channel == in_set && t.distance == distance)
                .collect();
            let place = format!("channel {} at {distance}", set.channels[in_set]);
            if tiles.is_empty() {
                remarks.push(format!("{place}: no usable tile"));
                continue;
            }
            let vergence = predictor
                .vergence(distance)
                .map_err(|error| error.within(&place))?;
            let group = Group {
                lens: LensAtDistance {
                    predictor: &predictor,
                    channel: in_lens,
                    vergence,
                },
                set,
                tiles: &tiles,
            };
            group.check_blurs().map_err(|error| error.within(&place))?;
            groups.push(group.evaluate(&correlation, settings, stage)?);
            remarks.extend(group.remarks(&place));
            if let Some(curve) = groups.last().and_then(|g| g.sparse.as_ref()) {
                remarks.extend(remarks::sparse(&place, curve));
            }
        }
    }
    if groups.is_empty() {
        return Err(Error::new(
            "observations",
            "no tile of the chosen channels and distances is usable",
            format!(
                "the set has channels {} and distances {}",
                set.channels.join(", "),
                listed(&set.distances())
            ),
        ));
    }
    whole.reach(1.0)?;
    Ok(Evaluation { groups, remarks })
}

/// A lens in one channel at one distance.
#[derive(Clone, Copy)]
struct LensAtDistance<'a> {
    predictor: &'a Predictor,
    channel: usize,
    vergence: f64,
}

impl LensAtDistance<'_> {
    /// Returns the blur at `field` before pixel integration.
    fn blur(&self, field: FieldPoint) -> LocalBlur {
        let placed = self.predictor.blur_at(self.channel, field, self.vergence);
        placed.blur
    }
}

/// One channel at one distance.
struct Group<'a> {
    lens: LensAtDistance<'a>,
    set: &'a ObservationSet,
    tiles: &'a [&'a MeasuredTile],
}

impl Group<'_> {
    /// Checks the blur that the lens predicts at every tile.
    ///
    /// # Errors
    /// Moments that are not finite, where numbers of the profile or the set are too large.
    fn check_blurs(&self) -> Result<()> {
        let frame = &self.lens.predictor.frame();
        for tile in self.tiles {
            let moments = self.lens.blur(tile.field_point(frame)).moments.to_array();
            if let Some(bad) = moments.iter().find(|m| !m.is_finite()) {
                return Err(Error::new(
                    &tile.file,
                    format!("the lens predicts a moment of {bad} there"),
                    "check the position of the tile and the coefficients of the lens",
                ));
            }
        }
        Ok(())
    }

    fn evaluate(
        &self,
        correlation: &ImageAutocorrelation,
        settings: &EvalSettings,
        stage: Stage,
    ) -> Result<GroupEvaluation> {
        let frame = &self.lens.predictor.frame();
        let first = self.tiles[0];
        let pairs: Vec<([f64; 7], [f64; 7])> = self
            .tiles
            .par_iter()
            .map(|tile| {
                let predicted = self.lens.blur(tile.field_point(frame)).moments;
                // Both without pixel integration, which cancels in their difference.
                (tile.optical.to_array(), predicted.to_array())
            })
            .collect();
        let explained = std::array::from_fn(|m| {
            let of_moment: Vec<(f64, f64)> = pairs.iter().map(|(a, b)| (a[m], b[m])).collect();
            VarianceExplained::of(&of_moment)
        });
        let mu20 = || {
            self.tiles
                .iter()
                .map(|t| t.optical.mu20 + PIXEL_VARIANCE_PX2)
        };
        let (square_px, placed) = prepare_tiles(
            std::slice::from_ref(self.set),
            self.tiles,
            frame,
            settings.support,
        );
        let scorer = correlation.scorer(square_px);
        let signal_powers: Vec<f64> = placed
            .par_iter()
            .map(|tile| scorer.blurred_power(&tile.measured))
            .collect();
        stage.reach(PREPARED_SHARE)?;
        let methods = methods::score(&placed, &signal_powers, self.lens, &scorer);
        let sparse = settings.sparse.as_ref().map(|sparse| {
            let stage = stage.part(METHODS_SHARE, 1.0);
            let group = sparse::GroupTiles {
                measured: self.tiles,
                tiles: &placed,
                signal_powers: &signal_powers,
            };
            sparse::curve(frame, &group, &scorer, sparse, stage)
        });
        Ok(GroupEvaluation {
            channel: self.set.channels[first.channel].clone(),
            distance: first.distance,
            tiles: self.tiles.len(),
            mu20_px2: (
                mu20().fold(f64::INFINITY, f64::min),
                mu20().fold(f64::NEG_INFINITY, f64::max),
            ),
            explained,
            methods,
            sparse: sparse.transpose()?,
            square_px,
        })
    }

    fn remarks(&self, place: &str) -> Option<String> {
        let impossible = self
            .tiles
            .iter()
            .filter(|tile| {
                let field = tile.field_point(&self.lens.predictor.frame());
                self.lens.blur(field).moments.least_variance() < 0.0
            })
            .count();
        (impossible > 0).then(|| {
            format!(
                "{place}: the lens predicts a negative variance at {impossible} of {} tiles; they are scored with the smallest variance of a kernel",
                self.tiles.len()
            )
        })
    }
}

fn one_frame(lens: &LensProfile, set: &ObservationSet) -> Result<()> {
    let size = |frame: &seidel_optics::field::Frame| {
        format!("{} x {}", frame.width_px(), frame.height_px())
    };
    let (lens, set) = (size(&lens.frame), size(&set.frame));
    if lens == set {
        return Ok(());
    }
    Err(Error::new(
        "image_size",
        format!("is {set} px for the observations and {lens} px for the lens"),
        "evaluate a lens on observations of the frame that it was fitted for",
    ))
}

/// Returns the indices, in the set and in the lens, of the channels to evaluate.
fn chosen_channels(
    lens: &LensProfile,
    set: &ObservationSet,
    settings: &EvalSettings,
) -> Result<Vec<(usize, usize)>> {
    for name in &settings.channels {
        set.channel_index(name)?;
    }
    set.channels
        .iter()
        .enumerate()
        .filter(|(_, name)| settings.channels.is_empty() || settings.channels.contains(name))
        .map(|(index, name)| {
            let in_lens = lens.channel_names().iter().position(|c| c == name);
            in_lens.map(|k| (index, k)).ok_or_else(|| {
                Error::new(
                    format!("channel `{name}`"),
                    "is in the observations and not in the lens",
                    format!(
                        "choose among the lens's channels: {}",
                        lens.channel_names().join(", ")
                    ),
                )
            })
        })
        .collect()
}

fn listed(distances: &[ObjectDistance]) -> String {
    let all: Vec<String> = distances.iter().map(ToString::to_string).collect();
    all.join(", ")
}

#[cfg(test)]
mod tests;
