//! Decentred lens elements: shifted or tilted.

use super::{
    ControlRatios, Description, Effect, FieldNeed, FitPart, Fitted, Parameter, ScenePoint, Scope,
    SearchStart, SensorTilt, Symmetry,
};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries, Wavefront};

/// `decentre`: the field centres of the aberrations do not lie on one axis.
///
/// # Appearance
/// Coma at the centre of the frame, the same everywhere; astigmatism and focus that change linearly across the frame; a
/// shift of the image that differs slightly between channels.
///
/// # Similar effects
/// `sensor_tilt`, if coma is weak.
///
/// # Model
/// Nodal aberration theory of Shack and Thompson (Proc. SPIE 251, 1980; Thompson, J. Opt. Soc. Am. A 22, 2005), to third
/// order. A share phi, gamma, delta of the reduced numbers that is centred at d instead of the axis adds
///
/// ```text
/// W = |u|² (c.u) + (X.u)(a.u) + (X.f) |u|²/2 + a0 (u_x² - u_y²)/2 + a45 u_x u_y
/// ```
///
/// with c = phi d, a = -gamma d and f = -2 delta d, in px of slope (per half frame width). a0 and a45 are astigmatism of
/// second order in d, or of a surface that is not rotationally symmetric. Fast lenses need the next order too, the terms
/// of fifth order centred at d:
///
/// ```text
/// W += |u|⁴ (p.u) + (X.q) |u|⁴/4 + |u|² (X.u)(r.u) + |X|² |u|² (s.u) + (X.t)(X.u) |u|² + (X.u)² (v.u)
/// ```
///
/// Distortion centred at d moves the chief ray by (X.k) X + |X|² b (decentring distortion: Brown, Photogrammetric
/// Engineering 32, 1966).
#[derive(Debug, Clone, Copy, Default)]
pub struct Decentre;

const fn term(name: &'static str, unit: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, unit, meaning).within(-100.0, 100.0)
}

const COUNT: usize = 28;
/// Index of the first parameter of decentring distortion, and of the first of fifth order.
const DISTORTION: usize = 12;
const FIFTH: usize = 16;

impl Decentre {
    /// Indices of the parameters that shift chief rays in all channels: the shift along x and y, keystone by x and y, and the bend
    /// along x and y.
    pub const CHIEF_RAY_TERMS: [usize; 6] = [
        8,
        9,
        DISTORTION,
        DISTORTION + 1,
        DISTORTION + 2,
        DISTORTION + 3,
    ];
}

const PARAMETERS: [Parameter; COUNT] = [
    term("coma_x", "px", "coma, constant over the field, along x"),
    term("coma_y", "px", "coma, constant over the field, along y"),
    term("astigmatism_x", "px/h", "astigmatism linear in field, by x"),
    term("astigmatism_y", "px/h", "astigmatism linear in field, by y"),
    term("focus_x", "px/h", "focus linear in field, by x"),
    term("focus_y", "px/h", "focus linear in field, by y"),
    term(
        "astigmatism_0",
        "px",
        "astigmatism, constant over the field, along the axes",
    ),
    term(
        "astigmatism_45",
        "px",
        "astigmatism, constant over the field, along the diagonals",
    ),
    term("shift_x", "px", "shift of the image along x").within(-500.0, 500.0),
    term("shift_y", "px", "shift of the image along y").within(-500.0, 500.0),
    term(
        "prism_x",
        "px",
        "shift relative to the channel of middle wavelength, along x",
    )
    .scope(Scope::Difference),
    term(
        "prism_y",
        "px",
        "shift relative to the channel of middle wavelength, along y",
    )
    .scope(Scope::Difference),
    term("keystone_x", "px/h²", "shift along X by X.k, x of k").within(-500.0, 500.0),
    term("keystone_y", "px/h²", "shift along X by X.k, y of k").within(-500.0, 500.0),
    term("bend_x", "px/h²", "shift along x quadratic in field").within(-500.0, 500.0),
    term("bend_y", "px/h²", "shift along y quadratic in field").within(-500.0, 500.0),
    term(
        "coma5_x",
        "px",
        "fifth-order coma, constant over the field, along x",
    ),
    term(
        "coma5_y",
        "px",
        "fifth-order coma, constant over the field, along y",
    ),
    term(
        "spherical_x",
        "px/h",
        "spherical aberration linear in field, by x",
    ),
    term(
        "spherical_y",
        "px/h",
        "spherical aberration linear in field, by y",
    ),
    term(
        "oblique_x",
        "px/h",
        "oblique spherical aberration linear in field, x of its vector",
    ),
    term(
        "oblique_y",
        "px/h",
        "oblique spherical aberration linear in field, y of its vector",
    ),
    term("coma_bend_x", "px/h²", "coma along x quadratic in field"),
    term("coma_bend_y", "px/h²", "coma along y quadratic in field"),
    term("coma_keystone_x", "px/h²", "coma along X by X.t, x of t"),
    term("coma_keystone_y", "px/h²", "coma along X by X.t, y of t"),
    term(
        "elliptical_x",
        "px/h²",
        "elliptical coma quadratic in field, x of its vector",
    ),
    term(
        "elliptical_y",
        "px/h²",
        "elliptical coma quadratic in field, y of its vector",
    ),
];

impl Effect for Decentre {
    fn description(&self) -> &'static Description {
        &Description {
            id: "decentre",
            summary: "an element is shifted or tilted: coma in the middle, astigmatism and focus linear in field",
            title: "a decentred element",
            meaning: "An element or a group of the lens is shifted or tilted off the axis: coma even in the middle, and corners that differ.",
            action: "Have the lens re-collimated (its elements centred again). Until then render with corrected.json, which holds for this copy of the lens only.",
            parameters: &PARAMETERS,
            symmetry: Symmetry::None,
            field_need: FieldNeed::Sides,
            far_out_of_focus: Some("both discs are brighter on one side"),
            two_stops_down: "coma shrinks with the square of the pupil",
            other_side_of_focus: "coma keeps its direction while discs flip",
            // A tilted sensor looks like the linear focus.
            contains: &[&SensorTilt],
            fit: FitPart {
                // Without the displacement of the image, which tiles do not show.
                used: 8,
                // Focus linear in field.
                described_by: &[(4, &SensorTilt), (5, &SensorTilt)],
                starts: || vec![vec![0.0; 8]],
                worth: 0.1,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn amount(&self, values: &[f64]) -> Option<String> {
        let &[x, y, ..] = values else {
            return None;
        };
        let (size, angle) = (x.hypot(y), y.atan2(x).to_degrees());
        Some(format!(
            "coma constant over the field of {size:.2} px, at {angle:.0} degrees from x towards y"
        ))
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let coma = fitted.vector("coma_x", "coma_y")?;
        let mut words = format!(
            "coma of {} in the middle, towards {}",
            coma.quantity(1.0, "px"),
            coma.direction(1.0)
        );
        if let Some(focus) = fitted.vector("focus_x", "focus_y") {
            words += &format!(
                "; defocus changes by {} from the middle to the side of the frame",
                focus.quantity(1.0, "px")
            );
        }
        Some(words)
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), COUNT, "one value a parameter");
        let (x, y) = (point.at.x, point.at.y);
        let (a, f) = ([values[2], values[3]], [values[4], values[5]]);
        let wave = &mut pupil.wavefront;
        wave.add_monomial(3, 0, values[0]);
        wave.add_monomial(1, 2, values[0]);
        wave.add_monomial(2, 1, values[1]);
        wave.add_monomial(0, 3, values[1]);
        wave.add(1, 0, Meridian::X, (x * f[0] + y * f[1]) / 2.0);
        wave.add_monomial(2, 0, x * a[0] + values[6] / 2.0);
        wave.add_monomial(1, 1, x * a[1] + y * a[0] + values[7]);
        wave.add_monomial(0, 2, y * a[1] - values[6] / 2.0);
        add_fifth_order(&values[FIFTH..], [x, y], wave);
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let (x, y) = (point.at.x, point.at.y);
        let &[kx, ky, bx, by] = &values[DISTORTION..FIFTH] else {
            panic!("four parameters of distortion");
        };
        let (along, h2) = (kx * x + ky * y, x * x + y * y);
        [
            values[8] + values[10] + along * x + h2 * bx,
            values[9] + values[11] + along * y + h2 * by,
        ]
    }

    // Coma and shifts alone, then third order, then everything.
    fn starts(&self) -> Vec<SearchStart> {
        let mut values = [0.0; COUNT];
        (values[0], values[1]) = (0.2, 0.2);
        let plain = |k: usize| !(2..8).contains(&k);
        vec![
            SearchStart::new(
                &values,
                &std::array::from_fn::<_, COUNT, _>(|k| plain(k) && k < DISTORTION),
            ),
            SearchStart::new(&values, &std::array::from_fn::<_, COUNT, _>(|k| k < FIFTH)),
            SearchStart::all_free(&values),
        ]
    }

    // Focus linear in field, and keystone along its direction.
    fn contained_values(&self, simpler: &dyn Effect, values: &[f64]) -> Option<Vec<f64>> {
        let (focus, keystone) = (
            [values[4], values[5]],
            [values[DISTORTION], values[DISTORTION + 1]],
        );
        let squared = focus[0] * focus[0] + focus[1] * focus[1];
        (simpler.id() == SensorTilt.id() && squared > 0.0).then(|| {
            let along = focus[0] * keystone[0] + focus[1] * keystone[1];
            vec![focus[0], focus[1], along / squared, 0.0]
        })
    }

    // Wave terms scale by docs/background/model.md section 10 with pupil power l and field power a: coma 3
    // and 0, terms linear in field 2 and 1, constant astigmatism 2 and 0. Shifts are angles times Z2.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let (r, k) = (ratios.pupil, ratios.image_distance);
        let factor = |index: usize| match index {
            0 | 1 => r * r * k,
            2..=5 => r,
            6 | 7 => r * k,
            8..DISTORTION => k,
            DISTORTION..FIFTH => 1.0 / k,
            _ => {
                let (pupil, field) =
                    [(5, 0), (4, 1), (4, 1), (3, 2), (3, 2), (3, 2)][(index - FIFTH) / 2];
                ratios.of_wave_term(pupil, field)
            }
        };
        let each = values.iter().enumerate();
        each.map(|(index, series)| series.scaled(factor(index)))
            .collect()
    }
}

/// Adds the terms of fifth order at field point `x` to `wave`; `values` are the components of p, q, r, s, t and v.
fn add_fifth_order(values: &[f64], x: [f64; 2], wave: &mut Wavefront) {
    let (vectors, _) = values.as_chunks::<2>();
    let &[p, q, r, s, t, v] = vectors else {
        panic!("six vectors");
    };
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    wave.add(2, 0, Meridian::X, dot(x, q) / 4.0);
    // |u|⁴ (p.u).
    wave.add_monomial(5, 0, p[0]);
    wave.add_monomial(3, 2, 2.0 * p[0]);
    wave.add_monomial(1, 4, p[0]);
    wave.add_monomial(4, 1, p[1]);
    wave.add_monomial(2, 3, 2.0 * p[1]);
    wave.add_monomial(0, 5, p[1]);
    // |u|² (X.u)(r.u).
    let (xx, xy, yy) = (x[0] * r[0], x[0] * r[1] + x[1] * r[0], x[1] * r[1]);
    wave.add_monomial(4, 0, xx);
    wave.add_monomial(2, 2, xx + yy);
    wave.add_monomial(0, 4, yy);
    wave.add_monomial(3, 1, xy);
    wave.add_monomial(1, 3, xy);
    // |u|² ((|X|² s + (X.t) X).u).
    let (h2, along) = (dot(x, x), dot(x, t));
    let coma = [0, 1].map(|k| h2 * s[k] + along * x[k]);
    wave.add_monomial(3, 0, coma[0]);
    wave.add_monomial(1, 2, coma[0]);
    wave.add_monomial(2, 1, coma[1]);
    wave.add_monomial(0, 3, coma[1]);
    // (X.u)² (v.u).
    let (xx, xy, yy) = (x[0] * x[0], 2.0 * x[0] * x[1], x[1] * x[1]);
    wave.add_monomial(3, 0, xx * v[0]);
    wave.add_monomial(2, 1, xx * v[1] + xy * v[0]);
    wave.add_monomial(1, 2, xy * v[1] + yy * v[0]);
    wave.add_monomial(0, 3, yy * v[1]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::DefocusOffset;
    use crate::effects::tests::{behind, disc, place};
    use crate::field::FieldPoint;
    use crate::lens::ReducedNumbers;

    #[test]
    fn coma_at_the_centre_points_along_its_vector() {
        let mut values = [0.0; COUNT];
        (values[0], values[1]) = (0.8, 0.6);
        let (moments, centroid) = behind(&Decentre, &values, place(0.0, 0.0), disc(5.0)).moments();
        assert!((centroid[0] - 0.8).abs() < 1e-12 && (centroid[1] - 0.6).abs() < 1e-12);
        // The flare points along c: docs/background/model.md section 4 with c for -phi X.
        let along = Meridian { cos: 0.8, sin: 0.6 };
        let turned = moments.rotated_into(along);
        assert!(
            (turned.mu30 - (25.0 / 2.0 + 1.0 / 4.0)).abs() < 1e-9,
            "{turned:?}"
        );
        assert!(
            turned.mu03.abs() < 1e-9 && turned.mu21.abs() < 1e-9,
            "{turned:?}"
        );
    }

    #[test]
    fn these_terms_equal_a_lens_shifted_off_its_axis() {
        let numbers = ReducedNumbers {
            alpha: 3.0,
            beta: 1.0,
            gamma: 2.0,
            delta: -1.4,
            phi: 0.5,
        };
        let (x, y) = (0.6, -0.5);
        let (dx, dy) = (0.11, 0.07);
        let lens = |x, y| {
            LocalPupil::circular(Wavefront::third_order(&numbers, FieldPoint::new(x, y)), 0.0)
        };
        let (gamma, delta, phi) = (numbers.gamma, numbers.delta, numbers.phi);
        let mut values = [0.0; COUNT];
        values[..8].copy_from_slice(&[
            phi * dx,
            phi * dy,
            -gamma * dx,
            -gamma * dy,
            -2.0 * delta * dx,
            -2.0 * delta * dy,
            gamma * (dx * dx - dy * dy) / 2.0,
            gamma * dx * dy,
        ]);
        let second = (gamma / 2.0 + delta) * (dx * dx + dy * dy);
        let got = behind(&Decentre, &values, place(x, y), lens(x, y));
        let got = behind(&DefocusOffset, &[second, 0.0], place(x, y), got);
        let want = lens(x - dx, y - dy);
        let pairs = got.wavefront.coefficients().iter();
        for (g, w) in pairs.zip(want.wavefront.coefficients()) {
            assert!((g - w).abs() < 1e-12, "{g} {w}");
        }
    }

    /// Fifth-order aberrations of a symmetric lens at field point `x`.
    fn fifth_order(x: [f64; 2]) -> Wavefront {
        let at = FieldPoint::new(x[0], x[1]);
        let (h, meridian) = (at.radius(), at.meridian());
        let mut wave = Wavefront::default();
        for (round, along, field, size) in [
            (2, 1, 1, 0.7),
            (2, 0, 2, 0.4),
            (1, 2, 2, -0.6),
            (1, 1, 3, 0.5),
            (0, 3, 3, -0.3),
        ] {
            wave.add(round, along, meridian, size * h.powi(field));
        }
        wave
    }

    #[test]
    fn fifth_order_terms_are_the_change_by_a_shift_off_the_axis() {
        let (x, d, step) = ([0.6, -0.4], [0.8, 0.3], 1e-5);
        let at = |side: f64| fifth_order([0, 1].map(|k| x[k] - side * step * d[k]));
        let change = at(1.0).add_scaled(-1.0, &at(-1.0));
        let mut values = Vec::new();
        for factor in [
            -0.7,
            -2.0 * 0.4 * 4.0,
            2.0 * 0.6,
            -0.5,
            -2.0 * 0.5,
            3.0 * 0.3,
        ] {
            values.extend(d.map(|d| factor * d));
        }
        let mut got = Wavefront::default();
        add_fifth_order(&values, x, &mut got);
        let pairs = got.coefficients().iter().zip(change.coefficients());
        for (got, change) in pairs {
            let want = change / (2.0 * step);
            assert!((got - want).abs() < 1e-7, "{got} {want}");
        }
    }

    #[test]
    fn shifts_are_constant_over_the_field() {
        let mut values = [0.0; COUNT];
        values[8..DISTORTION].copy_from_slice(&[3.0, -2.0, 0.1, 0.2]);
        for (x, y) in [(0.0, 0.0), (0.9, -0.3)] {
            let chief = Decentre.chief_ray(&values, place(x, y));
            assert_eq!(chief, [3.1, -1.8]);
            assert_eq!(
                behind(&Decentre, &values, place(x, y), disc(2.0)),
                disc(2.0)
            );
        }
    }
}
