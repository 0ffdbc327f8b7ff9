//! Independence of a plate with depth from the margin about it; results of brighter and of mirrored plates, and of settings written in
//! another way.

use seidel_core::{
    Depth, DepthPass, Edges, Expand, Image, Lens, LensSession, Margins, Plate, PlateGeometry,
    PreparedPlate, Quality, Rectangle, Settings, no_progress,
};
use std::sync::Arc;

/// The display window, and the window of the element in it.
const DISPLAY: [usize; 2] = [192, 108];
const ELEMENT: Rectangle = Rectangle {
    x: 61,
    y: 29,
    width: 70,
    height: 52,
};

fn lens() -> Lens {
    Lens::from_json(include_str!("data/lens.json")).expect("a lens profile")
}

/// Returns a thin lens focused on 3 m, whose blur is the same over the frame and symmetric.
fn thin_lens() -> Lens {
    let numbers = |values: &str, sigma: &str| {
        format!(r#"{{"coefficients": [{values}], "sigma": [{sigma}]}}"#)
    };
    let zeros = [
        "beta",
        "gamma",
        "delta",
        "phi",
        "blur_variance_px2",
        "magnification",
        "distortion",
    ];
    let zeros = zeros
        .map(|name| format!(r#""{name}": {}"#, numbers("0.0", "0.0")))
        .join(", ");
    let channel = |name: &str| {
        let alpha = numbers("-6.0, 18.0", "0.0, 0.0");
        format!(
            r#"{{"name": "{name}", "alpha": {alpha}, {zeros}, "measured_vergence_per_m": [0.0, 4.0], "effects": []}}"#
        )
    };
    let channels = ["R", "G", "B"].map(channel).join(", ");
    let [width, height] = DISPLAY;
    let axis = [width, height].map(|size| size as f64 / 2.0);
    let json = format!(
        r#"{{"format": "seidel-lens", "version": 1, "kind": "pupil", "image_size": [{width}, {height}], "optical_axis": {axis:?},
            "pixel_pitch_um": 56.25, "channels": [{channels}],
            "provenance": {{"program": "test", "sources": [], "settings": ""}}}}"#
    );
    Lens::from_json(&json).expect("a lens profile")
}

/// Returns red, green, blue, alpha and metres of a pixel of the frame: a disc at 3 m behind a bar at 1.5 m, with lights, over nothing.
fn element_at(x: i32, y: i32) -> [f32; 5] {
    let (u, v) = (x as f32 - 96.0, y as f32 - 54.0);
    let is_light = (x * 13 + y * 29) % 97 == 0;
    let tone = |k: f32| {
        let texture = 0.3 + 0.2 * (u * k).sin() * (v * 0.7).cos();
        if is_light { 40.0 } else { texture }
    };
    if (u - 0.3 * v).abs() < 5.0 && v.abs() < 22.0 {
        [tone(0.9), tone(0.5), tone(1.3), 1.0, 1.5]
    } else if u.hypot(v) < 24.0 {
        [tone(0.4), tone(0.8), tone(0.6), 1.0, 3.0]
    } else {
        [0.0, 0.0, 0.0, 0.0, 9.0]
    }
}

/// Whether an element has an alpha plane.
#[derive(Clone, Copy, PartialEq)]
enum Alpha {
    Kept,
    Dropped,
}

fn settings(quality: Quality) -> Settings {
    let mut settings = Settings::default();
    settings.quality = quality;
    settings.edges = Some(Edges::Black);
    settings.expand = Expand::Always;
    settings
}

fn session(lens: &Lens, settings: &Settings) -> Arc<LensSession> {
    Arc::new(LensSession::new(lens, settings).expect("a session"))
}

/// Returns a plate of `pixels` in a data window of the frame.
fn plate(data: Rectangle, alpha: Alpha, pixels: impl Fn(i32, i32) -> [f32; 5]) -> Plate {
    let rows = data.y..data.y + data.height as i32;
    let all = rows.flat_map(|y| (data.x..data.x + data.width as i32).map(move |x| (x, y)));
    let all: Vec<[f32; 5]> = all.map(|(x, y)| pixels(x, y)).collect();
    let channels = if alpha == Alpha::Kept { 4 } else { 3 };
    let samples: Vec<f32> = (all.iter())
        .flat_map(|pixel| &pixel[..channels])
        .copied()
        .collect();
    let image = Image::from_interleaved(data.width, data.height, channels, &samples);
    let metres = all.iter().map(|pixel| pixel[4]).collect();
    let mut plate = Plate::new(image.expect("an image"));
    plate.geometry = PlateGeometry {
        data,
        ..PlateGeometry::of_size(DISPLAY[0], DISPLAY[1])
    };
    plate.with_depth(Depth::Pass(DepthPass::metres(metres)))
}

fn rendered(prepared: &PreparedPlate) -> Vec<Vec<f32>> {
    prepared.apply(&no_progress).expect("a render")
}

/// Returns the part of planes over one window that lies in another one.
fn cut(planes: &[Vec<f32>], from: Rectangle, part: Rectangle) -> Vec<f32> {
    let row = |plane: &Vec<f32>, y: i32| {
        let first = (y - from.y) as usize * from.width + (part.x - from.x) as usize;
        plane[first..first + part.width].to_vec()
    };
    let rows = part.y..part.y + part.height as i32;
    let lines = (planes.iter()).flat_map(|plane| rows.clone().flat_map(move |y| row(plane, y)));
    lines.collect()
}

fn largest_difference(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f32::max)
}

#[test]
fn an_expanded_plate_has_the_same_samples_inside() {
    for alpha in [Alpha::Kept, Alpha::Dropped] {
        for quality in [Quality::Draft, Quality::Final, Quality::Exact] {
            let session = session(&lens(), &settings(quality));
            let own = session.prepare(plate(ELEMENT, alpha, element_at));
            let own = own.expect("a plate");
            let margins = own.expansion().expect("margins");
            assert!(!margins.is_none(), "the plate is expanded");
            let inside = rendered(&own).concat();
            let odd = Margins {
                left: 5,
                bottom: 3,
                ..Margins::default()
            };
            for margins in [margins, odd] {
                let expanded = own.expanded(margins).expect("an expanded plate");
                let of_expanded = rendered(&expanded);
                let apart = cut(&of_expanded, margins.around(ELEMENT), ELEMENT);
                let apart = largest_difference(&apart, &inside);
                // Rounding of positions in the frame.
                assert!(apart < 1e-5, "{quality:?}, {margins:?}: {apart}");
            }
        }
    }
}

#[test]
fn transparent_pixels_about_an_element_change_nothing_inside() {
    let wide = Rectangle {
        x: ELEMENT.x - 19,
        y: ELEMENT.y - 11,
        width: ELEMENT.width + 30,
        height: ELEMENT.height + 38,
    };
    for quality in [Quality::Final, Quality::Exact] {
        let session = session(&thin_lens(), &settings(quality));
        let of = |data| {
            let prepared = session.prepare(plate(data, Alpha::Kept, element_at));
            rendered(&prepared.expect("a plate"))
        };
        let apart = cut(&of(wide), wide, ELEMENT);
        let apart = largest_difference(&apart, &of(ELEMENT).concat());
        assert!(apart < 1e-5, "{quality:?}: {apart}");
    }
}

/// Returns the whole frame, rendered, of an element whose pixels are changed.
fn frame_of(change: impl Fn(i32, i32) -> [f32; 5]) -> Vec<Vec<f32>> {
    let all = PlateGeometry::of_size(DISPLAY[0], DISPLAY[1]).data;
    let session = session(&thin_lens(), &settings(Quality::Final));
    let prepared = session.prepare(plate(all, Alpha::Kept, change));
    rendered(&prepared.expect("a plate"))
}

#[test]
fn brighter_elements_give_results_as_many_times_as_bright() {
    let own = frame_of(element_at);
    for factor in [0.1, 10.0, 1e4] {
        let brighter = frame_of(|x, y| {
            let [r, g, b, alpha, metres] = element_at(x, y);
            [r * factor, g * factor, b * factor, alpha, metres]
        });
        for (plane, (brighter, own)) in brighter.iter().zip(&own).enumerate() {
            let factor = if plane == 3 { 1.0 } else { factor };
            let back: Vec<f32> = brighter.iter().map(|light| light / factor).collect();
            let apart = largest_difference(&back, own);
            assert!(apart < 1e-5, "plane {plane} by {factor}: {apart}");
        }
    }
}

#[test]
fn mirrored_elements_without_lights_give_mirrored_results() {
    let [right, bottom] = DISPLAY.map(|size| size as i32 - 1);
    let without_lights = |x, y| {
        let [r, g, b, alpha, metres] = element_at(x, y);
        [r.min(0.5), g.min(0.5), b.min(0.5), alpha, metres]
    };
    let own = frame_of(without_lights).concat();
    let width = DISPLAY[0];
    for (across, down) in [(true, false), (false, true), (true, true)] {
        let place = |x: i32, y: i32| {
            let x = if across { right - x } else { x };
            (x, if down { bottom - y } else { y })
        };
        let mirrored = frame_of(|x, y| {
            let (x, y) = place(x, y);
            without_lights(x, y)
        });
        let back = mirrored.iter().flat_map(|plane| {
            let at = move |(x, y): (i32, i32)| plane[y as usize * width + x as usize];
            let pixels = (0..=bottom).flat_map(|y| (0..=right).map(move |x| (x, y)));
            pixels.map(move |(x, y)| at(place(x, y)))
        });
        let squares = back.zip(&own).map(|(a, b)| f64::from(a - b).powi(2));
        let psnr = -10.0 * (squares.sum::<f64>() / own.len() as f64).log10();
        assert!(psnr > 72.0, "across {across}, down {down}: {psnr} dB");
    }
}

/// The profile's own focus, f-number and focal length, stated again, are no change; depth in another unit or convention is the same depth.
#[test]
fn settings_written_in_another_way_give_the_same_result() {
    use seidel_core::{Controls, DepthConvention, DepthMeaning, ObjectDistance};
    let frame = |controls: Controls, convention: DepthConvention, value: fn(f32) -> f32| {
        let mut settings = settings(Quality::Final);
        settings.controls = controls;
        let mut plate = plate(ELEMENT, Alpha::Kept, element_at);
        let Depth::Pass(pass) = &mut plate.depth else {
            panic!("a depth pass")
        };
        pass.samples
            .iter_mut()
            .for_each(|sample| *sample = value(*sample));
        pass.meaning = DepthMeaning {
            convention,
            ..DepthMeaning::METRES
        };
        let prepared = session(&lens(), &settings).prepare(plate);
        rendered(&prepared.expect("a plate")).concat()
    };
    let metres = DepthConvention::Distance {
        metres_per_unit: 1.0,
    };
    let own = frame(Controls::default(), metres, |z| z);
    let stated = [
        Controls {
            f_number: Some(0.95),
            ..Controls::default()
        },
        Controls {
            focus_distance: Some(ObjectDistance::Metres(2.0)),
            ..Controls::default()
        },
        Controls {
            focal_length_mm: Some(50.0),
            ..Controls::default()
        },
    ];
    for controls in stated {
        assert_eq!(
            largest_difference(&frame(controls, metres, |z| z), &own),
            0.0,
            "{controls:?}"
        );
    }
    let (near_m, far_m) = (1.0, 9.0);
    type Reading = (DepthConvention, fn(f32) -> f32);
    let conventions: [Reading; 5] = [
        (
            DepthConvention::Distance {
                metres_per_unit: 0.001,
            },
            |z| 1000.0 * z,
        ),
        (
            DepthConvention::Distance {
                metres_per_unit: -0.3048,
            },
            |z| z / -0.3048,
        ),
        (
            DepthConvention::Inverse {
                metres_per_unit: 1.0,
            },
            |z| 1.0 / z,
        ),
        (DepthConvention::FarOne { near_m, far_m }, |z| {
            (z - 1.0) / 8.0
        }),
        (DepthConvention::FarZero { near_m, far_m }, |z| {
            (9.0 - z) / 8.0
        }),
    ];
    let brightest = own.iter().copied().fold(0.0, f32::max);
    for (convention, value) in conventions {
        let apart = largest_difference(&frame(Controls::default(), convention, value), &own);
        assert!(
            apart < 1e-5 * brightest,
            "{convention:?}: {apart} of {brightest}"
        );
    }
}
