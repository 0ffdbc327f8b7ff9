//! Anamorphic lenses to fifth order: a wavefront even in x and even in y, but not rotationally symmetric.

use super::monomials::{FieldMonomial, apply, monomial, rescaled};
use super::{
    ControlRatios, Description, Effect, FitPart, Parameter, ScenePoint, SearchStart, Symmetry,
};
use crate::lens::{LocalPupil, VergenceSeries};

/// `double_plane`: aberrations that differ between the x and the y section, in a lens with cylindrical elements.
///
/// # Appearance
/// Elliptical discs, each section with a focus and aberrations of its own; the lens looks the same in a mirror along x or
/// along y.
///
/// # Similar effects
/// `anamorphic`, which has the first order of this in a few numbers, for lenses that became anamorphic; astigmatism.
///
/// # Model
/// The terms `w_ijkl u_x^i u_y^j x^k y^l / (i + j)` of the wavefront with i + k and j + l even, of second, fourth and sixth
/// degree, which rotationally symmetric lenses lack (docs/background/model.md section 12). The chief ray moves by
/// (x (`shift_x` + `shift_xxx` x² + `shift_xyy` y²), `shift_yyy` y³) px beyond magnification and distortion: the anamorphic
/// distortion. Values are the slope at the rim of
/// the pupil in px, per half frame width to the power k + l. Of every symmetric term one monomial is left out, so that each
/// wavefront is written in one way.
#[derive(Debug, Clone, Copy, Default)]
pub struct DoublePlane;

const COUNT: usize = 35;
/// Terms of the chief ray: along x with x, x³ and x y², along y with y³.
const SHIFTS: usize = 4;

// Left out, one for each symmetric term: u_x² u_y², u_x² u_y y, u_x u_y x y, u_x² y², and in fifth order u_x⁴ u_y²,
// u_x³ u_y² x, u_x⁴ y², u_x³ u_y x y, u_x² u_y x² y, u_x³ x y², u_x u_y x y³, u_x² y⁴.
/// The terms, in the order of the parameters.
static TERMS: [FieldMonomial; COUNT] = [
    FieldMonomial::new([2, 0], [0, 0]),
    // Third order.
    FieldMonomial::new([4, 0], [0, 0]),
    FieldMonomial::new([0, 4], [0, 0]),
    FieldMonomial::new([3, 0], [1, 0]),
    FieldMonomial::new([1, 2], [1, 0]),
    FieldMonomial::new([0, 3], [0, 1]),
    FieldMonomial::new([2, 0], [2, 0]),
    FieldMonomial::new([0, 2], [2, 0]),
    FieldMonomial::new([0, 2], [0, 2]),
    // Fifth order.
    FieldMonomial::new([6, 0], [0, 0]),
    FieldMonomial::new([2, 4], [0, 0]),
    FieldMonomial::new([0, 6], [0, 0]),
    FieldMonomial::new([5, 0], [1, 0]),
    FieldMonomial::new([4, 1], [0, 1]),
    FieldMonomial::new([2, 3], [0, 1]),
    FieldMonomial::new([1, 4], [1, 0]),
    FieldMonomial::new([0, 5], [0, 1]),
    FieldMonomial::new([4, 0], [2, 0]),
    FieldMonomial::new([2, 2], [2, 0]),
    FieldMonomial::new([2, 2], [0, 2]),
    FieldMonomial::new([1, 3], [1, 1]),
    FieldMonomial::new([0, 4], [2, 0]),
    FieldMonomial::new([0, 4], [0, 2]),
    FieldMonomial::new([3, 0], [3, 0]),
    FieldMonomial::new([2, 1], [0, 3]),
    FieldMonomial::new([1, 2], [3, 0]),
    FieldMonomial::new([1, 2], [1, 2]),
    FieldMonomial::new([0, 3], [0, 3]),
    FieldMonomial::new([0, 3], [2, 1]),
    FieldMonomial::new([2, 0], [4, 0]),
    FieldMonomial::new([2, 0], [2, 2]),
    FieldMonomial::new([1, 1], [3, 1]),
    FieldMonomial::new([0, 2], [4, 0]),
    FieldMonomial::new([0, 2], [2, 2]),
    FieldMonomial::new([0, 2], [0, 4]),
];

const PARAMETERS: [Parameter; COUNT + SHIFTS] = [
    monomial("w2000", "u_x²", 0),
    monomial("w4000", "u_x⁴", 0),
    monomial("w0400", "u_y⁴", 0),
    monomial("w3010", "u_x³ x", 1),
    monomial("w1210", "u_x u_y² x", 1),
    monomial("w0301", "u_y³ y", 1),
    monomial("w2020", "u_x² x²", 2),
    monomial("w0220", "u_y² x²", 2),
    monomial("w0202", "u_y² y²", 2),
    monomial("w6000", "u_x⁶", 0),
    monomial("w2400", "u_x² u_y⁴", 0),
    monomial("w0600", "u_y⁶", 0),
    monomial("w5010", "u_x⁵ x", 1),
    monomial("w4101", "u_x⁴ u_y y", 1),
    monomial("w2301", "u_x² u_y³ y", 1),
    monomial("w1410", "u_x u_y⁴ x", 1),
    monomial("w0501", "u_y⁵ y", 1),
    monomial("w4020", "u_x⁴ x²", 2),
    monomial("w2220", "u_x² u_y² x²", 2),
    monomial("w2202", "u_x² u_y² y²", 2),
    monomial("w1311", "u_x u_y³ x y", 2),
    monomial("w0420", "u_y⁴ x²", 2),
    monomial("w0402", "u_y⁴ y²", 2),
    monomial("w3030", "u_x³ x³", 3),
    monomial("w2103", "u_x² u_y y³", 3),
    monomial("w1230", "u_x u_y² x³", 3),
    monomial("w1212", "u_x u_y² x y²", 3),
    monomial("w0303", "u_y³ y³", 3),
    monomial("w0321", "u_y³ x² y", 3),
    monomial("w2040", "u_x² x⁴", 4),
    monomial("w2022", "u_x² x² y²", 4),
    monomial("w1131", "u_x u_y x³ y", 4),
    monomial("w0240", "u_y² x⁴", 4),
    monomial("w0222", "u_y² x² y²", 4),
    monomial("w0204", "u_y² y⁴", 4),
    shift("shift_x", "chief ray along x, with x"),
    shift("shift_xxx", "chief ray along x, with x³"),
    shift("shift_xyy", "chief ray along x, with x y²"),
    shift("shift_yyy", "chief ray along y, with y³"),
];

const fn shift(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "px", meaning).within(-500.0, 500.0)
}

impl DoublePlane {
    /// Number of the parameters that are terms of the wavefront, the first ones.
    pub const WAVEFRONT_TERMS: usize = COUNT;
}

impl Effect for DoublePlane {
    fn description(&self) -> &'static Description {
        &Description {
            id: "double_plane",
            summary: "the lens has two planes of symmetry: aberrations differ between x and y",
            title: "two planes of symmetry",
            meaning: "The lens has cylindrical elements, as anamorphic lenses do, so its aberrations differ along x and along y.",
            action: "Fit the lens again with the extended model and PSFs in all quarters of the frame.",
            parameters: &PARAMETERS,
            // A lens is designed so.
            is_cause: false,
            fits_chief_ray: true,
            symmetry: Symmetry::TwoPlanes,
            fit: FitPart {
                used: COUNT,
                // The difference of defocus between the planes follows the object's distance.
                linear: 1,
                starts: || vec![vec![0.0; COUNT]],
                worth: 0.5,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a term");
        apply(&TERMS, &values[..COUNT], point.at, pupil);
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let (x, y) = (point.at.x, point.at.y);
        let shifts = &values[COUNT..];
        [
            x * (shifts[0] + shifts[1] * x * x + shifts[2] * y * y),
            shifts[3] * y * y * y,
        ]
    }

    fn starts(&self) -> Vec<SearchStart> {
        let mut values = [0.0; COUNT + SHIFTS];
        values[0] = 0.5;
        vec![SearchStart::all_free(&values)]
    }

    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let (waves, shifts) = values.split_at(COUNT);
        // Powers of the field angle X / Z2, times Z2, like distortion.
        let shifts = shifts.iter().zip([0, -2, -2, -2]);
        let shifts = shifts.map(|(s, power)| s.scaled(ratios.image_distance.powi(power)));
        let waves = rescaled(&TERMS, waves, ratios);
        waves.into_iter().chain(shifts).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::HigherOrder;
    use crate::effects::tests::{behind, disc, place};

    /// Returns the pupil at (`x`, `y`) of a lens with fifth order in which all terms of two planes are strong.
    fn pupil(x: f64, y: f64) -> LocalPupil {
        let values: Vec<f64> = (0..COUNT + SHIFTS).map(|k| 0.3 + 0.1 * k as f64).collect();
        let round = behind(&HigherOrder, &[1.0; 8], place(x, y), disc(2.0));
        behind(&DoublePlane, &values, place(x, y), round)
    }

    #[test]
    fn both_sections_are_mirrors() {
        let (x, y) = (0.6, -0.4);
        for (u, v) in [(0.3, 0.7), (-0.5, 0.2)] {
            let here = pupil(x, y).landing([u, v]);
            let across_x = pupil(-x, y).landing([-u, v]);
            let across_y = pupil(x, -y).landing([u, -v]);
            for (got, want) in [
                (across_x, [-here[0], here[1]]),
                (across_y, [here[0], -here[1]]),
            ] {
                assert!((got[0] - want[0]).abs() < 1e-12 && (got[1] - want[1]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn names_say_the_powers_and_no_term_occurs_twice() {
        for (k, (term, parameter)) in TERMS.iter().zip(&PARAMETERS).enumerate() {
            assert_eq!(term.name(), parameter.name);
            assert!(!TERMS[..k].contains(term), "{}", parameter.name);
        }
    }
}
