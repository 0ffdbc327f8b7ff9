//! What cannot be is refused, in words, and nothing is written.

use std::ffi::CStr;
use std::ptr::{null, null_mut};

use seidel_c::*;

use crate::support::{Held, Picture, doors, plate, rect, refused, settings, well, why};

const SIDE: SeidelRect = SeidelRect {
    left: 0,
    top: 0,
    width: 24,
    height: 16,
};

#[test]
fn versions_are_told() {
    let doors = doors();
    // SAFETY: nothing is asked of a caller.
    unsafe {
        assert_eq!((doors.abi_version)(), SEIDEL_ABI_VERSION);
        let version = CStr::from_ptr((doors.version)());
        assert_eq!(version.to_str(), Ok(env!("CARGO_PKG_VERSION")));
    }
}

#[test]
fn null_pointers_are_refused_by_every_call() {
    let doors = doors();
    let lens = Held::new(2.0);
    let source = Picture::busy(SIDE, 4);
    let mut result = Picture::black(SIDE, 4);
    let (image, output) = (source.image(), result.output());
    let plate = plate(&image, SIDE);
    let settings = settings();
    let mut region = SIDE;
    let mut bytes = 0;
    // SAFETY: pointers are NULL or good.
    unsafe {
        let cases = [
            ((doors.open)(null(), &mut null_mut()), "path"),
            ((doors.open)(c"lens.json".as_ptr(), null_mut()), "lens"),
            ((doors.read)(null(), 3, &mut null_mut()), "json"),
            ((doors.read)(c"{}".as_ptr(), 2, null_mut()), "lens"),
        ];
        for (index, (status, _)) in cases.iter().enumerate() {
            assert_eq!(*status, SeidelStatus::Argument, "{index}");
        }
        let argument = |status, says: &str| refused(status, SeidelStatus::Argument, says);
        argument((doors.settings_init)(null_mut()), "settings");
        argument((doors.retain)(null()), "lens");
        argument((doors.info)(null(), null_mut()), "lens");
        argument((doors.info)(lens.0, null_mut()), "info");
        argument(
            (doors.channel)(null(), 0, null_mut(), 0, null_mut()),
            "lens",
        );
        argument((doors.model)(null(), 0, null_mut(), 0, null_mut()), "lens");
        well((doors.release)(null()));
        let apply =
            |lens, plate, output| (doors.apply)(lens, &settings, plate, output, null(), null());
        argument(apply(null(), &plate, &output), "lens");
        argument(apply(lens.0, null(), &output), "plate");
        argument(apply(lens.0, &plate, null()), "output");
        let remove = |lens, plate, output| {
            (doors.remove)(lens, &settings, plate, output, null(), null_mut(), null())
        };
        argument(remove(null(), &plate, &output), "lens");
        argument(remove(lens.0, null(), &output), "plate");
        argument(remove(lens.0, &plate, null()), "output");
        let relens = |from, to, plate, output| {
            (doors.relens)(from, to, &settings, plate, output, null(), null())
        };
        argument(relens(null(), lens.0, &plate, &output), "lens");
        argument(relens(lens.0, null(), &plate, &output), "lens");
        argument(relens(lens.0, lens.0, null(), &output), "plate");
        argument(relens(lens.0, lens.0, &plate, null()), "output");
        let of =
            |lens, plate, window, region| (doors.region)(lens, &settings, plate, window, region);
        argument(of(null(), &plate, &SIDE, &mut region), "lens");
        argument(of(lens.0, null(), &SIDE, &mut region), "plate");
        argument(of(lens.0, &plate, null(), &mut region), "window");
        argument(of(lens.0, &plate, &SIDE, null_mut()), "region");
        argument((doors.memory)(&settings, null(), 0, &mut bytes), "plate");
        argument((doors.memory)(&settings, &plate, 0, null_mut()), "bytes");
        let kernel =
            |lens, plate| (doors.kernel)(lens, &settings, plate, 0, 5.0, 5.0, 2.0, null_mut());
        argument(kernel(null(), &plate), "lens");
        argument(kernel(lens.0, null()), "plate");
        argument(kernel(lens.0, &plate), "kernel");
    }
    assert!(result.samples.iter().all(|v| *v == 0.0));
}

/// Applies with one thing about the call changed; it must be refused.
#[track_caller]
fn refuses(
    status: SeidelStatus,
    says: &str,
    change: impl FnOnce(&mut SeidelSettings, &mut SeidelImage, &mut SeidelImage, &mut SeidelPlate),
) {
    let lens = Held::new(2.0);
    let source = Picture::busy(SIDE, 4);
    let mut result = Picture::black(SIDE, 4);
    let (mut image, mut output) = (source.image(), result.output());
    let mut plate = plate(&image, SIDE);
    let mut settings = settings();
    change(&mut settings, &mut image, &mut output, &mut plate);
    plate.source = &image;
    // SAFETY: pointers are NULL or good; numbers are what is refused.
    let got = unsafe { (doors().apply)(lens.0, &settings, &plate, &output, null(), null()) };
    refused(got, status, says);
    assert!(result.samples.iter().all(|v| *v == 0.0));
}

#[test]
fn numbers_that_cannot_be_are_refused_by_name() {
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
    refuses(Argument, "settings.edges", |s, _, _, _| s.edges = 3);
    refuses(Argument, "settings.quality", |s, _, _, _| s.quality = 3);
    refuses(Argument, "amount", |s, _, _, _| s.amount = -1.0);
    refuses(Argument, "pixel_aspect", |s, _, _, _| s.pixel_aspect = 0.0);
    refuses(Argument, "lens_scale", |s, _, _, _| s.lens_scale = -1.0);
    refuses(Argument, "strength", |s, _, _, _| s.strength = f64::NAN);
    refuses(Argument, "front multiplier", |s, _, _, _| {
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
    refuses(Argument, "f-number", |s, _, _, _| s.f_number = -3.0);
}

#[test]
fn samples_that_are_not_finite_are_named_or_scrubbed() {
    let lens = Held::new(2.0);
    let area = rect(-4, 7, 24, 16);
    let mut source = Picture::busy(area, 4);
    source.samples[(3 * 24 + 5) * 4 + 1] = f32::NAN;
    let image = source.image();
    let plate = plate(&image, area);
    let mut settings = settings();
    let mut result = Picture::black(area, 4);
    let output = result.output();
    let apply = |settings: &SeidelSettings| {
        // SAFETY: all pointers are good.
        unsafe { (doors().apply)(lens.0, settings, &plate, &output, null(), null()) }
    };
    refused(
        apply(&settings),
        SeidelStatus::Argument,
        "channel G, pixel (1, 10)",
    );
    settings.amount = 0.0;
    refused(
        apply(&settings),
        SeidelStatus::Argument,
        "channel G, pixel (1, 10)",
    );
    settings.amount = 1.0;
    settings.scrub = 1;
    well(apply(&settings));
    assert_eq!(why(), "");
    assert!(result.samples.iter().all(|v| v.is_finite()));
}
