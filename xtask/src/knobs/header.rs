//! Comments of the members of `SeidelSettings` in the C header.

use seidel_core::{Knob, KnobKind, KnobScope};

use super::lines;

/// Width of a comment's text, characters.
const WIDTH: usize = 112;

/// Returns the generated `header` with a comment for each member of the settings that is a knob.
pub(crate) fn with_comments(header: &str) -> String {
    let mut text = String::new();
    let mut is_settings = false;
    for line in header.lines() {
        is_settings = (is_settings || line == "typedef struct SeidelSettings {")
            && line != "} SeidelSettings;";
        // Arrays such as the noise have comments of their own.
        let name = line
            .strip_suffix(';')
            .and_then(|member| member.rsplit(' ').next());
        let knob = Knob::all().find(|knob| Some(knob.identifier().as_str()) == name);
        if let Some(knob) = knob.filter(|_| is_settings) {
            text.push_str("  /**\n");
            for line in lines(&comment(knob), WIDTH) {
                text.push_str(&format!("   * {line}\n"));
            }
            text.push_str("   */\n");
        }
        text.push_str(line);
        text.push('\n');
    }
    text
}

fn comment(knob: &Knob) -> String {
    let summary = knob.summary("if NaN");
    let of = match knob.scope {
        KnobScope::Apply => " (seidel_apply)",
        KnobScope::Remove => " (seidel_remove)",
        KnobScope::Relens => " (seidel_relens)",
        KnobScope::Removal => " (blur removal)",
        KnobScope::Lens | KnobScope::Plates | KnobScope::NewBlur => "",
    };
    let sentence = match &knob.kind {
        KnobKind::Number(number) => {
            let default = number.default.map(|value| format!(" Default {value}."));
            format!("{summary}.{}", default.unwrap_or_default())
        }
        KnobKind::Switch(switch) => {
            format!("Switch: {summary}. Default {}.", u8::from(switch.default))
        }
        KnobKind::Choice(_) => {
            let constants = knob.identifier().to_uppercase();
            format!("{summary}: SEIDEL_{constants}_...")
        }
    };
    format!("{sentence} {}{of}", knob.details)
        .replace("  ", " ")
        .trim()
        .to_owned()
}
