//! Occlusion in small scenes with known results.

mod blur_map;
mod clean_plate;
mod hidden_texture;
mod mirroring;
mod range;
mod small_lights;
mod windows;

use super::depth_layers::STEP_SHARE;
use super::*;
use crate::Edges;
use crate::{BlurField, DisplacedBlur, Displacement, PlateMap, Scatter};
use seidel_optics::field::{FieldPoint, Frame, ImagePoint, Meridian};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{Gaussian, LocalBlur};

/// Three channels, blur growing from focus at vergence 0.5 at its own rate in each, and with the field.
struct Lens {
    field: f64,
    /// Change of the vergence in focus over half a frame width downwards, 1/m.
    tilt: f64,
}

impl BlurField for Lens {
    fn frame(&self) -> Frame {
        Frame::new(64, 48, None).expect("a valid frame")
    }

    fn channel_count(&self) -> usize {
        3
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
        let rate = 8.0 * (1.0 + 0.1 * channel as f64) * (1.0 + self.field * at.radius());
        let variance = (rate * (vergence - 0.5 - self.tilt * at.y)).powi(2);
        let moments = MeridionalMoments {
            mu20: variance,
            mu02: variance,
            mu30: 0.0,
            mu12: 0.0,
        };
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments.in_image(Meridian::X), Meridian::X),
            displacement_px: (0.0, 0.0),
        }
    }
}

const EVEN: Lens = Lens {
    field: 0.0,
    tilt: 0.0,
};
const WIDTH: usize = 64;
const HEIGHT: usize = 48;
const RED: &[f64] = &[1.0, 0.0, 0.0];
const GREEN: &[f64] = &[0.0, 1.0, 0.0];
const BLUE: &[f64] = &[0.0, 0.0, 1.0];
const ALPHA: &[f64] = &[0.25, 0.5, 0.25];

fn scene<'a>(lens: &'a Lens, vergence: VergencePass<'a>) -> Scene<'a> {
    Scene {
        lens,
        model: &Gaussian,
        width: WIDTH,
        height: HEIGHT,
        map: PlateMap {
            origin: ImagePoint::new(0.0, 0.0),
            scale: 1.0,
        },
        vergence,
        edges: Edges::Mirror,
        displacement: Displacement::None,
    }
}

fn plane<'a>(samples: &'a [f32], weights: &'a [f64]) -> Plane<'a> {
    Plane { samples, weights }
}

fn render(settings: Occlusion, scene: &Scene, planes: &[Plane]) -> Vec<Vec<f32>> {
    let layered = LayeredRenderer {
        inner: &Scatter,
        settings,
    };
    layered
        .render(scene, planes, &|_| true)
        .expect("a valid scene")
        .planes
}

/// Returns one value for columns left of 32, another for the rest.
fn halves(left: f32, right: f32) -> Vec<f32> {
    let value = |k: usize| if k % WIDTH < 32 { left } else { right };
    (0..WIDTH * HEIGHT).map(value).collect()
}

fn textured() -> Vec<f32> {
    (0..WIDTH * HEIGHT)
        .map(|k| ((k * 7919) % 101) as f32 / 100.0)
        .collect()
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f32::max)
}

#[test]
fn constant_vergence_equals_the_inner_renderer() {
    let light = textured();
    let planes = [plane(&light, RED), plane(&light, ALPHA)];
    let constant = scene(&Lens { field: 1.0, ..EVEN }, VergencePass::Constant(0.9));
    let want = Scatter
        .render(&constant, &planes, &|_| true)
        .expect("valid")
        .planes;
    assert_eq!(render(Occlusion::default(), &constant, &planes), want);
    // A constant depth pass: equal up to the split between two layers.
    let pass = vec![0.9; light.len()];
    let even = scene(&EVEN, VergencePass::PerPixel(&pass));
    let constant = scene(&EVEN, VergencePass::Constant(f64::from(0.9_f32)));
    let want = Scatter
        .render(&constant, &planes, &|_| true)
        .expect("valid")
        .planes;
    for (got, want) in render(Occlusion::default(), &even, &planes)
        .iter()
        .zip(&want)
    {
        assert!(largest_difference(got, want) < 4e-3);
    }
}

#[test]
fn opaque_scenes_stay_opaque_and_transparent_ones_transparent() {
    let slanted: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| 0.1 + 0.016 * (k / WIDTH) as f32 + 0.003 * (k % WIDTH) as f32)
        .collect();
    let lens = Lens { field: 1.0, ..EVEN };
    for pass in [slanted, halves(0.9, 0.2), halves(0.5, 0.1)] {
        let scene = scene(&lens, VergencePass::PerPixel(&pass));
        let (opaque, half) = (vec![1.0; pass.len()], vec![0.5; pass.len()]);
        let planes = [
            plane(&opaque, RED),
            plane(&opaque, GREEN),
            plane(&opaque, BLUE),
            plane(&opaque, ALPHA),
            plane(&half, ALPHA),
        ];
        let done = render(Occlusion::default(), &scene, &planes);
        for (out, want) in done.iter().zip(&planes) {
            assert!(largest_difference(out, want.samples) < 2e-6);
        }
    }
}

#[test]
fn a_sharp_foreground_does_not_leak_into_a_blurred_background() {
    let pass = halves(0.5, 0.1);
    let light = halves(1.0, 0.5);
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let done = &render(Occlusion::default(), &scene, &[plane(&light, RED)])[0];
    assert!(largest_difference(done, &light) < 1e-4);
    let plain = Scatter.render(&scene, &[plane(&light, RED)], &|_| true);
    // Without occlusion the background's light falls on the foreground.
    let worst = largest_difference(&plain.expect("valid").planes[0], &light);
    assert!(worst > 0.2, "{worst}");
}

#[test]
fn a_blurred_foreground_reveals_the_background_unless_its_outline_is_hard() {
    let pass = halves(0.9, 0.5);
    let light = halves(0.0, 1.0);
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let by = |settings| render(settings, &scene, &[plane(&light, RED)]).remove(0);
    let column = |out: &[f32], column: usize| out[20 * WIDTH + column];
    // One half at the edge; the blur extends two standard deviations (3.2 px) to either side.
    let both = by(Occlusion::default());
    assert!(
        (column(&both, 28) - 0.16).abs() < 0.04,
        "{}",
        column(&both, 28)
    );
    assert!(
        (column(&both, 35) - 0.84).abs() < 0.04,
        "{}",
        column(&both, 35)
    );
    assert!((column(&both, 31) + column(&both, 32) - 1.0).abs() < 0.02);
    let unfilled = by(Occlusion {
        fill_foreground: false,
        ..Occlusion::default()
    });
    assert!(column(&unfilled, 28) < 0.05);
    let hard = by(Occlusion {
        blur_inside: false,
        ..Occlusion::default()
    });
    assert!(column(&hard, 30) < 0.02, "{}", column(&hard, 30));
    assert!((column(&hard, 35) - column(&both, 35)).abs() < 0.01);
}

#[test]
fn a_holdout_stays_sharp_and_hides_only_what_is_behind() {
    let pass = halves(0.9, 0.2);
    let light = vec![1.0; pass.len()];
    let matte: Vec<f32> = (0..pass.len())
        .map(|k| if k / WIDTH < 20 { 1.0 } else { 0.0 })
        .collect();
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let held = |vergence| {
        let settings = Occlusion {
            holdout: Some(Holdout {
                matte: &matte,
                vergence,
            }),
            ..Occlusion::default()
        };
        render(settings, &scene, &[plane(&light, ALPHA)]).remove(0)
    };
    let all: Vec<f32> = matte.iter().map(|m| 1.0 - m).collect();
    assert!(largest_difference(&held(None), &all) < 2e-6);
    let some = held(Some(VergencePass::Constant(0.6)));
    for (index, got) in some.iter().enumerate() {
        let column = index % WIDTH;
        let want = if column < 20 { 1.0 } else { 1.0 - matte[index] };
        assert!(
            (20..44).contains(&column) || (got - want).abs() < 1e-3,
            "{index} {got}"
        );
    }
}

#[test]
fn light_may_leave_at_black_edges() {
    let pass = halves(0.9, 0.88);
    let light = vec![1.0; pass.len()];
    let scene = Scene {
        edges: Edges::Black,
        ..scene(&EVEN, VergencePass::PerPixel(&pass))
    };
    let planes = [plane(&light, RED)];
    let done = render(Occlusion::default(), &scene, &planes);
    let plain = Scatter.render(&scene, &planes, &|_| true);
    let plain = plain.expect("valid").planes;
    assert!((0.2..0.4).contains(&done[0][0]), "{}", done[0][0]);
    assert!(largest_difference(&done[0], &plain[0]) < 0.02);
}

#[test]
fn tiles_with_a_margin_equal_the_whole() {
    // Blur and local means reach no farther than 26 px, continued texture 70. The tile has 3 columns and a margin of 80.
    const WHOLE: usize = 128;
    const MARGIN: usize = 80;
    let (left, width) = (WHOLE - 3 - MARGIN, 3 + MARGIN);
    let near = |k: usize| (k % WHOLE / 9).is_multiple_of(2);
    let pixels = || 0..WHOLE * HEIGHT;
    let pass: Vec<f32> = pixels().map(|k| if near(k) { 0.7 } else { 0.42 }).collect();
    let light: Vec<f32> = pixels()
        .map(|k| ((k * 7919) % 101) as f32 / 100.0)
        .collect();
    let whole = Scene {
        width: WHOLE,
        ..scene(&EVEN, VergencePass::PerPixel(&pass))
    };
    let want = render(Occlusion::default(), &whole, &[plane(&light, RED)]).remove(0);
    let cut = |samples: &[f32]| -> Vec<f32> {
        let rows = samples.chunks_exact(WHOLE);
        rows.flat_map(|row| row[left..].to_vec()).collect()
    };
    let (tile_pass, tile_light) = (cut(&pass), cut(&light));
    let tile = Scene {
        width,
        map: PlateMap {
            origin: ImagePoint::new(left as f64, 0.0),
            scale: 1.0,
        },
        vergence: VergencePass::PerPixel(&tile_pass),
        ..whole
    };
    let got = render(Occlusion::default(), &tile, &[plane(&tile_light, RED)]).remove(0);
    for (got, want) in got.chunks_exact(width).zip(want.chunks_exact(WHOLE)) {
        assert!(largest_difference(&got[MARGIN..], &want[WHOLE - 3..]) < 1e-6);
    }
}

#[test]
fn the_result_does_not_depend_on_threads() {
    let (pass, light) = (halves(0.9, 0.2), textured());
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let planes = [plane(&light, RED), plane(&light, ALPHA)];
        pool.expect("threads")
            .install(|| render(Occlusion::default(), &scene, &planes))
    };
    assert_eq!(with(1), with(3));
}

/// A renderer that must not be reached.
struct Unreachable;

impl Renderer for Unreachable {
    fn id(&self) -> &'static str {
        "unreachable"
    }

    fn overshoot(&self) -> f32 {
        0.0
    }

    fn render_window(
        &self,
        _: &Scene,
        _: &[Plane],
        _: RenderWindow,
        _: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Rendered> {
        panic!("the render was cancelled before")
    }
}

#[test]
fn cancellation_takes_effect_before_the_first_layer() {
    let (samples, depth) = (textured(), halves(0.9, 0.3));
    let layered = LayeredRenderer {
        inner: &Unreachable,
        settings: Occlusion::default(),
    };
    let asked = std::sync::atomic::AtomicUsize::new(0);
    for stop_at in [0, 1, 2, 20] {
        asked.store(0, std::sync::atomic::Ordering::Relaxed);
        let goes_on = |_| asked.fetch_add(1, std::sync::atomic::Ordering::Relaxed) != stop_at;
        let scene = scene(&EVEN, VergencePass::PerPixel(&depth));
        let stopped_render = layered.render(&scene, &[plane(&samples, RED)], &goes_on);
        assert_eq!(stopped_render, Err(cancelled()), "{stop_at}");
    }
}

#[test]
fn renders_can_be_cancelled_and_invalid_mattes_are_refused() {
    let (pass, light) = (halves(0.9, 0.2), textured());
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let layered = |matte| LayeredRenderer {
        inner: &Scatter,
        settings: Occlusion {
            holdout: Some(Holdout {
                matte,
                vergence: None,
            }),
            ..Occlusion::default()
        },
    };
    let planes = [plane(&light, RED)];
    let stop = layered(&light).render(&scene, &planes, &|share| share < 0.5);
    assert_eq!(stop, Err(crate::cancelled()));
    let short = layered(&light[1..]).render(&scene, &planes, &|_| true);
    assert!(short.expect_err("too short").place.contains("holdout"));
    let mut broken = light.clone();
    broken[3] = f32::NAN;
    let broken = layered(&broken).render(&scene, &planes, &|_| true);
    assert!(broken.expect_err("not finite").place.contains("(3, 0)"));
}

#[test]
fn layers_depend_on_the_lens_alone_and_are_close() {
    let flat = scene(&EVEN, VergencePass::Constant(0.0));
    let (short, long) = (
        DepthLayers::new(&flat, 0.3, 0.6, LayerSpacing::BY_BLUR),
        DepthLayers::new(&flat, -0.4, 3.0, LayerSpacing::BY_BLUR),
    );
    for vergence in [0.0, 0.31, 0.5, 0.577] {
        assert_eq!(short.coordinate(vergence), long.coordinate(vergence));
    }
    assert!((long.vergence(0)..=long.vergence(long.len() - 1)).contains(&3.0));
    for layer in 1..long.len() {
        let (a, b) = (long.vergence(layer - 1), long.vergence(layer));
        assert!(a < b);
        // Kernel sizes, two standard deviations, in the channel with the most blur.
        let size = |v: f64| 2.0 * 9.6 * (v - 0.5);
        let step = size(b) - size(a);
        let least = size(a).abs().min(size(b).abs());
        assert!(step <= (STEP_SHARE * least).max(1.5) + 1e-9, "{a} {b}");
        if a.min(b) < 0.5 && a.max(b) > 0.5 {
            assert!(step <= 1.0, "{a} {b}");
        }
    }
}

#[test]
fn layers_for_the_inversion_of_kernels_are_half_as_far_apart() {
    let flat = scene(&EVEN, VergencePass::Constant(0.0));
    let layers = DepthLayers::new(&flat, 0.0, 3.0, LayerSpacing::BY_HALF_THE_BLUR);
    for layer in 1..layers.len() {
        let ends = [layer - 1, layer].map(|k| 2.0 * 9.6 * (layers.vergence(k) - 0.5));
        let least = ends[0].abs().min(ends[1].abs());
        let most = 0.5 * (STEP_SHARE * least).max(1.5);
        assert!(ends[1] - ends[0] <= most + 1e-9, "{ends:?}");
    }
}
