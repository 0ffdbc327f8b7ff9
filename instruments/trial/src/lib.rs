//! Simulated cases of the gap between a designed lens and the real one, for blind tests of the diagnosis.
//!
//! A [`Case`] is three observation sets with the [`Answer`]: `design`, the bare lens without noise; `real`, the same lens
//! with up to three causes or an unknown one added, with noise; and `holdout`, other positions of the real lens, almost
//! without noise. Designs that are too rich for the fitted model test whether the diagnosis doubts that model.
//! [`recipes`] lists cases, [`draw`] draws one, [`draw_further`] adds a capture that a diagnosis advises, [`Mistake`] plants a mistake
//! in keeping books, and [`scores`] rates the diagnoses of many.
//!
//! The simulation is independent of the model that it tests: it shares only the vocabulary (fields, tiles, observation
//! sets). Tiles are computed from dense rays (`rays`) or a sampled wave (`waves`) on grids of their own, without the
//! lens model, PSF models and effects of `seidel-optics`.
//!
//! Two simulators draw lenses, `third_order` and `glass`; `simulated` is their common interface. `plan` chooses a lens and
//! the strengths of its causes, and `sets` captures the three sets.
//!
//! The steps of a tile of the third-order simulator: `lens` gives a pencil; `perturb` or `unknown` changes it; `rays` or
//! `waves` fills a fine grid; `sensor` integrates it over pixels. The `glass` module names those of the other.

#![forbid(unsafe_code)]

mod case;
mod change;
mod conditions;
mod detection;
mod draw;
mod expose;
mod further_capture;
mod glass;
mod lens;
mod mask;
mod mistakes;
mod pencil;
mod perturb;
mod perturb_sensor;
mod plan;
mod rays;
mod recipe;
mod rng;
mod score;
mod sensor;
mod sets;
mod simulated;
mod third_order;
mod unknown;
mod waves;

#[cfg(test)]
mod tests;

pub use case::{Answer, Case, FurtherSets};
pub use conditions::{Conditions, Size};
pub use draw::{draw, draw_further};
pub use further_capture::FurtherCapture;
pub use mistakes::{Mistake, PlantedMistake};
pub use recipe::{FitModel, Kind, KindClass, Recipe, Selection, Simulator, recipes};
pub use score::{Bin, Breakdown, Measure, Outcome, Rate, Rates, Scores, Setting, Strength, scores};
