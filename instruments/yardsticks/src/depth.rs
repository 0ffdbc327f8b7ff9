//! Blur by depth beside each pixel's own disc.

use std::f64::consts::TAU;

use rayon::prelude::*;
use seidel_core::{Depth, DepthPass, Image, Lens, Plate, Result, Settings, apply, no_progress};

use crate::Extent;
use crate::page::{Case, Job};
use crate::picture::Picture;

/// Points of the pupil that the reference averages over.
const PUPIL_POINTS: usize = 900;
/// Radii of blur of background and card, px; a card in focus has 0. Negative radii lie behind the focus.
const RADII_PX: [[f64; 2]; 8] = [
    [5.0, 5.0],
    [-3.0, 0.0],
    [-10.0, 0.0],
    [-30.0, 0.0],
    [0.0, 3.0],
    [0.0, 10.0],
    [0.0, 30.0],
    [-10.0, 10.0],
];
const SIDE: usize = 256;
/// Side of the card, px.
const CARD: usize = 110;

/// A lens without aberrations, focused on 1 cm, whose disc has a radius of one pixel for each 1/m from there.
const THIN_LENS: &str = r#"{"format": "seidel-lens", "version": 1, "kind": "pupil", "image_size": [256, 256],
    "optical_axis": [128.0, 128.0], "channels": [{"name": "Y", "measured_vergence_per_m": [0.0, 200.0],
    "alpha": {"coefficients": [-100.0, 1.0], "sigma": [0.0, 0.0]}, "beta": {"coefficients": [0.0], "sigma": [0.0]},
    "gamma": {"coefficients": [0.0], "sigma": [0.0]}, "delta": {"coefficients": [0.0], "sigma": [0.0]},
    "phi": {"coefficients": [0.0], "sigma": [0.0]}, "blur_variance_px2": {"coefficients": [0.0], "sigma": [0.0]},
    "magnification": {"coefficients": [0.0], "sigma": [0.0]}, "distortion": {"coefficients": [0.0], "sigma": [0.0]}, "effects": []}],
    "provenance": {"program": "", "sources": [], "settings": ""}}"#;
/// Vergence of the focus of [`THIN_LENS`], 1/m.
const FOCUS_PER_M: f64 = 100.0;

/// Measures all cases.
pub(crate) fn job(extent: Extent) -> Result<Job> {
    let lens = Lens::from_json(THIN_LENS)?;
    let radii = if extent == Extent::Quick {
        &RADII_PX[..2]
    } else {
        &RADII_PX[..]
    };
    let cases: Result<Vec<Case>> = radii
        .par_iter()
        .map(|&[far, near]| case(&lens, far, near))
        .collect();
    Ok(Job {
        title: "Blur by depth",
        text: format!(
            "Peak signal-to-noise ratio of `seidel apply` with a depth pass: a card of {CARD} x {CARD} px before a background of \
             {SIDE} x {SIDE} px, both of dead leaves, in front of (+) or behind (-) the focus. The reference is the mean of sharp \
             pictures from {PUPIL_POINTS} points of the pupil, in each of which card and background are shifted by their parallax; \
             it sees what the card hides. The rival gives each pixel the mean over its own disc."
        ),
        rivals: &["own disc", "nothing"],
        cases: cases?,
    })
}

/// Card or background: what covers a pixel, and its light.
struct Layer<'a> {
    picture: &'a Picture,
    /// Columns and rows that are covered.
    covers: [f64; 2],
    radius_px: f64,
}

impl Layer<'_> {
    /// Returns light and coverage at `at`, by bilinear interpolation of samples at the centres of pixels.
    fn at(&self, at: [f64; 2]) -> [f64; 2] {
        let side = self.picture.side as isize;
        let (first, share) = (at.map(f64::floor), at.map(|x| x - x.floor()));
        let mut sum = [0.0; 2];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let weight = |share: f64, d: isize| if d == 0 { 1.0 - share } else { share };
            let weight = weight(share[0], dx) * weight(share[1], dy);
            let [x, y] = [first[0] as isize + dx, first[1] as isize + dy];
            let covered = [x, y]
                .iter()
                .all(|&x| (self.covers[0]..self.covers[1]).contains(&(x as f64)));
            let [x, y] = [x, y].map(|x| x.clamp(0, side - 1) as usize);
            if covered {
                sum[0] += weight * f64::from(self.picture.samples[y * self.picture.side + x]);
                sum[1] += weight;
            }
        }
        sum
    }
}

fn case(lens: &Lens, far: f64, near: f64) -> Result<Case> {
    let first = (SIDE - CARD) as f64 / 2.0;
    let pictures = [1, 2].map(|seed| Picture::dead_leaves(SIDE, seed));
    let back = Layer {
        picture: &pictures[0],
        covers: [f64::NEG_INFINITY, f64::INFINITY],
        radius_px: far,
    };
    let card = Layer {
        picture: &pictures[1],
        covers: [first, first + CARD as f64],
        radius_px: near,
    };
    // Sharp, as through a pinhole.
    let sharp = mean_over_pupil(&back, &card, &[[0.0; 2]]);
    let truth = mean_over_pupil(&back, &card, &pupil());
    let on_card = |k: usize| card.at([(k % SIDE) as f64, (k / SIDE) as f64])[1] > 0.5;
    let radius = |k: usize| if on_card(k) { near } else { far };
    let metres = (0..SIDE * SIDE)
        .map(|k| (1.0 / (FOCUS_PER_M + radius(k))) as f32)
        .collect();
    let image = Image::from_interleaved(SIDE, SIDE, 1, &sharp.samples)?;
    let plate = Plate::new(image).with_depth(Depth::Pass(DepthPass::metres(metres)));
    let ours = apply(lens, &plate, &Settings::default(), &no_progress)?;
    let ours = Picture {
        side: SIDE,
        samples: ours.colours[0].clone(),
    };
    let border = far.abs().max(near.abs()).ceil() as usize;
    Ok(Case {
        name: format!("background {far:+} px, card {near:+} px"),
        ours: ours.psnr(&truth, border),
        rivals: vec![
            own_discs(&sharp, radius).psnr(&truth, border),
            sharp.psnr(&truth, border),
        ],
    })
}

/// Returns points that fill the unit disc evenly, on a spiral by the golden angle (Vogel 1979).
fn pupil() -> Vec<[f64; 2]> {
    let golden = TAU * (1.0 - 2.0 / (1.0 + 5.0_f64.sqrt()));
    let point = |k: usize| {
        let (sin, cos) = (golden * k as f64).sin_cos();
        let radius = ((k as f64 + 0.5) / PUPIL_POINTS as f64).sqrt();
        [radius * cos, radius * sin]
    };
    (0..PUPIL_POINTS).map(point).collect()
}

/// Returns the mean of the pictures that the `points` of the pupil see.
fn mean_over_pupil(back: &Layer, card: &Layer, points: &[[f64; 2]]) -> Picture {
    let sample = |k: usize| {
        let pixel = [(k % SIDE) as f64, (k / SIDE) as f64];
        let through = |[x, y]: &[f64; 2]| {
            let seen = |layer: &Layer| {
                layer.at([
                    pixel[0] + layer.radius_px * x,
                    pixel[1] + layer.radius_px * y,
                ])
            };
            let (behind, [light, cover]) = (seen(back)[0], seen(card));
            light + (1.0 - cover) * behind
        };
        (points.iter().map(through).sum::<f64>() / points.len() as f64) as f32
    };
    let samples = (0..SIDE * SIDE).into_par_iter().map(sample).collect();
    Picture {
        side: SIDE,
        samples,
    }
}

/// Returns the mean over each pixel's own disc, of `radius` px.
fn own_discs(sharp: &Picture, radius: impl Fn(usize) -> f64 + Sync) -> Picture {
    let last = SIDE as isize - 1;
    let sample = |k: usize| {
        let (x, y) = ((k % SIDE) as isize, (k / SIDE) as isize);
        let radius = radius(k).abs();
        let reach = radius.ceil() as isize;
        let (mut sum, mut weights) = (0.0, 0.0);
        for (dx, dy) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dx, dy))) {
            // The edge of the disc, soft over a pixel.
            let weight = (radius + 0.5 - (dx as f64).hypot(dy as f64)).clamp(0.0, 1.0);
            let at = (y + dy).clamp(0, last) * SIDE as isize + (x + dx).clamp(0, last);
            sum += weight * f64::from(sharp.samples[at as usize]);
            weights += weight;
        }
        (sum / weights) as f32
    };
    let samples = (0..SIDE * SIDE).into_par_iter().map(sample).collect();
    Picture {
        side: SIDE,
        samples,
    }
}
