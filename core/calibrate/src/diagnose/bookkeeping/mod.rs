//! Mistakes in keeping books: a frame that is mirrored, a unit, exchanged labels. They are tried before effects.
//!
//! Each is a change of the set, whose amount if any is estimated, so that it costs a prediction and no fit. The right one leaves what the
//! lens always leaves; an effect of optics is closed by none. Beside a strong effect a mistake is only suspected: it is one if effects do
//! not explain the gap with it, and do without it.

mod another_lens;
mod between_sets;
mod camera;
mod crop;
mod denoising;
mod encodings;
mod estimates;
pub(super) mod exchanged;
mod mistakes;
mod noise_scale;
mod screening;
mod sharpening;
#[cfg(test)]
mod tests;

pub(super) use another_lens::or_another_lens;
pub use between_sets::{MistakeInSet, mistakes_between};

use schemars::JsonSchema;
use seidel_optics::effects::Effect;
use seidel_optics::error::Result;
use seidel_optics::observations::ObservationSet;
use seidel_optics::predict::Predictor;
use seidel_optics::profile::{LensDescription, LensProfile, PupilChannel};
use serde::Serialize;

use super::Verdict;
use super::gap_problem::mean_gap;
use super::hypothesis::Hypothesis;
use super::jitter;
use super::tiles::{TileData, TileSet};
use camera::{Contradiction, Side};
use mistakes::Mistake;

/// Least gap that a mistake of any weight leaves.
const MIN_GAP: f64 = 0.01;
/// Ratio of that gap to the own gap of the lens.
const MIN_RATIO: f64 = 4.0;
/// Gaps up to this ratio to the least are equal: of equal mistakes the commonest is named.
const EQUAL: f64 = 1.25;
/// Largest gap that the right mistake leaves: what an effect beside it makes.
const MAX_LEFT: f64 = 0.4;
/// Largest share of the gap that a suspected mistake leaves.
const SUSPECTED: f64 = 0.6;
/// PSFs that are compared with each prediction.
const SAMPLE: usize = 16;
/// One of so many of them is compared first.
const FIRST_STRIDE: usize = 4;
/// Largest ratio of the gap that a mistake leaves of those to their gap, above which the others are not compared: the right one falls in all.
const HOPELESS: f64 = 1.05;

/// A mistake in the books of a set, and the set without it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Bookkeeping {
    /// Identifier of the mistake.
    pub mistake: &'static str,
    /// The mistake as a sentence.
    pub words: String,
    /// The change that corrects it, as a sentence.
    pub remedy: String,
    /// Gap with the mistake, over a sample of the PSFs.
    pub gap_before: f64,
    /// Gap of the same PSFs without it.
    pub gap_after: f64,
    /// Whether the set can be corrected; not that of another lens.
    pub can_be_corrected: bool,
    /// Verdict on the corrected set, to which all other figures belong.
    pub verdict: Verdict,
    /// The corrected set.
    #[serde(skip)]
    pub corrected: ObservationSet,
}

/// A mistake as it was found.
#[derive(Debug, Clone)]
pub enum FoundMistake {
    /// It explains most of the gap.
    Sure(Box<Bookkeeping>),
    /// It explains a part of the gap, and effects may explain the rest.
    Suspected(Box<Bookkeeping>),
}

impl FoundMistake {
    /// Returns the mistake if it is sure.
    pub fn sure(self) -> Option<Bookkeeping> {
        match self {
            Self::Sure(found) => Some(*found),
            Self::Suspected(_) => None,
        }
    }
}

/// The books of a set, compared with a lens by predictions.
#[derive(Debug, Default)]
pub(super) struct Books {
    pub(super) found: Option<FoundMistake>,
    /// A contradiction that is no mistake: the set was taken at other settings than those of the lens.
    pub(super) remark: Option<String>,
}

/// A set and the lens that it is compared with.
struct Comparison<'a> {
    lens: &'a LensProfile,
    channels: &'a [PupilChannel],
    set: &'a ObservationSet,
    /// Some of its PSFs.
    sample: ObservationSet,
    /// The gap of the sample.
    before: f64,
}

impl<'a> Comparison<'a> {
    /// Creates the comparison; `None` where a few PSFs cannot be compared with the lens.
    fn new(
        lens: &'a LensProfile,
        channels: &'a [PupilChannel],
        set: &'a ObservationSet,
    ) -> Option<Self> {
        let sample = sample(set);
        // A few PSFs may cover too little of the field, where all of them do not.
        let before = gap(lens, channels, &sample).ok()?;
        Some(Self {
            lens,
            channels,
            set,
            sample,
            before,
        })
    }

    /// Returns the gap of `set`, a changed sample; `None` where the change leads out of the range of the lens, and is then none.
    fn gap(&self, set: &ObservationSet) -> Option<f64> {
        gap(self.lens, self.channels, set).ok()
    }

    /// Returns the mistakes with the gap that each leaves, the commoner of similar ones first, without those that make it much larger.
    fn tried(&self) -> Result<Vec<(f64, Mistake)>> {
        let nothing = Hypothesis::nothing(self.channels.len());
        let tiles = placed_tiles(self.lens, self.channels, &self.sample)?;
        // Before encodings, which a black level beside a tone curve resembles.
        let mut all = estimates::of(&nothing, &tiles, &self.sample);
        all.extend(mistakes::of_frame_and_samples(&self.sample));
        if Predictor::new(self.lens)?.depends_on_depth() {
            all.extend(mistakes::of_distances(&self.sample));
        }
        let first = self.gap(&first_of(&self.sample)).unwrap_or(f64::INFINITY);
        let tried = all.into_iter().filter_map(|mistake| {
            let corrected = mistake.correct(&self.sample)?;
            if self.gap(&first_of(&corrected)).unwrap_or(0.0) > (HOPELESS * first).max(MIN_GAP) {
                return None;
            }
            Some((self.gap(&corrected)?, mistake))
        });
        Ok(tried.collect())
    }

    /// Returns the mistake that leaves the gap `after`, with the whole set corrected.
    fn found(&self, (after, mistake): (f64, Mistake)) -> Option<Box<Bookkeeping>> {
        Some(Box::new(Bookkeeping {
            corrected: mistake.correct(self.set)?,
            mistake: mistake.id,
            words: mistake.words,
            remedy: mistake.remedy,
            gap_before: self.before,
            gap_after: after,
            can_be_corrected: true,
            verdict: Verdict::NoGap,
        }))
    }

    /// Returns the contradiction between what set and lens state of the camera.
    fn contradiction(&self) -> Option<Contradiction> {
        let gap_of = |lens: &LensProfile| match &lens.description {
            LensDescription::Pupil(channels) => gap(lens, channels, &self.sample).ok(),
            LensDescription::Moments(_) => None,
        };
        camera::contradiction(self.lens, self.set, self.before, gap_of)
    }

    /// Returns the wrong statements of the camera as a mistake.
    fn wrong_camera(&self, words: String) -> Box<Bookkeeping> {
        Box::new(Bookkeeping {
            mistake: "camera",
            words,
            remedy: "State the camera with which the set was taken.".to_owned(),
            gap_before: self.before,
            gap_after: self.before,
            can_be_corrected: true,
            verdict: Verdict::NoGap,
            corrected: ObservationSet {
                camera: self.lens.camera.clone(),
                pixel_pitch_um: self.lens.pixel_pitch_um,
                ..self.set.clone()
            },
        })
    }
}

/// Looks for a mistake that explains the gap between `lens`, whose own gap is `own_gap`, and `set`, or a part of it.
///
/// # Errors
/// A set that cannot be compared with the lens.
pub(super) fn find(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
    own_gap: f64,
) -> Result<Books> {
    let Some(books) = Comparison::new(lens, channels, set) else {
        return Ok(Books::default());
    };
    // Gaps are less noise, so that those of all other mistakes need it.
    if let Some(mistake) = noise_scale::find(&books.sample) {
        let corrected = mistake.correct(&books.sample);
        let after = corrected.and_then(|set| books.gap(&set));
        let found = after.and_then(|after| books.found((after, mistake)));
        return Ok(Books {
            found: found.map(FoundMistake::Sure),
            remark: None,
        });
    }
    let mut found = match books.before < MIN_GAP.max(MIN_RATIO * own_gap) {
        true => None,
        false => of_gap(&books)?,
    };
    let mut remark = None;
    if let Some(Contradiction { words, side }) = books.contradiction() {
        match side {
            Side::Set(after) => {
                remark = Some(format!(
                    "{words}; at the settings of the set the lens leaves a gap of {:.2} % in place of {:.2} %: \
                     compare the set with the lens at these settings",
                    100.0 * after,
                    100.0 * books.before
                ));
            }
            Side::Lens | Side::Undecided if matches!(found, Some(FoundMistake::Sure(_))) => {
                remark = Some(words);
            }
            Side::Lens => {
                let words = format!("{words}, and the tiles agree better with the lens");
                found = Some(FoundMistake::Sure(books.wrong_camera(words)));
            }
            Side::Undecided => {
                let words = format!("{words}, and one of them is wrong");
                found = Some(FoundMistake::Sure(books.wrong_camera(words)));
            }
        }
    }
    Ok(Books { found, remark })
}

/// Returns the mistake that explains the gap or a part of it.
fn of_gap(books: &Comparison) -> Result<Option<FoundMistake>> {
    let tried = books.tried()?;
    let least = tried.iter().map(|(gap, _)| *gap);
    let least = least.fold(f64::INFINITY, f64::min).max(0.0);
    let best = tried.into_iter().filter(|(after, _)| {
        *after <= EQUAL * least + 1e-4 && *after <= MAX_LEFT.min(SUSPECTED * books.before)
    });
    let is_sure =
        |(after, mistake): &(f64, Mistake)| *after <= mistake.largest_share * books.before;
    let (mut sure, suspected): (Vec<_>, Vec<_>) = best.partition(is_sure);
    if sure.is_empty() {
        sure.extend(crop::find(&books.sample, books.before, |set| {
            books.gap(set)
        }));
    }
    let first = |found: Vec<(f64, Mistake)>| books.found(found.into_iter().next()?);
    Ok(match sure.is_empty() {
        true => first(suspected).map(FoundMistake::Suspected),
        false => first(sure).map(FoundMistake::Sure),
    })
}

/// Returns the mistakes that may stand beside effects, the likelier first: the `suspected` one, that which a single effect of `library` complements best,
/// and that which explains what `corrected`, the lens with the effects found in the set as it stands, leaves.
///
/// # Errors
/// A set that cannot be compared with the lens.
pub(super) fn beside_effects(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
    corrected: &LensProfile,
    library: &[&'static dyn Effect],
    suspected: Option<Bookkeeping>,
) -> Result<Vec<Bookkeeping>> {
    let Some(books) = Comparison::new(lens, channels, set) else {
        return Ok(Vec::new());
    };
    let tried = books.tried()?;
    let screened = screening::best(lens, channels, &books.sample, books.before, library, tried);
    let mut all = Vec::from_iter(suspected.map(Box::new));
    all.extend(screened.and_then(|found| books.found(found)));
    if let LensDescription::Pupil(channels) = &corrected.description {
        let of_rest = find(corrected, channels, set, 0.0)?.found;
        let of_rest = of_rest.and_then(FoundMistake::sure);
        all.extend(of_rest.filter(|m| m.mistake != "camera").map(Box::new));
    }
    all.dedup_by(|next, kept| next.words == kept.words);
    Ok(all.into_iter().map(|found| *found).collect())
}

/// Returns a set of some observations, spread over the order of `set` and over its distances.
fn sample(set: &ObservationSet) -> ObservationSet {
    let mut chosen = Vec::new();
    let distances = set.distances();
    let share = SAMPLE.div_ceil(distances.len().max(1)).max(4);
    for distance in distances {
        let own = set.observations.iter().filter(|o| o.distance == distance);
        let own: Vec<_> = own.collect();
        let stride = own.len().div_ceil(share).max(1);
        chosen.extend(own.into_iter().step_by(stride).cloned());
    }
    ObservationSet {
        observations: chosen,
        ..set.clone()
    }
}

/// Returns `set` with some of its observations.
fn first_of(set: &ObservationSet) -> ObservationSet {
    ObservationSet {
        observations: set
            .observations
            .iter()
            .step_by(FIRST_STRIDE)
            .cloned()
            .collect(),
        ..set.clone()
    }
}

/// Returns the tiles of `set`, each where the lens agrees best with it if its position is not known.
fn placed_tiles(
    lens: &LensProfile,
    channels: &[PupilChannel],
    set: &ObservationSet,
) -> Result<Vec<TileData>> {
    let mut tiles = TileSet::new(lens, channels, set, &[])?.tiles;
    jitter::place_by_pixels(&Hypothesis::nothing(channels.len()), &[], &mut tiles);
    Ok(tiles)
}

/// Returns the mean gap of `set`, less noise.
fn gap(lens: &LensProfile, channels: &[PupilChannel], set: &ObservationSet) -> Result<f64> {
    let tiles = placed_tiles(lens, channels, set)?;
    Ok(mean_gap(&Hypothesis::nothing(channels.len()), &tiles))
}
