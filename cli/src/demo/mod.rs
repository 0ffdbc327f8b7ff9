//! The data of `seidel demo`: a CG plate with depth, a lens, and PSFs of that lens with noise.

pub mod lens;
mod noise;
pub mod observations;
mod props;
mod ray;
pub mod scene;
mod slate;
mod street;
