//! The meaning of samples that the name of a depth channel states.

/// A meaning of samples that a name states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedDepth {
    /// Distances run along the ray from the camera.
    AlongRay,
    /// Samples are averages over surfaces.
    Filtered,
    /// Samples are shares of a range.
    Normalised,
}

/// Words in lower case, letters and digits alone, in the names that renderers and their users give.
const WORDS: [(&str, NamedDepth); 8] = [
    // Karma's `ray:hitdist` is the distance from the origin of the ray.
    ("hitdist", NamedDepth::AlongRay),
    ("raydist", NamedDepth::AlongRay),
    ("raylength", NamedDepth::AlongRay),
    ("radial", NamedDepth::AlongRay),
    ("filtered", NamedDepth::Filtered),
    ("antialiased", NamedDepth::Filtered),
    ("normalized", NamedDepth::Normalised),
    ("normalised", NamedDepth::Normalised),
];

impl NamedDepth {
    /// Returns what the full `name` of a channel says; `None` for most.
    pub fn of(name: &str) -> Option<Self> {
        let letters = name.chars().filter(|c| c.is_alphanumeric());
        let name: String = letters.flat_map(char::to_lowercase).collect();
        let is_said = |word: &str| name.contains(word) && !name.contains(&format!("un{word}"));
        let row = WORDS.iter().find(|(word, _)| is_said(word));
        row.map(|(_, meaning)| *meaning)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_say_what_they_hold_are_understood() {
        for (name, expected) in [
            ("hitDist.V", Some(NamedDepth::AlongRay)),
            ("depth.radial", Some(NamedDepth::AlongRay)),
            ("z_filtered", Some(NamedDepth::Filtered)),
            ("depth_unfiltered.Z", None),
            ("Z Normalized", Some(NamedDepth::Normalised)),
            ("ViewLayer.Depth.Z", None),
            ("Z", None),
        ] {
            assert_eq!(NamedDepth::of(name), expected, "{name}");
        }
    }
}
