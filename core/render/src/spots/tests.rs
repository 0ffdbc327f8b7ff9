//! What is said of a render: how it was made, and how far it is from an exact one.

use crate::*;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::moments::MeridionalMoments;
use seidel_optics::psf::{LocalBlur, SkewNormal};

const WIDTH: usize = 200;
const HEIGHT: usize = 140;

/// Blur that grows off the axis and with depth, fast enough for the fast renderer to be seen.
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

/// Depth in two steps, and a slope.
fn depth() -> Vec<f32> {
    let at = |k: usize| match k % WIDTH {
        x if x < 70 => 0.6,
        x if x < 140 => 0.1,
        x => 0.1 + 0.004 * (x - 140) as f32,
    };
    (0..WIDTH * HEIGHT).map(at).collect()
}

/// `inner` within occlusion and the edges asked for.
fn rendered(
    inner: &dyn Renderer,
    (scene, extended): (&Scene, bool),
    samples: &[f32],
) -> Vec<Vec<f32>> {
    let planes = [Plane {
        samples,
        weights: &[1.0],
    }];
    let layered = Layered {
        inner,
        settings: Occlusion::default(),
    };
    let done = match extended {
        false => layered.render(scene, &planes, &|_| true),
        true => Extended { inner: &layered }.render(scene, &planes, &|_| true),
    };
    done.expect("a sound scene")
}

#[test]
fn spots_are_what_is_exact_within_occlusion_and_edges() {
    let (samples, pass) = (plate(), depth());
    let pixels = spread_pixels(WIDTH, HEIGHT, 64);
    for vergence in [VergencePass::Constant(0.2), VergencePass::PerPixel(&pass)] {
        for (edges, extended) in [
            (Edges::Mirror, false),
            (Edges::Black, false),
            (Edges::Black, true),
        ] {
            let scene = Scene {
                edges,
                ..scene(vergence)
            };
            let spots = Spots {
                map: scene.map,
                pixels: &pixels,
                cell_px: 1,
            };
            let got = rendered(&spots, (&scene, extended), &samples);
            let want = rendered(&Scatter, (&scene, extended), &samples);
            for (x, y) in &pixels {
                let (got, want) = (got[0][y * WIDTH + x], want[0][y * WIDTH + x]);
                assert!((got - want).abs() < 2e-4, "({x}, {y}): {got} {want}");
            }
        }
    }
}

#[test]
fn a_few_pixels_say_how_far_a_render_is_from_an_exact_one() {
    let samples = plate();
    let slope: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| 0.003 * (k % WIDTH) as f32)
        .collect();
    let pixels = spread_pixels(WIDTH, HEIGHT, 64);
    for vergence in [VergencePass::Constant(0.2), VergencePass::PerPixel(&slope)] {
        let scene = scene(vergence);
        let spots = Spots {
            map: scene.map,
            pixels: &pixels,
            cell_px: 1,
        };
        let few = rendered(&spots, (&scene, false), &samples);
        let exact = rendered(&Scatter, (&scene, false), &samples);
        for quality in [Quality::Draft, Quality::Final] {
            let fast = rendered(&Gather { quality }, (&scene, false), &samples);
            let told = psnr_at((&fast, &few), WIDTH, &pixels, 1.0).expect("pixels");
            let truth = psnr_at((&fast, &exact), WIDTH, &all_pixels(), 1.0).expect("pixels");
            assert!((told - truth).abs() < 2.0, "{quality:?}: {told} {truth}");
        }
    }
}

#[test]
fn pixels_are_spread_and_compared() {
    let pixels = spread_pixels(WIDTH, HEIGHT, 64);
    // Every ninth of the plate has its share.
    for (left, top) in (0..9).map(|k| (k % 3, k / 3)) {
        let inside = |&&(x, y): &&(usize, usize)| x * 3 / WIDTH == left && y * 3 / HEIGHT == top;
        let count = pixels.iter().filter(inside).count();
        assert!((4..=11).contains(&count), "{count}");
    }
    assert!(spread_pixels(1, 1, 3).iter().all(|at| *at == (0, 0)));
    let (a, b) = (vec![vec![0.0_f32; 4]], vec![vec![0.1_f32; 4]]);
    let at = [(0, 0), (1, 1)];
    let db = psnr_at((&a, &b), 2, &at, 2.0).expect("a peak");
    assert!((db - 20.0 * 20.0_f64.log10()).abs() < 1e-5, "{db}");
    assert_eq!(psnr_at((&a, &a), 2, &at, 2.0), Some(f64::INFINITY));
    assert_eq!(psnr_at((&a, &b), 2, &at, 0.0), None);
    assert_eq!(psnr_at((&a, &b), 2, &[], 1.0), None);
}

#[test]
fn methods_are_those_that_were_used() {
    let (mut samples, pass) = (plate(), depth());
    samples[70 * WIDTH + 100] = 1e4;
    let planes = [Plane {
        samples: &samples,
        weights: &[1.0],
    }];
    let gather = Gather::default();
    let noted = Noted::new(&gather);
    let constant = scene(VergencePass::Constant(1.0));
    let done = noted.render(&constant, &planes, &|_| true).expect("sound");
    assert_eq!(
        done,
        gather.render(&constant, &planes, &|_| true).expect("sound")
    );
    let methods = noted.methods();
    assert_eq!(
        (methods.renders, methods.scattered, methods.lights),
        (1, 0, 1)
    );
    assert_eq!(noted.slices(), 1);
    // Wide blur: the finest level is made of coarser ones, and the coarsest is gathered.
    let (first, last) = (methods.levels[0], methods.levels[methods.levels.len() - 1]);
    assert!(methods.levels.len() > 1 && first.doubled > 0, "{methods:?}");
    assert!(last.gathered > 0 && last.doubled == 0 && last.sides_px.0 >= 4);

    let exact = Noted::new(&Scatter);
    exact.render(&constant, &planes, &|_| true).expect("sound");
    assert_eq!(
        exact.methods(),
        Methods {
            renders: 1,
            scattered: 1,
            ..Methods::default()
        }
    );

    // One render a slice or more.
    let noted = Noted::new(&gather);
    let layered = Layered {
        inner: &noted,
        settings: Occlusion::default(),
    };
    let varying = scene(VergencePass::PerPixel(&pass));
    layered.render(&varying, &planes, &|_| true).expect("sound");
    assert!(noted.slices() > 3 && noted.methods().renders >= noted.slices());
    // Without occlusion a plate of varying depth is scattered.
    let noted = Noted::new(&gather);
    noted.render(&varying, &planes, &|_| true).expect("sound");
    assert_eq!((noted.methods().scattered, noted.slices()), (1, 0));
}
