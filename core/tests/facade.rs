//! The facade: `apply`, `remove` and `relens` in one call, and what they refuse.

use std::sync::Arc;

use seidel_core::{
    AlphaKind, ChannelScale, Controls, Depth, DepthPass, ErrorKind, Image, Lens, LensSession,
    Margins, ObjectDistance, Plate, Quality, RenderWindow, Settings, apply, match_colours,
    no_progress, relens, remove,
};

const WIDTH: usize = 96;
const HEIGHT: usize = 54;

fn lens() -> Lens {
    Lens::from_json(include_str!("data/lens.json")).expect("a lens profile")
}

/// Bars and a gradient, with alpha where `channels` is 4.
fn image(channels: usize) -> Image {
    let sample = |x: usize, y: usize, k: usize| match k {
        3 => f32::from(u8::from(x > 20)),
        _ => 0.2 + 0.6 * f32::from(u8::from((x / 8 + y / 9).is_multiple_of(2))) + 0.05 * k as f32,
    };
    let samples: Vec<f32> = (0..HEIGHT)
        .flat_map(|y| (0..WIDTH).flat_map(move |x| (0..channels).map(move |k| sample(x, y, k))))
        .collect();
    Image::from_interleaved(WIDTH, HEIGHT, channels, &samples).expect("an image")
}

fn at_metres(metres: f64) -> Depth {
    Depth::Distance(ObjectDistance::metres(metres).expect("a distance"))
}

fn root_mean_square_difference(a: &Image, b: &Image) -> f64 {
    let (a, b) = (a.to_interleaved(), b.to_interleaved());
    let sum: f64 = (a.iter().zip(&b))
        .map(|(a, b)| f64::from(a - b).powi(2))
        .sum();
    (sum / a.len() as f64).sqrt()
}

fn with(change: impl FnOnce(&mut Settings)) -> Settings {
    let mut settings = Settings::default();
    change(&mut settings);
    settings
}

#[test]
fn zero_amount_returns_the_plate_to_the_bit() {
    let plate = Plate::new(image(4)).with_depth(at_metres(4.0));
    let settings = with(|s| s.amount = 0.0);
    let blurred = apply(&lens(), &plate, &settings, &no_progress).expect("a render");
    assert_eq!(blurred, plate.image);
}

#[test]
fn removal_undoes_most_of_the_blur() {
    let (lens, sharp) = (lens(), image(3));
    let settings = Settings::default();
    let plate = Plate::new(sharp.clone()).with_depth(at_metres(4.0));
    let blurred = apply(&lens, &plate, &settings, &no_progress).expect("a render");
    let before = root_mean_square_difference(&blurred, &sharp);
    assert!(before > 0.01, "the lens blurs: {before}");
    let plate = Plate::new(blurred).with_depth(at_metres(4.0));
    let restored = remove(&lens, &plate, &settings, &no_progress).expect("a removal");
    let after = root_mean_square_difference(&restored, &sharp);
    assert!(after < 0.6 * before, "{after} of {before}");
}

/// Tiles of the local spectra are no wider than such kernels.
#[test]
fn removal_of_blur_as_wide_as_the_plate_makes_nothing_worse() {
    let (lens, sharp) = (lens(), image(3));
    let settings = Settings::default();
    for metres in [0.13, 0.1] {
        let plate = Plate::new(sharp.clone()).with_depth(at_metres(metres));
        let blurred = apply(&lens, &plate, &settings, &no_progress).expect("a render");
        let before = root_mean_square_difference(&blurred, &sharp);
        let blurred = Plate::new(blurred).with_depth(at_metres(metres));
        let removed = remove(&lens, &blurred, &settings, &no_progress).expect("a removal");
        let after = root_mean_square_difference(&removed, &sharp);
        assert!(after < 1.01 * before, "{metres} m: {before} {after}");
    }
}

#[test]
fn noise_of_two_colours_of_three_is_refused() {
    let plate = Plate::new(image(3)).with_depth(at_metres(4.0));
    let settings = with(|s| s.removal.noise = vec![0.01, 0.02]);
    for removal in [remove, match_colours] {
        let refused = removal(&lens(), &plate, &settings, &no_progress).expect_err("refused");
        let message = refused.to_string();
        let parts = ["noise", "2 values", "3 colours", "one for each"];
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
}

#[test]
fn the_same_lens_put_back_gives_the_plate_back() {
    let lens = lens();
    let settings = Settings::default();
    let plate = Plate::new(image(3)).with_depth(at_metres(4.0));
    let blurred = apply(&lens, &plate, &settings, &no_progress).expect("a render");
    let plate = Plate::new(blurred.clone()).with_depth(at_metres(4.0));
    let same = relens(&lens, &lens, &plate, &settings, &no_progress).expect("a render");
    let difference = root_mean_square_difference(&same, &blurred);
    assert!(difference < 1e-6, "{difference}");
}

#[test]
fn a_depth_pass_of_one_distance_equals_that_distance() {
    let lens = lens();
    let settings = with(|s| {
        s.quality = Quality::Exact;
        s.occlusion = None;
    });
    let constant = Plate::new(image(3)).with_depth(at_metres(4.0));
    let pass = Depth::Pass(DepthPass::metres(vec![4.0; WIDTH * HEIGHT]));
    let varying = Plate::new(image(3)).with_depth(pass);
    let render = |plate: &Plate| apply(&lens, plate, &settings, &no_progress).expect("a render");
    let difference = root_mean_square_difference(&render(&constant), &render(&varying));
    assert!(difference < 1e-6, "{difference}");
}

#[test]
fn premultiplied_and_unpremultiplied_plates_agree() {
    let lens = lens();
    let premultiplied = {
        let image = image(4);
        let alpha = image.alpha.clone().expect("alpha");
        let colours = image.colours.iter().map(|plane| {
            plane
                .iter()
                .zip(&alpha)
                .map(|(c, a)| c * a)
                .collect::<Vec<f32>>()
        });
        let colours = colours.collect();
        Image::new(WIDTH, HEIGHT, image.names.clone(), colours)
            .expect("an image")
            .with_alpha(Some(alpha), Vec::new(), AlphaKind::Premultiplied)
    };
    let mut straight = image(4);
    straight.alpha_kind = AlphaKind::Unpremultiplied;
    let render = |image: Image| {
        let plate = Plate::new(image).with_depth(at_metres(4.0));
        apply(&lens, &plate, &Settings::default(), &no_progress).expect("a render")
    };
    let (a, b) = (render(premultiplied), render(straight));
    assert_eq!(a.alpha, b.alpha);
    let alpha = a.alpha.as_ref().expect("alpha");
    for (plane, straight) in a.colours.iter().zip(&b.colours) {
        for ((colour, straight), alpha) in plane.iter().zip(straight).zip(alpha) {
            if *alpha > 0.0 {
                assert!((colour - straight * alpha).abs() < 1e-5);
            } else {
                assert_eq!(*straight, 0.0, "no colour where nothing covers the pixel");
            }
        }
    }
}

/// A lens keeps kernels from render to render: other plates, focus and quality get what a lens read anew gives.
#[test]
fn a_lens_that_rendered_before_gives_the_same_result() {
    let used = lens();
    let depth = |nearest: f32| {
        let metres = (0..WIDTH * HEIGHT).map(|index| nearest + (index % WIDTH) as f32 / 20.0);
        Depth::Pass(DepthPass::metres(metres.collect()))
    };
    let focused = with(|s| {
        s.controls = Controls {
            focus_distance: Some(ObjectDistance::metres(1.5).expect("a distance")),
            ..Controls::default()
        };
    });
    let draft = with(|s| s.quality = Quality::Draft);
    for settings in [Settings::default(), focused, draft, Settings::default()] {
        for nearest in [0.8, 1.0] {
            let plate = Plate::new(image(3)).with_depth(depth(nearest));
            let [again, anew] = [&used, &lens()]
                .map(|lens| apply(lens, &plate, &settings, &no_progress).expect("a render"));
            assert_eq!(again, anew);
        }
    }
}

/// The kind and place of the error of a render.
fn refusal(plate: &Plate, settings: &Settings) -> (ErrorKind, String) {
    let refused = apply(&lens(), plate, settings, &no_progress);
    let error = refused.expect_err("a refusal");
    (error.kind(), error.place.clone())
}

#[test]
fn refusals_say_where_and_of_what_kind() {
    let plate = Plate::new(image(3)).with_depth(at_metres(4.0));
    let invalid = |place: &str| (ErrorKind::InvalidInput, place.to_owned());
    assert_eq!(
        refusal(&plate, &with(|s| s.amount = 17.0)),
        invalid("amount")
    );
    let no_channel = with(|s| {
        s.channel_scales = vec![ChannelScale {
            channel: "X".into(),
            scale: 1.0,
        }];
    });
    assert_eq!(refusal(&plate, &no_channel), invalid("channel scale X"));
    let unknown = Plate::new(image(3));
    assert_eq!(
        refusal(&unknown, &Settings::default()),
        invalid("object distance")
    );
    let mut bad = image(3);
    bad.colours[1][WIDTH + 2] = f32::NAN;
    let bad = Plate::new(bad).with_depth(at_metres(4.0));
    assert_eq!(
        refusal(&bad, &Settings::default()),
        invalid("channel G, pixel (2, 1)")
    );
    let focus = with(|s| {
        s.controls = Controls {
            f_number: Some(-1.0),
            ..Controls::default()
        };
    });
    assert_eq!(refusal(&plate, &focus).0, ErrorKind::InvalidInput);
}

#[test]
fn progress_that_says_stop_cancels() {
    let plate = Plate::new(image(3)).with_depth(at_metres(4.0));
    let error = apply(&lens(), &plate, &Settings::default(), &|_| false);
    assert!(error.expect_err("cancelled").is_cancelled());
}

/// An image of small light with the sample `light` in the 4 x 4 pixels from (40, 24), in each colour.
fn with_light(light: f32) -> Image {
    let mut image = image(3);
    for plane in &mut image.colours {
        for at in (24..28).flat_map(|y| (40..44).map(move |x| WIDTH * y + x)) {
            plane[at] = light;
        }
    }
    image
}

#[test]
fn no_light_that_a_plate_can_hold_overflows() {
    let lens = lens();
    for light in [1e10, 1e15, 1e19, 1e30, f32::MAX] {
        let plate = Plate::new(with_light(light)).with_depth(at_metres(4.0));
        let sum = |image: &Image| -> f64 { image.colours[1].iter().map(|v| f64::from(*v)).sum() };
        for quality in [Quality::Draft, Quality::Final, Quality::Exact] {
            let settings = with(|s| s.quality = quality);
            let blurred = apply(&lens, &plate, &settings, &no_progress).expect("a render");
            blurred.check_finite().expect("finite");
            let kept = sum(&blurred) / sum(&plate.image);
            assert!((kept - 1.0).abs() < 0.01, "{light} {quality:?}: {kept}");
        }
        if light > 1e19 {
            // A removal divides by the noise, which is lost beside such light.
            continue;
        }
        let settings = Settings::default();
        let sharp = remove(&lens, &plate, &settings, &no_progress).expect("a removal");
        sharp.check_finite().expect("finite");
        let same = relens(&lens, &lens, &plate, &settings, &no_progress).expect("a render");
        same.check_finite().expect("finite");
    }
}

#[test]
fn an_overflow_of_a_removal_is_refused_by_channel_and_pixel() {
    let plate = Plate::new(with_light(f32::MAX)).with_depth(at_metres(4.0));
    let settings = Settings::default();
    let nearer = Controls {
        focus_distance: Some(ObjectDistance::Metres(1.9)),
        ..Controls::default()
    };
    let other = lens().with_controls(&nearer).expect("possible");
    for result in [
        remove(&lens(), &plate, &settings, &no_progress),
        relens(&lens(), &other, &plate, &settings, &no_progress),
    ] {
        let refused = result.expect_err("an overflow");
        assert!(refused.place.starts_with("channel R, pixel ("), "{refused}");
        assert!(refused.place.ends_with(") of the result"), "{refused}");
        assert!(refused.remedy.contains("clip"), "{refused}");
    }
}

#[test]
fn pixels_of_expanded_plates_and_windows_are_counted_on_the_plate() {
    let session = LensSession::new(&lens(), &Settings::default()).expect("a session");
    let plate = Plate::new(image(3)).with_depth(at_metres(4.0));
    let own = Arc::new(session).prepare(plate).expect("a plate");
    let margins = Margins {
        left: 10,
        top: 7,
        ..Margins::default()
    };
    let expanded = own.expanded(margins).expect("an expanded plate");
    // The sample at column 3 and row 2 of planes of this size.
    let planes = |width: usize, height: usize| {
        let mut plane = vec![0.0; width * height];
        plane[2 * width + 3] = f32::INFINITY;
        vec![plane; 3]
    };
    let window = RenderWindow {
        column: 12,
        row: 6,
        width: 8,
        height: 4,
    };
    let (width, height) = (WIDTH + 10, HEIGHT + 7);
    for (image, pixel) in [
        (own.to_image(planes(WIDTH, HEIGHT)), "(3, 2)"),
        (own.to_image_of_window(window, planes(8, 4)), "(15, 8)"),
        (expanded.to_image(planes(width, height)), "(-7, -5)"),
        (expanded.to_image_of_window(window, planes(8, 4)), "(5, 1)"),
    ] {
        let place = image.expect_err("an infinite sample").place;
        assert_eq!(place, format!("channel R, pixel {pixel} of the result"));
    }
}

#[test]
fn a_product_of_colour_and_alpha_that_overflows_is_refused() {
    let mut image = image(4);
    image.alpha_kind = AlphaKind::Unpremultiplied;
    image.colours[2][WIDTH * 3 + 5] = 1e30;
    if let Some(alpha) = &mut image.alpha {
        alpha[WIDTH * 3 + 5] = 1e30;
    }
    let plate = Plate::new(image).with_depth(at_metres(4.0));
    let refused = apply(&lens(), &plate, &Settings::default(), &no_progress);
    let place = refused.expect_err("an overflow").place;
    assert_eq!(place, "channel B, pixel (5, 3)");
}
