//! Decentred lens elements: shifted or tilted.

use super::{ControlRatios, Effect, Parameter, ScenePoint, Scope, SearchStart};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

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
/// second order in d, or of a surface that is not rotationally symmetric.
#[derive(Debug, Clone, Copy, Default)]
pub struct Decentre;

const fn term(name: &'static str, unit: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, unit, meaning).within(-100.0, 100.0)
}

const COUNT: usize = 12;

static PARAMETERS: [Parameter; COUNT] = [
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
];

impl Effect for Decentre {
    fn id(&self) -> &'static str {
        "decentre"
    }

    fn summary(&self) -> &'static str {
        "an element is shifted or tilted: coma in the middle, astigmatism and focus linear in field"
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

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
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
    }

    fn chief_ray(&self, values: &[f64], _point: ScenePoint) -> [f64; 2] {
        [values[8] + values[10], values[9] + values[11]]
    }

    // Coma and shifts alone, then everything.
    fn starts(&self) -> Vec<SearchStart> {
        let mut values = [0.0; COUNT];
        (values[0], values[1]) = (0.2, 0.2);
        let plain = |k: usize| !(2..8).contains(&k);
        vec![
            SearchStart {
                values: values.to_vec(),
                free: (0..COUNT).map(plain).collect(),
            },
            SearchStart::all_free(&values),
        ]
    }

    // Wave terms scale by docs/background/model.md section 10 with pupil power l and field power a: coma 3
    // and 0, terms linear in field 2 and 1, constant astigmatism 2 and 0. Shifts are angles times Z2.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let (r, k) = (ratios.pupil, ratios.image_distance);
        let factor = |index: usize| match index {
            0 | 1 => r * r * k,
            2..=5 => r,
            6 | 7 => r * k,
            _ => k,
        };
        let each = values.iter().enumerate();
        each.map(|(index, series)| series.scaled(factor(index)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::DefocusOffset;
    use crate::effects::tests::{behind, disc, place};
    use crate::field::FieldPoint;
    use crate::lens::{ReducedNumbers, Wavefront};

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

    #[test]
    fn shifts_are_constant_over_the_field() {
        let mut values = [0.0; COUNT];
        values[8..].copy_from_slice(&[3.0, -2.0, 0.1, 0.2]);
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
