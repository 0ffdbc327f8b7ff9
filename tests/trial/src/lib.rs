//! Sealed cases of the gap between a simulated lens and the real one, on which a diagnosis is tested blind.
//!
//! A case is three observation sets: what the user simulated (`design`, the bare lens without noise), what
//! the camera saw (`real`, the same lens with one, two, none or an unknown cause on top, with noise), and
//! `holdout` (other places of the real lens, nearly without noise), with the answer.
//!
//! This room shares nothing with the model that it tests but the vocabulary: its pictures are made from
//! dense rays (`rays`) or from a sampled wave (`waves`) on grids of its own, never from the crate's
//! lens, PSF models or effects.
//!
//! Way of a tile: `lens` -> pencil -> `perturb` or `unknown` change it -> `rays` or `waves` ->
//! fine grid -> `sensor` -> tile.

#![forbid(unsafe_code)]

mod case;
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
mod unknown;
mod waves;

#[cfg(test)]
mod tests;

pub use case::{Answer, Case};
pub use draw::draw;
pub use recipe::{EFFECTS, Kind, Recipe, Size, UNKNOWN, recipes};
pub use score::{Bin, Measure, Outcome, Rate, Scores, scores};
