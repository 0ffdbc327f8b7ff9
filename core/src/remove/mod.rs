//! Taking a lens's blur off plates.

mod local;
mod noise;
mod prior;
mod solve;

use crate::error::Result;
use crate::render::{Operator, Quality, Scene, VergencePass};

pub fn remove_plane(scene: &Scene, weights: &[f64], blurred: &[f32]) -> Result<(Vec<f32>, f64)> {
    let VergencePass::Constant(v) = scene.vergence else { unreachable!() };
    let operator = Operator::new(scene, &[weights.to_vec()], Quality::Final)?;
    let local = local::Local::new(scene, weights, v)?;
    let sigma = noise::deviation(blurred, scene.width, |_| true);
    Ok((solve::solve(blurred, scene.width, sigma, &operator, &local)?, sigma))
}
