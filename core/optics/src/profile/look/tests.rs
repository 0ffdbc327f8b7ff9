//! Tests of each look on PSFs, drawn and measured.

use std::f64::consts::TAU;

use super::*;
use crate::BlurField;
use crate::effects::amount;
use crate::field::FieldPoint;
use crate::library::{self, LibraryLens};
use crate::predict::Predictor;
use crate::psf::{LocalBlur, SampleGrid};

const SIDE: usize = 121;
const MIDDLE: f64 = SIDE as f64 / 2.0;
const AXIS: FieldPoint = FieldPoint { x: 0.0, y: 0.0 };
/// Vergences far behind and well before the focus of the lenses used here, which is at 2 to 2.5 m, 1/m.
const FAR: f64 = 0.0;
const NEAR: f64 = 0.95;

fn lens(name: &str) -> LensProfile {
    let lens = LibraryLens::by_name(name).expect("a name of the library");
    lens.profile().expect("valid")
}

fn with(name: &str, look: Look) -> Predictor {
    let changed = lens(name).with_look(&look).expect("a valid look");
    Predictor::new(&changed).expect("a lens")
}

/// Returns a tile of the light of `blur`, whose centroid lies in its middle.
fn tile(lens: &Predictor, blur: &LocalBlur) -> Vec<f64> {
    let grid = SampleGrid::for_tile(SIDE, SIDE, MIDDLE, MIDDLE);
    let mut samples = vec![0.0; grid.len()];
    lens.default_model().sample(blur, &grid, &mut samples);
    samples
}

fn green(lens: &Predictor, at: FieldPoint, vergence: f64) -> LocalBlur {
    lens.blur_at(1, at, vergence).blur
}

/// Returns the mean light per pixel between two radii from the middle.
fn between(tile: &[f64], inner: f64, outer: f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (k, light) in tile.iter().enumerate() {
        let (x, y) = ((k % SIDE) as f64 + 0.5, (k / SIDE) as f64 + 0.5);
        if (inner..outer).contains(&(x - MIDDLE).hypot(y - MIDDLE)) {
            sum += light;
            count += 1.0;
        }
    }
    sum / count
}

/// Returns the amplitudes of the first harmonics of the light's reach by direction, over its mean.
fn angular_spectrum(tile: &[f64]) -> Vec<f64> {
    const SECTORS: usize = 360;
    let mut reach = vec![0.0; SECTORS];
    // The light of thin sectors grows with the square of their reach in an even disc.
    for (k, light) in tile.iter().enumerate() {
        for sub in 0..25 {
            let x = (k % SIDE) as f64 + 0.1 + 0.2 * (sub % 5) as f64 - MIDDLE;
            let y = (k / SIDE) as f64 + 0.1 + 0.2 * (sub / 5) as f64 - MIDDLE;
            let turn = (y.atan2(x) / TAU).rem_euclid(1.0);
            reach[(turn * SECTORS as f64) as usize % SECTORS] += light / 25.0;
        }
    }
    let amplitude = |n: usize| {
        let wave = |k: usize| (TAU * (n * k) as f64 / SECTORS as f64).sin_cos();
        let (mut s, mut c) = (0.0, 0.0);
        for (k, light) in reach.iter().enumerate() {
            let (sin, cos) = wave(k);
            s += light * sin;
            c += light * cos;
        }
        f64::hypot(s, c)
    };
    (0..=16).map(amplitude).collect()
}

#[test]
fn the_neutral_look_leaves_every_lens_as_it_is() {
    for entry in library::ALL {
        let profile = entry.profile().expect("valid");
        let changed = profile.with_look(&Look::default()).expect("neutral");
        assert_eq!(changed, profile);
        assert_eq!(changed.to_json(), profile.to_json());
        let untilted = Look {
            tilt_direction_deg: -30.0,
            ..Look::default()
        };
        assert_eq!(profile.with_look(&untilted).expect("neutral"), profile);
    }
}

#[test]
fn a_tilted_lens_is_sharp_on_the_plane_of_scheimpflugs_rule() {
    // 50 mm at f/2 on 2 m; half the frame is 1.5 mm wide. Sensor, lens and plane of focus meet in a line.
    let image_m = 0.05 / 0.975;
    for sign in [1.0, -1.0] {
        let lens = amount::tests::lens(sign);
        for (tilt_deg, tilt_direction_deg) in [(8.0, 90.0), (8.0, -90.0), (-5.0, 30.0)] {
            let look = Look {
                tilt_deg,
                tilt_direction_deg,
                ..Look::default()
            };
            let tilted = lens.with_look(&look).expect("a valid look");
            let (y, x) = f64::to_radians(tilt_direction_deg).sin_cos();
            let tangent = f64::to_radians(tilt_deg).tan();
            let predictor = Predictor::new(&tilted).expect("a lens");
            for at in [AXIS, FieldPoint::new(0.3, 0.6), FieldPoint::new(-0.9, 0.4)] {
                // The vertex of the variance, a parabola in vergence.
                let size = |v: f64| predictor.blur_at(0, at, v).blur.moments.trace();
                let [far, middle, near] = [0.3, 0.5, 0.7].map(size);
                let sharpest = 0.5 + 0.1 * (far - near) / (far - 2.0 * middle + near);
                let slope = (at.x * x + at.y * y) * 1.5e-3 / image_m;
                let change = slope * tangent / image_m;
                let error = (sharpest - 0.5 - change).abs();
                assert!(
                    error <= 1e-3 + 0.01 * change.abs(),
                    "{look} {at:?}: {error}"
                );
            }
            let plane = tilted.plane_of_focus().expect("tilted");
            let want = (2.0 / image_m * tangent.abs()).atan().to_degrees();
            assert!((plane.tilt_deg - want).abs() < 0.5, "{plane:?} {want}");
            let along = (plane.nearer[0] * x + plane.nearer[1] * y) * tilt_deg.signum();
            assert!((along - 1.0).abs() < 1e-9, "{plane:?}");
        }
    }
    let mut unknown = amount::tests::lens(1.0);
    unknown.camera.f_number = None;
    let look = Look {
        tilt_deg: 1.0,
        ..Look::default()
    };
    let error = unknown.with_look(&look).expect_err("no cone");
    assert!(error.to_string().contains("camera.f_number"), "{error}");
}

#[test]
fn blades_are_counted_in_the_edge_of_a_disc() {
    for count in [5, 6, 9] {
        let look = Look {
            blades: Some(Blades {
                count,
                roundness: 0.0,
                rotation_deg: 12.0,
            }),
            ..Look::default()
        };
        // Lenses with and without blades of their own.
        for name in ["macro-100", "anamorphic-75", "soft-portrait-85"] {
            if name == "anamorphic-75" && count == 6 {
                continue;
            }
            let lens = with(name, look.clone());
            let mut pupil = green(&lens, AXIS, FAR).pupil.expect("rays");
            // The disc alone: its size, not the aberrations, shows the blades.
            pupil.wavefront = crate::lens::Wavefront::default();
            pupil.wavefront.add_monomial(2, 0, 20.0);
            pupil.wavefront.add_monomial(0, 2, 20.0);
            pupil.sensor = crate::sensor::Sensor::default();
            let blur = LocalBlur::from_pupil(pupil, crate::field::Meridian::X);
            let spectrum = angular_spectrum(&tile(&lens, &blur));
            let strongest = (2..=13).max_by(|a, b| spectrum[*a].total_cmp(&spectrum[*b]));
            assert_eq!(strongest, Some(count as usize), "{name}: {spectrum:?}");
        }
    }
    let round = Look {
        blades: Some(Blades {
            count: 0,
            roundness: 0.0,
            rotation_deg: 0.0,
        }),
        ..Look::default()
    };
    let sixth = |lens: &Predictor| {
        let spectrum = angular_spectrum(&tile(lens, &green(lens, AXIS, 1.8)));
        spectrum[6] / spectrum[0]
    };
    let own = sixth(&with("macro-100", Look::default()));
    let round = sixth(&with("macro-100", round));
    assert!(own > 0.01 && own > 8.0 * round, "{own} {round}");
}

#[test]
fn rotation_turns_the_blades_and_roundness_bends_them() {
    let lens = |roundness, rotation_deg| {
        let blades = Blades {
            count: 5,
            roundness,
            rotation_deg,
        };
        with(
            "soft-portrait-85",
            Look {
                blades: Some(blades),
                ..Look::default()
            },
        )
    };
    let reach = |lens: &Predictor, degrees: f64| {
        let pupil = green(lens, AXIS, FAR).pupil.expect("rays");
        let (sin, cos) = degrees.to_radians().sin_cos();
        pupil.edge([0.0, 0.0], cos, sin).0
    };
    assert!((reach(&lens(0.0, 20.0), 20.0) - 1.0).abs() < 1e-5);
    assert!(reach(&lens(0.0, 20.0), 56.0) < 0.82);
    assert!(reach(&lens(0.7, 20.0), 56.0) > 0.9);
    assert!((reach(&lens(1.0, 20.0), 56.0) - 1.0).abs() < 1e-5);
}

#[test]
fn squeeze_is_the_ratio_of_second_moments() {
    let ratio = |name, squeeze| {
        let look = Look {
            squeeze,
            ..Look::default()
        };
        let lens = with(name, look.clone());
        let tile = tile(&lens, &green(&lens, AXIS, FAR));
        let moment = |axis: usize| {
            let of = |(k, light): (usize, &f64)| {
                let p = [(k % SIDE) as f64, (k / SIDE) as f64][axis] + 0.5 - MIDDLE;
                light * p * p
            };
            tile.iter().enumerate().map(of).sum::<f64>()
        };
        (moment(1) / moment(0)).sqrt()
    };
    // The symmetric blur and the pixels of small discs are not squeezed.
    for squeeze in [0.5, 1.33, 2.0] {
        let got = ratio("modern-50", squeeze);
        assert!((got / squeeze - 1.0).abs() < 0.02, "{squeeze}: {got}");
    }
}

#[test]
fn an_obstruction_leaves_no_light_in_the_middle() {
    for name in ["modern-50", "swirl-58"] {
        let look = Look {
            obstruction: 0.5,
            ..Look::default()
        };
        let (plain, ring) = (with(name, Look::default()), with(name, look.clone()));
        let radius = 2.0 * green(&plain, AXIS, FAR).moments.mu20.sqrt();
        let middle =
            |lens: &Predictor| between(&tile(lens, &green(lens, AXIS, FAR)), 0.0, 0.3 * radius);
        assert!(middle(&ring) < 1e-3 * middle(&plain), "{}", middle(&ring));
        let rim = |lens: &Predictor| {
            between(
                &tile(lens, &green(lens, AXIS, FAR)),
                0.65 * radius,
                0.85 * radius,
            )
        };
        assert!(
            (rim(&ring) / rim(&plain) - 1.0 / 0.75).abs() < 0.05,
            "{}",
            rim(&ring)
        );
    }
}

#[test]
fn spherical_aberration_makes_bubbles_behind_the_focus_and_soft_discs_before_it() {
    let edge = |spherical, vergence| {
        let look = Look {
            spherical,
            ..Look::default()
        };
        let lens = with("modern-50", look);
        let blur = green(&lens, AXIS, vergence);
        let light = tile(&lens, &blur);
        // The radius of the disc is that of its outermost rays.
        let pupil = blur.pupil.expect("rays");
        let radius = (0..40)
            .map(|k| pupil.landing([f64::from(k) / 39.0, 0.0])[0].abs())
            .fold(0.0, f64::max);
        between(&light, 0.84 * radius, 0.95 * radius) / between(&light, 0.0, 0.4 * radius)
    };
    let measured = edge(0.0, FAR);
    assert!((0.8..1.3).contains(&measured), "{measured}");
    assert!(edge(1.0, FAR) > 1.6 * measured, "{}", edge(1.0, FAR));
    assert!(edge(-1.0, FAR) < 0.7 * measured, "{}", edge(-1.0, FAR));
    assert!(
        edge(1.0, NEAR) < 0.7 * edge(0.0, NEAR),
        "{}",
        edge(1.0, NEAR)
    );
    assert!(edge(-1.0, NEAR) > 1.6 * edge(0.0, NEAR));
    // The lens stays focused: no other distance nearby is sharper.
    let lens = with(
        "modern-50",
        Look {
            spherical: 1.0,
            ..Look::default()
        },
    );
    let size = |v| green(&lens, AXIS, v).moments.trace();
    assert!(size(0.5) < size(0.47) && size(0.5) < size(0.53));
}

#[test]
fn axial_colour_scales_and_swaps_the_sizes_of_red_and_blue() {
    let difference = |axial_colour, vergence| {
        let look = Look {
            axial_colour,
            ..Look::default()
        };
        let lens = with("modern-50", look);
        let size = |c| lens.blur_at(c, AXIS, vergence).blur.moments.trace().sqrt();
        (size(2) - size(0), (size(0) + size(1) + size(2)) / 3.0)
    };
    // Blue focuses farther than red: smaller behind the focus, larger before it.
    let (far, mean) = difference(1.0, FAR);
    let (near, _) = difference(1.0, 0.85);
    assert!(far * near < 0.0, "{far} {near}");
    // Spherical aberration differs between the channels as well, and stays.
    let (none, _) = difference(0.0, FAR);
    for factor in [-1.0, 2.0, 4.0] {
        let (scaled, kept) = difference(factor, FAR);
        let ratio = (scaled - none) / (far - none);
        assert!((ratio / factor - 1.0).abs() < 0.02, "{factor}: {ratio}");
        assert!((kept / mean - 1.0).abs() < 0.01, "{factor}: {kept} {mean}");
    }
}

#[test]
fn lateral_colour_scales_the_distance_of_red_and_blue() {
    let corner = FieldPoint { x: 0.8, y: 0.5 };
    let places = |lateral_colour| {
        let look = Look {
            lateral_colour,
            ..Look::default()
        };
        let lens = with("swirl-58", look);
        [0, 1, 2].map(|c| lens.blur_at(c, corner, 0.5).displacement_px)
    };
    let measured = places(1.0);
    let red = measured[0].0 - measured[1].0;
    assert!(red.abs() > 0.5, "{measured:?}");
    for factor in [-1.0, 0.0, 3.0] {
        let changed = places(factor);
        assert!((changed[1].0 - measured[1].0).abs() < 1e-9, "green stays");
        for (new, old) in [(changed[0], measured[0]), (changed[2], measured[2])] {
            let [new, old] = [new.0 - changed[1].0, old.0 - measured[1].0];
            assert!((new - factor * old).abs() < 1e-9, "{factor}: {new} {old}");
        }
    }
}

#[test]
fn cats_eyes_are_the_area_of_corner_discs() {
    let areas = |name, vergence, cats_eye| {
        let look = Look {
            cats_eye,
            ..Look::default()
        };
        let lens = with(name, look.clone());
        [AXIS, FieldPoint { x: 0.85, y: 0.45 }].map(|at| {
            let tile = tile(&lens, &green(&lens, at, vergence));
            let peak = tile.iter().fold(0.0_f64, |a, b| a.max(*b));
            tile.iter().filter(|v| **v > 0.1 * peak).count() as f64
        })
    };
    let [axis, corner] = areas("modern-50", FAR, 0.0);
    assert!(corner < 0.95 * axis, "{corner} {axis}");
    for (strength, least, most) in [(-1.0, 0.97, 1.1), (0.5, 0.5, 0.75), (1.0, 0.2, 0.5)] {
        let [middle, off] = areas("modern-50", FAR, strength);
        assert!((middle / axis - 1.0).abs() < 0.01, "the middle stays");
        let share = off / axis;
        assert!((least..most).contains(&share), "{strength}: {share}");
    }
    // A lens without vignetting gets it.
    let [middle, off] = areas("macro-100", 1.8, 0.6);
    assert!(off < 0.8 * middle && middle > 1000.0, "{off} {middle}");
}

#[test]
fn background_discs_show_the_picture_upright_and_foreground_discs_turned() {
    // Light in the upper right quarter.
    let samples: Vec<f32> = (0..80 * 80)
        .map(|k| f32::from(u8::from(k % 80 >= 40 && k / 80 < 40)))
        .collect();
    let picture = AperturePicture::new(80, &samples).expect("lit");
    let look = Look {
        picture: Some(picture),
        ..Look::default()
    };
    for name in ["modern-50", "soft-portrait-85"] {
        let lens = with(name, look.clone());
        for (vergence, upright) in [(FAR, true), (NEAR, false)] {
            let mut pupil = green(&lens, AXIS, vergence).pupil.expect("rays");
            // Diffraction and rays see the same picture.
            for wave_px in [0.0, 0.4] {
                pupil.wave_px = wave_px;
                let blur = LocalBlur::from_pupil(pupil.clone(), crate::field::Meridian::X);
                let tile = tile(&lens, &blur);
                let [x, y] = pupil.centroid();
                let chief = [MIDDLE - x, MIDDLE - y];
                let mut lit = 0.0;
                for (k, light) in tile.iter().enumerate() {
                    let right = (k % SIDE) as f64 + 0.5 > chief[0];
                    let above = (k / SIDE) as f64 + 0.5 < chief[1];
                    if right == upright && above == upright {
                        lit += light;
                    }
                }
                let share = lit / tile.iter().sum::<f64>();
                assert!(share > 0.85, "{name} {vergence} {wave_px}: {share}");
            }
        }
    }
    let drawn = lens("modern-50").with_look(&look).expect("valid");
    let error = drawn.check_storable().expect_err("files hold no picture");
    assert!(error.to_string().contains("without the picture"), "{error}");
    assert!(LensProfile::from_json(&drawn.to_json()).is_err());
}

#[test]
fn looks_are_saved_with_the_lens() {
    let look = Look {
        blades: Some(Blades {
            count: 7,
            roundness: 0.3,
            rotation_deg: -20.0,
        }),
        picture: None,
        squeeze: 1.5,
        obstruction: 0.3,
        cats_eye: 0.4,
        spherical: -0.5,
        axial_colour: 2.0,
        lateral_colour: 0.0,
        tilt_deg: 4.0,
        tilt_direction_deg: -90.0,
    };
    let settings = "look: 7 blades, roundness 0.3, rotation -20 degrees, squeeze 1.5, obstruction 0.3, cat's eye 0.4, spherical -0.5, axial colour 2, lateral colour 0, tilt 4 degrees towards -90 degrees";
    for entry in library::ALL {
        let changed = entry.profile().expect("valid").with_look(&look);
        let changed = changed.expect("a valid look");
        let read = LensProfile::from_json(&changed.to_json()).expect("valid");
        assert_eq!(read, changed, "{}", entry.name);
        assert!(changed.provenance.settings.ends_with(settings));
    }
}

#[test]
fn bad_values_and_lenses_without_a_pupil_are_refused() {
    let blades = |count, roundness, rotation_deg| Look {
        blades: Some(Blades {
            count,
            roundness,
            rotation_deg,
        }),
        ..Look::default()
    };
    let neutral = Look::default();
    for (look, words) in [
        (blades(2, 0.0, 0.0), ["blades", "3 to 13"]),
        (blades(14, 0.0, 0.0), ["blades", "3 to 13"]),
        (blades(5, 1.5, 0.0), ["roundness", "0 to 1"]),
        (blades(5, 0.5, f64::NAN), ["rotation", "-180 to 180"]),
        (
            Look {
                squeeze: 0.1,
                ..neutral.clone()
            },
            ["squeeze", "0.4 to 2.5"],
        ),
        (
            Look {
                obstruction: 1.0,
                ..neutral.clone()
            },
            ["obstruction", "0 to 0.9"],
        ),
        (
            Look {
                cats_eye: 2.0,
                ..neutral.clone()
            },
            ["cat's eye", "-1 to 1"],
        ),
        (
            Look {
                spherical: -3.0,
                ..neutral.clone()
            },
            ["spherical", "-1 to 1"],
        ),
        (
            Look {
                axial_colour: 9.0,
                ..neutral.clone()
            },
            ["axial colour", "-4 to 4"],
        ),
        (
            Look {
                lateral_colour: f64::INFINITY,
                ..neutral.clone()
            },
            ["lateral colour", "-4 to 4"],
        ),
        (
            Look {
                tilt_deg: 31.0,
                ..neutral.clone()
            },
            ["tilt", "-30 to 30"],
        ),
        (
            Look {
                tilt_direction_deg: 200.0,
                tilt_deg: 1.0,
                ..neutral.clone()
            },
            ["tilt direction", "-180 to 180"],
        ),
    ] {
        let error = lens("modern-50").with_look(&look).expect_err("refused");
        for word in words {
            assert!(error.to_string().contains(word), "{error}");
        }
    }
    let text = r#"{"format": "seidel-lens", "version": 1, "kind": "moments", "image_size": [1920, 1080],
        "optical_axis": [960, 540], "channels": [{"name": "Y", "planes": [{"depth_m": null,
        "s": [4, 1, 0.5, 0, 0, 0, 0, 0, 0, 0], "s_sigma": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
        "tiles_used": 25, "tiles_rejected": 0}]}], "provenance": {"program": "by hand", "sources": [], "settings": ""}}"#;
    let moments = LensProfile::from_json(text).expect("valid");
    let error = moments
        .with_look(&blades(6, 0.0, 0.0))
        .expect_err("no pupil");
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    assert!(error.to_string().contains("reduced model"), "{error}");
}
