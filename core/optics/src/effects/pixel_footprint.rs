//! Pixel aperture and optical low-pass filter.

use super::{Description, Effect, Fitted, Parameter, ScenePoint, SearchStart, Symmetry};
use crate::lens::LocalPupil;

/// `pixel_footprint`: the sensor gathers light from more than the area of each pixel.
///
/// # Appearance
/// A box blur or four close copies, the same over the whole field and in all channels; visible where the lens is sharp.
///
/// # Similar effects
/// Weak `motion`; `diffraction`; the symmetric blur of the lens.
///
/// # Model
/// A box of side `box` px, in addition to the pixel area of the base model. A birefringent filter makes copies `copies_x`
/// and `copies_y` px apart (Greivenkamp, Applied Optics 29, 1990).
#[derive(Debug, Clone, Copy, Default)]
pub struct PixelFootprint;

const fn length(name: &'static str, meaning: &'static str) -> Parameter {
    Parameter::new(name, "px", meaning).within(0.0, 16.0)
}

const PARAMETERS: [Parameter; 3] = [
    length("box", "side of the box"),
    length("copies_x", "distance of the copies along x"),
    length("copies_y", "distance of the copies along y"),
];

impl Effect for PixelFootprint {
    fn description(&self) -> &'static Description {
        &Description {
            id: "pixel_footprint",
            summary: "pixels and low-pass filter have a size: a box or four close copies, alike everywhere",
            title: "the pixel footprint",
            meaning: "The pixels or the optical low-pass filter in front of them spread light more than the profile assumes, alike everywhere.",
            action: "Use corrected.json for this camera. The cause is the sensor, not the lens: another camera needs another value. Make sure that no picture was scaled or sharpened.",
            parameters: &PARAMETERS,
            symmetry: Symmetry::TwoPlanes,
            ..Description::DEFAULT
        }
    }

    fn fitted_amount(&self, fitted: Fitted) -> Option<String> {
        let size = fitted.of("box")?;
        let micrometres = fitted.lens.pitch_um.map_or(String::new(), |pitch| {
            format!(" ({})", size.quantity(pitch, "µm"))
        });
        let mut words = format!(
            "a box of {}{micrometres} besides the pixel itself",
            size.quantity(1.0, "px")
        );
        if let (Some(x), Some(y)) = (fitted.of("copies_x"), fitted.of("copies_y")) {
            words += &format!(
                "; copies {} apart along x and {} along y",
                x.quantity(1.0, "px"),
                y.quantity(1.0, "px")
            );
        }
        Some(words)
    }

    fn apply(&self, values: &[f64], _point: ScenePoint, pupil: &mut LocalPupil) {
        let &[side, copies_x, copies_y] = values else {
            panic!("one value a parameter");
        };
        let sensor = &mut pupil.sensor;
        sensor.box_px = sensor.box_px.map(|b| b + side);
        sensor.copies_px[0] += copies_x;
        sensor.copies_px[1] += copies_y;
    }

    // The box, the filter, then both.
    fn starts(&self) -> Vec<SearchStart> {
        vec![
            SearchStart::new(&[1.5, 0.0, 0.0], &[true, false, false]),
            SearchStart::new(&[0.0, 1.0, 1.0], &[false, true, true]),
            SearchStart::all_free(&[1.0, 0.7, 0.7]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::{behind, disc, place};

    #[test]
    fn box_and_copies_add_the_same_variance_over_the_field() {
        for (x, y) in [(0.0, 0.0), (0.9, -0.3)] {
            let moments = |values: [f64; 3]| {
                behind(&PixelFootprint, &values, place(x, y), disc(2.0))
                    .moments()
                    .0
            };
            let [still, side, copies] = [[0.0; 3], [1.5, 0.0, 0.0], [0.0, 1.0, 0.5]].map(moments);
            assert!((side.mu20 - still.mu20 - 2.25 / 12.0).abs() < 1e-12);
            assert!((side.mu02 - still.mu02 - 2.25 / 12.0).abs() < 1e-12);
            assert!((copies.mu20 - still.mu20 - 0.25).abs() < 1e-12);
            assert!((copies.mu02 - still.mu02 - 0.0625).abs() < 1e-12);
        }
    }
}
