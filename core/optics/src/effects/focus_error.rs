//! Focus errors of single shots.

use super::amount::joined;
use super::defocus_offset::metres;
use super::{
    ControlRatios, DefocusOffset, DepthScale, Description, Effect, Fitted, Parameter, ScenePoint,
    SearchStart,
};
use crate::field::Meridian;
use crate::lens::{LocalPupil, VergenceSeries};

/// `focus_error`: the focus of each object distance has an error of its own.
///
/// # Appearance
/// Extra defocus that is the same all over the frame and another at each distance, without a rule: autofocus moved between the
/// shots, or the ring was touched.
///
/// # Similar effects
/// `defocus_offset`, the same at every distance; `depth_scale`, in proportion to vergence.
///
/// # Model
/// At the vergence of a shot k, W gains `alpha_k` |u|²/2 as for `defocus_offset`, and the chief ray moves by `breathing` `alpha_k` X px.
/// Between the shots the errors are interpolated by inverse squared distance in vergence (Shepard, Proc. 23rd ACM National Conference,
/// 1968), which never exceeds them.
#[derive(Debug, Clone, Copy, Default)]
pub struct FocusError;

/// Largest number of shots.
const SHOTS: usize = 6;
/// Indices of the first vergence, of the first error, and of the breathing.
const VERGENCES: usize = 1;
const ERRORS: usize = VERGENCES + SHOTS;
const BREATHING: usize = ERRORS + SHOTS;
/// Squared difference of vergence at which interpolation stays finite, 1/m².
const SAME: f64 = 1e-12;

const fn vergence(name: &'static str) -> Parameter {
    Parameter::new(name, "1/m", "vergence of the shot")
        .within(0.0, 1e4)
        .step(0.01)
}

const fn error(name: &'static str) -> Parameter {
    Parameter::new(name, "px", "defocus added in the shot").within(-200.0, 200.0)
}

const PARAMETERS: [Parameter; BREATHING + 1] = [
    Parameter::new("shots", "1", "number of shots")
        .neutral_at(1.0)
        .within(1.0, SHOTS as f64)
        .step(1.0),
    vergence("vergence_1"),
    vergence("vergence_2"),
    vergence("vergence_3"),
    vergence("vergence_4"),
    vergence("vergence_5"),
    vergence("vergence_6"),
    error("alpha_1"),
    error("alpha_2"),
    error("alpha_3"),
    error("alpha_4"),
    error("alpha_5"),
    error("alpha_6"),
    Parameter::new(
        "breathing",
        "1/h",
        "outward shift of chief rays per px of that defocus and half frame width off the axis",
    )
    .within(-50.0, 50.0)
    .step(0.1),
];

/// Returns the extra defocus at `point`, px.
fn defocus(values: &[f64], point: ScenePoint) -> f64 {
    let shots = values[0] as usize;
    let (mut sum, mut weights) = (0.0, 0.0);
    for shot in 0..shots {
        let apart = point.vergence_per_m - values[VERGENCES + shot];
        let weight = 1.0 / (apart * apart + SAME);
        sum += weight * values[ERRORS + shot];
        weights += weight;
    }
    sum / weights
}

impl Effect for FocusError {
    fn description(&self) -> &'static Description {
        &Description {
            id: "focus_error",
            summary: "focus moved between the shots: extra defocus that is another at each distance",
            title: "focus that moved between the shots",
            meaning: "Focus was another at each object distance: autofocus moved between the shots, or the ring was touched.",
            action: "Switch autofocus off, tape the focus ring, and take the PSFs of all distances again in one go. corrected.json holds for these shots only.",
            parameters: &PARAMETERS,
            two_stops_down: Description::SHRINKS,
            other_side_of_focus: Description::ADDS,
            second_distance: "the new shot has an extra defocus of its own",
            contains: &[&DefocusOffset, &DepthScale],
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let shots = fitted.number("shots") as usize;
        let errors = (0..shots).filter_map(|shot| {
            let alpha = fitted.of(PARAMETERS[ERRORS + shot].name)?;
            let distance = metres(fitted.number(PARAMETERS[VERGENCES + shot].name));
            Some(
                match (fitted.lens.mm_per_px(), fitted.lens.side(alpha.value)) {
                    (Some(mm), Some(side)) => {
                        let length = alpha.quantity(mm, "mm");
                        format!("{length} {side} the focus at {distance}")
                    }
                    _ => format!("{} of defocus off at {distance}", alpha.quantity(1.0, "px")),
                },
            )
        });
        let errors = joined(errors.collect())?;
        Some(format!("the sensor sat {errors}"))
    }

    fn apply(&self, values: &[f64], point: ScenePoint, pupil: &mut LocalPupil) {
        assert_eq!(values.len(), PARAMETERS.len(), "one value a parameter");
        let alpha = defocus(values, point);
        pupil.wavefront.add(1, 0, Meridian::X, alpha / 2.0);
    }

    fn chief_ray(&self, values: &[f64], point: ScenePoint) -> [f64; 2] {
        let stretch = values[BREATHING] * defocus(values, point);
        [stretch * point.at.x, stretch * point.at.y]
    }

    fn starts(&self) -> Vec<SearchStart> {
        self.starts_at(&[0.1, 0.2, 0.4, 0.7, 1.0, 1.5])
    }

    // One distance does not distinguish it from a focus offset.
    fn starts_at(&self, vergences: &[f64]) -> Vec<SearchStart> {
        let shots = vergences.len();
        if !(2..=SHOTS).contains(&shots) {
            return Vec::new();
        }
        let start = |sign: f64| {
            let mut values = [0.0; BREATHING + 1];
            let mut free = [false; BREATHING + 1];
            (values[0], free[BREATHING]) = (shots as f64, true);
            for (shot, vergence) in vergences.iter().enumerate() {
                values[VERGENCES + shot] = *vergence;
                values[ERRORS + shot] = 0.5 * sign.powi(shot as i32);
                free[ERRORS + shot] = true;
            }
            SearchStart::new(&values, &free)
        };
        vec![start(1.0), start(-1.0)]
    }

    // Like `defocus_offset` at each distance; breathing is the ratio of shift and defocus.
    fn rescale(&self, values: &[VergenceSeries], ratios: ControlRatios) -> Vec<VergenceSeries> {
        let each = values.iter().enumerate();
        each.map(|(index, series)| match index {
            ERRORS..BREATHING => series.scaled(ratios.pupil / ratios.image_distance),
            BREATHING => series.scaled(1.0 / ratios.pupil),
            _ => series.clone(),
        })
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, point};

    #[test]
    fn every_shot_has_its_own_defocus_and_none_between_exceeds_them() {
        let mut values = FocusError.starts_at(&[0.2, 0.5, 1.0])[0].values.clone();
        values[ERRORS..ERRORS + 3].copy_from_slice(&[1.0, -2.0, 0.5]);
        values[BREATHING] = 0.3;
        let at = |vergence_per_m: f64| {
            let there = ScenePoint {
                vergence_per_m,
                ..point()
            };
            let pupil = behind(&FocusError, &values, there, disc(2.0));
            let chief = FocusError.chief_ray(&values, there);
            (pupil.landing([1.0, 0.0])[0] - 2.0, chief[0] / there.at.x)
        };
        for (vergence, alpha) in [(0.2, 1.0), (0.5, -2.0), (1.0, 0.5)] {
            let (defocus, stretch) = at(vergence);
            assert!((defocus - alpha).abs() < 1e-9, "{vergence}: {defocus}");
            assert!(
                (stretch - 0.3 * alpha).abs() < 1e-9,
                "{vergence}: {stretch}"
            );
        }
        for k in 0..20 {
            let (defocus, _) = at(0.1 * f64::from(k));
            assert!((-2.0..=1.0).contains(&defocus), "{defocus}");
        }
        assert!(FocusError.starts_at(&[0.5]).is_empty());
    }
}
