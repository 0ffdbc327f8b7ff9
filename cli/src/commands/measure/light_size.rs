//! The size of photographed lights, taken off the blur of the lens that was fitted to them.

use seidel_core::LensProfile;
use seidel_core::profile::LensDescription;

/// Largest diameter of the image of a light that is taken off, px. Larger discs are no blur that a variance describes.
pub(super) const MAX_DIAMETER_PX: f64 = 3.0;

/// Takes the variance of discs of `diameter_px`, along x and y, off the blur of `lens`, in every channel as far as it has so much.
/// Returns what was done, in words.
pub(super) fn take_off(lens: &mut LensProfile, diameter_px: f64) -> String {
    let disc = diameter_px * diameter_px / 16.0;
    let mut short = Vec::new();
    let mut reduce = |name: &str, variance: &mut f64| {
        let taken = disc.min(variance.max(0.0));
        *variance -= taken;
        if taken < disc {
            short.push(format!("{name}: {taken:.3} px²"));
        }
    };
    match &mut lens.description {
        LensDescription::Pupil(channels) => {
            for channel in channels {
                reduce(
                    &channel.name,
                    &mut channel.blur_variance_px2.coefficients[0],
                );
            }
        }
        LensDescription::Moments(channels) => {
            for channel in channels {
                for plane in &mut channel.planes {
                    reduce(&channel.name, &mut plane.s.0[0]);
                }
            }
        }
    }
    let settings = &mut lens.provenance.settings;
    settings.push_str(&format!("; lights of {diameter_px} px taken off"));
    if short.is_empty() {
        format!(
            "the size of the lights, a variance of {disc:.3} px², was taken off the blur of the lens"
        )
    } else {
        format!(
            "the symmetric blur of the lens is smaller than the size of the lights, a variance of {disc:.3} px²; taken off were {}. The rest is in the lens: photograph smaller lights",
            short.join(", ")
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blurs(lens: &LensProfile) -> Vec<f64> {
        let channels = lens.pupil_channels().iter();
        channels
            .map(|c| c.blur_variance_px2.coefficients[0])
            .collect()
    }

    #[test]
    fn the_variance_of_a_disc_is_taken_off_as_far_as_there_is_blur() {
        let mut lens = crate::demo::lens::lens(320, 180).expect("a lens");
        let LensDescription::Pupil(channels) = &mut lens.description else {
            panic!("the demo's lens has a pupil");
        };
        let count = channels.len();
        for channel in channels {
            channel.blur_variance_px2.coefficients[0] = 0.1;
        }
        let note = take_off(&mut lens, 0.8);
        assert!(note.contains("0.040 px², was taken off"), "{note}");
        assert!(blurs(&lens).iter().all(|b| (b - 0.06).abs() < 1e-12));
        let note = take_off(&mut lens, 2.0);
        assert!(
            note.contains("0.060 px²") && note.contains("smaller lights"),
            "{note}"
        );
        assert_eq!(blurs(&lens), vec![0.0; count]);
    }
}
