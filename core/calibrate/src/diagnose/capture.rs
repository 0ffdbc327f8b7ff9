//! Captures that a diagnosis can recommend, and the response of each effect to them.

use schemars::JsonSchema;
use serde::Serialize;

/// A capture that settles which of several causes is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Capture {
    /// No capture is needed.
    None,
    /// A quarter of the exposure time at the same aperture.
    ShorterExposure,
    /// Discs of at least 40 px in the middle and in a corner.
    FarOutOfFocus,
    /// Two stops down, at the same exposure time.
    TwoStopsDown,
    /// The same points as far on the other side of focus.
    OtherSideOfFocus,
    /// PSFs at another, much nearer distance.
    SecondDistance,
    /// A lamp on a wide dark surround, by long and short exposures.
    DarkSurround,
    /// PSFs at more places, up to the corners.
    MorePlaces,
    /// Middle, edge and corner two stops down, and again with the camera turned by 90 degrees.
    StoppedDownAndTurned,
}

/// Captures that separate effects, the cheapest first.
pub(super) const SEPARATING: [Capture; 6] = [
    Capture::ShorterExposure,
    Capture::FarOutOfFocus,
    Capture::TwoStopsDown,
    Capture::OtherSideOfFocus,
    Capture::SecondDistance,
    Capture::DarkSurround,
];

impl Capture {
    /// All captures.
    pub const ALL: [Self; 9] = [
        Self::None,
        Self::ShorterExposure,
        Self::FarOutOfFocus,
        Self::TwoStopsDown,
        Self::OtherSideOfFocus,
        Self::SecondDistance,
        Self::DarkSurround,
        Self::MorePlaces,
        Self::StoppedDownAndTurned,
    ];

    /// Returns the identifier used in reports.
    pub fn id(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::ShorterExposure => "shorter_exposure",
            Self::FarOutOfFocus => "far_out_of_focus",
            Self::TwoStopsDown => "two_stops_down",
            Self::OtherSideOfFocus => "other_side_of_focus",
            Self::SecondDistance => "second_distance",
            Self::DarkSurround => "dark_surround",
            Self::MorePlaces => "more_places",
            Self::StoppedDownAndTurned => "stopped_down_and_turned",
        }
    }

    /// Returns the instruction to the photographer, without a full stop.
    pub fn instruction(self) -> &'static str {
        match self {
            Self::None => "none needed",
            Self::ShorterExposure => {
                "repeat one PSF with a quarter of the exposure time and the same aperture"
            }
            Self::FarOutOfFocus => {
                "photograph one point in the middle and one in a corner so far out of focus that their discs are 40 px wide"
            }
            Self::TwoStopsDown => {
                "repeat one corner PSF two stops down, with the same exposure time and more light"
            }
            Self::OtherSideOfFocus => {
                "refocus so that the same points lie as far on the other side of focus"
            }
            Self::SecondDistance => "add PSFs at another, much nearer distance",
            Self::DarkSurround => {
                "photograph one lamp on a wide dark surround with long and short exposures"
            }
            Self::MorePlaces => "add PSFs at more places, up to the corners on all sides",
            Self::StoppedDownAndTurned => {
                "repeat three PSFs (middle, edge, corner) two stops down and, apart from that, with the camera turned by 90 degrees"
            }
        }
    }

    /// Returns the response of the effect `id` to the capture; `None` if the capture does not show the effect.
    pub(super) fn response(self, id: &str) -> Option<&'static str> {
        let listed = self.responses().iter().find(|(effect, _)| *effect == id);
        let unlisted = (self != Self::FarOutOfFocus).then_some(UNCHANGED);
        listed.map(|(_, response)| *response).or(unlisted)
    }

    /// Returns the effects that respond to the capture, each with its response.
    pub(super) fn responses(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::ShorterExposure => &[
                ("motion", "the streak shortens"),
                ("tone_curve", "bright cores are compressed less"),
            ],
            Self::FarOutOfFocus => &[
                ("aperture_polygon", "the discs have corners"),
                ("vignetting", "only the disc in the corner is cut"),
                ("apodisation", "the rims of both discs are soft or bright"),
                ("higher_order", "the discs have rings and flares"),
                (
                    "pupil_scale",
                    "both discs are whole and of another size than stated",
                ),
                ("anamorphic", "both discs are ellipses"),
                ("decentre", "both discs are brighter on one side"),
            ],
            Self::TwoStopsDown => &[
                ("diffraction", "the blur grows"),
                ("defocus_offset", WITH_PUPIL),
                ("depth_scale", WITH_PUPIL),
                ("sensor_tilt", WITH_PUPIL),
                ("anamorphic", WITH_PUPIL),
                ("pupil_scale", WITH_PUPIL),
                (
                    "axial_colour",
                    "the difference in focus shrinks with the pupil",
                ),
                ("decentre", "coma shrinks with the square of the pupil"),
                ("higher_order", "rings and flares vanish first"),
                ("vignetting", "the cat's eye becomes round"),
                ("aperture_polygon", "the polygon shows in full"),
                ("apodisation", "the edge of the disc hardens"),
            ],
            Self::OtherSideOfFocus => &[
                ("defocus_offset", ADDS),
                ("depth_scale", ADDS),
                ("sensor_tilt", "the side that is in focus changes"),
                ("axial_colour", "the colour order of the discs flips"),
                ("aperture_polygon", "the polygon turns upside down"),
                ("vignetting", "the cat's eye turns over"),
                ("decentre", "coma keeps its direction while discs flip"),
                ("anamorphic", "the long axis of the discs changes"),
                ("higher_order", "bright rims turn into soft ones"),
                ("apodisation", "soft edges stay soft"),
                ("pupil_scale", "discs on both sides are scaled alike"),
            ],
            Self::SecondDistance => &[
                ("depth_scale", "the extra defocus grows with 1 / distance"),
                (
                    "defocus_offset",
                    "the extra defocus is the same at both distances",
                ),
            ],
            Self::DarkSurround => &[("veiling_glare", "its halo goes on far beyond the tile")],
            Self::None | Self::MorePlaces | Self::StoppedDownAndTurned => &[],
        }
    }
}

/// Response of an effect that a capture leaves alone.
pub(super) const UNCHANGED: &str = "nothing changes";
/// Response of defocus to the pupil.
const WITH_PUPIL: &str = "the blur shrinks with the pupil";
/// Response of extra defocus to a change of side.
const ADDS: &str = "discs grow on one side of focus and shrink on the other";

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_optics::effects;

    #[test]
    fn captures_have_identifiers_and_instructions_of_their_own() {
        for (index, capture) in Capture::ALL.into_iter().enumerate() {
            assert!(!capture.instruction().ends_with('.'));
            for other in &Capture::ALL[..index] {
                assert_ne!(capture.id(), other.id());
                assert_ne!(capture.instruction(), other.instruction());
            }
        }
    }

    #[test]
    fn every_effect_of_the_library_but_plain_shifts_responds_to_a_capture() {
        let shifts = ["lateral_colour", "distortion", "pixel_footprint"];
        for effect in effects::causes().filter(|e| !shifts.contains(&e.id())) {
            let answers = |capture: &Capture| {
                let mut listed = capture.responses().iter();
                listed.any(|(id, _)| *id == effect.id())
            };
            assert!(SEPARATING.iter().any(answers), "{}", effect.id());
        }
    }
}
