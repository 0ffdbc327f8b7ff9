//! What the source's numbers are.

use super::{Group, Kind, Knob};

/// Source codes: none, the source is light.
pub(crate) const LINEAR: i32 = 0;
/// Source codes: a space of an OpenColorIO config.
pub(crate) const BY_OCIO: i32 = 13;

/// The curves of `SOURCE_CODES`, by their names in the table of colour; none for light.
pub(crate) const CURVES: [&str; 13] = [
    "",
    "srgb",
    "bt1886",
    "acescct",
    "acescc",
    "logc3-ei800",
    "logc4",
    "slog3",
    "log3g10",
    "canon-log3",
    "vlog",
    "bmdfilm-gen5",
    "davinci-intermediate",
];

pub(crate) static SOURCE_CODES: Knob = Knob {
    name: c"sourceCodes",
    label: c"Source Codes",
    hint: c"What the source's numbers are. Linear: light, as most hosts give. Else they are turned to light, blurred, and turned back: by a curve, in the gamut they have, or as an OpenColorIO config has it.",
    kind: Kind::Choice {
        default: LINEAR,
        options: &[
            c"Linear",
            c"sRGB",
            c"Gamma 2.4",
            c"ACEScct",
            c"ACEScc",
            c"ARRI LogC3 (EI 800)",
            c"ARRI LogC4",
            c"Sony S-Log3",
            c"RED Log3G10",
            c"Canon Log 3",
            c"Panasonic V-Log",
            c"Blackmagic Film Gen 5",
            c"DaVinci Intermediate",
            c"By OpenColorIO",
        ],
    },
};

pub(crate) static CONFIG: Knob = Knob {
    name: c"ocioConfig",
    label: c"OCIO Config",
    hint: c"OpenColorIO config: a file, ocio://NAME for one that comes with OpenColorIO, or seidel for Seidel's own. Empty: the one that the environment variable OCIO names, else Seidel's own.",
    kind: Kind::File,
};

pub(crate) static SOURCE_SPACE: Knob = Knob {
    name: c"sourceSpace",
    label: c"Source Space",
    hint: c"Colour space that the source is in, and the result is given in: a name, alias or role of the config. `seidel lut --list` shows them.",
    kind: Kind::Text,
};

pub(crate) static WORKING_SPACE: Knob = Knob {
    name: c"workingSpace",
    label: c"Working Space",
    hint: c"Colour space to blur in, which must be proportional to light. Empty: the config's role scene_linear.",
    kind: Kind::Text,
};

pub(crate) static GROUP: Group = Group {
    name: c"colourGroup",
    label: c"Colour",
    open: false,
    knobs: &[&SOURCE_CODES, &CONFIG, &SOURCE_SPACE, &WORKING_SPACE],
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_choice_between_light_and_configs_is_a_curve() {
        let table = seidel_colour::curves::CurveTable::embedded().expect("in order");
        let Kind::Choice { options, .. } = SOURCE_CODES.kind else {
            panic!("a choice");
        };
        assert_eq!(options.len(), CURVES.len() + 1);
        assert_eq!(BY_OCIO as usize, CURVES.len());
        for name in &CURVES[1..] {
            assert!(table.curves.contains_key(*name), "{name}");
        }
    }
}
