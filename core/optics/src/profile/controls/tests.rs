//! Controls follow the scaling laws and reject what a lens profile does not determine.

use super::*;
use crate::camera::Camera;
use crate::effects;
use crate::field::{FieldPoint, Frame};
use crate::lens::{LocalPupil, MomentCoefficients, VergenceSeries};
use crate::profile::{MomentsChannel, Provenance};

fn channel(name: &str, offset: f64) -> PupilChannel {
    let series = |c: &[f64]| VergenceSeries::new(c.to_vec());
    let higher = [0.4, -0.3, 0.2, 0.5, -0.6, 0.7, 0.3, -0.2];
    let circles = [1.1, 0.6, 1.3, -0.5];
    PupilChannel {
        name: name.into(),
        alpha: series(&[-10.0 + offset, 20.0]),
        beta: series(&[1.5, 0.2]),
        gamma: series(&[2.0]),
        delta: series(&[-0.7]),
        phi: series(&[0.9]),
        blur_variance_px2: series(&[0.1]),
        magnification: series(&[1e-3]),
        distortion: series(&[-4e-3]),
        measured_vergence: (0.0, 1.0),
        stop_lever_m: 0.0,
        added: Vec::new(),
        picture: None,
        wavelength_px: 0.0,
        effects: vec![
            ProfileEffect {
                effect: effects::by_id("higher_order").expect("listed"),
                values: higher.map(VergenceSeries::constant).to_vec(),
            },
            ProfileEffect {
                effect: effects::by_id("vignetting").expect("listed"),
                values: circles.map(VergenceSeries::constant).to_vec(),
            },
        ],
    }
}

/// A lens that is sharpest at the distance that it states, about 1.8 m, with red and blue focused before and behind it.
fn lens() -> LensProfile {
    let mut lens = lens_with_stated_focus(2.0);
    let sharpest = focus::sharpest(lens.pupil_channels()).expect("a focus");
    lens.camera.focus_distance = ObjectDistance::Metres(1.0 / sharpest);
    lens
}

fn lens_with_stated_focus(metres: f64) -> LensProfile {
    LensProfile {
        frame: Frame::new(600, 400, None).expect("valid"),
        pixel_pitch_um: Some(5.0),
        camera: Camera {
            focal_length_mm: Some(50.0),
            f_number: Some(2.0),
            focus_distance: ObjectDistance::Metres(metres),
            ..Camera::default()
        },
        description: LensDescription::Pupil(vec![channel("R", 0.4), channel("B", -0.4)]),
        held_out: None,
        provenance: Provenance::default(),
    }
}

fn f_number(n: f64) -> Controls {
    Controls {
        f_number: Some(n),
        ..Controls::default()
    }
}

fn focal_length(mm: f64) -> Controls {
    Controls {
        focal_length_mm: Some(mm),
        ..Controls::default()
    }
}

fn focused(distance: ObjectDistance) -> Controls {
    Controls {
        focus_distance: Some(distance),
        ..Controls::default()
    }
}

fn shift(um: f64) -> Controls {
    Controls {
        sensor_shift_um: Some(um),
        ..Controls::default()
    }
}

fn assert_same(a: &LocalPupil, b: &LocalPupil, tolerance: f64) {
    let (x, y) = (a.wavefront.coefficients(), b.wavefront.coefficients());
    for (x, y) in x.iter().zip(y) {
        assert!((x - y).abs() < tolerance, "{a:?}\n{b:?}");
    }
    assert_eq!(a.stops().len(), b.stops().len());
    for (x, y) in a.stops().iter().zip(b.stops()) {
        assert!((x.radius - y.radius).abs() < tolerance);
        assert!((x.centre[0] - y.centre[0]).abs() < tolerance);
        assert!((x.centre[1] - y.centre[1]).abs() < tolerance);
    }
    assert_eq!(a.blur_variance_px2, b.blur_variance_px2);
}

#[test]
fn doubling_the_f_number_halves_the_pupil() {
    let lens = lens();
    let stopped = lens.with_controls(&f_number(4.0)).expect("possible");
    assert_eq!(stopped.camera.f_number, Some(4.0));
    for (x, y) in [(0.0, 0.0), (0.9, 0.0), (-0.4, 0.7), (1.3, -1.2)] {
        let at = FieldPoint::new(x, y);
        for v in [0.0, 0.4, 1.0, 1.3] {
            let wide = lens.pupil_channels()[0].pupil_at(at, v);
            let narrow = stopped.pupil_channels()[0].pupil_at(at, v);
            assert_same(&narrow, &wide.with_pupil(0.5), 1e-12);
        }
    }
    // The original f-number gives the same lens up to rounding, with a warning about extrapolation.
    let back = stopped.with_controls(&f_number(2.0)).expect("possible");
    assert_eq!(back.description, lens.description);
    assert_eq!(stopped.control_warnings(&f_number(2.0)).len(), 1);
    assert!(lens.control_warnings(&f_number(4.0)).is_empty());
}

#[test]
fn neutral_vignetting_stays_within_its_limits() {
    let mut lens = lens();
    let LensDescription::Pupil(channels) = &mut lens.description else {
        panic!("of this kind");
    };
    for channel in channels {
        let carried = &mut channel.effects[1];
        let neutral = effects::neutral(carried.effect);
        carried.values = neutral.into_iter().map(VergenceSeries::constant).collect();
    }
    let stopped = lens.with_controls(&f_number(8.0)).expect("possible");
    assert_eq!(
        stopped.pupil_channels()[0].effects[1].values,
        lens.pupil_channels()[0].effects[1].values
    );
    assert!(LensProfile::from_json(&stopped.to_json()).is_ok());
}

#[test]
fn focus_moves_the_sharpest_plane_and_keeps_axial_colour() {
    let lens = lens();
    let own = lens.camera.focus_distance.vergence_per_m().expect("known");
    for (to, v) in [
        (ObjectDistance::Metres(1.0), 1.0),
        (ObjectDistance::Infinity, 0.0),
    ] {
        let set = lens.with_controls(&focused(to)).expect("possible");
        assert_eq!(set.camera.focus_distance, to);
        let sharpest = focus::sharpest(set.pupil_channels()).expect("a focus");
        assert!((sharpest - v).abs() < 1e-6, "{sharpest} {v}");
        let ratio = (1.0 - 0.05 * own) / (1.0 - 0.05 * v);
        let offset = |lens: &LensProfile, v: f64| {
            let alpha = |k: usize| lens.pupil_channels()[k].numbers(v).alpha;
            alpha(0) - alpha(1)
        };
        assert!((offset(&set, v) - ratio * offset(&lens, own)).abs() < 1e-9);
        for (old, new) in lens.pupil_channels().iter().zip(set.pupil_channels()) {
            assert!((new.alpha.slope(0.3) - 20.0 * ratio).abs() < 1e-12);
            // Aberrations follow the object's distance.
            assert!((new.beta.at(1.0) - 1.7 * ratio).abs() < 1e-12);
            assert!((new.gamma.at(0.0) - 2.0 / ratio).abs() < 1e-12);
            // The slope of the rim ray of f/2 falls with the image distance.
            let slope = |v: f64| (1.0 - 0.05 * v) / 4.0;
            let less_coma = 75.0 * (slope(own).powi(2) - slope(v).powi(2));
            assert!((old.phi.at(0.0) - new.phi.at(0.0) - less_coma).abs() < 1e-12);
        }
    }
    let mut unknown = lens.clone();
    unknown.camera.focal_length_mm = None;
    let to = focused(ObjectDistance::Metres(1.0));
    let set = unknown.with_controls(&to).expect("possible");
    assert_eq!(set.pupil_channels()[0].alpha.slope(0.0), 20.0);
    assert_eq!(unknown.control_warnings(&to).len(), 1);
    assert!(lens.control_warnings(&to).is_empty());
}

#[test]
fn the_stated_focus_leaves_the_lens_as_it_is_and_a_pull_from_it_has_no_step() {
    let lens = lens_with_stated_focus(2.0);
    let sharpest = |metres: f64| {
        let to = focused(ObjectDistance::Metres(metres));
        let set = lens.with_controls(&to).expect("possible");
        focus::sharpest(set.pupil_channels()).expect("a focus")
    };
    let own = lens.with_controls(&focused(ObjectDistance::Metres(2.0)));
    assert_eq!(own.expect("possible").description, lens.description);
    let offset = sharpest(2.0) - 0.5;
    assert!(offset < -0.05, "{offset}");
    for away in [0.0, 1e-4, 1.0, 3.0, 4.0, 10.0] {
        let wanted = 0.5 - away * offset;
        let want = wanted + offset * (1.0 - away / 4.0).max(0.0);
        let found = sharpest(1.0 / wanted);
        assert!((found - want).abs() < 1e-6, "{away}: {found} {want}");
    }
}

#[test]
fn each_plane_of_symmetry_stays_in_focus() {
    let mut lens = lens();
    let LensDescription::Pupil(channels) = &mut lens.description else {
        panic!("of this kind");
    };
    // Along x a quarter of the slope, in focus at the same distance.
    for channel in channels.iter_mut() {
        let mut along_x: Vec<_> = effects::neutral(&effects::DoublePlane)
            .into_iter()
            .map(VergenceSeries::constant)
            .collect();
        along_x[0] = VergenceSeries::new(vec![7.5, -15.0]);
        channel.effects = vec![ProfileEffect {
            effect: &effects::DoublePlane,
            values: along_x,
        }];
        (channel.alpha, channel.beta) = (
            VergenceSeries::new(vec![-10.0, 20.0]),
            VergenceSeries::constant(0.0),
        );
    }
    lens.camera.focus_distance = ObjectDistance::Metres(2.0);
    let axis = FieldPoint::new(0.0, 0.0);
    for metres in [0.8, 1.2, 8.0, 1e9] {
        let to = focused(ObjectDistance::Metres(metres));
        let set = lens.with_controls(&to).expect("possible");
        let size = |v: f64| {
            let moments = set.pupil_channels()[0].moments_at(axis, v);
            [moments.mu20 - 0.1, moments.mu02 - 0.1].map(|m| m.max(0.0).sqrt())
        };
        let [x, y] = size(1.0 / metres);
        assert!(x < 1e-4 && y < 1e-4, "{metres} m: {x} {y}");
        // Before and behind it, beyond the measured range too, discs keep their shape.
        for v in [1.0 / metres - 0.3, 1.0 / metres + 0.4] {
            let [x, y] = size(v);
            assert!((x / y - 0.25).abs() < 1e-4, "{metres} m, {v}: {x} {y}");
        }
    }
}

#[test]
fn a_lens_twice_as_large_has_the_rays_of_objects_at_half_the_distance() {
    let mut lens = lens();
    let LensDescription::Pupil(channels) = &mut lens.description else {
        panic!("of this kind");
    };
    for channel in channels {
        (channel.stop_lever_m, channel.wavelength_px) = (0.02, 0.1);
    }
    // Focused at twice the distance, which leaves the distance to the sensor in proportion.
    let stated = 1.0 / focus::sharpest(lens.pupil_channels()).expect("a focus");
    lens.camera.focus_distance = ObjectDistance::Metres(stated);
    let large = lens.with_controls(&Controls {
        focus_distance: Some(ObjectDistance::Metres(2.0 * stated)),
        ..focal_length(100.0)
    });
    let large = large.expect("possible");
    assert_eq!(large.camera.focal_length_mm, Some(100.0));
    assert_eq!(large.pixel_pitch_um, Some(10.0));
    assert!(large.provenance.settings.contains("100 mm"));
    let pairs = lens.pupil_channels().iter().zip(large.pupil_channels());
    for (old, new) in pairs {
        assert_eq!(new.measured_vergence, (0.0, 0.5));
        assert_eq!(new.wavelength_px, 0.05);
        for (x, y) in [(0.0, 0.0), (-0.4, 0.7), (1.3, -1.2)] {
            let at = FieldPoint::new(x, y);
            for v in [0.0, 0.4, 1.0, 1.3] {
                // The focus is found to 1e-7 / m.
                assert_same(&new.pupil_at(at, v / 2.0), &old.pupil_at(at, v), 1e-5);
                let displacement = |channel: &PupilChannel, v| {
                    let (x, y) = channel.displacement_at(at, v, 300.0);
                    [x, y]
                };
                let (a, b) = (displacement(new, v / 2.0), displacement(old, v));
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6, "{a:?} {b:?}");
            }
        }
    }
    // The focus stays where none is given.
    let kept = lens.with_controls(&focal_length(100.0)).expect("possible");
    assert_eq!(kept.camera.focus_distance, lens.camera.focus_distance);
    let [was, is] = [&lens, &kept].map(|l| focus::sharpest(l.pupil_channels()).expect("a focus"));
    assert!((was - is).abs() < 1e-6, "{was} {is}");
}

#[test]
fn focal_length_focus_and_sensor_shift_follow_the_thin_lens_law() {
    // alpha = Z2 R (v - vfoc) / pitch of a thin lens at every setting.
    let (f, n, pitch) = (0.05, 2.0, 5e-6);
    let of_lens = |z2: f64, f: f64, pitch: f64| {
        let slope = z2 * f / (2.0 * n) / pitch;
        let focus = 1.0 / f - 1.0 / z2;
        VergenceSeries::new(vec![-slope * focus, slope])
    };
    let alpha = |z2| of_lens(z2, f, pitch);
    let at_focus = |v: f64| f / (1.0 - f * v);
    let mut thin = lens_with_stated_focus(2.0);
    let mut only = channel("Y", 0.0);
    only.alpha = alpha(at_focus(0.5));
    only.beta = VergenceSeries::constant(0.0);
    only.effects.clear();
    thin.description = LensDescription::Pupil(vec![only]);
    let near = thin
        .with_controls(&focused(ObjectDistance::Metres(1.25)))
        .expect("possible");
    let moved = thin.with_controls(&shift(200.0)).expect("possible");
    let longer = thin.with_controls(&focal_length(85.0)).expect("possible");
    let (long, wide_pitch) = (0.085, pitch * 85.0 / 50.0);
    let of_longer = of_lens(long / (1.0 - long * 0.5), long, wide_pitch);
    for (set, want) in [
        (&near, alpha(at_focus(0.8))),
        (&moved, alpha(at_focus(0.5) + 2e-4)),
        (&longer, of_longer),
    ] {
        for v in [0.0, 0.5, 1.2] {
            let got = set.pupil_channels()[0].alpha.at(v);
            assert!((got - want.at(v)).abs() < 1e-9, "{v}: {got} {}", want.at(v));
        }
    }
    let ObjectDistance::Metres(m) = moved.camera.focus_distance else {
        panic!("nearer than infinity");
    };
    assert!(m < 2.0, "away from the lens focuses nearer: {m}");
}

#[test]
fn invalid_controls_are_rejected_with_a_remedy() {
    let lens = lens();
    let mut flat = lens.clone();
    let mut still = channel("R", 0.0);
    still.alpha = VergenceSeries::constant(3.0);
    flat.description = LensDescription::Pupil(vec![still]);
    let mut moments = lens.clone();
    moments.description = LensDescription::Moments(vec![MomentsChannel {
        name: "Y".into(),
        planes: vec![crate::profile::MomentsPlane {
            distance: ObjectDistance::Unknown,
            s: MomentCoefficients([1.0; 10]),
            s_sigma: [0.0; 10],
            displacement: None,
            tiles_used: 1,
            tiles_rejected: 0,
        }],
    }]);
    let mut bare = lens.clone();
    bare.camera = Camera::default();
    let mut dark = lens.clone();
    dark.camera.f_number = Some(1e9);
    let one_metre = focused(ObjectDistance::Metres(1.0));
    for (lens, controls, expected) in [
        (&moments, f_number(4.0), "reduced model"),
        (&flat, one_metre, "one object distance"),
        (&lens, focused(ObjectDistance::Metres(0.04)), "focal length"),
        (&lens, focused(ObjectDistance::Unknown), "is unknown"),
        (&lens, f_number(0.0), "f-number"),
        (&lens, f_number(f64::NAN), "f-number"),
        (&lens, f_number(0.49), "give at least 0.5"),
        (&dark, f_number(0.7), "`camera.f_number`"),
        (&bare, f_number(4.0), "camera.f_number"),
        (&bare, shift(10.0), "camera.focal_length_mm"),
        (&bare, focal_length(85.0), "camera.focal_length_mm"),
        (&lens, focal_length(0.0), "at most 64 times"),
        (&lens, focal_length(f64::NAN), "at most 64 times"),
        (&moments, focal_length(85.0), "reduced model"),
        (&lens, shift(f64::INFINITY), "sensor shift"),
    ] {
        let error = lens.with_controls(&controls).expect_err(expected);
        assert!(error.to_string().contains(expected), "{error}");
    }
    // Empty controls are always valid, and so is a sensor shift of a lens measured at one distance.
    assert_eq!(moments.with_controls(&Controls::default()), Ok(moments));
    let moved = flat.with_controls(&shift(10.0)).expect("possible");
    assert_eq!(moved.pupil_channels()[0].alpha.degree(), 0);
    assert!(moved.pupil_channels()[0].alpha.at(0.0) < 3.0);
}
