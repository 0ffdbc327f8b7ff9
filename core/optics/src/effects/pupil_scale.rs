//! An iris of another size than stated.

use super::amount::quantity;
use super::{Description, Effect, Fitted, Parameter, ScenePoint, SearchStart};
use crate::lens::LocalPupil;

/// `pupil_scale`: the pupil is `radius` times as wide as the one that the lens was measured with.
///
/// # Appearance
/// All blur is scaled: defocused discs with the radius of the pupil, coma with its square, spherical aberration with its
/// cube. Cat's eyes change their shape, because the barrel keeps its size.
///
/// # Similar effects
/// `defocus_offset`, if there is one object distance only; `aperture_polygon` of many blades, `apodisation`.
///
/// # Model
/// W is taken at `radius` u: a term of degree l grows by radius^l, its slope in pupil radii likewise (Hopkins, Wave
/// Theory of Aberrations, 1950). Stops outside the iris keep their size. A T-stop taken for an f-stop, a wrong f-number
/// and a worn iris all act like this. The ratio of the true to the stated radius is the same at other stops.
#[derive(Debug, Clone, Copy, Default)]
pub struct PupilScale;

const PARAMETERS: [Parameter; 1] = [Parameter::new(
    "radius",
    "1",
    "radius of the pupil over that of the lens as measured",
)
.neutral_at(1.0)
.within(0.4, 2.5)
.step(0.01)];

impl Effect for PupilScale {
    fn description(&self) -> &'static Description {
        &Description {
            id: "pupil_scale",
            summary: "the f-number is not the stated one: all blur is scaled by the radius of the pupil",
            title: "a wrong f-number",
            meaning: "The f-number is not the stated one: the stop has another size, or a T-stop was taken for an f-stop, so all blur is scaled alike.",
            action: "Correct the stated f-number in the manifest or the profile (camera.f_number), and fit or diagnose again. A T-stop includes the light loss of the glass, so it is always the larger number. If the stated number is right, have the iris checked.",
            parameters: &PARAMETERS,
            far_out_of_focus: Some("both discs are whole and of another size than stated"),
            two_stops_down: Description::SHRINKS,
            other_side_of_focus: "discs on both sides are scaled alike",
            ..Description::DEFAULT
        }
    }

    fn amount(&self, values: &[f64]) -> Option<String> {
        let &[radius] = values else {
            return None;
        };
        let stops = -2.0 * radius.log2();
        Some(format!(
            "f-number {:.2} times the stated one ({stops:+.1} stops)",
            1.0 / radius
        ))
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let scale = fitted.values.first()?;
        let stated = fitted.lens.f_number.filter(|_| scale.value > 0.0);
        let number = stated.map_or(String::new(), |n| {
            let found = quantity(n / scale.value, n / scale.value.powi(2) * scale.sigma, "");
            format!(": f/{found} instead of f/{n}")
        });
        Some(format!(
            "the pupil is {} times as wide as stated{number}",
            scale.quantity(1.0, "")
        ))
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[radius] = values else {
            panic!("one value a parameter");
        };
        if radius != 1.0 {
            *pupil = pupil.with_pupil(radius);
        }
    }

    fn starts(&self) -> Vec<SearchStart> {
        [1.15, 0.87]
            .map(|radius| SearchStart::all_free(&[radius]))
            .to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place, point};
    use crate::effects::{AperturePolygon, Vignetting};
    use crate::field::Meridian;
    use crate::lens::Wavefront;

    #[test]
    fn aberrations_grow_with_their_power_of_the_radius() {
        let mut wavefront = Wavefront::default();
        wavefront.add(1, 0, Meridian::X, 1.0);
        let mut spherical = Wavefront::default();
        spherical.add(2, 0, Meridian::X, 1.0);
        for (wavefront, power) in [(wavefront, 2), (spherical, 4)] {
            let lens = LocalPupil::circular(wavefront, 0.0);
            let wide = behind(&PupilScale, &[1.2], point(), lens.clone());
            let rim = |p: &LocalPupil| p.landing([1.0, 0.0])[0];
            // A ray lands at the slope by the physical height, so a power less than the wavefront.
            let grown = 1.2_f64.powi(power - 1);
            assert!((rim(&wide) / rim(&lens) - grown).abs() < 1e-12, "{power}");
        }
    }

    #[test]
    fn blades_scale_with_the_iris_and_the_barrel_stays() {
        let at = place(1.0, 0.0);
        let bladed = behind(&AperturePolygon, &[6.0, 10.0, 1.0, 0.0], at, disc(3.0));
        let wide = behind(&PupilScale, &[1.25], at, bladed.clone());
        assert_eq!(wide.stops(), bladed.stops());
        let clipped = behind(&Vignetting, &[1.0, 0.5, 1.0, -0.5], at, bladed.clone());
        let wide = behind(&PupilScale, &[1.25], at, clipped);
        assert_eq!(wide.stops()[..7], bladed.stops()[..7]);
        assert!((wide.stops()[7].radius - 1.0 / 1.25).abs() < 1e-12);
        assert!((wide.stops()[7].centre[0] - 0.5 / 1.25).abs() < 1e-12);
    }

    #[test]
    fn the_amount_is_stated_in_stops() {
        let words = PupilScale.amount(&[0.5_f64.sqrt()]).expect("one value");
        assert_eq!(words, "f-number 1.41 times the stated one (+1.0 stops)");
    }
}
