//! A renderer that replicates the plate's edge pixels beyond its edges.

use crate::{
    Background, ClampedLens, Edges, Holdout, LayeredRenderer, Occlusion, Plane, RenderWindow,
    Rendered, Renderer, Scene, VergencePass,
};
use rayon::prelude::*;
use seidel_optics::error::Result;

/// A renderer for which every pixel beyond an edge repeats the nearest one on the plate: its light, depth and blur.
///
/// An even plate stays as even at its edges as in the middle. The sum of light is not kept: incoming light replaces
/// what leaves. The scene's own [`Edges`] are ignored.
#[derive(Clone, Copy)]
pub struct EdgeReplicatingRenderer<'r> {
    /// The renderer of the plate with its margin, or of its depth layers.
    pub inner: &'r dyn Renderer,
    /// Occlusion, by layers around `inner`. Its holdout and its background repeat their edge pixels too.
    pub occlusion: Option<Occlusion<'r>>,
}

impl Renderer for EdgeReplicatingRenderer<'_> {
    fn id(&self) -> &'static str {
        self.inner.id()
    }

    fn overshoot(&self) -> f32 {
        self.inner.overshoot()
    }

    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: RenderWindow,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        scene.check(planes)?;
        window.check(scene)?;
        if let Some(occlusion) = &self.occlusion {
            occlusion.check(scene, planes.len())?;
        }
        let margin = Margin::new(scene);
        let samples: Vec<Vec<f32>> = planes
            .par_iter()
            .map(|plane| margin.padded(plane.samples))
            .collect();
        let planes: Vec<Plane> = samples
            .iter()
            .zip(planes)
            .map(|(samples, plane)| Plane {
                samples,
                weights: plane.weights,
            })
            .collect();
        let pass = match scene.vergence {
            VergencePass::Constant(_) => Vec::new(),
            VergencePass::PerPixel(pass) => margin.padded(pass),
        };
        let lens = ClampedLens::new(scene, RenderWindow::whole(scene));
        let padded = Scene {
            lens: &lens,
            width: scene.width + 2 * margin.x,
            height: scene.height + 2 * margin.y,
            map: scene.map.moved(-(margin.x as f64), -(margin.y as f64)),
            vergence: match scene.vergence {
                VergencePass::Constant(vergence) => VergencePass::Constant(vergence),
                VergencePass::PerPixel(_) => VergencePass::PerPixel(&pass),
            },
            edges: Edges::Black,
            ..*scene
        };
        let window = RenderWindow {
            column: window.column + margin.x,
            row: window.row + margin.y,
            ..window
        };
        let Some(settings) = self.occlusion else {
            return self.inner.render_window(&padded, &planes, window, progress);
        };
        let mattes = PaddedMattes::new(&margin, &settings);
        let background_planes: Vec<&[f32]> = mattes.background.iter().map(Vec::as_slice).collect();
        let layered = LayeredRenderer {
            inner: self.inner,
            settings: mattes.occlusion(&settings, &background_planes),
        };
        layered.render_window(&padded, &planes, window, progress)
    }
}

/// The planes of a holdout and a background with their margin; empty where there are none.
struct PaddedMattes {
    matte: Vec<f32>,
    matte_vergence: Vec<f32>,
    background: Vec<Vec<f32>>,
    background_vergence: Vec<f32>,
}

impl PaddedMattes {
    fn new(margin: &Margin, settings: &Occlusion) -> Self {
        let pass = |vergence: Option<VergencePass>| match vergence {
            Some(VergencePass::PerPixel(pass)) => margin.padded(pass),
            Some(VergencePass::Constant(_)) | None => Vec::new(),
        };
        let background = settings.background.map(|background| background.planes);
        let planes = background.unwrap_or_default().iter();
        Self {
            matte: (settings.holdout).map_or_else(Vec::new, |h| margin.padded(h.matte)),
            matte_vergence: pass(settings.holdout.and_then(|holdout| holdout.vergence)),
            background: planes.map(|plane| margin.padded(plane)).collect(),
            background_vergence: pass(settings.background.map(|b| b.vergence)),
        }
    }

    /// Returns `settings` with these planes; `background` are those of the background.
    fn occlusion<'a>(
        &'a self,
        settings: &Occlusion<'a>,
        background: &'a [&'a [f32]],
    ) -> Occlusion<'a> {
        let pass = |own: VergencePass<'a>, padded: &'a [f32]| match own {
            VergencePass::PerPixel(_) => VergencePass::PerPixel(padded),
            constant => constant,
        };
        Occlusion {
            holdout: settings.holdout.map(|holdout| Holdout {
                matte: &self.matte,
                vergence: holdout.vergence.map(|own| pass(own, &self.matte_vergence)),
            }),
            background: settings.background.map(|own| Background {
                planes: background,
                vergence: pass(own.vergence, &self.background_vergence),
            }),
            ..*settings
        }
    }
}

/// The margin of replicated pixels about a plate, px.
struct Margin {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

impl Margin {
    /// The margin that kernels reach into, at most the longer side of the plate.
    fn new(scene: &Scene) -> Self {
        let (x, y) = scene.reach_px();
        let longest = scene.width.max(scene.height);
        Self {
            x: (x.ceil() as usize).min(longest),
            y: (y.ceil() as usize).min(longest),
            width: scene.width,
            height: scene.height,
        }
    }

    /// Returns the plate's `samples` with the margin around them.
    fn padded(&self, samples: &[f32]) -> Vec<f32> {
        let mut out = Vec::with_capacity((self.width + 2 * self.x) * (self.height + 2 * self.y));
        for row in 0..self.height + 2 * self.y {
            let row = row.saturating_sub(self.y).min(self.height - 1);
            let line = &samples[row * self.width..(row + 1) * self.width];
            out.extend(std::iter::repeat_n(line[0], self.x));
            out.extend_from_slice(line);
            out.extend(std::iter::repeat_n(line[self.width - 1], self.x));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BlurField, DisplacedBlur, Displacement, Gather, PlateMap, Scatter};
    use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
    use seidel_optics::moments::MeridionalMoments;
    use seidel_optics::psf::{Gaussian, LocalBlur};

    /// A lens whose blur grows to the right and with vergence.
    struct Growing;

    impl BlurField for Growing {
        fn frame(&self) -> Frame {
            Frame::new(60, 40, None).expect("a valid frame")
        }

        fn channel_count(&self) -> usize {
            1
        }

        fn blur_at(&self, _: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
            let sigma = 2.5 + 1.2 * at.x + vergence;
            let moments = MeridionalMoments {
                mu20: sigma * sigma,
                mu02: sigma * sigma,
                mu30: 0.0,
                mu12: 0.0,
            };
            let meridian = FieldPoint::new(1.0, 0.0).meridian();
            DisplacedBlur {
                blur: LocalBlur::from_moments(moments.in_image(meridian), meridian),
                displacement_px: (0.0, 0.0),
            }
        }
    }

    fn scene(vergence: VergencePass) -> Scene {
        Scene {
            lens: &Growing,
            model: &Gaussian,
            width: 60,
            height: 40,
            map: PlateMap {
                origin: ImagePoint::new(0.0, 0.0),
                scale: 1.0,
            },
            vergence,
            edges: Edges::Mirror,
            displacement: Displacement::None,
        }
    }

    fn rendered(inner: &dyn Renderer, scene: &Scene, samples: &[f32]) -> Vec<f32> {
        let plane = Plane {
            samples,
            weights: &[1.0],
        };
        let rendered = EdgeReplicatingRenderer {
            inner,
            occlusion: None,
        }
        .render(scene, &[plane], &|_| true);
        rendered.expect("a valid scene").planes.remove(0)
    }

    /// Output pixels equal their definition, summed directly.
    #[test]
    fn pixels_beyond_the_edge_repeat_the_nearest_one() {
        let samples: Vec<f32> = (0..60 * 40)
            .map(|k| ((k * 7919) % 97) as f32 / 97.0)
            .collect();
        let got = rendered(&Scatter, &scene(VergencePass::Constant(0.0)), &samples);
        for (x, y) in [(0, 0), (59, 39), (59, 20), (30, 0), (30, 20)] {
            let mut sum = 0.0;
            for v in -40_i32..80 {
                for u in -40_i32..100 {
                    let (near_x, near_y) = (u.clamp(0, 59), v.clamp(0, 39));
                    let centre = (f64::from(u) + 0.5).clamp(0.0, 60.0);
                    let sigma = 2.5 + 1.2 * (centre - 30.0) / 30.0;
                    let square = f64::from((u - x).pow(2) + (v - y).pow(2));
                    let weight = (-square / (2.0 * sigma * sigma)).exp()
                        / (std::f64::consts::TAU * sigma * sigma);
                    sum += weight * f64::from(samples[(near_y * 60 + near_x) as usize]);
                }
            }
            let got = f64::from(got[(y * 60 + x) as usize]);
            assert!((got - sum).abs() < 1e-4, "({x}, {y}): {got} {sum}");
        }
    }

    #[test]
    fn even_plates_stay_even_with_every_renderer() {
        let even = vec![0.7_f32; 60 * 40];
        let pass: Vec<f32> = (0..60 * 40).map(|k| (k % 60) as f32 / 60.0).collect();
        let layered = LayeredRenderer {
            inner: &Gather::default(),
            settings: Occlusion::default(),
        };
        let constant = scene(VergencePass::Constant(0.5));
        // Growing blur does not keep an even plate exactly even, wherever it is.
        for (renderer, scene, limit) in [
            (&Scatter as &dyn Renderer, &constant, 0.03),
            (&Gather::default(), &constant, 0.03),
            (&layered, &scene(VergencePass::PerPixel(&pass)), 0.03),
        ] {
            let got = rendered(renderer, scene, &even);
            let worst = got.iter().map(|v| (v - 0.7).abs()).fold(0.0, f32::max);
            assert!(worst < limit, "{}: {worst}", renderer.id());
        }
    }

    /// A holdout that covers the left half also covers what lies beyond the left edge, and nothing on the right.
    #[test]
    fn holdouts_are_replicated_with_the_plate() {
        let even = vec![0.7_f32; 60 * 40];
        let pass: Vec<f32> = (0..60 * 40).map(|k| (k % 60) as f32 / 60.0).collect();
        let matte: Vec<f32> = (0..60 * 40)
            .map(|k| f32::from(u8::from(k % 60 < 30)))
            .collect();
        let plane = Plane {
            samples: &even,
            weights: &[1.0],
        };
        let renderer = EdgeReplicatingRenderer {
            inner: &Scatter,
            occlusion: Some(Occlusion {
                holdout: Some(Holdout {
                    matte: &matte,
                    vergence: None,
                }),
                ..Occlusion::default()
            }),
        };
        let scene = scene(VergencePass::PerPixel(&pass));
        let done = renderer.render(&scene, &[plane], &|_| true);
        let out = done.expect("a valid scene").planes.remove(0);
        assert_eq!(out[20 * 60], 0.0);
        assert!(
            (out[20 * 60 + 59] - 0.7).abs() < 0.03,
            "{}",
            out[20 * 60 + 59]
        );
        let small = Occlusion {
            holdout: Some(Holdout {
                matte: &matte[..60],
                vergence: None,
            }),
            ..Occlusion::default()
        };
        let renderer = EdgeReplicatingRenderer {
            inner: &Scatter,
            occlusion: Some(small),
        };
        assert!(renderer.render(&scene, &[plane], &|_| true).is_err());
    }
}
