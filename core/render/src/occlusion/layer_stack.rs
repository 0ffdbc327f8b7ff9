//! The layers of a plate, blurred and composited band by band.

use super::composite::{BlurredLayer, Compositor, SharpMattes};
use super::depth_layers::DepthLayers;
use super::layer_samples::{self, LayerSamples, LayerSource};
use super::layer_waves::{CropProgress, LayerCrop, waves};
use crate::{
    Edges, LayerContext, Plane, RenderStatistics, RenderWindow, Rendered, Renderer, Scene,
};
use rayon::prelude::*;
use seidel_optics::error::Result;

/// Least number of pixels of a band: an HD frame is one band.
const BAND_PIXELS: usize = 1 << 21;
/// Least height of a band in reaches of the blur: each band blurs the rows within one reach of it again.
const BAND_REACHES: usize = 8;

/// The depth layers of a plate.
pub(super) struct LayerStack<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) layers: &'a DepthLayers,
    pub(super) source: &'a LayerSource<'a>,
    pub(super) mattes: &'a SharpMattes<'a>,
    pub(super) blur: LayerBlur<'a>,
}

impl LayerStack<'_> {
    /// Renders a window of the plate in bands, so that what a composite keeps does not grow with the frame.
    pub(super) fn render(
        &self,
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<(Vec<Vec<f32>>, RenderStatistics)> {
        let lit = self.source.lit(self.scene, self.layers);
        let size = window.width * window.height;
        let mut planes = vec![Vec::with_capacity(size); self.blur.planes.len()];
        let mut statistics = RenderStatistics::default();
        let (_, reach) = self.scene.reach_px();
        let bands = bands(window, reach);
        let share = 1.0 / bands.len() as f64;
        for (index, band) in bands.into_iter().enumerate() {
            let progress = |done: f64| progress((index as f64 + done) * share);
            let (of_band, counts) = self.render_band(band, &lit, &progress)?;
            statistics.layers = statistics.layers.max(counts.layers);
            statistics.add_part(&counts);
            for (out, plane) in planes.iter_mut().zip(of_band) {
                out.extend_from_slice(&plane);
            }
        }
        Ok((planes, statistics))
    }

    fn render_band(
        &self,
        band: RenderWindow,
        lit: &[Vec<bool>],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<(Vec<Vec<f32>>, RenderStatistics)> {
        let (layers, mixes) = (self.layers, &self.blur.mixes);
        let mut composite = Compositor::new(
            band,
            self.scene.width,
            mixes.presence_of.clone(),
            mixes.mix_of.clone(),
            self.mattes,
        );
        let crops = layer_samples::crops(self.scene, lit, layers, band);
        let mut statistics = RenderStatistics {
            layers: crops.iter().filter(|crops| !crops.is_empty()).count(),
            ..RenderStatistics::default()
        };
        let all: Vec<LayerCrop> = (0..crops.len())
            .rev()
            .flat_map(|layer| crops[layer].iter().map(move |crop| (layer, *crop)))
            .map(|(layer, crop)| LayerCrop { layer, crop })
            .collect();
        let progress_of_crops = CropProgress::new(all.len(), progress);
        let count = self.blur.planes.len();
        for wave in waves(&all, self.scene.pixel_count()) {
            let blurred: Vec<Rendered> = all[wave.clone()]
                .par_iter()
                .enumerate()
                .map(|(index, part)| {
                    let vergence = layers.vergence(part.layer);
                    let samples = (self.source).layer(layers.coordinate_of(part.layer), part.crop);
                    let cropped = layer_samples::cropped_scene(self.scene, part.crop, vergence);
                    let progress = |share| progress_of_crops.set(wave.start + index, share);
                    self.blur.blur(&cropped, &samples, &progress)
                })
                .collect::<Result<_>>()?;
            for (part, blurred) in all[wave].iter().zip(blurred) {
                statistics.add_part(&blurred.statistics);
                composite.add(
                    &BlurredLayer {
                        layer: part.layer,
                        coordinate: layers.coordinate_of(part.layer),
                        vergence: layers.vergence(part.layer),
                        crop: part.crop,
                        planes: &blurred.planes[..count],
                        presence: &blurred.planes[count..],
                    },
                    self.mattes,
                );
            }
        }
        Ok((composite.finish(), statistics))
    }
}

/// Cuts a window into bands of equal height, where blur reaches `reach_px` along columns.
fn bands(window: RenderWindow, reach_px: f64) -> Vec<RenderWindow> {
    let least = BAND_PIXELS.div_ceil(window.width.max(1));
    let least = least.max(BAND_REACHES * reach_px.ceil() as usize);
    let count = (window.height / least).max(1);
    let height = window.height.div_ceil(count).max(1);
    let first_rows = (0..window.height.max(1)).step_by(height);
    first_rows
        .map(|row| RenderWindow {
            row: window.row + row,
            height: height.min(window.height - row),
            ..window
        })
        .collect()
}

/// The inner renderer with what all layers of a plate share.
pub(super) struct LayerBlur<'a> {
    inner: &'a dyn Renderer,
    mixes: PresenceMixes,
    planes: &'a [Plane<'a>],
    context: LayerContext,
}

impl<'a> LayerBlur<'a> {
    /// The blur of the layers of `planes` by `inner`.
    pub(super) fn new(inner: &'a dyn Renderer, scene: &Scene, planes: &'a [Plane<'a>]) -> Self {
        Self {
            inner,
            mixes: PresenceMixes::new(planes),
            planes,
            context: inner.layer_context(scene),
        }
    }

    /// Blurs the samples of one layer: the planes, then the presence planes.
    fn blur(
        &self,
        scene: &Scene,
        samples: &LayerSamples,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        let light = samples
            .planes
            .iter()
            .zip(self.planes)
            .map(|(samples, plane)| Plane {
                samples,
                weights: plane.weights,
            });
        let presences = self.mixes.presence_weights.iter().map(|weights| Plane {
            samples: &samples.presence,
            weights,
        });
        let context = &self.context;
        if scene.edges == Edges::Mirror {
            let all: Vec<_> = light.chain(presences).collect();
            return self.inner.render_layer(scene, &all, context, progress);
        }
        // Light may leave the plate. Presence must not, or the composite would make up for that light.
        let light: Vec<_> = light.collect();
        let presences: Vec<_> = presences.collect();
        let mut blurred = self
            .inner
            .render_layer(scene, &light, context, &|done| progress(0.5 * done))?;
        let mirrored = Scene {
            edges: Edges::Mirror,
            ..*scene
        };
        let presence = self
            .inner
            .render_layer(&mirrored, &presences, context, &|done| {
                progress(0.5 + 0.5 * done)
            })?;
        blurred.planes.extend(presence.planes);
        blurred.statistics.add_part(&presence.statistics);
        Ok(blurred)
    }
}

/// The distinct channel weights ("mixes") of planes, and the presence planes that they need.
struct PresenceMixes {
    /// Index of each plane's mix.
    mix_of: Vec<usize>,
    /// Channel weights of the presence planes.
    presence_weights: Vec<Vec<f64>>,
    /// For each mix, the weight of each presence plane.
    presence_of: Vec<Vec<f32>>,
}

impl PresenceMixes {
    fn new(planes: &[Plane]) -> Self {
        let mut mixes: Vec<&[f64]> = Vec::new();
        let mut mix_of = Vec::with_capacity(planes.len());
        for plane in planes {
            let known = mixes.iter().position(|mix| *mix == plane.weights);
            mix_of.push(known.unwrap_or_else(|| {
                mixes.push(plane.weights);
                mixes.len() - 1
            }));
        }
        let channels = mixes.first().map_or(0, |mix| mix.len());
        let used: Vec<usize> = (0..channels)
            .filter(|&channel| mixes.iter().any(|mix| mix[channel] != 0.0))
            .collect();
        // Blur is linear: with fewer channels than mixes, the presence of a mix is the sum of its channels'.
        if used.len() < mixes.len() {
            let unit = |channel: usize| {
                (0..channels)
                    .map(|k| f64::from(u8::from(k == channel)))
                    .collect()
            };
            let pick = |mix: &&[f64]| used.iter().map(|&k| mix[k] as f32).collect();
            return Self {
                mix_of,
                presence_weights: used.iter().map(|&k| unit(k)).collect(),
                presence_of: mixes.iter().map(pick).collect(),
            };
        }
        let count = mixes.len();
        let unit = |mix: usize| (0..count).map(|k| f32::from(u8::from(k == mix))).collect();
        Self {
            mix_of,
            presence_weights: mixes.iter().map(|mix| mix.to_vec()).collect(),
            presence_of: (0..count).map(unit).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_hold_each_row_once_and_are_no_lower_than_the_blur_asks() {
        let window = |height: usize| RenderWindow {
            column: 5,
            row: 7,
            width: 7680,
            height,
        };
        for (height, reach_px, count) in [
            (4320, 100.0, 5),
            (4320, 300.0, 1),
            (273, 1.0, 1),
            (0, 1.0, 1),
        ] {
            let found = bands(window(height), reach_px);
            assert_eq!(found.len(), count, "{height} rows, {reach_px} px");
            let mut row = 7;
            for band in &found {
                assert_eq!((band.column, band.width, band.row), (5, 7680, row));
                row += band.height;
            }
            assert_eq!(row, 7 + height);
        }
    }
}
