//! What a lens makes of the light on a canvas: one layer where all is at one distance, otherwise one for each rung of
//! the depth layers.

use super::canvas::{Canvas, part_of};
use super::detail::{Found, change};
use super::local::Local;
use super::prior::all_slope_lengths;
use crate::{
    DepthLayers, Edges, LayerSpacing, Operator, Quality, RenderWindow, Scene, VergencePass,
    kernel_reach,
};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use seidel_optics::error::Result;

/// Least light of an even canvas that is made up for at a pixel.
const LEAST_LIGHT: f32 = 0.05;

/// The lens on a canvas, as an operator: the light of every layer is blurred on its own and all is added up. Where
/// depth varies, even light stays even, as if what is hidden behind a blurred edge were like what is seen there.
pub(super) struct View {
    layers: Vec<Layer>,
    size: (usize, usize),
    /// By how much each pixel is multiplied for even light to stay even, where there are layers.
    evened: Option<Vec<f32>>,
}

/// How exactly light is blurred.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Care {
    /// As the adjoint is the adjoint of.
    Quick,
    /// As the renderer of the best quality does.
    Exact,
}

/// What is at nearly one distance.
struct Layer {
    quick: Operator,
    exact: Operator,
    local: Local,
    /// The part of the canvas that its light reaches.
    window: RenderWindow,
    /// How much of each of the window's pixels is in this layer; all if there are no other layers.
    share: Option<Vec<f32>>,
}

impl View {
    /// Of the canvas of `scene`, for a plane of some channel weights; `pass` is the vergence of each of the
    /// canvas's pixels if it varies.
    ///
    /// # Errors
    /// A lens that cannot be drawn.
    pub(super) fn new(scene: &Scene, canvas: &Canvas, weights: &[f64]) -> Result<Self> {
        // Light that leaves the canvas is lost.
        let whole = Scene {
            edges: Edges::Black,
            ..canvas.scene(scene, None)
        };
        let size = canvas.size();
        let VergencePass::PerPixel(pass) = scene.vergence else {
            let layer = Layer::new(&whole, weights, RenderWindow::whole(&whole), None)?;
            return Ok(Self {
                layers: vec![layer],
                size,
                evened: None,
            });
        };
        let pass = canvas.extended(pass);
        let layers = layers(&whole, &pass, weights)?;
        let mut view = Self {
            layers,
            size,
            evened: None,
        };
        let even = view.blurred(&vec![1.0; size.0 * size.1], Care::Exact)?;
        view.evened = Some(
            even.iter()
                .map(|light| light.max(LEAST_LIGHT).recip())
                .collect(),
        );
        Ok(view)
    }

    /// A: the canvas blurred.
    ///
    /// # Errors
    /// None where `plane` is of the canvas's size.
    pub(super) fn blurred(&self, plane: &[f32], care: Care) -> Result<Vec<f32>> {
        let mut out = self.over_layers(|layer| {
            let light = layer.light(self.size.0, plane, 1.0);
            let operator = match care {
                Care::Quick => &layer.quick,
                Care::Exact => &layer.exact,
            };
            Ok(operator.apply(&[light])?.swap_remove(0))
        })?;
        self.even(&mut out);
        Ok(out)
    }

    /// A^T.
    ///
    /// # Errors
    /// None where `plane` is of the canvas's size.
    pub(super) fn adjoint(&self, mut plane: Vec<f32>) -> Result<Vec<f32>> {
        self.even(&mut plane);
        self.over_layers(|layer| {
            let seen = layer.window_of(self.size.0, &plane);
            let mut back = layer.quick.adjoint(&[seen])?.swap_remove(0);
            layer.keep(&mut back, 1.0);
            Ok(back)
        })
    }

    /// By what share even light would not stay even by itself at each sample: most at depth edges, where what is hidden and
    /// what is not are mixed up. None where all is at one depth.
    pub(super) fn uneven(&self) -> Option<Vec<f32>> {
        let evened = self.evened.as_ref()?;
        Some(
            (evened.iter())
                .map(|gain| (gain.recip() - 1.0).abs())
                .collect(),
        )
    }

    /// `plane` filtered by what `filter` makes of local spectra and |D|^2, each pixel by those of its own layer.
    pub(super) fn filtered(
        &self,
        plane: &[f32],
        filter: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        self.over_layers(|layer| {
            let seen = layer.window_of(self.size.0, plane);
            let mut out = layer.local.filtered(&seen, layer.share.as_deref(), &filter);
            layer.keep(&mut out, 1.0);
            Ok(out)
        })
    }

    /// The same, symmetric where `filter` is real.
    pub(super) fn eased(
        &self,
        plane: &[f32],
        filter: impl Fn(Complex<f32>, f32) -> Complex<f32> + Sync,
    ) -> Result<Vec<f32>> {
        self.over_layers(|layer| {
            let light = layer.light(self.size.0, plane, 0.5);
            let mut out = layer
                .local
                .filtered(&light, layer.share.as_deref(), &filter);
            layer.keep(&mut out, 0.5);
            Ok(out)
        })
    }

    /// How a picture should change whose `rest` the lens does not explain, within `deviation` of noise ([`change`]).
    pub(super) fn change(&self, picture: &[f32], rest: &[f32], deviation: f64) -> Result<Vec<f32>> {
        let slopes = all_slope_lengths(picture, self.size.0);
        self.over_layers(|layer| {
            let [picture, rest, slopes] =
                [picture, rest, &slopes].map(|plane| layer.window_of(self.size.0, plane));
            let found = Found {
                picture: &picture,
                rest: &rest,
                slopes: &slopes,
                deviation: deviation as f32,
            };
            let size = (layer.window.width, layer.window.height);
            let mut out = change(&layer.local, size, &found, layer.share.as_deref());
            layer.keep(&mut out, 1.0);
            Ok(out)
        })
    }

    /// Mean over all waves of what `share` makes of local spectra and |D|^2, each pixel by those of its own layer.
    pub(super) fn mean_over_waves(
        &self,
        share: impl Fn(Complex<f32>, f32) -> f32 + Sync,
    ) -> Result<Vec<f32>> {
        self.over_layers(|layer| {
            let mut out = layer.local.mean_over_waves(&share);
            layer.keep(&mut out, 1.0);
            Ok(out)
        })
    }

    /// Median powers of the noise of a canvas, wherever it can be told from the picture ([`Local::quiet_powers`]).
    pub(super) fn quiet_powers(&self, plane: &[f32], passed: f32, count: usize) -> Vec<f64> {
        let of_layer = |layer: &Layer| {
            let seen = layer.window_of(self.size.0, plane);
            layer
                .local
                .quiet_powers(&seen, layer.share.as_deref(), passed, count)
        };
        self.layers.iter().flat_map(of_layer).collect()
    }

    /// The sum of what `one` makes of each layer's window.
    fn over_layers(&self, one: impl Fn(&Layer) -> Result<Vec<f32>> + Sync) -> Result<Vec<f32>> {
        if let [only] = self.layers.as_slice()
            && only.share.is_none()
        {
            return one(only);
        }
        let mut out = vec![0.0; self.size.0 * self.size.1];
        // In order, so that sums do not depend on threads.
        for layer in &self.layers {
            layer.add(self.size.0, &one(layer)?, &mut out);
        }
        Ok(out)
    }

    fn even(&self, plane: &mut [f32]) {
        if let Some(evened) = &self.evened {
            for (sample, gain) in plane.iter_mut().zip(evened) {
                *sample *= gain;
            }
        }
    }
}

/// The layers of a canvas with these vergences.
fn layers(scene: &Scene, pass: &[f32], weights: &[f64]) -> Result<Vec<Layer>> {
    let ends = |(low, high): (f32, f32), v: &f32| (low.min(*v), high.max(*v));
    let (least, most) = pass.iter().fold((f32::INFINITY, f32::NEG_INFINITY), ends);
    let depths = DepthLayers::new(
        scene,
        f64::from(least),
        f64::from(most),
        LayerSpacing::ByBlur,
    );
    let places: Vec<f32> = pass
        .par_iter()
        .map(|vergence| depths.coordinate(f64::from(*vergence)))
        .collect();
    let of_rung = |rung: usize| {
        let share = |place: &f32| (1.0 - (place - depths.coordinate_of(rung)).abs()).max(0.0);
        let shares: Vec<f32> = places.iter().map(share).collect();
        let at_rung = Scene {
            vergence: VergencePass::Constant(depths.vergence(rung)),
            ..*scene
        };
        let lit = lit(&shares, scene.width)?;
        Some(Layer::of_rung(&at_rung, weights, lit, &shares))
    };
    (0..depths.len())
        .into_par_iter()
        .filter_map(of_rung)
        .collect()
}

/// The smallest window that holds all shares above zero.
fn lit(shares: &[f32], width: usize) -> Option<RenderWindow> {
    let (mut left, mut right, mut top, mut bottom) = (usize::MAX, 0, usize::MAX, 0);
    for (y, row) in shares.chunks_exact(width).enumerate() {
        let Some(first) = row.iter().position(|share| *share > 0.0) else {
            continue;
        };
        let last = row.iter().rposition(|share| *share > 0.0).unwrap_or(first);
        (left, right) = (left.min(first), right.max(last + 1));
        (top, bottom) = (top.min(y), y + 1);
    }
    (left < right).then(|| RenderWindow {
        column: left,
        row: top,
        width: right - left,
        height: bottom - top,
    })
}

impl Layer {
    /// The layer of a canvas at one vergence whose light is within `lit`.
    fn of_rung(scene: &Scene, weights: &[f64], lit: RenderWindow, shares: &[f32]) -> Result<Self> {
        let VergencePass::Constant(vergence) = scene.vergence else {
            unreachable!("layers are at one vergence");
        };
        let far = kernel_reach(scene, lit, vergence);
        let column = lit.column.saturating_sub(far.left_px as usize);
        let row = lit.row.saturating_sub(far.up_px as usize);
        let right = (lit.column + lit.width + far.right_px as usize).min(scene.width);
        let bottom = (lit.row + lit.height + far.down_px as usize).min(scene.height);
        let window = RenderWindow {
            column,
            row,
            width: right - column,
            height: bottom - row,
        };
        Self::new(scene, weights, window, Some(shares))
    }

    fn new(
        scene: &Scene,
        weights: &[f64],
        window: RenderWindow,
        shares: Option<&[f32]>,
    ) -> Result<Self> {
        let part = part_of(scene, window);
        let operator = |quality| Operator::new(&part, &[weights.to_vec()], quality);
        let (quick, (exact, local)) = rayon::join(
            || operator(Quality::Draft),
            || rayon::join(|| operator(Quality::Final), || Local::new(&part, weights)),
        );
        Ok(Self {
            quick: quick?,
            exact: exact?,
            local: local?,
            window,
            share: shares.map(|shares| window.cut(scene.width, shares)),
        })
    }

    fn window_of(&self, width: usize, plane: &[f32]) -> Vec<f32> {
        self.window.cut(width, plane)
    }

    /// The window's light that is in this layer, its share to the power `power`.
    fn light(&self, width: usize, plane: &[f32], power: f32) -> Vec<f32> {
        let mut light = self.window_of(width, plane);
        self.keep(&mut light, power);
        light
    }

    fn keep(&self, window: &mut [f32], power: f32) {
        if let Some(share) = &self.share {
            for (sample, share) in window.iter_mut().zip(share) {
                *sample *= if power == 1.0 {
                    *share
                } else {
                    share.powf(power)
                };
            }
        }
    }

    fn add(&self, width: usize, window: &[f32], out: &mut [f32]) {
        let rows = out.chunks_exact_mut(width).skip(self.window.row);
        for (out, row) in rows.zip(window.chunks_exact(self.window.width)) {
            for (out, sample) in out[self.window.column..].iter_mut().zip(row) {
                *out += sample;
            }
        }
    }
}
