//! A hypothesis: the effects that the lens may lack, and their free parameters.

use super::registration::ReferencePupil;
use super::tiles::TileData;
use seidel_optics::effects::{self, Effect, ScenePoint, Scope, SearchStart};
use seidel_optics::lens::LocalPupil;
use seidel_optics::lens::VergenceSeries;
use seidel_optics::profile::{ProfileEffect, PupilChannel};

/// The channels of a lens.
#[derive(Debug, Clone)]
pub(super) struct LensChannels {
    /// Whether the observations show the channel. Parameters of others are not free.
    observed: Vec<bool>,
    /// Index of the observed channel from which differences count: that of middle wavelength where it is observed.
    reference: usize,
}

impl LensChannels {
    /// Creates the channels of a lens with `count` of them, of which `tiles` show some. `reference` is that of middle wavelength.
    pub(super) fn of(tiles: &[TileData], count: usize, reference: usize) -> Self {
        let mut observed = vec![false; count];
        tiles.iter().for_each(|tile| observed[tile.of_lens] = true);
        let first = observed.iter().position(|is_observed| *is_observed);
        let reference = match observed[reference] {
            true => reference,
            false => first.unwrap_or(reference),
        };
        Self {
            observed,
            reference,
        }
    }

    /// Returns the index of the channel from which differences count.
    pub(super) fn reference(&self) -> usize {
        self.reference
    }
}

/// Effects with their free parameters.
#[derive(Clone)]
pub(super) struct Hypothesis {
    /// Effects in acting order, each with its search start.
    pub(super) parts: Vec<(&'static dyn Effect, SearchStart)>,
    pub(super) slots: Vec<Slot>,
    /// Whether the observations show each channel of the lens.
    observed: Vec<bool>,
}

/// One free parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slot {
    pub(super) part: usize,
    pub(super) parameter: usize,
    /// Channel; `None` if all channels share the parameter.
    pub(super) channel: Option<usize>,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) step: f64,
}

impl Hypothesis {
    /// Creates the null hypothesis for a lens of `channels` channels: no effect is missing.
    pub(super) fn nothing(channels: usize) -> Self {
        Self {
            parts: Vec::new(),
            slots: Vec::new(),
            observed: vec![true; channels],
        }
    }

    /// Creates the hypothesis of `parts`.
    pub(super) fn new(
        mut parts: Vec<(&'static dyn Effect, SearchStart)>,
        channels: &LensChannels,
    ) -> Self {
        parts.sort_by_key(|(effect, _)| rank(*effect));
        let observed = || {
            let all = channels.observed.iter().enumerate();
            all.filter(|(_, is_observed)| **is_observed).map(|(c, _)| c)
        };
        let mut slots = Vec::new();
        for (part, (effect, start)) in parts.iter().enumerate() {
            for (parameter, p) in effect.parameters().iter().enumerate() {
                if !start.free[parameter] {
                    continue;
                }
                let mut push = |channel| {
                    slots.push(Slot {
                        part,
                        parameter,
                        channel,
                        least: p.least,
                        most: p.most,
                        step: p.step,
                    });
                };
                match p.scope {
                    Scope::Lens => push(None),
                    Scope::Channel => observed().for_each(|c| push(Some(c))),
                    Scope::Difference => observed()
                        .filter(|c| *c != channels.reference)
                        .for_each(|c| push(Some(c))),
                }
            }
        }
        Self {
            parts,
            slots,
            observed: channels.observed.clone(),
        }
    }

    /// Returns the starting values of the free parameters.
    pub(super) fn start(&self) -> Vec<f64> {
        self.slots
            .iter()
            .map(|slot| self.parts[slot.part].1.values[slot.parameter])
            .collect()
    }

    /// Returns the values at which the effects vanish.
    pub(super) fn neutral(&self) -> Vec<f64> {
        let of = |slot: &Slot| self.parts[slot.part].0.parameters()[slot.parameter].neutral;
        self.slots.iter().map(of).collect()
    }

    /// Returns the identifiers of the effects.
    pub(super) fn ids(&self) -> Vec<&'static str> {
        self.parts.iter().map(|(effect, _)| effect.id()).collect()
    }

    /// Returns the parameter values of every effect in `channel`.
    pub(super) fn values(&self, theta: &[f64], channel: usize) -> Vec<Vec<f64>> {
        let mut values: Vec<Vec<f64>> = self
            .parts
            .iter()
            .map(|(effect, start)| {
                // Differences between channels are zero where they are not free, and nothing is known of channels that are not observed.
                let own = effect.parameters().iter().zip(&start.values);
                own.map(|(p, v)| match p.scope {
                    Scope::Difference => p.neutral,
                    Scope::Channel if !self.observed[channel] => p.neutral,
                    _ => *v,
                })
                .collect()
            })
            .collect();
        for (slot, value) in self.slots.iter().zip(theta) {
            if slot.channel.is_none_or(|c| c == channel) {
                values[slot.part][slot.parameter] = *value;
            }
        }
        values
    }

    /// Returns whether free parameter `slot` affects `channel`.
    pub(super) fn concerns(&self, slot: usize, channel: usize) -> bool {
        self.slots[slot].channel.is_none_or(|c| c == channel)
    }

    /// Returns the pupil of `tile` with the effects applied, and the shift of the chief ray, px.
    pub(super) fn act(&self, values: &[Vec<f64>], tile: &TileData) -> (LocalPupil, [f64; 2]) {
        self.act_at(values, tile.point, tile.pupil.clone())
    }

    fn act_at(
        &self,
        values: &[Vec<f64>],
        point: ScenePoint,
        mut pupil: LocalPupil,
    ) -> (LocalPupil, [f64; 2]) {
        let mut moved = [0.0; 2];
        for ((effect, _), values) in self.parts.iter().zip(values) {
            effect.apply(values, point, &mut pupil);
            let shift = effect.chief_ray(values, point);
            moved = [moved[0] + shift[0], moved[1] + shift[1]];
        }
        (pupil, moved)
    }

    /// Returns the shift of the centroid of the reference channel by the effects, px. `values` are those of any channel.
    pub(super) fn reference_shift(
        &self,
        values: &[Vec<f64>],
        reference: &ReferencePupil,
    ) -> [f64; 2] {
        let own = self.parts.iter().zip(values).map(|((effect, _), values)| {
            let each = effect.parameters().iter().zip(values);
            let each = each.map(|(p, value)| match p.scope {
                Scope::Difference => p.neutral,
                _ => *value,
            });
            each.collect()
        });
        let own: Vec<Vec<f64>> = own.collect();
        let (pupil, moved) = self.act_at(&own, reference.point, reference.pupil.clone());
        let centroid = pupil.centroid();
        [0, 1].map(|axis| moved[axis] + centroid[axis] - reference.centroid[axis])
    }

    /// Returns `channels` with the effects at `theta` added.
    pub(super) fn added_to(
        &self,
        channels: &[PupilChannel],
        theta: &[f64],
        sigma: &[f64],
    ) -> Vec<PupilChannel> {
        let of_channel = |(index, channel): (usize, &PupilChannel)| {
            let (values, errors) = (self.values(theta, index), self.errors(sigma, index));
            let mut added = channel.added.clone();
            for (((effect, _), values), errors) in self.parts.iter().zip(values).zip(errors) {
                added.retain(|c| c.effect.id() != effect.id());
                added.push(ProfileEffect {
                    effect: *effect,
                    values: values
                        .into_iter()
                        .zip(errors)
                        .map(|(value, error)| VergenceSeries {
                            coefficients: vec![value],
                            sigma: vec![error],
                            remainders: Vec::new(),
                        })
                        .collect(),
                });
            }
            added.sort_by_key(|c| rank(c.effect));
            PupilChannel {
                added,
                ..channel.clone()
            }
        };
        channels.iter().enumerate().map(of_channel).collect()
    }

    fn errors(&self, sigma: &[f64], channel: usize) -> Vec<Vec<f64>> {
        let none = self.parts.iter();
        let mut errors: Vec<Vec<f64>> =
            none.map(|(e, _)| vec![0.0; e.parameters().len()]).collect();
        for (slot, error) in self.slots.iter().zip(sigma) {
            if slot.channel.is_none_or(|c| c == channel) {
                errors[slot.part][slot.parameter] = *error;
            }
        }
        errors
    }

    /// Returns the number of channels.
    pub(super) fn channels(&self) -> usize {
        self.observed.len()
    }
}

/// Returns the position of `effect` in acting order.
fn rank(effect: &dyn Effect) -> usize {
    let mut all = effects::ALL.iter();
    all.position(|e| e.id() == effect.id())
        .unwrap_or(usize::MAX)
}
