//! Simulated cases of the gap between a designed lens and the real one, for blind tests of the diagnosis.
//!
//! A [`Case`] is three observation sets with the [`Answer`]: `design`, the bare lens without noise; `real`, the same lens
//! with up to three causes or an unknown one added, with noise; and `holdout`, other positions of the real lens, almost
//! without noise. Designs that are too rich for the fitted model test whether the diagnosis doubts that model.
//! [`recipes`] lists cases, [`draw`] draws one, and [`scores`] rates the diagnoses of many.
//!
//! The simulation is independent of the model that it tests: it shares only the vocabulary (fields, tiles, observation
//! sets). Tiles are computed from dense rays (`rays`) or a sampled wave (`waves`) on grids of their own, without the
//! lens model, PSF models and effects of `seidel-optics`.
//!
//! The steps of a tile of the third-order simulator: `lens` gives a pencil; `perturb` or `unknown` changes it; `rays` or `waves` fills a fine grid;
//! `sensor` integrates it over pixels.

#![forbid(unsafe_code)]

mod case;
mod conditions;
mod detection;
mod draw;
mod expose;
mod lens;
mod mask;
mod pencil;
mod perturb;
mod perturb_sensor;
mod rays;
mod recipe;
mod rng;
mod score;
mod sensor;
mod third_order;
mod unknown;
mod waves;

#[cfg(test)]
mod tests;

pub use case::{Answer, Case};
pub use conditions::{Conditions, Size};
pub use draw::draw;
pub use recipe::{
    EFFECTS, FitModel, Kind, KindClass, Recipe, Selection, Simulator, UNKNOWN, recipes,
};
pub use score::{Bin, Breakdown, Measure, Outcome, Rate, Rates, Scores, Setting, Strength, scores};
