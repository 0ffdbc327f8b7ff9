//! What the program carries to show itself: a CG plate with depth and a lens to blur it with.

mod lamps;
pub mod lens;
mod noise;
pub mod observations;
mod patterns;
mod props;
pub mod scene;
mod street;
mod vector;
