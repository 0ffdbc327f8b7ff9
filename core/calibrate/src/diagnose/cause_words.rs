//! Plain words for causes: title, meaning and action of each effect.

/// Plain words for a cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CauseWords {
    /// Identifier of the effect, or `unknown`.
    pub id: &'static str,
    /// Name in plain words: a noun phrase that starts in lower case.
    pub title: &'static str,
    /// Meaning for the lens or the camera, in one sentence.
    pub meaning: &'static str,
    /// Advice on what to do about it.
    pub action: &'static str,
}

/// Returns the words for the effect `id` or for `unknown`; `None` for other identifiers.
pub fn cause_words(id: &str) -> Option<&'static CauseWords> {
    WORDS.iter().find(|words| words.id == id)
}

/// Returns the title of the effect `id`; the identifier itself where no words are known.
pub(super) fn title(id: &str) -> &str {
    cause_words(id).map_or(id, |words| words.title)
}

/// Words for every effect of the library, for `pupil_scale`, and for the unknown cause.
static WORDS: [CauseWords; 22] = [
    CauseWords {
        id: "defocus_offset",
        title: "a focus offset",
        meaning: "The sensor or the focus ring is not where the camera says: every point is out of focus by the same amount.",
        action: "Set the focus to the stated distance again and repeat one PSF. If the offset returns, have the flange distance (shims of the mount) adjusted, or render with corrected.json.",
    },
    CauseWords {
        id: "depth_scale",
        title: "wrong object distances",
        meaning: "The stated object distances are wrong by one factor, for example measured from another point than the entrance pupil.",
        action: "Measure the distances again, in metres from the entrance pupil. Correct depth_m in the manifest, and fit or diagnose again.",
    },
    CauseWords {
        id: "sensor_tilt",
        title: "a tilted sensor",
        meaning: "The sensor, or the lens on its mount, is not square to the optical axis: one side of the frame focuses nearer than the other.",
        action: "Clean and tighten mount and adapter, and have the sensor or the mount shimmed. If all PSFs are of one flat chart, first make sure that the chart itself was parallel to the sensor.",
    },
    CauseWords {
        id: "decentre",
        title: "a decentred element",
        meaning: "An element or a group of the lens is shifted or tilted off the axis: coma even in the middle, and corners that differ.",
        action: "Have the lens re-collimated (its elements centred again). Until then render with corrected.json, which holds for this copy of the lens only.",
    },
    CauseWords {
        id: "higher_order",
        title: "fifth-order aberrations",
        meaning: "The lens has stronger fifth-order aberrations than its profile: rings and flares in its discs, corners that worsen faster.",
        action: "Fit the lens again with `seidel fit --model extended` and PSFs up to the corners. If an extended profile was right before, have the spacing of the elements checked.",
    },
    CauseWords {
        id: "seventh_order",
        title: "seventh-order aberrations",
        meaning: "The lens has aberrations of seventh order, which show in the corners of fast and wide lenses.",
        action: "Fit the lens again with `seidel fit --model extended` and PSFs up to the corners.",
    },
    CauseWords {
        id: "double_plane",
        title: "two planes of symmetry",
        meaning: "The lens has cylindrical elements, as anamorphic lenses do, so its aberrations differ along x and along y.",
        action: "Fit the lens again with `seidel fit --model extended` and PSFs in all quarters of the frame.",
    },
    CauseWords {
        id: "axial_colour",
        title: "axial colour",
        meaning: "The colour channels focus at different distances.",
        action: "Use corrected.json, or fit the lens to PSFs of all channels. If it was right before, look for another light source or a filter in the beam.",
    },
    CauseWords {
        id: "lateral_colour",
        title: "lateral colour",
        meaning: "The colour channels have different magnifications: they are shifted against each other towards the corners.",
        action: "Use corrected.json. First make sure that neither camera nor raw converter corrects chromatic aberration in one of the sets.",
    },
    CauseWords {
        id: "distortion",
        title: "distortion",
        meaning: "The magnification changes with the field: PSFs lie radially off their ideal positions, alike in every channel.",
        action: "Check the ideal positions and the focal length, and that neither camera nor raw converter undistorts one of the sets. Then use corrected.json.",
    },
    CauseWords {
        id: "anamorphic",
        title: "an anamorphic squeeze",
        meaning: "The lens focuses and magnifies differently along x and along y: out-of-focus discs are ellipses.",
        action: "State camera.squeeze in the manifest and fit again with `seidel fit --model extended`. Make sure that both sets are squeezed, or both desqueezed.",
    },
    CauseWords {
        id: "aperture_polygon",
        title: "iris blades",
        meaning: "The iris is a polygon: out-of-focus highlights have corners.",
        action: "Use corrected.json at this f-number, or fit again with `seidel fit --model extended` to PSFs far out of focus. Profiles of other stops need PSFs of their own.",
    },
    CauseWords {
        id: "vignetting",
        title: "vignetting",
        meaning: "The barrel, a hood or a filter ring clips oblique light: out-of-focus discs become cat's eyes towards the corners.",
        action: "Remove hood and filters and look again. If it stays, it is the lens's own: use corrected.json, or fit again with `seidel fit --model extended`.",
    },
    CauseWords {
        id: "obstruction",
        title: "a central obstruction",
        meaning: "The middle of the pupil is dark: out-of-focus discs are rings.",
        action: "Check that the lens is a mirror lens, or that nothing stands before it.",
    },
    CauseWords {
        id: "apodisation",
        title: "an uneven pupil",
        meaning: "The pupil does not transmit evenly: out-of-focus discs have soft or bright rims on both sides of focus.",
        action: "Look for haze, a smooth-transition filter or a mirror's shadow. Use corrected.json, or fit again with `seidel fit --model extended`.",
    },
    CauseWords {
        id: "diffraction",
        title: "diffraction",
        meaning: "The stop is so small against the pixels that light spreads as a wave, in an Airy pattern.",
        action: "Use corrected.json. Make sure that f-number, pixel pitch and wavelengths of the profile are those of the camera.",
    },
    CauseWords {
        id: "pupil_scale",
        title: "a wrong f-number",
        meaning: "The f-number is not the stated one: the stop has another size, or a T-stop was taken for an f-stop, so all blur is scaled alike.",
        action: "Correct the stated f-number in the manifest or the profile (camera.f_number), and fit or diagnose again. A T-stop includes the light loss of the glass, so it is always the larger number. If the stated number is right, have the iris checked.",
    },
    CauseWords {
        id: "motion",
        title: "camera motion",
        meaning: "Camera or target moved during the exposure: the same streak everywhere, in every channel.",
        action: "Re-shoot from a firm support with a remote release and a shorter exposure. Do not keep this in the profile: it belongs to these pictures, not to the lens.",
    },
    CauseWords {
        id: "pixel_footprint",
        title: "the pixel footprint",
        meaning: "The pixels or the optical low-pass filter in front of them spread light more than the profile assumes, alike everywhere.",
        action: "Use corrected.json for this camera. The cause is the sensor, not the lens: another camera needs another value. Make sure that no picture was scaled or sharpened.",
    },
    CauseWords {
        id: "veiling_glare",
        title: "veiling glare",
        meaning: "Light scatters in lens or sensor: a faint wide halo around every point.",
        action: "Clean front and rear element and filters, shade the lens, and re-shoot. If the halo stays, use corrected.json.",
    },
    CauseWords {
        id: "tone_curve",
        title: "a tone curve",
        meaning: "Pixel values are not proportional to light: bright cores are compressed, stretched or clipped.",
        action: "Develop the pictures scene-linear, without picture profile, and expose so that nothing clips. Then measure the PSFs again.",
    },
    CauseWords {
        id: "unknown",
        title: "an unknown cause",
        meaning: "No effect of the library describes this gap.",
        action: "Make the next capture. Look at the residuals of the PSFs for rings, sides and directions.",
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::effects;

    #[test]
    fn every_effect_has_words_of_its_own() {
        let ids = effects::ALL.iter().map(|effect| effect.id());
        for id in ids.chain(["unknown"]) {
            let words = cause_words(id).unwrap_or_else(|| panic!("no words for {id}"));
            assert!(
                words.title != id || !id.contains('_'),
                "{id} needs a plain title"
            );
            for sentence in [words.meaning, words.action] {
                assert!(sentence.ends_with('.'), "{sentence}");
                let raw = effects::ALL.iter().map(|effect| effect.id());
                for raw in raw.filter(|raw| raw.contains('_')) {
                    assert!(!sentence.contains(raw), "{sentence}");
                }
            }
            assert_eq!(words.meaning.matches(". ").count(), 0, "one sentence: {id}");
        }
        assert_eq!(title("no_such_effect"), "no_such_effect");
    }

    #[test]
    fn titles_are_unique() {
        let mut titles: Vec<&str> = WORDS.iter().map(|words| words.title).collect();
        titles.sort_unstable();
        titles.dedup();
        assert_eq!(titles.len(), WORDS.len());
    }
}
