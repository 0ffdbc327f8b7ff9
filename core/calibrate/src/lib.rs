//! Calibration: a lens fitted to measured point-spread functions (PSFs), its score, and the diagnosis of
//! effects that the fitted model lacks.
//!
//! [`measure`] takes moments from PSF tiles, [`fit`] turns them into a lens profile, [`score`] compares predicted with
//! observed PSFs, [`eval`] makes the tables of the paper, and [`diagnose`] names the effects that close the gap between a
//! profile and a set.
#![forbid(unsafe_code)]

mod depth_json;
pub mod diagnose;
pub mod eval;
pub mod fit;
mod helix;
mod least_squares;
pub mod measure;
mod reference_channel;
pub mod registration;
pub mod score;
mod stage;
