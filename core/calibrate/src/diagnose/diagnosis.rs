//! What a diagnosis says.

use seidel_optics::distance::ObjectDistance;
use seidel_optics::field::ImagePoint;
use seidel_optics::profile::LensProfile;
use seidel_optics::tile::Tile;

/// The answer: where reality departs from the lens, which effect the lens lacks, how far adding it goes.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// The answer in a word.
    pub verdict: Verdict,
    /// Effects added to the lens, the stronger first. In [`Verdict::Unexplained`] what explains a part.
    pub added: Vec<&'static str>,
    /// How large the gap is and how far it closes.
    pub gap: Gap,
    /// Probability that nothing is missing. Those of [`Diagnosis::causes`] are given that something is.
    pub nothing_missing: f64,
    /// Every effect tried and the unknown, likeliest first; probabilities sum to one.
    pub causes: Vec<Cause>,
    /// Pairs of effects tried, best first.
    pub pairs: Vec<Pair>,
    /// Sets of effects that these data cannot tell apart.
    pub equivalents: Vec<Vec<&'static str>>,
    /// Parts of field, channel and depth where the gap lies, largest first.
    pub places: Vec<Place>,
    /// In which part of the PSFs it lies.
    pub shape: Shape,
    /// Capture that would decide what is open.
    pub next_capture: String,
    /// The residual that is left, in words; empty where none is.
    pub residual: String,
    /// What a user should know besides.
    pub remarks: Vec<String>,
    /// The lens with [`Diagnosis::added`].
    pub corrected: LensProfile,
    /// The gap of every tile.
    pub tiles: Vec<TileGap>,
    /// Some tiles to look at, worst gaps and typical ones.
    pub examples: Vec<Example>,
}

/// The answer in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The lens explains the data to their noise and its own accuracy.
    NoGap,
    /// The effects in [`Diagnosis::added`] close the gap.
    Explained,
    /// Causes close it that these data cannot tell apart: [`Diagnosis::equivalents`].
    Ambiguous,
    /// A gap stays that no known effect closes.
    Unexplained,
}

impl Verdict {
    /// As reports write it.
    pub fn id(self) -> &'static str {
        match self {
            Self::NoGap => "no_gap",
            Self::Explained => "explained",
            Self::Ambiguous => "ambiguous",
            Self::Unexplained => "unexplained",
        }
    }
}

/// Gaps: mean over tiles of the squared difference between observed and predicted unit-sum tiles over
/// the squared norm of the observed, less what noise alone gives. On observations that took no part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Of the lens as given.
    pub before: f64,
    /// Of the lens with [`Diagnosis::added`], fitted without the zone of the field it is scored on.
    pub after: f64,
    /// 1 - after / before.
    pub closed: f64,
    /// Interval that holds `closed` with 95 %.
    pub closed_ci95: (f64, f64),
    /// What noise alone gives.
    pub noise_floor: f64,
    /// What the lens leaves on the data it was fitted to, where it knows.
    pub lens_misfit: f64,
    /// Share of the gap that a free-form residual model closes, likewise on zones that took no part: what
    /// can be explained at all, at least.
    pub explainable: f64,
}

/// One effect tried alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Cause {
    /// Identifier of the effect, or `unknown`.
    pub effect: &'static str,
    /// Probability that it is what is missing, given that something is.
    pub probability: f64,
    /// Share of the gap that it closes, on zones that took no part; with the effects of its best pair
    /// where [`Diagnosis::added`] holds two.
    pub gap_closed: f64,
    /// Interval that holds it with 95 %.
    pub gap_closed_ci95: (f64, f64),
    /// Its values where it fits best.
    pub parameters: Vec<Value>,
}

/// A value of a parameter of an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Value {
    /// Name of the parameter.
    pub name: &'static str,
    /// Channel, for a parameter that channels do not share.
    pub channel: Option<String>,
    /// Unit.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
    /// Its standard error; zero for kinds that are counted.
    pub sigma: f64,
}

impl Value {
    /// Name as reports write it: with the channel where there is one.
    pub fn key(&self) -> String {
        match &self.channel {
            Some(channel) => format!("{}.{channel}", self.name),
            None => self.name.to_owned(),
        }
    }
}

/// Two effects tried together.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Which.
    pub effects: [&'static str; 2],
    /// Probability that both are missing, given that something is.
    pub probability: f64,
    /// Share of the gap that they close together, on zones that took no part.
    pub gap_closed: f64,
}

/// A part of the field in one channel at one depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Channel name.
    pub channel: String,
    /// Object distance.
    pub distance: ObjectDistance,
    /// Distances from the optical axis, in units of the farthest tile's: from, to.
    pub radius: (f64, f64),
    /// Directions from it, degrees from image x towards y: from, to.
    pub angle_deg: (f64, f64),
    /// Tiles there.
    pub tiles: usize,
    /// Mean gap there.
    pub excess: f64,
    /// The same in standard errors.
    pub z: f64,
}

/// In which part of the PSFs the gap lies: shares of the residual's energy.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Within the circle about the centroid that holds half the light.
    pub core: f64,
    /// Outside.
    pub skirt: f64,
    /// By moment: what a change of position, size, ellipticity and skew explains one after the other,
    /// and what is left; each with its share and its significance in standard errors of the noise.
    pub orders: Vec<Order>,
}

/// A kind of change of a PSF.
#[derive(Debug, Clone, PartialEq)]
pub struct Order {
    /// Name: `position`, `size`, `ellipticity`, `skew`, `finer`.
    pub name: &'static str,
    /// Share of the residual's energy.
    pub share: f64,
    /// Significance.
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
    /// Middle of the tile.
    pub at: ImagePoint,
    /// Gap of the lens as given, noise taken off.
    pub before: f64,
    /// Gap of the corrected lens, likewise, fitted without the tile's zone.
    pub after: f64,
    /// What noise gives.
    pub noise: f64,
}

/// One tile, observed and predicted; unit sums.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// Which: index into [`Diagnosis::tiles`].
    pub tile: usize,
    /// As observed, background taken off.
    pub observed: Tile,
    /// As the lens given predicts it.
    pub predicted: Tile,
    /// As the corrected lens predicts it.
    pub corrected: Tile,
}
