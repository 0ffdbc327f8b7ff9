//! The dataclasses `Look` and `Settings` of the Python package.

use seidel_core::{Knob, KnobKind, KnobScope};

use super::lines;

pub(super) const PATH: &str = "python/seidel/_settings.py";

/// Width of a line, characters.
const WIDTH: usize = 116;

const HEAD: &str = r#""""Settings of calls. Written by ``cargo xtask knobs`` from the table of knobs; do not edit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from numpy.typing import NDArray
"#;

const LOOK: &str =
    "Artistic changes of a lens traced ray by ray. The defaults leave it as measured, to the bit.

They act on the lens as f-number and focus distance set it. docs/guide/looks.md shows them.";

const SETTINGS: &str = "Settings of ``apply``, ``remove`` and ``relens``. The defaults use the lens as measured.

The options of the command ``seidel`` have the same names. ``dataclasses.replace`` returns settings with changes.";

/// An attribute of a dataclass.
struct Attribute {
    name: String,
    annotation: String,
    default: String,
    help: String,
}

/// Returns an attribute that is no knob of the table, or is more than a number.
fn own(name: &str, annotation: &str, default: &str, help: &str) -> Attribute {
    Attribute {
        name: name.to_owned(),
        annotation: annotation.to_owned(),
        default: default.to_owned(),
        help: help.to_owned(),
    }
}

/// The knobs that have attributes of another form, or none.
const OTHER_KNOBS: [&str; 4] = ["noise", "clip", "clip-level", "expand"];

pub(super) fn text() -> String {
    let knobs = || Knob::all().filter(|knob| !OTHER_KNOBS.contains(&knob.name));
    let mut look = vec![
        own(
            "blades",
            "int | None",
            "None",
            "Iris blades: 3 to 13, or 0 for a round iris; those of the lens if ``None``",
        ),
        own(
            "aperture_picture",
            "NDArray[Any] | None",
            "None",
            "Picture of the aperture, white (1) where light passes: array of rows x columns, with or without 1 to 4 channels, ``float32`` or ``float16``. Background discs show it. Its shorter side is the width of the pupil",
        ),
    ];
    look.extend(knobs().filter(|knob| knob.is_of_look()).map(attribute));
    let mut settings: Vec<_> = knobs()
        .filter(|knob| !knob.is_of_look())
        .map(attribute)
        .collect();
    settings.extend([
        own("psf_model", "str | None", "None", "Identifier of the PSF model, such as ``pupil``; the best for the lens if ``None``"),
        own("channel_scales", "Mapping[str, float]", "field(default_factory=dict)", "Strength of the blur of lens channels by name, on top of ``amount``: above 0, up to 16"),
        own("axis_offset_px", "tuple[float, float]", "(0.0, 0.0)", "Offset of the optical axis, image pixels right and down"),
        own("noise", "float | Sequence[float] | None", "None", &knob_help("noise")),
        own("clip", "float | Literal[\"auto\", \"none\"]", "\"auto\"", &knob_help("clip")),
        own("alpha", "Literal[\"premultiplied\", \"unpremultiplied\"]", "\"premultiplied\"", "Relation of colour and alpha"),
        own("scrub", "bool", "False", "Samples that are not finite count as zero; otherwise they are an error"),
        own("pixel_aspect", "float", "1.0", "Width of a pixel over its height in the scene, 1/16 to 16: 2 for an image of a 2x anamorphic lens before it is desqueezed"),
        own("display_window", "tuple[int, int, int, int] | None", "None", "Display window (x, y, width, height) in image pixels from the top-left corner of the array, which is the data window: of an image with overscan, or of a part of a picture. It lies centre on centre with the lens's frame. The array if ``None``"),
        own("threads", "int", "0", "Most threads; 0 for one each core. Results do not depend on it"),
        own("look", "Look", "Look()", "Artistic changes of the lens of ``apply``, and of the new lens of ``relens``"),
    ]);
    [
        HEAD.to_owned(),
        class("Look", LOOK, &look),
        class("Settings", SETTINGS, &settings),
    ]
    .join("\n\n")
}

fn knob_help(name: &str) -> String {
    Knob::named(name).map_or_else(String::new, |knob| knob.summary("if ``None``"))
}

fn attribute(knob: &Knob) -> Attribute {
    let (annotation, default) = match &knob.kind {
        KnobKind::Number(number) => match number.default {
            Some(value) => ("float".to_owned(), format!("{value:?}")),
            None => ("float | None".to_owned(), "None".to_owned()),
        },
        KnobKind::Switch(switch) => {
            let default = if switch.default { "True" } else { "False" };
            ("bool".to_owned(), default.to_owned())
        }
        KnobKind::Choice(choice) => {
            let words = choice
                .options
                .iter()
                .map(|option| format!("{:?}", option.word));
            let words: Vec<_> = words.collect();
            (
                format!("Literal[{}]", words.join(", ")),
                words[choice.default].clone(),
            )
        }
    };
    let of = match knob.scope {
        KnobScope::Apply => "; in ``apply``",
        KnobScope::Remove => "; in ``remove``",
        KnobScope::Relens => "; in ``relens``",
        _ => "",
    };
    let details = Some(knob.details).filter(|details| !details.is_empty());
    let details = details.map(|details| format!(". {}", details.trim_end_matches('.')));
    Attribute {
        name: knob.identifier(),
        annotation,
        default,
        help: format!(
            "{}{of}{}",
            knob.summary("if ``None``"),
            details.unwrap_or_default()
        ),
    }
}

/// Returns a frozen dataclass, whose docstring lists its attributes, so that `help` shows them.
fn class(name: &str, about: &str, attributes: &[Attribute]) -> String {
    let mut text = format!("@dataclass(frozen=True, kw_only=True)\nclass {name}:\n    \"\"\"");
    text += &about.replace('\n', "\n    ").replace("    \n", "\n");
    text += "\n\n    Attributes:\n";
    for attribute in attributes {
        let help = format!("{}: {}.", attribute.name, attribute.help);
        for (k, line) in lines(&help, WIDTH - 12).iter().enumerate() {
            let indent = if k == 0 { 8 } else { 12 };
            text += &format!("{:indent$}{line}\n", "");
        }
    }
    text += "    \"\"\"\n\n";
    for Attribute {
        name,
        annotation,
        default,
        ..
    } in attributes
    {
        text += &format!("    {name}: {annotation} = {default}\n");
    }
    text
}
