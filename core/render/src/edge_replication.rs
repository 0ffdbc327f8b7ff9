//! A renderer for which the plate goes on beyond its edges with the depth and the blur of its edge pixels.

use crate::{
    Background, ClampedLens, Edges, Holdout, LayeredRenderer, Occlusion, OtherSides, Plane,
    RenderStatistics, RenderWindow, Rendered, Renderer, Scene, VergencePass,
};
use rayon::prelude::*;
use seidel_optics::error::Result;
use std::ops::Range;

/// The light beyond the edges of a plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LightBeyond {
    /// That of the nearest pixel. An even plate stays as even at its edges as in the middle. The sum of light is not kept: incoming
    /// light replaces what leaves.
    Nearest,
    /// None.
    Black,
}

/// A renderer for which every pixel beyond an edge repeats the nearest one on the plate: its depth, its blur and, on request, its light.
///
/// The scene's own [`Edges`] are ignored.
#[derive(Clone, Copy)]
pub struct EdgeReplicatingRenderer<'r> {
    /// Light beyond the edges.
    pub light: LightBeyond,
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

    fn is_preview(&self) -> bool {
        self.inner.is_preview()
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
        let margin = Margin::new(self, scene, planes);
        let padded_light = |plane: &Plane| match self.light {
            LightBeyond::Nearest => margin.padded(plane.samples, |light| light),
            LightBeyond::Black => margin.padded(plane.samples, |_| 0.0),
        };
        let samples: Vec<Vec<f32>> = planes.par_iter().map(padded_light).collect();
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
            VergencePass::PerPixel(pass) => margin.padded(pass, |vergence| vergence),
        };
        let lens = ClampedLens::new(scene, RenderWindow::whole(scene));
        let padded = Scene {
            lens: &lens,
            width: margin.columns().count(),
            height: margin.rows().count(),
            map: scene.map.moved(-(margin.left as f64), -(margin.top as f64)),
            vergence: match scene.vergence {
                VergencePass::Constant(vergence) => VergencePass::Constant(vergence),
                VergencePass::PerPixel(_) => VergencePass::PerPixel(&pass),
            },
            edges: Edges::Black,
            ..*scene
        };
        let Some((part, place)) = margin.part_of(window) else {
            return Ok(Rendered {
                planes: vec![vec![0.0; window.width * window.height]; planes.len()],
                statistics: RenderStatistics::default(),
            });
        };
        let Some(settings) = self.occlusion else {
            return self.inner.render_window(&padded, &planes, part, progress);
        };
        let mattes = PaddedMattes::new(&margin, &settings);
        let background_planes: Vec<&[f32]> = mattes.background.iter().map(Vec::as_slice).collect();
        let side_planes: Vec<&[f32]> = mattes.sides.iter().map(Vec::as_slice).collect();
        let own = settings.own.unwrap_or(RenderWindow::whole(scene));
        let layered = LayeredRenderer {
            inner: self.inner,
            settings: Occlusion {
                own: match self.light {
                    LightBeyond::Nearest => None,
                    LightBeyond::Black => margin.part_of(own).map(|(own, _)| own),
                },
                ..mattes.occlusion(&settings, &background_planes, &side_planes)
            },
        };
        let mut rendered = layered.render_window(&padded, &planes, part, progress)?;
        if place != RenderWindow::from_size(window.width, window.height) {
            let planes = rendered.planes.iter_mut();
            planes.for_each(|plane| *plane = place.surrounded(window.width, window.height, plane));
        }
        Ok(rendered)
    }
}

/// The planes of a holdout, a background and other sides with their margin; empty where there are none.
struct PaddedMattes {
    matte: Vec<f32>,
    matte_vergence: Vec<f32>,
    background: Vec<Vec<f32>>,
    background_vergence: Vec<f32>,
    sides: Vec<Vec<f32>>,
    side_share: Vec<f32>,
    side_vergence: Vec<f32>,
}

impl PaddedMattes {
    fn new(margin: &Margin, settings: &Occlusion) -> Self {
        let same = |sample: f32| sample;
        let pass = |vergence: Option<VergencePass>| match vergence {
            Some(VergencePass::PerPixel(pass)) => margin.padded(pass, same),
            Some(VergencePass::Constant(_)) | None => Vec::new(),
        };
        let background = settings.background.map(|background| background.planes);
        let planes = background.unwrap_or_default().iter();
        let sides = settings.other_sides;
        let of_sides = |samples: fn(OtherSides) -> &[f32]| {
            sides.map_or_else(Vec::new, |sides| margin.padded(samples(sides), same))
        };
        Self {
            matte: (settings.holdout).map_or_else(Vec::new, |h| margin.padded(h.matte, same)),
            matte_vergence: pass(settings.holdout.and_then(|holdout| holdout.vergence)),
            background: planes.map(|plane| margin.padded(plane, same)).collect(),
            background_vergence: pass(settings.background.map(|b| b.vergence)),
            sides: (sides.map_or(&[][..], |sides| sides.planes).iter())
                .map(|plane| margin.padded(plane, same))
                .collect(),
            side_share: of_sides(|sides| sides.share),
            side_vergence: of_sides(|sides| sides.vergence),
        }
    }

    /// Returns `settings` with these planes; `background` are those of the background, `sides` those of other sides.
    fn occlusion<'a>(
        &'a self,
        settings: &Occlusion<'a>,
        background: &'a [&'a [f32]],
        sides: &'a [&'a [f32]],
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
            other_sides: settings.other_sides.map(|_| OtherSides {
                planes: sides,
                share: &self.side_share,
                vergence: &self.side_vergence,
            }),
            ..*settings
        }
    }
}

/// The margin of replicated pixels on each side of a plate, px; negative where pixels of the plate are left out.
struct Margin {
    left: i64,
    top: i64,
    right: i64,
    bottom: i64,
    width: usize,
    height: usize,
}

impl Margin {
    /// The margin that kernels reach into, at most the longer side of the plate.
    fn new(renderer: &EdgeReplicatingRenderer, scene: &Scene, planes: &[Plane]) -> Self {
        let Scene { width, height, .. } = *scene;
        let whole = RenderWindow::whole(scene);
        let settings = renderer.occlusion.as_ref();
        let own = settings.and_then(|settings| settings.own).unwrap_or(whole);
        let (x, y) = scene.reach_within(own);
        let longest = own.width.max(own.height) as i64;
        let [x, y] = [x, y].map(|reach| (reach.ceil() as i64).min(longest));
        if renderer.light == LightBeyond::Nearest {
            return Self {
                left: x,
                top: y,
                right: x,
                bottom: y,
                width,
                height,
            };
        }
        let samples = planes.iter().map(|plane| plane.samples);
        let lit = match settings.and_then(|settings| settings.background) {
            // A background may have light anywhere.
            Some(_) => whole,
            None => RenderWindow::of_light(samples, width, 0.0).unwrap_or(own),
        };
        let [first_x, first_y] = scene.place_in_cell(GRID_PX);
        let [left, right] = black_margin(own.columns(), lit.columns(), width, x, first_x);
        let [top, bottom] = black_margin(own.rows(), lit.rows(), height, y, first_y);
        Self {
            left,
            top,
            right,
            bottom,
            width,
            height,
        }
    }

    /// The columns of the padded plate, counted on the plate.
    fn columns(&self) -> Range<i64> {
        -self.left..self.width as i64 + self.right
    }

    /// The rows of the padded plate, counted on the plate.
    fn rows(&self) -> Range<i64> {
        -self.top..self.height as i64 + self.bottom
    }

    /// Returns the part of a `window` of the plate that the padded plate holds, on the padded plate and in the window; `None` without any.
    fn part_of(&self, window: RenderWindow) -> Option<(RenderWindow, RenderWindow)> {
        let common = |all: Range<i64>, of: Range<usize>| {
            let (first, end) = (all.start.max(of.start as i64), all.end.min(of.end as i64));
            let length = usize::try_from(end - first)
                .ok()
                .filter(|length| *length > 0)?;
            Some((
                (first - all.start) as usize,
                (first - of.start as i64) as usize,
                length,
            ))
        };
        let (column, left, width) = common(self.columns(), window.columns())?;
        let (row, top, height) = common(self.rows(), window.rows())?;
        let at = |column: usize, row: usize| RenderWindow {
            column,
            row,
            width,
            height,
        };
        Some((at(column, row), at(left, top)))
    }

    /// Returns the plate's `samples` with the margin around them: each pixel of the margin is `fill` of the nearest pixel.
    fn padded(&self, samples: &[f32], fill: impl Fn(f32) -> f32) -> Vec<f32> {
        let nearest = |at: i64, size: usize| at.clamp(0, size as i64 - 1) as usize;
        let row = |row: i64| {
            let near = nearest(row, self.height);
            let line = &samples[near * self.width..][..self.width];
            let fill = &fill;
            self.columns().map(move |column| {
                let sample = line[nearest(column, self.width)];
                if near as i64 == row && (0..self.width as i64).contains(&column) {
                    sample
                } else {
                    fill(sample)
                }
            })
        };
        self.rows().flat_map(row).collect()
    }
}

/// Returns the black margin before and after a plate of `size` pixels along an axis, its pixels with a picture those of `own`, its lit ones
/// those of `lit`, where blur reaches `reach` and the first pixel is the one after `first` of its cell.
///
/// Depth beyond an edge matters where it reaches light. Margins begin and end on the grid of the frame, and are measured from the picture.
/// So the padded plate is the same whatever part of its margin the plate came with.
fn black_margin(
    own: Range<usize>,
    lit: Range<usize>,
    size: usize,
    reach: i64,
    first: usize,
) -> [i64; 2] {
    let [own, lit] = [own, lit].map(|range| range.start as i64..range.end as i64);
    let (size, first, cell) = (size as i64, first as i64, GRID_PX as i64);
    let needed = |dark: i64| (2 * reach - dark.max(0)).clamp(0, reach);
    let start = (own.start - needed(lit.start - own.start)).min(lit.start);
    let end = (own.end + needed(own.end - lit.end)).max(lit.end);
    let start = (start + first).div_euclid(cell) * cell - first;
    let end = (end + first + cell - 1).div_euclid(cell) * cell - first;
    [-start, end - size]
}

/// Side of the cells of the frame's grid on which black margins begin and end, px.
const GRID_PX: usize = 32;

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
            light: LightBeyond::Nearest,
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

    #[test]
    fn black_margins_do_not_depend_on_those_that_a_plate_came_with() {
        // A picture of 90 px from place 40 of the frame on, of which 20 to 70 are lit.
        let padded = |before: usize, after: usize, reach: i64| {
            let own = before..before + 90;
            let lit = before + 20..before + 70;
            let place = (40 + 96 - before) % GRID_PX;
            let [left, right] = black_margin(own, lit, before + 90 + after, reach, place);
            let first = -(before as i64);
            [first - left, 90 + after as i64 + right]
        };
        for reach in [0, 13, 60] {
            let alone = padded(0, 0, reach);
            assert!(alone[0] <= -(2 * reach - 20).clamp(0, reach), "{alone:?}");
            for (before, after) in [(5, 0), (33, 17), (90, 90)] {
                assert_eq!(padded(before, after, reach), alone, "{reach}");
            }
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
            light: LightBeyond::Nearest,
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
            light: LightBeyond::Nearest,
            inner: &Scatter,
            occlusion: Some(small),
        };
        assert!(renderer.render(&scene, &[plane], &|_| true).is_err());
    }
}
