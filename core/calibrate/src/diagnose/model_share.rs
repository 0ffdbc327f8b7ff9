//! The part of a gap that is the lens's own: what its model does not describe of the set that it was fitted to.

use schemars::JsonSchema;
use seidel_optics::effects;
use seidel_optics::error::{Error, ErrorKind, Result};
use seidel_optics::no_progress;
use seidel_optics::observations::ObservationSet;
use seidel_optics::profile::{LensDescription, LensProfile, MAX_EXCESS_DESCRIBED, PupilChannel};
use seidel_optics::psf::pupil::Detail;
use serde::Serialize;

use super::gap_problem::GapProblem;
use super::hypothesis::Hypothesis;
use super::tiles::{TileData, TileSet};
use crate::fit::{PupilModel, PupilSettings, fit_pupil};

/// Own gap that is assumed for lenses that were designed or corrected, not fitted.
const ASSUMED_GAP: f64 = 5e-4;
/// Own gap from which on a model is too simple, if noise lets it be seen: the limit of the verdict of `fit`.
pub(super) const MAX_OWN_GAP: f64 = MAX_EXCESS_DESCRIBED;
/// PSFs to which richer models are fitted.
const REFIT_PSFS: [usize; 2] = [60, 150];
/// Share of the own gap that a richer model must close to be named.
const MIN_CLOSED: f64 = 0.3;

/// The gap between a lens and the set that it was fitted to.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ModelShare {
    /// Mean gap, less the contribution of noise.
    pub own_gap: f64,
    /// The PSFs on which it was measured.
    pub measured_on: OwnGapSource,
    /// Effects of a richer model of the same set that close a part of it; empty where none was tried, or none does.
    pub freedom: Vec<&'static str>,
    /// Share of the own gap that they close on held-out PSFs.
    pub freedom_closes: f64,
}

/// The PSFs on which the own gap of a lens was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OwnGapSource {
    /// PSFs that the fit of the lens held out, as its profile states.
    HeldOut,
    /// The set that it was fitted to, which was given.
    Design,
    /// None: the lens was designed or corrected, and a small gap is assumed.
    Assumed,
}

impl ModelShare {
    /// Returns the own gap of `lens`, from its profile or from the set `design` that it was fitted to.
    ///
    /// # Errors
    /// A lens whose fit held no PSFs out, without `design`; a `design` that does not suit the lens.
    pub(super) fn of(
        lens: &LensProfile,
        channels: &[PupilChannel],
        design: Option<&ObservationSet>,
    ) -> Result<Self> {
        let (own_gap, measured_on) = if let Some(design) = design {
            (gap(lens, channels, design)?, OwnGapSource::Design)
        } else if let Some(held_out) = &lens.held_out {
            let excess = held_out.adequacy.as_ref().map(|a| a.excess_gap);
            (excess.unwrap_or(held_out.pixel_gap), OwnGapSource::HeldOut)
        } else if lens.provenance.held_nothing_out() {
            return Err(Error::new(
                "held_out",
                "is missing: the fit of the lens held no PSFs out, so what its own model leaves is not known",
                "give the set that it was fitted to, or fit it with PSFs held out",
            )
            .with_kind(ErrorKind::InsufficientData));
        } else {
            (ASSUMED_GAP, OwnGapSource::Assumed)
        };
        Ok(Self {
            own_gap,
            measured_on,
            freedom: Vec::new(),
            freedom_closes: 0.0,
        })
    }

    /// Looks for the freedom that the model lacks: fits the extended model to some PSFs of `set`, and to more if that leaves most of
    /// the gap, as some parts need many PSFs.
    pub(super) fn find_freedom(&mut self, lens: &LensProfile, set: &ObservationSet) {
        for count in REFIT_PSFS {
            self.find_freedom_with(lens, &thinned(set, count));
            if !self.freedom.is_empty() || set.observations.len() <= count {
                return;
            }
        }
    }

    fn find_freedom_with(&mut self, lens: &LensProfile, set: &ObservationSet) {
        let settings = PupilSettings {
            model: PupilModel::Extended,
            ..PupilSettings::default()
        };
        let Ok(fit) = fit_pupil(std::slice::from_ref(set), &settings, &no_progress) else {
            return;
        };
        let Some(richer) = &fit.lens.held_out else {
            return;
        };
        let left = (richer.adequacy.as_ref()).map_or(richer.pixel_gap, |a| a.excess_gap);
        let closes = 1.0 - left.max(0.0) / self.own_gap;
        if closes < MIN_CLOSED {
            return;
        }
        let known = effect_ids(lens);
        let mut freedom = effect_ids(&fit.lens);
        freedom.retain(|id| !known.contains(id));
        (self.freedom, self.freedom_closes) = (freedom, closes);
    }
}

/// Returns the mean gap of `lens` on all tiles of `set`, less noise.
fn gap(lens: &LensProfile, channels: &[PupilChannel], set: &ObservationSet) -> Result<f64> {
    let tiles = TileSet::new(lens, channels, set, &[]).map_err(|e| e.within("design set"))?;
    let tiles: Vec<&TileData> = tiles.tiles.iter().collect();
    let nothing = Hypothesis::nothing(channels.len());
    let gaps = GapProblem::new(&nothing, &tiles, Detail::FULL).gaps(&[]);
    let excess: f64 = gaps.iter().zip(&tiles).map(|(g, t)| g - t.noise).sum();
    Ok((excess / tiles.len() as f64).max(0.0))
}

/// Returns the effects of the model of `lens`, in acting order.
fn effect_ids(lens: &LensProfile) -> Vec<&'static str> {
    let LensDescription::Pupil(channels) = &lens.description else {
        return Vec::new();
    };
    let mut parts: Vec<_> = channels[0].effects.iter().map(|e| e.effect).collect();
    parts.sort_by_key(|effect| effects::acting_position(*effect));
    parts.into_iter().map(|effect| effect.id()).collect()
}

/// Returns `set` with at most `most` of its PSFs, evenly spaced in the list.
fn thinned(set: &ObservationSet, most: usize) -> ObservationSet {
    let count = set.observations.len();
    let step = (count as f64 / most as f64).max(1.0);
    let chosen = (0..count.min(most)).map(|k| (k as f64 * step) as usize);
    ObservationSet {
        observations: chosen.map(|k| set.observations[k].clone()).collect(),
        ..set.clone()
    }
}
