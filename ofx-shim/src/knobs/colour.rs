//! The colour group: encoding and colour space of the source.

use super::{Group, Kind, Knob, Own, Rows};

/// Source encoding: scene-linear.
pub(crate) const LINEAR: i32 = 0;
/// Source encoding: a colour space of an OpenColorIO config.
pub(crate) const BY_OCIO: i32 = 13;

/// Names of the transfer functions in `luts/curves.toml`, for the options of [`SOURCE_ENCODING`] before [`BY_OCIO`].
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

pub(crate) static SOURCE_ENCODING: Knob = Knob {
    name: c"sourceCodes",
    label: c"Source Encoding",
    hint: c"Encoding of the source. Linear: scene-linear light, as most hosts pass it. Otherwise the source is converted to linear, blurred and converted back: by a transfer function, within its gamut, or by an OpenColorIO config.",
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
    hint: c"OpenColorIO config: a file, ocio://NAME for a config built into OpenColorIO, or seidel for Seidel's own. Empty: the config that the environment variable OCIO names, otherwise Seidel's own.",
    kind: Kind::File,
};

pub(crate) static SOURCE_SPACE: Knob = Knob {
    name: c"sourceSpace",
    label: c"Source Space",
    hint: c"Colour space of source and result: a name, alias or role of the config. `seidel lut --list` lists them.",
    kind: Kind::Text,
};

pub(crate) static WORKING_SPACE: Knob = Knob {
    name: c"workingSpace",
    label: c"Working Space",
    hint: c"Colour space to blur in; it must be proportional to light. Empty: the config's role scene_linear.",
    kind: Kind::Text,
};

pub(crate) static GROUP: Group = Group {
    name: c"colourGroup",
    label: c"Colour",
    open: false,
    own: &[
        Own::first(&SOURCE_ENCODING),
        Own::first(&CONFIG),
        Own::first(&SOURCE_SPACE),
        Own::first(&WORKING_SPACE),
    ],
    table: Rows::None,
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_between_linear_and_ocio_is_a_curve() {
        let table = seidel_colour::curves::CurveTable::embedded().expect("valid");
        let Kind::Choice { options, .. } = SOURCE_ENCODING.kind else {
            panic!("not a choice");
        };
        assert_eq!(options.len(), CURVES.len() + 1);
        assert_eq!(BY_OCIO as usize, CURVES.len());
        for name in &CURVES[1..] {
            assert!(table.curves.contains_key(*name), "{name}");
        }
    }
}
