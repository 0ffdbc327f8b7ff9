//! Invalid arguments are refused with an error that names them, and outputs are left alone.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use seidel_c::*;

use crate::support::{
    LensHandle, TestImage, assert_ok, assert_refused, exports, last_error, plate, rect, settings,
};

const AREA: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 24,
    height: 16,
};

#[test]
fn versions_are_those_of_the_package_and_the_header() {
    let exports = exports();
    // SAFETY: these functions have no requirements.
    unsafe {
        assert_eq!((exports.abi_version)(), SEIDEL_ABI_VERSION);
        let version = CStr::from_ptr((exports.version)());
        assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
    }
}

#[test]
fn null_pointers_are_refused_by_every_call() {
    let exports = exports();
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(AREA, 4);
    let mut result = TestImage::black(AREA, 4);
    let (image, output) = (source.input(), result.output());
    let plate = plate(&image, AREA);
    let settings = settings();
    let mut region = AREA;
    let mut bytes = 0;
    // SAFETY: pointers are NULL or valid.
    unsafe {
        let argument = |status, text: &str| assert_refused(status, SeidelStatus::Argument, text);
        argument((exports.open)(null(), &mut null_mut()), "path");
        argument((exports.open)(c"lens.json".as_ptr(), null_mut()), "lens");
        argument((exports.read)(null(), 3, &mut null_mut()), "json");
        argument((exports.read)(c"{}".as_ptr(), 2, null_mut()), "lens");
        argument((exports.settings_init)(null_mut()), "settings");
        argument((exports.retain)(null()), "lens");
        argument((exports.info)(null(), null_mut()), "lens");
        argument((exports.info)(lens.0, null_mut()), "info");
        argument(
            (exports.channel)(null(), 0, null_mut(), 0, null_mut()),
            "lens",
        );
        argument(
            (exports.model)(null(), 0, null_mut(), 0, null_mut()),
            "lens",
        );
        assert_ok((exports.release)(null()));
        let apply =
            |lens, plate, output| (exports.apply)(lens, &settings, plate, output, null(), null());
        argument(apply(null(), &plate, &output), "lens");
        argument(apply(lens.0, null(), &output), "plate");
        argument(apply(lens.0, &plate, null()), "output");
        let remove = |lens, plate, output| {
            (exports.remove)(lens, &settings, plate, output, null(), null_mut(), null())
        };
        argument(remove(null(), &plate, &output), "lens");
        argument(remove(lens.0, null(), &output), "plate");
        argument(remove(lens.0, &plate, null()), "output");
        let relens = |from, to, plate, output| {
            (exports.relens)(from, to, &settings, plate, output, null(), null())
        };
        argument(relens(null(), lens.0, &plate, &output), "lens");
        argument(relens(lens.0, null(), &plate, &output), "lens");
        argument(relens(lens.0, lens.0, null(), &output), "plate");
        argument(relens(lens.0, lens.0, &plate, null()), "output");
        let match_colours = |lens, plate, output| {
            (exports.match_colours)(lens, &settings, plate, output, null(), null())
        };
        argument(match_colours(null(), &plate, &output), "lens");
        argument(match_colours(lens.0, null(), &output), "plate");
        argument(match_colours(lens.0, &plate, null()), "output");
        let region_of_interest = |lens, plate, window, region| {
            (exports.region_of_interest)(lens, &settings, plate, window, region)
        };
        argument(
            region_of_interest(null(), &plate, &AREA, &mut region),
            "lens",
        );
        argument(
            region_of_interest(lens.0, null(), &AREA, &mut region),
            "plate",
        );
        argument(
            region_of_interest(lens.0, &plate, null(), &mut region),
            "window",
        );
        argument(
            region_of_interest(lens.0, &plate, &AREA, null_mut()),
            "region",
        );
        let distance_at =
            |lens, plate, distance| (exports.distance_at)(lens, &settings, plate, 5, 5, distance);
        argument(distance_at(null(), &plate, &mut 0.0), "lens");
        argument(distance_at(lens.0, null(), &mut 0.0), "plate");
        argument(distance_at(lens.0, &plate, null_mut()), "distance");
        argument((exports.memory)(&settings, null(), 0, &mut bytes), "plate");
        argument((exports.memory)(&settings, &plate, 0, null_mut()), "bytes");
        let kernel =
            |lens, plate| (exports.kernel)(lens, &settings, plate, 0, 5.0, 5.0, 2.0, null_mut());
        argument(kernel(null(), &plate), "lens");
        argument(kernel(lens.0, null()), "plate");
        argument(kernel(lens.0, &plate), "kernel");
    }
    assert!(result.samples.iter().all(|v| *v == 0.0));
}

/// Asserts that `seidel_apply` refuses arguments with one `change`, with an error that contains `text`.
#[track_caller]
fn refuses(
    status: SeidelStatus,
    text: &str,
    change: impl FnOnce(&mut SeidelSettings, &mut SeidelImage, &mut SeidelImage, &mut SeidelPlate),
) {
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(AREA, 4);
    let mut result = TestImage::black(AREA, 4);
    let (mut image, mut output) = (source.input(), result.output());
    let mut plate = plate(&image, AREA);
    let mut settings = settings();
    change(&mut settings, &mut image, &mut output, &mut plate);
    plate.source = &image;
    // SAFETY: pointers are NULL or valid, and invalid numbers are refused before memory is used.
    let got = unsafe { (exports().apply)(lens.0, &settings, &plate, &output, null(), null()) };
    assert_refused(got, status, text);
    assert!(result.samples.iter().all(|v| *v == 0.0));
}

#[test]
fn invalid_members_are_refused_by_name() {
    use SeidelStatus::{Argument, Unsupported};
    refuses(Argument, "source.data", |_, image, _, _| {
        image.data = null_mut()
    });
    refuses(Argument, "source.channels", |_, image, _, _| {
        image.channels = 5
    });
    refuses(Argument, "source.sample", |_, image, _, _| image.sample = 9);
    refuses(Argument, "source.row_bytes", |_, image, _, _| {
        image.row_bytes = 383
    });
    refuses(Argument, "source.row_bytes", |_, image, _, _| {
        image.row_bytes = i64::MIN
    });
    refuses(Argument, "source.row_bytes", |_, image, _, _| {
        image.row_bytes = i64::MAX / 2;
    });
    refuses(Argument, "source.pixel_bytes", |_, image, _, _| {
        image.pixel_bytes = 15
    });
    refuses(Argument, "source.rect", |_, image, _, _| {
        image.rect.width = 0
    });
    refuses(Argument, "source.rect", |_, image, _, _| {
        image.rect.left = i32::MIN
    });
    refuses(Argument, "source: has a size of 3", |_, image, _, _| {
        image.size = 3
    });
    refuses(Unsupported, "library knows", |_, image, _, _| {
        image.size = 4000
    });
    refuses(Unsupported, "settings", |s, _, _, _| s.size += 8);
    refuses(Argument, "settings", |s, _, _, _| s.size = 0);
    refuses(Argument, "plate", |_, _, _, plate| plate.size = 8);
    refuses(Argument, "plate.format", |_, _, _, plate| {
        plate.format.height = -1
    });
    refuses(Argument, "plate.extent", |_, _, _, plate| {
        plate.extent.width = 0
    });
    refuses(Argument, "output.rect", |_, _, output, _| {
        output.rect.top = 1
    });
    refuses(Argument, "output.channels", |_, _, output, _| {
        output.channels = 3
    });
    refuses(Argument, "settings.edges", |s, _, _, _| s.edges = 4);
    refuses(Argument, "settings.quality", |s, _, _, _| s.quality = 3);
    refuses(Argument, "amount", |s, _, _, _| s.amount = -1.0);
    refuses(Argument, "pixel_aspect", |s, _, _, _| s.pixel_aspect = 0.0);
    refuses(Argument, "lens_scale", |s, _, _, _| s.lens_scale = -1.0);
    refuses(Argument, "film_back_mm", |s, _, _, _| s.film_back_mm = 0.0);
    refuses(Argument, "beside lens_scale", |s, _, _, _| {
        (s.lens_scale, s.film_back_mm) = (1.0, 36.0);
    });
    refuses(Argument, "settings.focal_length_mm", |s, _, _, _| {
        s.focal_length_mm = 0.0
    });
    refuses(Argument, "strength", |s, _, _, _| s.strength = f64::NAN);
    refuses(Argument, "settings.front_multiplier", |s, _, _, _| {
        s.front_multiplier = 99.0
    });
    refuses(Argument, "distance", |s, _, _, _| s.distance = -2.0);
    refuses(Argument, "object distance", |s, _, _, _| {
        s.distance = f64::NAN
    });
    refuses(Argument, "channel_scales", |s, _, _, _| {
        s.channel_scale_count = 3
    });
    refuses(Argument, "alphas", |s, _, _, _| s.alpha_per_channel = 1);
    refuses(Argument, "`swirl`", |s, _, _, _| {
        s.psf_model = c"swirl".as_ptr()
    });
    let scales = [1.0, 1.0];
    refuses(Argument, "settings.channel_scales", |s, _, _, _| {
        s.channel_scales = scales.as_ptr();
        s.channel_scale_count = 2;
    });
    refuses(SeidelStatus::Memory, "settings.memory", |s, _, _, _| {
        s.memory = 1000
    });
    refuses(Argument, "settings.f_number", |s, _, _, _| {
        s.f_number = -3.0
    });
}

#[test]
fn samples_that_are_not_finite_are_refused_by_pixel_or_scrubbed() {
    let lens = LensHandle::new(2.0);
    let area = rect(-4, 7, 24, 16);
    let mut source = TestImage::pattern(area, 4);
    source.samples[(3 * 24 + 5) * 4 + 1] = f32::NAN;
    let image = source.input();
    let plate = plate(&image, area);
    let mut settings = settings();
    let mut result = TestImage::black(area, 4);
    let output = result.output();
    let apply = |settings: &SeidelSettings| {
        // SAFETY: all pointers are valid.
        unsafe { (exports().apply)(lens.0, settings, &plate, &output, null(), null()) }
    };
    assert_refused(
        apply(&settings),
        SeidelStatus::Argument,
        "channel G, pixel (1, 10)",
    );
    settings.amount = 0.0;
    assert_refused(
        apply(&settings),
        SeidelStatus::Argument,
        "channel G, pixel (1, 10)",
    );
    settings.amount = 1.0;
    settings.scrub = 1;
    assert_ok(apply(&settings));
    assert_eq!(last_error(), "");
    assert!(result.samples.iter().all(|v| v.is_finite()));
}
