//! Distortion: magnification changes with field.

use super::amount::{outwards, quantity};
use super::{
    ControlRatios, Description, Effect, FieldNeed, Fitted, Parameter, ScenePoint, SearchStart,
};
use crate::lens::VergenceSeries;

/// `distortion`: images land off their ideal position along the meridian, equally in all channels.
///
/// # Appearance
/// Straight lines bend towards the centre or away from it. PSFs keep their shape.
///
/// # Similar effects
/// An error in focal length or optical axis; the shift of centroids by coma.
///
/// # Model
/// Chief rays move by X (`linear` + `cubic` |X|² + `fifth` |X|⁴) px, with X in half frame widths: focal length error,
/// Seidel's fifth sum and the next order (the radial terms of Brown, Photogrammetric Engineering 37, 1971).
#[derive(Debug, Clone, Copy, Default)]
pub struct Distortion;

const fn term(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "px", meaning).within(-2000.0, 2000.0)
}

const PARAMETERS: [Parameter; 3] = [
    term(
        "linear",
        "shift half a frame width off the axis, linear in field",
    ),
    term(
        "cubic",
        "shift half a frame width off the axis, cubic in field",
    ),
    term(
        "fifth",
        "shift half a frame width off the axis, fifth power of field",
    ),
];

impl Effect for Distortion {
    fn description(&self) -> &'static Description {
        &Description {
            id: "distortion",
            summary: "magnification changes with field: pictures land radially off, alike in every channel",
            title: "distortion",
            meaning: "The magnification changes with the field: PSFs lie radially off their ideal positions, alike in every channel.",
            action: "Check the ideal positions and the focal length, and that neither camera nor raw converter undistorts one of the sets. Then use corrected.json.",
            parameters: &PARAMETERS,
            field_need: FieldNeed::Radii,
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        fitted.of("linear")?;
        let shift: f64 = PARAMETERS.iter().map(|p| fitted.number(p.name)).sum();
        let share = 100.0 * shift.abs() / fitted.lens.half_width_px;
        Some(format!(
            "points at the side of the frame land {} ({} of their distance from the axis)",
            outwards(shift),
            quantity(share, 0.0, "%")
        ))
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let h2 = point.at.radius().powi(2);
        let stretch = values[0] + (values[1] + values[2] * h2) * h2;
        [stretch * point.at.x, stretch * point.at.y]
    }

    fn starts(&self) -> Vec<SearchStart> {
        vec![SearchStart::all_free(&[0.5, 0.5, 0.0])]
    }

    // Powers of the field angle X / Z2, times Z2, like E in docs/background/model.md section 10.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let powers = [0, -2, -4].into_iter().zip(values);
        powers
            .map(|(power, series)| series.scaled(ratios.image_distance.powi(power)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Scope;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn shifts_lie_along_the_meridian_and_shapes_stay() {
        assert!(PARAMETERS.iter().all(|p| p.scope == Scope::Lens));
        let shift = |values: [f64; 3], x, y| Distortion.chief_ray(&values, place(x, y));
        assert_eq!(shift([1.0, 2.0, 4.0], 0.0, 0.0), [0.0; 2]);
        assert_eq!(shift([1.0, 2.0, 4.0], -1.0, 0.0), [-7.0, 0.0]);
        assert_eq!(shift([0.0, 2.0, 0.0], 0.0, 0.5), [0.0, 0.25]);
        assert_eq!(shift([0.0, 0.0, 4.0], 0.0, 0.5), [0.0, 0.125]);
        let pupil = behind(&Distortion, &[1.0, 2.0, 4.0], place(0.7, 0.4), disc(2.0));
        assert_eq!(pupil, disc(2.0));
    }
}
