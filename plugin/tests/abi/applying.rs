//! Blur: the renderer's own, windows that are parts of the whole, every knob.

use std::ptr::null;

use seidel_c::*;
use seidel_core::predict::Predictor;
use seidel_core::psf::Gaussian;
use seidel_core::render::{
    BlurField, Displacement, Edges, Gather, LayeredRenderer, Occlusion, Plane, Renderer, Scene,
    VergencePass,
};
use seidel_core::{PlateGeometry, PlatePlacement, no_progress};

use crate::support::{
    Held, Picture, applied, doors, farthest, plate, profile, rect, refused, settings, well,
};

const AREA: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 120,
    height: 80,
};

fn depth(area: SeidelRect) -> Picture {
    Picture::of(area, 1, |x, y, _| {
        if x > 40 && x < 70 {
            1.3
        } else {
            2.0 + 0.1 * y as f32
        }
    })
}

/// Renders a premultiplied RGBA picture by the renderers themselves, without the facade that the C ABI calls.
fn render_by_renderers(picture: &Picture, vergence: VergencePass) -> Vec<Vec<f32>> {
    let lens = Predictor::new(&profile(2.0)).expect("a lens");
    let (width, height) = (picture.rect.width as usize, picture.rect.height as usize);
    let placement = PlatePlacement::new(lens.frame(), &PlateGeometry::of_size(width, height));
    let scene = Scene {
        lens: &lens,
        model: &Gaussian,
        width,
        height,
        map: placement.map,
        vergence,
        edges: Edges::Mirror,
        displacement: Displacement::Lateral,
    };
    let samples: Vec<_> = (0..4).map(|k| picture.plane(k)).collect();
    let third = 1.0 / 3.0;
    let weights = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [third, third, third],
    ];
    let planes: Vec<_> = (samples.iter().zip(&weights))
        .map(|(samples, weights)| Plane { samples, weights })
        .collect();
    let layered = LayeredRenderer {
        inner: &Gather::default(),
        settings: Occlusion::default(),
    };
    let rendered = layered.render(&scene, &planes, &no_progress);
    rendered.expect("drawable").planes
}

#[test]
fn results_are_those_of_the_renderer() {
    let lens = Held::new(2.0);
    let picture = Picture::busy(AREA, 4);
    let pass = depth(AREA);
    let (image, depth_image) = (picture.image(), pass.image());
    for with_depth in [false, true] {
        let mut plate = plate(&image, AREA);
        let vergence = |metres: &f32| (1.0 / f64::from(*metres)) as f32;
        let vergences: Vec<f32> = pass.samples.iter().map(vergence).collect();
        let mut vergence = VergencePass::Constant(0.5);
        if with_depth {
            plate.depth = &depth_image;
            vergence = VergencePass::PerPixel(&vergences);
        }
        let got = applied(&lens, &settings(), &plate, AREA);
        for (channel, want) in render_by_renderers(&picture, vergence).iter().enumerate() {
            assert_eq!(&got.plane(channel), want, "{channel} {with_depth}");
        }
        assert!(farthest(&got.samples, &picture.samples) > 1.0);
    }
}

/// The region that a window needs.
fn region(
    lens: &Held,
    settings: &SeidelSettings,
    plate: &SeidelPlate,
    window: SeidelRect,
) -> SeidelRect {
    let mut region = rect(0, 0, 0, 0);
    // SAFETY: all pointers are good.
    well(unsafe { (doors().region)(lens.0, settings, plate, &window, &mut region) });
    region
}

#[test]
fn windows_are_parts_of_the_whole_to_the_bit() {
    let lens = Held::new(2.0);
    let extent = rect(-9, 4, 120, 80);
    let picture = Picture::busy(extent, 4);
    let pass = depth(extent);
    let mut narrowed = 0;
    for (quality, edges, with_depth) in [
        (SEIDEL_QUALITY_FINAL, SEIDEL_EDGES_MIRROR, false),
        (SEIDEL_QUALITY_FINAL, SEIDEL_EDGES_NEAREST, false),
        (SEIDEL_QUALITY_DRAFT, SEIDEL_EDGES_BLACK, false),
        (SEIDEL_QUALITY_EXACT, SEIDEL_EDGES_MIRROR, false),
        (SEIDEL_QUALITY_EXACT, SEIDEL_EDGES_BLACK, false),
        (SEIDEL_QUALITY_EXACT, SEIDEL_EDGES_NEAREST, false),
        (SEIDEL_QUALITY_FINAL, SEIDEL_EDGES_MIRROR, true),
    ] {
        let mut settings = settings();
        (settings.quality, settings.edges) = (quality, edges);
        let (image, depth_image) = (picture.image(), pass.image());
        let mut ground = plate(&image, extent);
        ground.format = rect(0, 0, 100, 75);
        if with_depth {
            ground.depth = &depth_image;
        }
        let whole = applied(&lens, &settings, &ground, extent);
        for window in [
            rect(-9, 4, 30, 20),
            rect(31, 30, 40, 25),
            rect(110, 40, 1, 44),
        ] {
            // No more is handed in than was asked for.
            let needed = region(&lens, &settings, &ground, window);
            narrowed += usize::from(needed != extent);
            let part = picture.cut(needed);
            let image = part.image();
            let part_plate = SeidelPlate {
                source: &image,
                ..ground
            };
            let got = applied(&lens, &settings, &part_plate, window);
            let want = whole.cut(window);
            assert_eq!(got.bits(), want.bits(), "{quality} {edges} {window:?}");
        }
    }
    assert!(narrowed >= 6, "{narrowed}");
}

#[test]
fn results_are_the_same_for_any_number_of_threads() {
    let lens = Held::new(3.0);
    let picture = Picture::busy(AREA, 4);
    let pass = depth(AREA);
    let (image, depth_image) = (picture.image(), pass.image());
    let mut plate = plate(&image, AREA);
    plate.depth = &depth_image;
    let results = [1, 2, 3].map(|threads| {
        let mut settings = settings();
        settings.threads = threads;
        applied(&lens, &settings, &plate, AREA).bits()
    });
    assert_eq!(results[0], results[1]);
    assert_eq!(results[0], results[2]);
}

#[test]
fn every_setting_changes_the_picture() {
    let lens = Held::new(2.0);
    let picture = Picture::busy(AREA, 4);
    let pass = depth(AREA);
    let matte = Picture::of(AREA, 1, |x, _, _| f32::from(u8::from(x > 90)));
    let (image, depth_image, matte_image) = (picture.image(), pass.image(), matte.image());
    let mut ground = plate(&image, AREA);
    ground.depth = &depth_image;
    // Wide enough for what is behind an edge to show.
    let mut base = settings();
    base.amount = 4.0;
    let plain = applied(&lens, &base, &ground, AREA).bits();
    let scales = [1.0, 1.3, 0.8];
    type Change<'a> = (&'a str, &'a dyn Fn(&mut SeidelSettings, &mut SeidelPlate));
    let changes: &[Change] = &[
        ("amount", &|s, _| s.amount = 0.7),
        ("channel_scales", &|s, _| {
            s.channel_scales = scales.as_ptr();
            s.channel_scale_count = 3;
        }),
        ("geometry", &|s, _| s.geometry = SEIDEL_GEOMETRY_NONE),
        ("geometry full", &|s, _| s.geometry = SEIDEL_GEOMETRY_FULL),
        ("axis_offset_x", &|s, _| s.axis_offset_x = 9.0),
        ("axis_offset_y", &|s, _| s.axis_offset_y = 9.0),
        ("psf_model", &|s, _| s.psf_model = c"skew-normal".as_ptr()),
        ("focus_distance", &|s, _| s.focus_distance = 1.5),
        ("f_number", &|s, _| s.f_number = 4.0),
        ("sensor_shift_um", &|s, _| s.sensor_shift_um = 5.0),
        ("depth_of_field", &|s, _| {
            s.focus_distance = 2.0;
            s.depth_of_field = 0.7;
        }),
        ("front_multiplier", &|s, _| {
            s.focus_distance = 2.0;
            s.front_multiplier = 2.0;
        }),
        ("back_multiplier", &|s, _| {
            s.focus_distance = 2.0;
            s.back_multiplier = 2.0;
        }),
        ("maximum_size", &|s, _| s.maximum_size = 5.0),
        ("quality", &|s, _| s.quality = SEIDEL_QUALITY_DRAFT),
        ("edges", &|s, _| s.edges = SEIDEL_EDGES_BLACK),
        ("edges nearest", &|s, _| s.edges = SEIDEL_EDGES_NEAREST),
        ("occlusion", &|s, _| s.occlusion = 0),
        ("fill_foreground", &|s, _| s.fill_foreground = 0),
        ("blur_inside", &|s, _| s.blur_inside = 0),
        ("alpha", &|s, _| s.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED),
        ("lens_scale", &|s, _| s.lens_scale = 0.5),
        ("pixel_aspect", &|s, _| s.pixel_aspect = 2.0),
        ("depth_unit", &|s, _| s.depth_unit = 0.8),
        ("depth_kind", &|s, _| s.depth_kind = SEIDEL_DEPTH_INVERSE),
        ("depth far one", &|s, _| {
            s.depth_kind = SEIDEL_DEPTH_FAR_ONE;
            (s.depth_near, s.depth_far) = (1.0, 9.0);
        }),
        ("along_ray", &|s, _| s.along_ray = 60.0),
        ("matte", &|_, p| p.matte = &matte_image),
        ("matte_depth", &|_, p| {
            p.matte = &matte_image;
            p.matte_depth = &depth_image;
        }),
        ("format", &|_, p| p.format.width = 90),
        ("depth", &|_, p| p.depth = null()),
    ];
    let mut seen = vec![("plain", plain)];
    for (name, change) in changes {
        let (mut settings, mut plate) = (base, ground);
        change(&mut settings, &mut plate);
        let got = applied(&lens, &settings, &plate, AREA).bits();
        assert!(
            seen.iter().all(|(_, other)| *other != got),
            "{name} changes nothing"
        );
        seen.push((name, got));
    }
}

#[test]
fn the_alpha_of_each_colour_is_blurred_as_its_colour() {
    let lens = Held::new(3.0);
    let picture = Picture::of(AREA, 4, |x, _, _| f32::from(u8::from(x > 60)));
    let mut settings = settings();
    settings.alpha_per_channel = 1;
    let image = picture.image();
    let plate = plate(&image, AREA);
    let (mut out, mut alphas) = (Picture::black(AREA, 4), Picture::black(AREA, 3));
    let (output, alphas_image) = (out.output(), alphas.output());
    // SAFETY: all pointers are good.
    unsafe {
        let call = |alphas| (doors().apply)(lens.0, &settings, &plate, &output, alphas, null());
        refused(call(null()), SeidelStatus::Argument, "alphas");
        well(call(&alphas_image));
    }
    // Colour is one where alpha is: each is its own alpha.
    for channel in 0..3 {
        assert!(farthest(&out.plane(channel), &alphas.plane(channel)) < 1e-6);
    }
    assert!(farthest(&alphas.plane(0), &alphas.plane(2)) > 1e-3);
    assert!(farthest(&alphas.plane(0), &out.plane(3)) > 1e-3);
}

#[test]
fn a_kernel_is_what_becomes_of_a_point_of_light() {
    let lens = Held::new(2.0);
    let picture = Picture::of(AREA, 3, |x, y, _| f32::from(u8::from((x, y) == (80, 30))));
    let image = picture.image();
    let plate = plate(&image, AREA);
    let mut settings = settings();
    settings.quality = SEIDEL_QUALITY_EXACT;
    let blurred = applied(&lens, &settings, &plate, AREA);
    for channel in 0..3 {
        let mut kernel = SeidelKernel {
            size: size_of::<SeidelKernel>() as u64,
            weights: std::ptr::null_mut(),
            capacity: 0,
            left: 0,
            top: 0,
            width: 0,
            height: 0,
        };
        // SAFETY: all pointers are good, weights as many as is said.
        let ask = |kernel: &mut SeidelKernel| unsafe {
            (doors().kernel)(lens.0, &settings, &plate, channel, 80.5, 30.5, 2.0, kernel)
        };
        refused(ask(&mut kernel), SeidelStatus::TooSmall, "capacity");
        let mut weights = vec![0.0_f32; (kernel.width * kernel.height) as usize];
        kernel.weights = weights.as_mut_ptr();
        kernel.capacity = weights.len() as u64;
        well(ask(&mut kernel));
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let place = rect(
            80 + kernel.left,
            30 + kernel.top,
            kernel.width as i32,
            kernel.height as i32,
        );
        let drawn = blurred.cut(place).plane(channel as usize);
        assert!(farthest(&drawn, &weights) < 1e-6);
        assert!(weights.iter().any(|w| *w > 0.02));
        let beyond = SeidelStatus::Argument;
        // SAFETY: all pointers are good.
        let got =
            unsafe { (doors().kernel)(lens.0, &settings, &plate, 3, 5.0, 5.0, 2.0, &mut kernel) };
        refused(got, beyond, "channel 3");
    }
}
