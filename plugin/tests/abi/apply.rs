//! `seidel_apply`, `seidel_region_of_interest` and `seidel_kernel`: agreement with the renderers, windows, settings.

use std::ptr::null;

use seidel_c::*;
use seidel_core::{
    BlurField, Displacement, LensFrame, PlateGeometry, PlatePlacement, Predictor, no_progress,
};
use seidel_optics::psf::Gaussian;
use seidel_render::{
    Edges, Gather, LayeredRenderer, Occlusion, Plane, Renderer, Scene, VergencePass,
};

use crate::support::{
    LensHandle, TestImage, apply, assert_ok, assert_refused, exports, max_difference, plate,
    profile, rect, settings,
};

const AREA: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 120,
    height: 80,
};

/// A few rows of it.
const STRIP: SeidelRect = SeidelRect { height: 32, ..AREA };

/// Returns distances in metres: a near strip before a background that recedes downwards.
fn depth(area: SeidelRect) -> TestImage {
    TestImage::from_fn(area, 1, |x, y, _| {
        if x > 40 && x < 70 {
            1.3
        } else {
            2.0 + 0.1 * y as f32
        }
    })
}

/// Renders a premultiplied RGBA image by the renderers, without the facade that the C ABI calls.
fn render_by_renderers(image: &TestImage, vergence: VergencePass) -> Vec<Vec<f32>> {
    let lens = Predictor::new(&profile(2.0)).expect("a valid profile");
    let (width, height) = (image.rect.width as usize, image.rect.height as usize);
    let frame = LensFrame {
        frame: lens.frame(),
        squeeze: 1.0,
        pixel_pitch_um: None,
    };
    let placement = PlatePlacement::new(frame, &PlateGeometry::of_size(width, height));
    let placement = placement.expect("a place");
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
    let samples: Vec<_> = (0..4).map(|k| image.plane(k)).collect();
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
        settings: Occlusion {
            // The fourth is alpha.
            light_planes: Some(3),
            ..Occlusion::default()
        },
    };
    let rendered = layered.render(&scene, &planes, &no_progress);
    rendered.expect("a lens that can be drawn").planes
}

#[test]
fn results_equal_those_of_the_renderers() {
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(AREA, 4);
    let pass = depth(AREA);
    let (input, depth_input) = (source.input(), pass.input());
    for with_depth in [false, true] {
        let mut plate = plate(&input, AREA);
        let vergence = |metres: &f32| (1.0 / f64::from(*metres)) as f32;
        let vergences: Vec<f32> = pass.samples.iter().map(vergence).collect();
        let mut vergence = VergencePass::Constant(0.5);
        if with_depth {
            plate.depth = &depth_input;
            vergence = VergencePass::PerPixel(&vergences);
        }
        let mut settings = settings();
        settings.edges = SEIDEL_EDGES_MIRROR;
        let got = apply(&lens, &settings, &plate, AREA);
        for (channel, want) in render_by_renderers(&source, vergence).iter().enumerate() {
            assert_eq!(&got.plane(channel), want, "{channel} {with_depth}");
        }
        assert!(max_difference(&got.samples, &source.samples) > 1.0);
    }
}

/// Returns the region of interest of `window`.
fn region_of_interest(
    lens: &LensHandle,
    settings: &SeidelSettings,
    plate: &SeidelPlate,
    window: SeidelRect,
) -> SeidelRect {
    let mut region = rect(0, 0, 0, 0);
    // SAFETY: all pointers are valid.
    assert_ok(unsafe {
        (exports().region_of_interest)(lens.0, settings, plate, &window, &mut region)
    });
    region
}

#[test]
fn windows_are_bit_identical_parts_of_the_whole() {
    let lens = LensHandle::new(2.0);
    let extent = rect(-9, 4, 120, 80);
    let source = TestImage::pattern(extent, 4);
    let pass = depth(extent);
    let mut smaller_regions = 0;
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
        let (input, depth_input) = (source.input(), pass.input());
        let mut whole_plate = plate(&input, extent);
        whole_plate.format = rect(0, 0, 100, 75);
        if with_depth {
            whole_plate.depth = &depth_input;
        }
        let whole = apply(&lens, &settings, &whole_plate, extent);
        for window in [
            rect(-9, 4, 30, 20),
            rect(31, 30, 40, 25),
            rect(110, 40, 1, 44),
        ] {
            let region = region_of_interest(&lens, &settings, &whole_plate, window);
            smaller_regions += usize::from(region != extent);
            let part = source.cut(region);
            let input = part.input();
            let part_plate = SeidelPlate {
                source: &input,
                ..whole_plate
            };
            let got = apply(&lens, &settings, &part_plate, window);
            let want = whole.cut(window);
            assert_eq!(got.bits(), want.bits(), "{quality} {edges} {window:?}");
        }
    }
    assert!(smaller_regions >= 6, "{smaller_regions}");
}

#[test]
fn results_are_the_same_for_any_number_of_threads() {
    let lens = LensHandle::new(3.0);
    let source = TestImage::pattern(AREA, 4);
    let pass = depth(AREA);
    let (input, depth_input) = (source.input(), pass.input());
    let mut plate = plate(&input, AREA);
    plate.depth = &depth_input;
    let results = [1, 2, 3].map(|threads| {
        let mut settings = settings();
        settings.threads = threads;
        apply(&lens, &settings, &plate, AREA).bits()
    });
    assert_eq!(results[0], results[1]);
    assert_eq!(results[0], results[2]);
}

#[test]
fn every_setting_changes_the_result() {
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(STRIP, 4);
    let pass = depth(STRIP);
    let matte = TestImage::from_fn(STRIP, 1, |x, _, _| f32::from(u8::from(x > 90)));
    let (input, depth_input, matte_input) = (source.input(), pass.input(), matte.input());
    let mut base_plate = plate(&input, STRIP);
    base_plate.depth = &depth_input;
    // The blur is wide enough to show background behind an edge.
    let mut base = settings();
    base.amount = 4.0;
    let unchanged = apply(&lens, &base, &base_plate, STRIP).bits();
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
        // The plate's border is partly transparent, so that the nearest pixel is the choice of SEIDEL_EDGES_AUTO.
        ("edges mirror", &|s, _| s.edges = SEIDEL_EDGES_MIRROR),
        ("occlusion", &|s, _| s.occlusion = 0),
        ("fill_foreground", &|s, _| s.fill_foreground = 0),
        ("blur_inside", &|s, _| s.blur_inside = 0),
        ("alpha", &|s, _| s.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED),
        ("lens_scale", &|s, _| s.lens_scale = 0.5),
        ("film_back_mm", &|s, _| s.film_back_mm = 1.0),
        ("focal_length_mm", &|s, _| s.focal_length_mm = 70.0),
        ("pixel_aspect", &|s, _| s.pixel_aspect = 2.0),
        ("depth_unit", &|s, _| s.depth_unit = 0.8),
        ("depth_kind", &|s, _| s.depth_kind = SEIDEL_DEPTH_INVERSE),
        ("depth far one", &|s, _| {
            s.depth_kind = SEIDEL_DEPTH_FAR_ONE;
            (s.depth_near, s.depth_far) = (1.0, 9.0);
        }),
        ("along_ray", &|s, _| s.along_ray = 60.0),
        ("depth_filter", &|s, _| s.depth_filter = 12.0),
        ("matte", &|_, p| p.matte = &matte_input),
        ("matte_depth", &|_, p| {
            p.matte = &matte_input;
            p.matte_depth = &depth_input;
        }),
        ("format", &|_, p| p.format.width = 90),
        ("depth", &|_, p| p.depth = null()),
    ];
    let mut results = vec![("unchanged", unchanged)];
    for (name, change) in changes {
        let (mut settings, mut plate) = (base, base_plate);
        change(&mut settings, &mut plate);
        let got = apply(&lens, &settings, &plate, STRIP).bits();
        assert!(
            results.iter().all(|(_, other)| *other != got),
            "{name} has no effect of its own"
        );
        results.push((name, got));
    }
}

#[test]
fn the_alpha_of_each_colour_is_blurred_like_its_colour() {
    let lens = LensHandle::new(3.0);
    let source = TestImage::from_fn(AREA, 4, |x, _, _| f32::from(u8::from(x > 60)));
    let mut settings = settings();
    settings.alpha_per_channel = 1;
    let input = source.input();
    let plate = plate(&input, AREA);
    let (mut out, mut alphas) = (TestImage::black(AREA, 4), TestImage::black(AREA, 3));
    let (output, alphas_output) = (out.output(), alphas.output());
    // SAFETY: all pointers are valid.
    unsafe {
        let call = |alphas| (exports().apply)(lens.0, &settings, &plate, &output, alphas, null());
        assert_refused(call(null()), SeidelStatus::Argument, "alphas");
        assert_ok(call(&alphas_output));
    }
    // Colour equals alpha in the source, so each blurred colour equals its own alpha.
    for channel in 0..3 {
        assert!(max_difference(&out.plane(channel), &alphas.plane(channel)) < 1e-6);
    }
    assert!(max_difference(&alphas.plane(0), &alphas.plane(2)) > 1e-3);
    assert!(max_difference(&alphas.plane(0), &out.plane(3)) > 1e-3);
}

#[test]
fn a_kernel_is_the_image_of_a_point_light() {
    let lens = LensHandle::new(2.0);
    let source = TestImage::from_fn(AREA, 3, |x, y, _| f32::from(u8::from((x, y) == (80, 30))));
    let input = source.input();
    let plate = plate(&input, AREA);
    let mut settings = settings();
    settings.quality = SEIDEL_QUALITY_EXACT;
    let blurred = apply(&lens, &settings, &plate, AREA);
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
        // SAFETY: all pointers are valid, and `capacity` is the number of weights.
        let draw = |kernel: &mut SeidelKernel| unsafe {
            (exports().kernel)(lens.0, &settings, &plate, channel, 80.5, 30.5, 2.0, kernel)
        };
        assert_refused(draw(&mut kernel), SeidelStatus::TooSmall, "capacity");
        let mut weights = vec![0.0_f32; (kernel.width * kernel.height) as usize];
        kernel.weights = weights.as_mut_ptr();
        kernel.capacity = weights.len() as u64;
        assert_ok(draw(&mut kernel));
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let window = rect(
            80 + kernel.left,
            30 + kernel.top,
            kernel.width as i32,
            kernel.height as i32,
        );
        let drawn = blurred.cut(window).plane(channel as usize);
        assert!(max_difference(&drawn, &weights) < 1e-6);
        assert!(weights.iter().any(|w| *w > 0.02));
        // SAFETY: all pointers are valid.
        let status =
            unsafe { (exports().kernel)(lens.0, &settings, &plate, 3, 5.0, 5.0, 2.0, &mut kernel) };
        assert_refused(status, SeidelStatus::Argument, "channel 3");
    }
}
