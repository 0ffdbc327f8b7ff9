//! The data of `seidel demo`: a CG plate with depth, two lenses, and PSFs of one of them with noise.

pub mod anamorphic;
pub mod lens;
mod noise;
pub mod observations;
mod props;
mod ray;
pub mod scene;
mod slate;
mod street;
