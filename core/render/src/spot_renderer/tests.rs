//! The spot renderer against the exact one, and the statistics of renders.

use crate::*;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{LocalBlur, SkewNormal};

const WIDTH: usize = 200;
const HEIGHT: usize = 140;

/// A lens whose blur grows off the axis and with depth, fast enough for the error of the fast renderer to show.
struct Growing;

impl BlurField for Growing {
    fn frame(&self) -> Frame {
        Frame::new(WIDTH as u32, HEIGHT as u32, None).expect("a frame")
    }

    fn channel_count(&self) -> usize {
        1
    }

    fn blur_at(&self, _: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
        let h = at.radius().min(1.0);
        let sigma = 0.8 + 5.0 * vergence.abs() + 2.0 * h * h;
        let moments = MeridionalMoments {
            mu20: sigma * sigma,
            mu02: (1.0 - 0.4 * h * h) * sigma * sigma,
            mu30: 0.1 * h * sigma.powi(3),
            mu12: 0.0,
        };
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments.in_image(at.meridian()), at.meridian()),
            displacement_px: (0.0, 0.0),
        }
    }
}

fn scene(vergence: VergencePass) -> Scene {
    Scene {
        lens: &Growing,
        model: &SkewNormal,
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

fn plate() -> Vec<f32> {
    (0..WIDTH * HEIGHT)
        .map(|k| ((k * 7919) % 97) as f32 / 97.0)
        .collect()
}

fn all_pixels() -> Vec<(usize, usize)> {
    (0..WIDTH * HEIGHT)
        .map(|k| (k % WIDTH, k / WIDTH))
        .collect()
}

/// Vergences of two fronto-parallel surfaces and a slanted one.
fn depth() -> Vec<f32> {
    let at = |k: usize| match k % WIDTH {
        x if x < 70 => 0.6,
        x if x < 140 => 0.1,
        x => 0.1 + 0.004 * (x - 140) as f32,
    };
    (0..WIDTH * HEIGHT).map(at).collect()
}

#[derive(Clone, Copy, PartialEq)]
enum Extension {
    None,
    Replicate,
}

/// Renders with `inner` below occlusion and, where asked for, edge replication.
fn rendered(
    inner: &dyn Renderer,
    scene: &Scene,
    extension: Extension,
    samples: &[f32],
) -> Vec<Vec<f32>> {
    let planes = [Plane {
        samples,
        weights: &[1.0],
    }];
    let layered = LayeredRenderer {
        inner,
        settings: Occlusion::default(),
    };
    let replicating = EdgeReplicatingRenderer {
        light: crate::LightBeyond::Nearest,
        inner: &layered,
        occlusion: None,
    };
    let renderer: &dyn Renderer = match extension {
        Extension::None => &layered,
        Extension::Replicate => &replicating,
    };
    let rendered = renderer.render(scene, &planes, &|_| true);
    rendered.expect("a valid scene").planes
}

#[test]
fn spots_equal_the_exact_renderer_below_occlusion_and_edge_replication() {
    let (samples, pass) = (plate(), depth());
    let pixels = low_discrepancy_pixels(WIDTH, HEIGHT, 64);
    for vergence in [VergencePass::Constant(0.2), VergencePass::PerPixel(&pass)] {
        for (edges, extension) in [
            (Edges::Mirror, Extension::None),
            (Edges::Black, Extension::None),
            (Edges::Black, Extension::Replicate),
        ] {
            let scene = Scene {
                edges,
                ..scene(vergence)
            };
            let spots = SpotRenderer {
                map: scene.map,
                pixels: &pixels,
                cell_px: 1,
            };
            let got = rendered(&spots, &scene, extension, &samples);
            let want = rendered(&Scatter, &scene, extension, &samples);
            for (x, y) in &pixels {
                let (got, want) = (got[0][y * WIDTH + x], want[0][y * WIDTH + x]);
                assert!((got - want).abs() < 2e-4, "({x}, {y}): {got} {want}");
            }
        }
    }
}

#[test]
fn psnr_at_a_few_pixels_estimates_that_of_the_plate() {
    let samples = plate();
    let slope: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| 0.003 * (k % WIDTH) as f32)
        .collect();
    let pixels = low_discrepancy_pixels(WIDTH, HEIGHT, 64);
    for vergence in [VergencePass::Constant(0.2), VergencePass::PerPixel(&slope)] {
        let scene = scene(vergence);
        let spots = SpotRenderer {
            map: scene.map,
            pixels: &pixels,
            cell_px: 1,
        };
        let few = rendered(&spots, &scene, Extension::None, &samples);
        let exact = rendered(&Scatter, &scene, Extension::None, &samples);
        for quality in [Quality::Draft, Quality::Final] {
            let fast = rendered(
                &Gather {
                    quality,
                    kernels: None,
                },
                &scene,
                Extension::None,
                &samples,
            );
            let estimate = psnr_at(&fast, &few, WIDTH, &pixels, 1.0).expect("pixels");
            let truth = psnr_at(&fast, &exact, WIDTH, &all_pixels(), 1.0).expect("pixels");
            assert!(
                (estimate - truth).abs() < 2.0,
                "{quality:?}: {estimate} {truth}"
            );
        }
    }
}

#[test]
fn low_discrepancy_pixels_cover_the_plate_evenly() {
    let pixels = low_discrepancy_pixels(WIDTH, HEIGHT, 64);
    // Every ninth of the plate has its share.
    for (left, top) in (0..9).map(|k| (k % 3, k / 3)) {
        let inside = |&&(x, y): &&(usize, usize)| x * 3 / WIDTH == left && y * 3 / HEIGHT == top;
        let count = pixels.iter().filter(inside).count();
        assert!((4..=11).contains(&count), "{count}");
    }
    assert!(
        low_discrepancy_pixels(1, 1, 3)
            .iter()
            .all(|at| *at == (0, 0))
    );
}

#[test]
fn psnr_is_that_of_the_mean_square_error() {
    let (a, b) = (vec![vec![0.0_f32; 4]], vec![vec![0.1_f32; 4]]);
    let at = [(0, 0), (1, 1)];
    let db = psnr_at(&a, &b, 2, &at, 2.0).expect("a peak");
    assert!((db - 20.0 * 20.0_f64.log10()).abs() < 1e-5, "{db}");
    assert_eq!(psnr_at(&a, &a, 2, &at, 2.0), Some(f64::INFINITY));
    assert_eq!(psnr_at(&a, &b, 2, &at, 0.0), None);
    assert_eq!(psnr_at(&a, &b, 2, &[], 1.0), None);
}

#[test]
fn statistics_count_the_work_done() {
    let (mut samples, pass) = (plate(), depth());
    samples[70 * WIDTH + 100] = 1e4;
    let planes = [Plane {
        samples: &samples,
        weights: &[1.0],
    }];
    let statistics = |renderer: &dyn Renderer, scene: &Scene| {
        let rendered = renderer.render(scene, &planes, &|_| true);
        rendered.expect("a valid scene").statistics
    };
    let gather = Gather::default();
    let constant = scene(VergencePass::Constant(1.0));
    let of_gather = statistics(&gather, &constant);
    assert_eq!(
        (of_gather.layers, of_gather.renders, of_gather.exact),
        (1, 1, 0)
    );
    assert_eq!(of_gather.highlights, 1);
    // Wide blur: the finest level is interpolated from coarser ones, and the coarsest is gathered.
    let levels = &of_gather.levels;
    let (first, last) = (levels[0], levels[levels.len() - 1]);
    assert!(levels.len() > 1 && first.upsampled > 0, "{levels:?}");
    assert!(last.gathered > 0 && last.upsampled == 0 && last.min_tile_px >= 4);

    assert_eq!(
        statistics(&Scatter, &constant),
        RenderStatistics {
            layers: 1,
            renders: 1,
            exact: 1,
            ..RenderStatistics::default()
        }
    );

    // One render or more for each depth layer.
    let layered = LayeredRenderer {
        inner: &gather,
        settings: Occlusion::default(),
    };
    let varying = scene(VergencePass::PerPixel(&pass));
    let of_layers = statistics(&layered, &varying);
    assert!(of_layers.layers > 3 && of_layers.renders >= of_layers.layers);
    assert!(of_layers.exact < of_layers.renders && of_layers.levels.len() > 1);
    // Without occlusion a plate of varying depth is scattered.
    let of_varying = statistics(&gather, &varying);
    assert_eq!((of_varying.exact, of_varying.layers), (1, 0));
}

#[test]
fn statistics_of_parts_add_up_level_by_level() {
    let level = |gathered, upsampled, min_tile_px, max_tile_px| LevelStatistics {
        gathered,
        scattered: 0,
        upsampled,
        min_tile_px,
        max_tile_px,
    };
    let part = |levels: &[LevelStatistics]| RenderStatistics {
        layers: 1,
        renders: 1,
        exact: 0,
        levels: levels.to_vec(),
        highlights: 2,
    };
    let mut sum = RenderStatistics::default();
    sum.add_part(&part(&[level(3, 4, 16, 16)]));
    sum.add_part(&part(&[level(1, 2, 8, 8), level(5, 0, 32, 32)]));
    sum.add_part(&part(&[level(1, 1, 64, 64)]));
    assert_eq!(sum.levels, [level(5, 7, 8, 64), level(5, 0, 32, 32)]);
    assert_eq!((sum.layers, sum.renders, sum.highlights), (0, 3, 6));
}
