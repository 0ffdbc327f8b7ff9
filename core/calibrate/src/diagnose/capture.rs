//! Captures that a diagnosis can recommend.

use schemars::JsonSchema;
use seidel_optics::effects::{Description, Effect};
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

    /// Returns the response of `effect` to the capture; `None` if the capture does not show the effect.
    pub(super) fn response(self, effect: &dyn Effect) -> Option<&'static str> {
        let change = effect.description();
        match self {
            Self::ShorterExposure => Some(change.shorter_exposure),
            Self::FarOutOfFocus => change.far_out_of_focus,
            Self::TwoStopsDown => Some(change.two_stops_down),
            Self::OtherSideOfFocus => Some(change.other_side_of_focus),
            Self::SecondDistance => Some(change.second_distance),
            Self::DarkSurround => Some(change.dark_surround),
            Self::None | Self::MorePlaces | Self::StoppedDownAndTurned => {
                Some(Description::UNCHANGED)
            }
        }
    }
}

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
                let response = capture.response(effect);
                response.is_some_and(|words| words != Description::UNCHANGED)
            };
            assert!(SEPARATING.iter().any(answers), "{}", effect.id());
        }
    }
}
