//! Anamorphic lenses: two focal lengths.

use super::{
    ControlRatios, DefocusOffset, DepthScale, Description, Effect, Fitted, Parameter, ScenePoint,
    SearchStart, Symmetry,
};
use crate::lens::{LocalPupil, VergenceSeries};

/// `anamorphic`: the lens differs between the x and the y section.
///
/// # Appearance
/// Defocused discs are ellipses, the same over the whole field. The image is sharp along one axis before the other.
///
/// # Similar effects
/// Astigmatism, which grows with field and turns with the meridian; pixels that are not square.
///
/// # Model
/// First order in the difference of the two sections (after Wynne, Proc. Phys. Soc. B 67, 1954):
/// - W gains `astigmatism` (u_x² - u_y²)/2 + `focus` |u|²/2: a cylinder has power along one axis only, so half of it is
///   mean focus.
/// - The pupil is an ellipse, `pupil` times as wide along x: a disc of radius alpha has the half-axis alpha `pupil`
///   there.
/// - Landing points are scaled by `squeeze` along x.
/// - The image point X moves by (`scale_x` X, `scale_y` Y) px.
///
/// The effect acts after those on the wavefront, which it scales as well. Stops stay circular in units of the ellipse.
#[derive(Debug, Clone, Copy, Default)]
pub struct Anamorphic;

const fn ratio(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "1", meaning)
        .neutral_at(1.0)
        .within(0.4, 2.5)
        .step(0.01)
}

const PARAMETERS: [Parameter; 6] = [
    ratio(
        "squeeze",
        "scale of landing points along x relative to a spherical lens",
    ),
    ratio("pupil", "width of the pupil along x over that along y"),
    Parameter::new(
        "astigmatism",
        "px",
        "half the difference of defocus along x and along y",
    )
    .within(-200.0, 200.0),
    Parameter::new(
        "scale_x",
        "px",
        "outward shift along x, half a frame width off the axis",
    )
    .within(-2000.0, 2000.0),
    Parameter::new(
        "scale_y",
        "px",
        "outward shift along y, half a frame width off the axis",
    )
    .within(-2000.0, 2000.0),
    Parameter::new("focus", "px", "mean of the defocus along x and along y").within(-200.0, 200.0),
];

impl Effect for Anamorphic {
    fn description(&self) -> &'static Description {
        &Description {
            id: "anamorphic",
            summary: "the lens has two focal lengths: elliptical discs, another focus along x than along y",
            title: "an anamorphic squeeze",
            meaning: "The lens focuses and magnifies differently along x and along y: out-of-focus discs are ellipses.",
            action: "State camera.squeeze in the manifest and fit again with the extended model. Make sure that both sets are squeezed, or both desqueezed.",
            parameters: &PARAMETERS,
            symmetry: Symmetry::TwoPlanes,
            far_out_of_focus: Some("both discs are ellipses"),
            two_stops_down: Description::SHRINKS,
            other_side_of_focus: "the long axis of the discs changes",
            // A focus offset, or one that changes with distance, looks like the mean focus of a cylinder.
            contains: &[&DefocusOffset, &DepthScale],
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let squeeze = fitted.of("squeeze")?;
        let mut words = format!(
            "blur along x is {} times as wide as of a spherical lens",
            squeeze.quantity(1.0, "")
        );
        if let Some(astigmatism) = fitted.of("astigmatism") {
            words += &format!(
                "; defocus along x and along y differs by {}",
                astigmatism.quantity(2.0, "px")
            );
        }
        Some(words)
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[squeeze, width, astigmatism, _, _, focus] = values else {
            panic!("one value a parameter");
        };
        let wave = &mut pupil.wavefront;
        wave.add_monomial(2, 0, (focus + astigmatism) / 2.0);
        wave.add_monomial(0, 2, (focus - astigmatism) / 2.0);
        // The ray passes (w u_x, u_y) on the glass: the slope by u_x is w times that on the glass.
        *wave = wave.stretched_x(width);
        pupil.squeeze[0] *= squeeze / width;
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        [values[3] * point.at.x, values[4] * point.at.y]
    }

    // A wider or a narrower image, an elliptical pupil, then everything.
    fn starts(&self) -> Vec<SearchStart> {
        let from = |squeeze, pupil, free: [bool; 2]| {
            SearchStart::new(
                &[squeeze, pupil, 0.0, 0.0, 0.0, 0.0],
                &[free[0], free[1], true, true, true, true],
            )
        };
        vec![
            from(0.8, 1.0, [true, false]),
            from(1.25, 1.0, [true, false]),
            from(1.0, 0.8, [false, true]),
            from(0.9, 0.9, [true, true]),
        ]
    }

    // Ratios of the glass stay. Astigmatism and focus are R Z2 times powers of the sections.
    // Scales follow the field angle.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let mut all = values.to_vec();
        for of_power in [2, 5] {
            all[of_power] = values[of_power].scaled(ratios.pupil * ratios.image_distance);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};
    use crate::field::Meridian;

    /// Returns the half-axes of a disc of radius `alpha` behind the effect.
    fn half_axes(values: [f64; 6], alpha: f64, at: ScenePoint) -> [f64; 2] {
        let (moments, _) = behind(&Anamorphic, &values, at, disc(alpha)).moments();
        [moments.mu20, moments.mu02].map(|m| 2.0 * m.sqrt())
    }

    #[test]
    fn discs_are_the_same_ellipses_over_the_field() {
        for (x, y) in [(0.0, 0.0), (0.9, -0.3)] {
            for (values, along) in [
                ([1.0, 0.75, 0.0, 0.0, 0.0, 0.0], 3.0),
                ([0.5, 1.0, 0.0, 0.0, 0.0, 0.0], 2.0),
                ([0.5, 0.75, 0.0, 0.0, 0.0, 0.0], 1.5),
            ] {
                let got = half_axes(values, 4.0, place(x, y));
                assert!((got[0] - along).abs() < 1e-9, "{got:?}");
                assert!((got[1] - 4.0).abs() < 1e-9, "{got:?}");
            }
        }
    }

    #[test]
    fn the_image_is_sharp_along_one_axis_first() {
        let values = [1.0, 1.0, 1.5, 0.0, 0.0, 0.0];
        let got = half_axes(values, -1.5, place(0.0, 0.0));
        assert!(got[0] < 1e-6 && (got[1] - 3.0).abs() < 1e-9, "{got:?}");
        let got = half_axes(values, 1.5, place(0.0, 0.0));
        assert!((got[0] - 3.0).abs() < 1e-9 && got[1] < 1e-6, "{got:?}");
        // A cylinder along x alone.
        let got = half_axes([1.0, 1.0, 1.5, 0.0, 0.0, 1.5], 2.0, place(0.0, 0.0));
        assert!((got[0] - 5.0).abs() < 1e-9 && (got[1] - 2.0).abs() < 1e-9);
    }

    #[test]
    fn the_ellipse_scales_all_aberrations() {
        let mut round = disc(2.0);
        round.wavefront.add(1, 1, Meridian::X, 0.7);
        round.wavefront.add(2, 0, Meridian::X, -0.4);
        let values = [0.9, 0.8, 0.0, 5.0, -2.0, 0.0];
        let oval = behind(&Anamorphic, &values, place(0.5, 0.4), round.clone());
        for u in [[0.3, -0.4], [-0.8, 0.1]] {
            let on_glass = round.landing([0.8 * u[0], u[1]]);
            let got = oval.landing(u);
            assert!((got[0] - 0.9 * on_glass[0]).abs() < 1e-12);
            assert!((got[1] - on_glass[1]).abs() < 1e-12);
        }
        let chief = Anamorphic.chief_ray(&values, place(0.5, 0.4));
        assert_eq!(chief, [2.5, -0.8]);
    }
}
