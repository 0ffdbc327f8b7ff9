//! Focus controls: neutral values, the range in focus, multipliers, the largest kernel, and order in depth.

use crate::*;
use seidel_optics::field::{FieldPoint, Frame, ImagePoint};
use seidel_optics::lens::{LocalPupil, ReducedNumbers, Wavefront};
use seidel_optics::moments::CentralMoments;
use seidel_optics::numeric::SplitMix64;
use seidel_optics::psf::LocalBlur;

/// A lens in focus at 2 m, with more blur off the axis and a little more in the second channel.
struct TestLens {
    /// Growth of the standard deviation with vergence, px m.
    slope: f64,
}

const MADE: TestLens = TestLens { slope: 9.0 };
const FOCUS: f64 = 0.5;

impl BlurField for TestLens {
    fn frame(&self) -> Frame {
        Frame::new(300, 200, None).expect("a valid frame")
    }

    fn channel_count(&self) -> usize {
        2
    }

    fn blur_at(&self, channel: usize, at: FieldPoint, vergence: f64) -> DisplacedBlur {
        let sigma = self.slope * (vergence - FOCUS);
        let field = 1.0 + 0.3 * (at.x * at.x + at.y * at.y);
        let along = (sigma * sigma * field + 0.4) * (1.0 + 0.1 * channel as f64);
        let moments = CentralMoments::from_array([along, 0.1, 0.8 * along, 0.0, 0.0, 0.0, 0.0]);
        DisplacedBlur {
            blur: LocalBlur::from_moments(moments, at.meridian()),
            displacement_px: (0.0, 0.0),
        }
    }
}

const PLATE: PlateExtent = PlateExtent {
    map: PlateMap {
        origin: ImagePoint {
            x_px: 0.0,
            y_px: 0.0,
        },
        scale: 2.0,
    },
    width: 600,
    height: 400,
};

fn remap(controls: FocusControls) -> FocusRemap {
    FocusRemap::new(&MADE, PLATE, &controls).expect("valid")
}

/// Vergences from beyond infinity to 5 cm.
fn vergences() -> impl Iterator<Item = f64> {
    (-40..4000).map(|k| f64::from(k) * 0.005)
}

#[test]
fn neutral_controls_change_no_bit() {
    let neutral = remap(FocusControls::default());
    let wide = remap(FocusControls {
        focus_per_m: Some(0.37),
        maximum_px: Some(1e9),
        ..FocusControls::default()
    });
    for v in vergences() {
        assert_eq!(neutral.vergence(v).to_bits(), (v + 0.0).to_bits(), "{v}");
        assert_eq!(wide.vergence(v).to_bits(), (v + 0.0).to_bits(), "{v}");
    }
}

#[test]
fn the_range_is_in_focus_and_blur_grows_from_its_ends() {
    let range = remap(FocusControls {
        depth_of_field_m: 0.8,
        ..FocusControls::default()
    });
    for (z, want) in [
        (2.4, FOCUS),
        (2.0, FOCUS),
        (1.7, FOCUS),
        (1.6, FOCUS),
        (1.0, FOCUS + 1.0 - 1.0 / 1.6),
        (4.0, FOCUS + 0.25 - 1.0 / 2.4),
        (f64::INFINITY, FOCUS - 1.0 / 2.4),
    ] {
        assert!((range.vergence(1.0 / z) - want).abs() < 1e-9, "{z} m");
    }
    // A range that reaches the camera: nothing in front of the focus plane is blurred.
    let all = remap(FocusControls {
        depth_of_field_m: 5.0,
        ..FocusControls::default()
    });
    assert!((all.vergence(40.0) - FOCUS).abs() < 1e-9);
    assert!(all.vergence(0.1) < FOCUS - 0.1);
}

#[test]
fn multipliers_scale_the_distance_from_focus() {
    let range = remap(FocusControls {
        front: 2.0,
        back: 0.0,
        ..FocusControls::default()
    });
    let at = FieldPoint::new(0.6, -0.3);
    let blur = |v: f64| MADE.blur_at(1, at, v).blur.moments.to_array();
    for by in [0.01, 0.2, 3.0] {
        let front = blur(range.vergence(FOCUS + by));
        for (got, want) in front.iter().zip(blur(FOCUS + 2.0 * by)) {
            assert!((got - want).abs() < 1e-6 * (1.0 + want), "{by}");
        }
        assert!((range.vergence(FOCUS - by) - FOCUS).abs() < 1e-9, "{by}");
    }
    let front_alone = remap(FocusControls {
        front: 2.0,
        ..FocusControls::default()
    });
    assert_eq!(front_alone.vergence(0.123), 0.123);
}

/// Two standard deviations of the widest kernel of all pixels on the plate's rim, plate px.
fn largest(lens: &dyn BlurField, v: f64) -> f64 {
    let mut most = 0.0_f64;
    for k in 0..2 * (PLATE.width + PLATE.height) {
        let (column, row) = match k / 2 {
            c if c < PLATE.width => (c, (k % 2) * (PLATE.height - 1)),
            r => ((k % 2) * (PLATE.width - 1), r - PLATE.width),
        };
        let at = lens.frame().field_point(PLATE.map.frame_point(column, row));
        for channel in 0..lens.channel_count() {
            let m = lens.blur_at(channel, at, v).blur.moments;
            // The widest of many directions.
            for turn in 0..90 {
                let angle = f64::from(turn) * std::f64::consts::PI / 90.0;
                let (sin, cos) = angle.sin_cos();
                let along = cos * cos * m.mu20 + 2.0 * sin * cos * m.mu11 + sin * sin * m.mu02;
                most = most.max(2.0 * along.sqrt() * PLATE.map.scale);
            }
        }
    }
    most
}

#[test]
fn the_largest_kernel_has_the_maximum_size() {
    let maximum = 11.0;
    let range = remap(FocusControls {
        maximum_px: Some(maximum),
        front: 1.5,
        ..FocusControls::default()
    });
    for v in [0.0, 0.2, 0.49, 0.6, 1.0, 7.0, 1e3] {
        let size = largest(&MADE, range.vergence(v));
        assert!(size <= maximum * (1.0 + 1e-6), "{v}: {size}");
    }
    assert!(largest(&MADE, range.vergence(7.0)) > 0.999 * maximum);
    assert!(largest(&MADE, range.vergence(0.0)) > 0.999 * maximum);
    assert_eq!(range.vergence(0.45), 0.45, "what is small enough stays");
}

#[test]
fn a_maximum_below_the_kernels_in_focus_draws_everything_as_in_focus() {
    let range = remap(FocusControls {
        maximum_px: Some(1.0),
        ..FocusControls::default()
    });
    let in_focus = largest(&MADE, FOCUS);
    let stated = range.unreachable_maximum_px().expect("a maximum too small");
    // The sharpest vergence is found to a thousandth of the blur there.
    let ratio = stated / in_focus;
    assert!((ratio - 1.0).abs() < 1e-3, "{stated} {in_focus}");
    for v in vergences().step_by(37) {
        assert!(largest(&MADE, range.vergence(v)) < 1.002 * in_focus, "{v}");
    }
}

#[test]
fn all_controls_keep_the_order_in_depth() {
    let mut random = SplitMix64::new(8);
    for _ in 0..200 {
        let controls = FocusControls {
            focus_per_m: (random.unit() < 0.5).then(|| 0.2 + random.unit()),
            depth_of_field_m: 3.0 * (random.unit() - 0.3).max(0.0),
            front: 4.0 * random.unit(),
            back: 4.0 * random.unit(),
            maximum_px: (random.unit() < 0.5).then(|| 40.0 + 200.0 * random.unit()),
        };
        let range = remap(controls);
        let drawn: Vec<f64> = vergences().map(|v| range.vergence(v)).collect();
        assert!(
            drawn.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12),
            "{controls:?}"
        );
    }
}

#[test]
fn focus_is_where_the_lens_is_sharpest() {
    let found = focus_vergence(&MADE).expect("a focus");
    assert!((found - FOCUS).abs() < 1e-9);
    assert_eq!(focus_vergence(&TestLens { slope: 0.0 }), None);
    // Spherical aberration moves the sharpest plane away from the paraxial focus.
    struct Spherical;
    impl BlurField for Spherical {
        fn frame(&self) -> Frame {
            MADE.frame()
        }
        fn channel_count(&self) -> usize {
            1
        }
        fn blur_at(&self, _: usize, at: FieldPoint, v: f64) -> DisplacedBlur {
            let numbers = ReducedNumbers {
                alpha: 6.0 * (v - 0.8),
                beta: 1.5,
                gamma: 0.0,
                delta: 0.0,
                phi: 0.0,
            };
            let pupil = LocalPupil::circular(Wavefront::third_order(&numbers, at), 0.0);
            DisplacedBlur {
                blur: LocalBlur::from_pupil(pupil, at.meridian()),
                displacement_px: (0.0, 0.0),
            }
        }
    }
    let size = |v: f64| {
        let axis = FieldPoint::new(0.0, 0.0);
        Spherical.blur_at(0, axis, v).blur.moments.trace()
    };
    let found = focus_vergence(&Spherical).expect("a focus");
    assert!((found - 0.8).abs() > 0.05);
    let steps = (0..4000).map(|k| f64::from(k) * 0.0005);
    let least = steps.reduce(|a, b| if size(b) < size(a) { b } else { a });
    assert!((found - least.expect("steps")).abs() < 0.001);
}

#[test]
fn focus_planes_and_lenses_without_a_range_are_refused() {
    let refused = |lens: &TestLens, controls: FocusControls| {
        let error = FocusRemap::new(lens, PLATE, &controls).expect_err("refused");
        error.to_string()
    };
    let neutral = FocusControls::default();
    let nowhere = FocusControls {
        focus_per_m: Some(f64::NAN),
        front: 2.0,
        ..neutral
    };
    assert!(refused(&MADE, nowhere).contains("focus plane"));
    let far = FocusControls {
        focus_per_m: Some(0.0),
        depth_of_field_m: 1.0,
        ..neutral
    };
    assert!(refused(&MADE, far).contains("infinity"));
    let front = FocusControls {
        front: 2.0,
        ..neutral
    };
    assert!(refused(&TestLens { slope: 0.0 }, front).contains("focus controls"));
}
