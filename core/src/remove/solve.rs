//! One plane without its blur.

use super::local::Local;
use super::prior::Slopes;
use crate::error::Result;
use crate::render::Operator;
use rustfft::num_complex::Complex;

fn ev(n: &str, d: f64) -> f64 { std::env::var(n).map_or(d, |v| v.parse().unwrap()) }

pub(super) fn solve(
    blurred: &[f32],
    width: usize,
    sigma: f64,
    operator: &Operator,
    local: &Local,
) -> Result<Vec<f32>> {
    let noise = (sigma * sigma).max(1e-12) as f32;
    // Mean square slope of the sharp picture: of the blurred one to begin with, then of what was found.
    let mut found = blurred.to_vec();
    let mut square = (Slopes::of(blurred, width).energy() / blurred.len() as f64 - 4.0 * sigma * sigma).max(1e-8) * 2.0;
    for _ in 0..ev("EM", 2.0) as usize {
        let precision = (2.0 / square) as f32;
        found = local.filtered(blurred, |h, slope| {
            h.conj() / (h.norm_sqr() + noise * (precision * slope + 1e-3))
        });
        square = (Slopes::of(&found, width).energy() / blurred.len() as f64).max(1e-8);
    }
    let rounds = ev("K", 5.0) as usize;
    let mut seen = operator.apply(&[found.clone()])?.swap_remove(0);
    let mut dual: Option<Slopes> = None;
    for _ in 0..rounds {
        let slopes = Slopes::of(&found, width);
        let scale = slopes.mean_length();
        let sharp = (ev("LAM", 1.0) / scale) as f32; // lambda, 1/length
        let stiff = sharp / (ev("T", 1.0) * scale) as f32; // beta
        let with_dual = match &dual { Some(d) => slopes.plus(d, 1.0), None => slopes.plus(&slopes, 0.0) };
        let target = with_dual.shortened(sharp / stiff, scale as f32, ev("P", 1.0) as f32);
        let next_dual = with_dual.plus(&target, -1.0);
        // gradient
        let rest: Vec<f32> = blurred.iter().zip(&seen).map(|(b, s)| (b - s) / noise).collect();
        let mut gradient = operator.adjoint(&[rest])?.swap_remove(0);
        let pull = target.plus(&next_dual, -1.0).plus(&slopes, -1.0).gathered(width);
        // target - dual - slopes, gathered by D^T
        for (g, p) in gradient.iter_mut().zip(&pull) { *g += stiff * p; }
        let step = local.filtered(&gradient, |h, slope| Complex::new(1.0 / (h.norm_sqr() / noise + stiff * slope + 1e-3), 0.0));
        let step_seen = operator.apply(&[step.clone()])?.swap_remove(0);
        let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>();
        let along = dot(&gradient, &step);
        let curved = dot(&step_seen, &step_seen) / f64::from(noise) + f64::from(stiff) * Slopes::of(&step, width).energy();
        let gain = if curved > 0.0 { (along / curved) as f32 } else { 0.0 };
        for (f, s) in found.iter_mut().zip(&step) { *f += gain * s; }
        for (f, s) in seen.iter_mut().zip(&step_seen) { *f += gain * s; }
        if ev("DUAL", 1.0) > 0.0 { dual = Some(next_dual); }
        if std::env::var("VV").is_ok() { eprintln!("gain {gain} along {along:.3e} misfit {:.4}", (dot(&rest_of(blurred, &seen), &rest_of(blurred, &seen)) / blurred.len() as f64).sqrt() / sigma); }
    }
    Ok(found)
}
fn rest_of(a: &[f32], b: &[f32]) -> Vec<f32> { a.iter().zip(b).map(|(a, b)| a - b).collect() }
