//! The parts that the extended model can gain: effects, with their free parameters and the values at which fits start.

use super::parameters::{ModelStructure, PolynomialSpec, Quantity};
use seidel_optics::effects::{self, Effect, FitPart};

/// Minimum number of fitted tiles per free parameter of a part.
const TILES_PER_PARAMETER: f64 = 1.5;

/// A part of the extended model: an effect with the parameters that a fit may change.
#[derive(Clone, Copy)]
pub(in crate::fit) struct Part {
    pub(in crate::fit) effect: &'static dyn Effect,
    pub(in crate::fit) fit: &'static FitPart,
}

/// Returns all parts, in acting order.
pub(in crate::fit) fn all() -> impl Iterator<Item = Part> {
    let parts = effects::ALL.iter().map(|effect| Part::of(*effect));
    parts.filter(|part| part.fit.used > 0)
}

impl Part {
    /// Returns `effect` as a part.
    pub(in crate::fit) fn of(effect: &'static dyn Effect) -> Self {
        let fit = &effect.description().fit;
        Self { effect, fit }
    }

    /// Returns `structure` with this part.
    pub(in crate::fit) fn added_to(&self, structure: &ModelStructure) -> ModelStructure {
        let mut extended = structure.clone();
        let which = extended.effects.len();
        extended.effects.push(self.effect);
        for k in 0..self.fit.used {
            let degree = usize::from(k < self.fit.linear);
            extended.polynomials.push(PolynomialSpec {
                quantity: Quantity::Effect(which, k),
                degree,
                least_degree: degree,
                shared: self.fit.shared,
                fixed: self.fit.fixed.contains(&k) || self.is_described(k, structure),
            });
        }
        extended
    }

    /// Returns the number of free parameters.
    pub(in crate::fit) fn free(&self) -> usize {
        self.fit.used - self.fit.fixed.len()
    }

    /// Returns the number of free parameters in all `channels`.
    pub(in crate::fit) fn parameters(&self, channels: usize) -> usize {
        self.free() * if self.fit.shared { 1 } else { channels }
    }

    /// Returns the number of tiles that the part needs.
    pub(in crate::fit) fn least_tiles(&self) -> usize {
        (TILES_PER_PARAMETER * self.free() as f64).ceil() as usize
    }

    pub(in crate::fit) fn is_determined_by(&self, tiles: usize) -> bool {
        tiles >= self.least_tiles()
    }

    /// Returns whether an effect of `structure` describes what parameter `k` does.
    fn is_described(&self, k: usize, structure: &ModelStructure) -> bool {
        let mut by = self.fit.described_by.iter();
        by.any(|(of, effect)| *of == k && Self::of(*effect).is_in(structure))
    }

    /// Returns whether an effect of `structure` describes all that this part does.
    pub(in crate::fit) fn is_contained_in(&self, structure: &ModelStructure) -> bool {
        let mut effects = structure.effects.iter();
        effects.any(|effect| {
            let by = effect.description().fit.described_by;
            by.iter().any(|(_, other)| other.id() == self.effect.id())
        })
    }

    pub(in crate::fit) fn is_in(&self, structure: &ModelStructure) -> bool {
        let mut effects = structure.effects.iter();
        effects.any(|effect| effect.id() == self.effect.id())
    }
}
