//! The lens has two focal lengths.

use super::{Effect, Parameter, Resetting, ScenePoint, Start};
use crate::lens::{LocalPupil, VergenceSeries};

/// `anamorphic`: the lens is another one along x than along y.
///
/// Discs out of focus are ellipses, alike all over the field; along one axis the picture is sharp where it
/// is not yet along the other. Mistaken for astigmatism, which is round at one focus and grows with
/// field, and for pixels that are not square. Three things, to first order in how the two sections of
/// the lens differ (after Wynne, Proc. Phys. Soc. B 67, 1954): rays land `squeeze` times as far along x; the
/// pupil is an ellipse, `pupil` times as wide along x, so that a disc of radius alpha has the half-axis
/// alpha pupil there; and W gains `astigmatism` (u_x² - u_y²)/2. Pictures land scale_x X, scale_y Y px
/// off. It takes all that other effects do to the wavefront along, so it acts after them; stops stay
/// round in units of the ellipse.
#[derive(Debug, Clone, Copy, Default)]
pub struct Anamorphic;

const fn ratio(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "1", meaning)
        .at_rest(1.0)
        .within(0.4, 2.5)
        .step(0.01)
}

static PARAMETERS: [Parameter; 5] = [
    ratio(
        "squeeze",
        "how far rays land along x over where a round lens puts them",
    ),
    ratio("pupil", "width of the pupil along x over that along y"),
    Parameter::new(
        "astigmatism",
        "px",
        "defocus along x less that along y, halved",
    )
    .within(-200.0, 200.0),
    Parameter::new(
        "scale_x",
        "px",
        "how far pictures half a frame width off move out along x",
    )
    .within(-2000.0, 2000.0),
    Parameter::new(
        "scale_y",
        "px",
        "how far pictures half a frame width off move out along y",
    )
    .within(-2000.0, 2000.0),
];

impl Effect for Anamorphic {
    fn id(&self) -> &'static str {
        "anamorphic"
    }

    fn summary(&self) -> &'static str {
        "the lens has two focal lengths: elliptical discs, another focus along x than along y"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &PARAMETERS
    }

    fn act(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[squeeze, width, astigmatism, ..] = values else {
            panic!("one value a parameter");
        };
        let wave = &mut pupil.wavefront;
        wave.add_monomial(2, 0, astigmatism / 2.0);
        wave.add_monomial(0, 2, -astigmatism / 2.0);
        // A ray through (w u_x, u_y): the slope by u_x is w times that by the place on the glass.
        *wave = wave.stretched_x(width);
        pupil.squeeze[0] *= squeeze / width;
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        [values[3] * point.at.x, values[4] * point.at.y]
    }

    // Wider or narrower pictures, an elliptical pupil, then all together.
    fn starts(&self) -> Vec<Start> {
        let from = |squeeze, pupil, free: [bool; 2]| Start {
            values: vec![squeeze, pupil, 0.0, 0.0, 0.0],
            free: vec![free[0], free[1], true, true, true],
        };
        vec![
            from(0.8, 1.0, [true, false]),
            from(1.25, 1.0, [true, false]),
            from(1.0, 0.8, [false, true]),
            from(0.9, 0.9, [true, true]),
        ]
    }

    // Ratios of the glass stay; astigmatism is a power of the glass that differs by section, R Z2 times it;
    // scales go with the field angle.
    fn reset(&self, values: &[VergenceSeries], to: Resetting) -> Vec<VergenceSeries> {
        let mut all = values.to_vec();
        all[2] = values[2].scaled(to.pupil * to.image_distance);
        all
    }
}
