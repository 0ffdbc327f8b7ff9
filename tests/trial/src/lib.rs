//! Simulated cases of the gap between a designed lens and the real one, for blind tests of the diagnosis.
//!
//! A [`Case`] is three observation sets with the [`Answer`]: `design`, the bare lens without noise; `real`, the same lens
//! with no, one, two or an unknown cause added, with noise; and `holdout`, other positions of the real lens, almost
//! without noise. [`scores`] rates the diagnoses of many cases.
//!
//! The simulation is independent of the model that it tests: it shares only the vocabulary (fields, tiles, observation
//! sets). Tiles are computed from dense rays (`rays`) or a sampled wave (`waves`) on grids of their own, without the
//! lens model, PSF models and effects of `seidel-optics`.
//!
//! Two simulators draw cases: the pencils of third order below, and `glass`, which traces published lenses exactly.
//!
//! The steps of a tile of pencils: `lens` gives a pencil; `perturb` or `unknown` changes it; `rays` or `waves` fills a fine grid;
//! `sensor` integrates it over pixels.

#![forbid(unsafe_code)]

mod case;
mod draw;
mod expose;
pub mod glass;
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
mod unknown;
mod waves;

#[cfg(test)]
mod tests;

pub use case::{Answer, Case};
pub use draw::draw;
pub use recipe::{EFFECTS, Kind, Recipe, Size, UNKNOWN, recipes};
pub use score::{Bin, Measure, Outcome, Rate, Scores, scores};
