//! The data of `seidel demo`: a CG plate with depth, two lenses, PSFs of one of them with noise, and a fault
//! planted in it.

pub mod anamorphic;
pub mod lens;
mod noise;
pub mod observations;
pub mod photograph;
pub mod planted;
mod props;
mod ray;
pub mod scene;
mod slate;
mod street;
