//! Uneven transmission of the pupil.

use super::{
    ControlRatios, Description, Effect, FitPart, Fitted, Parameter, ScenePoint, SearchStart,
    Symmetry,
};
use crate::lens::{LocalPupil, VergenceSeries};

/// `apodisation`: the transmission of the pupil falls towards its rim or its centre, about the axis or beside it.
///
/// # Appearance
/// Defocused discs have soft or bright edges on both sides of focus, the same over the whole field. A filter that is
/// decentred makes one side of them dimmer, which changes sides through focus.
///
/// # Similar effects
/// Spherical aberration, which is soft on one side of focus and bright on the other; the shadow of a mirror, which has a
/// sharp edge. Coma, if the filter is decentred.
///
/// # Model
/// The transmission at pupil point u is exp(-(`square` |u - c|² + `fourth` |u - c|⁴)): even powers of the density of a
/// round filter (Jacquinot and Roizen-Dossier, Progress in Optics 3, 1964) with its centre c at (`centre_x`, `centre_y`).
/// Where a lens has several, the coefficients and the centres add.
#[derive(Debug, Clone, Copy, Default)]
pub struct Apodisation;

const PARAMETERS: [Parameter; 4] = [
    Parameter::new("square", "1", "loss by the squared pupil radius")
        .within(-1.5, 8.0)
        .step(0.05),
    Parameter::new(
        "fourth",
        "1",
        "loss by the fourth power of the pupil radius",
    )
    .within(-4.0, 8.0)
    .step(0.05),
    centre("centre_x", "centre of the filter along x"),
    centre("centre_y", "centre of the filter along y"),
];

const fn centre(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "pupil radii", meaning).within(-1.0, 1.0)
}

impl Effect for Apodisation {
    fn description(&self) -> &'static Description {
        &Description {
            id: "apodisation",
            summary: "the pupil is not evenly clear: soft-edged or ring-edged discs on both sides of focus",
            title: "an uneven pupil",
            meaning: "The pupil does not transmit evenly: out-of-focus discs have soft or bright rims on both sides of focus.",
            action: "Look for haze, a smooth-transition filter or a mirror's shadow. Use corrected.json, or fit again with the extended model.",
            parameters: &PARAMETERS,
            far_out_of_focus: Some("the rims of both discs are soft or bright"),
            two_stops_down: "the edge of the disc hardens",
            other_side_of_focus: "soft edges stay soft",
            fit: FitPart {
                used: 4,
                shared: true,
                // A faint filter does not show its centre.
                starts: || vec![vec![0.4, 0.0, 0.0, 0.0], vec![-0.3, 0.0, 0.0, 0.0]],
                worth: 0.1,
                ..FitPart::NONE
            },
            ..Description::DEFAULT
        }
    }

    fn amount(&self, values: &[f64]) -> Option<String> {
        let &[square, fourth, x, y] = values else {
            return None;
        };
        let rim = 100.0 * (-square - fourth).exp();
        Some(format!(
            "{rim:.0} % of the light of its centre one pupil radius from it, centre at ({x:.2}, {y:.2})"
        ))
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        fitted.of("square")?;
        let rim = (-(fitted.number("square") + fitted.number("fourth"))).exp();
        Some(format!(
            "the pupil transmits {:.0} % as much light at its rim as at its centre",
            100.0 * rim
        ))
    }

    // Round if the filter lies on the axis.
    fn symmetry(&self, values: &[VergenceSeries]) -> Symmetry {
        let mut centre = values[2..].iter().flat_map(|series| &series.coefficients);
        if centre.all(|c| *c == 0.0) {
            Symmetry::Round
        } else {
            Symmetry::None
        }
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        pupil.transmission.square += values[0];
        pupil.transmission.fourth += values[1];
        pupil.transmission.centre[0] += values[2];
        pupil.transmission.centre[1] += values[3];
    }

    fn starts(&self) -> Vec<SearchStart> {
        let centred = |[square, of_fourth]: [f64; 2], fourth| {
            SearchStart::new(
                &[square, of_fourth, 0.0, 0.0],
                &[true, fourth, false, false],
            )
        };
        vec![
            centred([0.5, 0.0], false),
            centred([-0.3, 0.0], false),
            centred([0.3, 0.3], true),
            SearchStart::new(&[0.5, 0.0, 0.0, 0.0], &[true, false, true, true]),
        ]
    }

    // The filter stays; a smaller pupil uses less of it.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        vec![
            values[0].scaled(ratios.pupil.powi(2)),
            values[1].scaled(ratios.pupil.powi(4)),
            values[2].scaled(1.0 / ratios.pupil),
            values[3].scaled(1.0 / ratios.pupil),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn discs_are_soft_or_ringed_on_both_sides_of_focus() {
        let variance = |[square, fourth]: [f64; 2], alpha| {
            let values = [square, fourth, 0.0, 0.0];
            let pupil = behind(&Apodisation, &values, place(0.3, 0.5), disc(alpha));
            let (moments, centroid) = pupil.moments();
            assert!(centroid[0].abs() < 1e-12 && centroid[1].abs() < 1e-12);
            assert!((moments.mu20 - moments.mu02).abs() < 1e-9);
            moments.mu20
        };
        let even = 4.0;
        for values in [[1.0, 0.0], [0.0, 1.0]] {
            let soft = variance(values, 4.0);
            assert!(soft < even - 0.3, "{soft}");
            assert!((variance(values, -4.0) - soft).abs() < 1e-9);
            assert!(variance(values.map(|v| -v), 4.0) > even + 0.2);
        }
        // For exp(-s r²) over the disc, the mean of r² is 1/s - 1/(e^s - 1).
        let want = 16.0 / 2.0 * (1.0 - 1.0 / (1.0_f64.exp() - 1.0));
        assert!((variance([1.0, 0.0], 4.0) - want).abs() < 1e-9);
    }

    #[test]
    fn a_decentred_filter_dims_one_side_and_the_other_beyond_focus() {
        let centroid = |alpha| {
            let values = [0.8, 0.0, 0.3, -0.1];
            behind(&Apodisation, &values, place(0.3, 0.5), disc(alpha)).centroid()
        };
        let [x, y] = centroid(4.0);
        assert!(
            x > 0.2 && y < -0.07 && (x + 3.0 * y).abs() < 0.01,
            "{x} {y}"
        );
        let [beyond, _] = centroid(-4.0);
        assert!((beyond + x).abs() < 1e-9);
    }
}
