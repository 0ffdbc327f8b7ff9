//! The table of knobs in the guide.

use seidel_core::{Knob, KnobKind, KnobScope};

use super::default_text;

pub(super) const PATH: &str = "docs/guide/knobs.md";

const INTRODUCTION: &str = "# Knobs

Each setting has one name: the option of the command, with `_` for `-` the attribute of `seidel.Settings` and
`seidel.Look` in Python and the member of `SeidelSettings` in C. Nodes in OpenFX hosts show the label. A number that is left
out is `None` in Python, NaN in C and 0 in a node.

This page is written by `cargo xtask knobs` from the table in `core/src/knobs`.
";

/// The headings of the guide, each with the commands that it is about.
const SECTIONS: [(&str, KnobScope); 7] = [
    ("All commands that draw a lens", KnobScope::Lens),
    ("Apply, remove and relens", KnobScope::Plates),
    ("Apply and relens", KnobScope::NewBlur),
    ("Apply", KnobScope::Apply),
    ("Remove and relens", KnobScope::Removal),
    ("Remove", KnobScope::Remove),
    ("Relens, for one of its lenses", KnobScope::Relens),
];

pub(super) fn text() -> String {
    let mut text = INTRODUCTION.to_owned();
    for (heading, scope) in SECTIONS {
        text += &format!("\n## {heading}\n\n");
        text += "| option | in a node | default | meaning |\n| --- | --- | --- | --- |\n";
        for knob in Knob::all().filter(|knob| knob.scope == scope) {
            text += &row(knob);
        }
    }
    text
}

fn row(knob: &Knob) -> String {
    let label = knob.host.as_ref().map_or("", |host| host.label);
    let label = Some(label).filter(|label| !label.is_empty());
    let label = label.map(|label| format!("*{label}*"));
    let options = match &knob.kind {
        KnobKind::Choice(choice) => {
            let options = choice.options.iter();
            let options = options.map(|option| format!("<br>`{}`: {}", option.word, option.help));
            options.collect()
        }
        KnobKind::Number(_) | KnobKind::Switch(_) => String::new(),
    };
    let details = Some(knob.details).filter(|details| !details.is_empty());
    let details = details.map(|details| format!(". {}", details.trim_end_matches('.')));
    format!(
        "| `{}` | {} | {} | {}{}{options} |\n",
        knob.name,
        label.unwrap_or_default(),
        default_text(knob).unwrap_or_default(),
        knob.summary("if left out"),
        details.unwrap_or_default(),
    )
}
