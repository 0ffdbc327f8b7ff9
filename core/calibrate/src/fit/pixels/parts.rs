//! The parts that the extended model can gain: effects, with their free parameters and the values at which fits start.

use std::f64::consts::TAU;

use super::parameters::{ModelStructure, PolynomialSpec, Quantity};
use seidel_optics::effects::{self, Effect};

/// Minimum number of fitted tiles per free parameter of a part.
const TILES_PER_PARAMETER: f64 = 1.5;

/// A part of the extended model: an effect with the parameters that a fit may change.
pub(in crate::fit) struct Part {
    pub(in crate::fit) effect: &'static dyn Effect,
    /// Number of the effect's parameters, from the first, that take part; the others stay neutral.
    pub(in crate::fit) used: usize,
    /// Those of them that stay at their start.
    pub(in crate::fit) fixed: &'static [usize],
    /// Whether all channels share them.
    pub(in crate::fit) shared: bool,
    /// Number of parameters that are at least linear in vergence, the first ones.
    pub(in crate::fit) linear: usize,
    /// Returns values of the used parameters at which fits start.
    pub(in crate::fit) starts: fn() -> Vec<Vec<f64>>,
    /// Decrease of the mean log misfit of held-out zones that the part must reach.
    pub(in crate::fit) worth: f64,
}

/// Fifth-order aberrations.
pub(in crate::fit) static HIGHER_ORDER: Part = Part {
    effect: &effects::HigherOrder,
    used: 8,
    fixed: &[],
    shared: false,
    linear: 0,
    starts: || vec![vec![0.0; 8]],
    worth: 0.0,
};

/// Seventh-order aberrations.
pub(in crate::fit) static SEVENTH_ORDER: Part = Part {
    effect: &effects::SeventhOrder,
    used: 13,
    fixed: &[],
    shared: false,
    linear: 0,
    starts: || vec![vec![0.0; 13]],
    worth: 0.1,
};

/// Two planes of symmetry: anamorphic lenses.
pub(in crate::fit) static DOUBLE_PLANE: Part = Part {
    effect: &effects::DoublePlane,
    used: effects::DoublePlane::WAVEFRONT_TERMS,
    fixed: &[],
    shared: false,
    // The difference of defocus between the planes follows the object's distance.
    linear: 1,
    starts: || vec![vec![0.0; effects::DoublePlane::WAVEFRONT_TERMS]],
    worth: 0.5,
};

/// Two stops that clip oblique pencils.
pub(in crate::fit) static VIGNETTING: Part = Part {
    effect: &effects::Vignetting,
    used: 4,
    fixed: &[],
    shared: true,
    linear: 0,
    starts: stops,
    worth: 0.01,
};

/// The parts that are tried, those with fewer parameters first.
pub(in crate::fit) static PARTS: [&Part; 6] = [
    &VIGNETTING,
    // The number of blades is counted, and the distance of the corners is one with the size of the pupil.
    &Part {
        effect: &effects::AperturePolygon,
        used: 4,
        fixed: &[0, 2],
        shared: true,
        linear: 0,
        starts: irises,
        worth: 0.1,
    },
    // Without the displacement of the image, which tiles do not show.
    &Part {
        effect: &effects::Decentre,
        used: 8,
        fixed: &[],
        shared: false,
        linear: 0,
        starts: || vec![vec![0.0; 8]],
        worth: 0.1,
    },
    &Part {
        effect: &effects::Apodisation,
        used: 4,
        fixed: &[],
        shared: true,
        linear: 0,
        // A faint filter does not show its centre.
        starts: || vec![vec![0.4, 0.0, 0.0, 0.0], vec![-0.3, 0.0, 0.0, 0.0]],
        worth: 0.1,
    },
    &SEVENTH_ORDER,
    &DOUBLE_PLANE,
];

impl Part {
    /// Returns `structure` with this part.
    pub(in crate::fit) fn added_to(&self, structure: &ModelStructure) -> ModelStructure {
        let mut extended = structure.clone();
        let which = extended.effects.len();
        extended.effects.push(self.effect);
        for k in 0..self.used {
            let degree = usize::from(k < self.linear);
            extended.polynomials.push(PolynomialSpec {
                quantity: Quantity::Effect(which, k),
                degree,
                least_degree: degree,
                shared: self.shared,
                fixed: self.fixed.contains(&k),
            });
        }
        extended
    }

    /// Returns the number of free parameters.
    pub(in crate::fit) fn free(&self) -> usize {
        self.used - self.fixed.len()
    }

    /// Returns the number of free parameters in all `channels`.
    pub(in crate::fit) fn parameters(&self, channels: usize) -> usize {
        self.free() * if self.shared { 1 } else { channels }
    }

    /// Returns the number of tiles that the part needs.
    pub(in crate::fit) fn least_tiles(&self) -> usize {
        (TILES_PER_PARAMETER * self.free() as f64).ceil() as usize
    }

    pub(in crate::fit) fn is_determined_by(&self, tiles: usize) -> bool {
        tiles >= self.least_tiles()
    }

    pub(in crate::fit) fn is_in(&self, structure: &ModelStructure) -> bool {
        let mut effects = structure.effects.iter();
        effects.any(|effect| effect.id() == self.effect.id())
    }
}

/// Returns initial stops: radius and shift of a front and a rear one. One alone clips half way to the corner; two begin to
/// clip on the axis, half way to the corner, or near it.
fn stops() -> Vec<Vec<f64>> {
    let values = effects::neutral(&effects::Vignetting);
    let neutral = [values[0], values[1]];
    let one = [[[1.05, 0.3], neutral], [neutral, [1.05, -0.3]]];
    let two = [[1.0, 0.15], [1.0, 0.5], [1.4, 0.6], [1.8, 0.9]];
    let two = two.map(|[radius, shift]| [[radius, shift], [radius, -shift]]);
    one.iter().chain(&two).map(|stops| stops.concat()).collect()
}

/// Returns initial irises: blades, rotation of a corner, distance of the corners, roundness. Their discs are about as large
/// as round ones.
fn irises() -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for blades in 5..=11 {
        let blades = f64::from(blades);
        let straight = (3.0 / (2.0 + (TAU / blades).cos())).sqrt();
        for roundness in [0.2, 0.7] {
            for quarter in 0..4 {
                let rotation = 90.0 / blades * f64::from(quarter);
                let reach = 1.0 + (1.0 - roundness) * (straight - 1.0);
                all.push(vec![blades, rotation, reach, roundness]);
            }
        }
    }
    all
}
