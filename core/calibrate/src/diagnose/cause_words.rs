//! Plain words for causes: title, meaning and action of each effect, and of the unknown cause.

use schemars::JsonSchema;
use seidel_optics::effects;
use serde::Serialize;

/// An effect with its plain words.
#[derive(Serialize, JsonSchema)]
pub struct CauseWords<'a> {
    /// Identifier of the effect, or `unknown`.
    pub effect: &'a str,
    /// Name in plain words.
    pub title: &'a str,
    /// Meaning for the lens or the camera.
    pub meaning: &'static str,
    /// Advice on what to do about it.
    pub action: &'static str,
}

/// Returns the words for the effect `id` or for `unknown`. Other identifiers are their own title.
pub fn cause_words(id: &str) -> CauseWords<'_> {
    let known = effects::by_id(id).map(|effect| effect.description());
    let (title, meaning, action) = match known {
        Ok(known) => (known.title, known.meaning, known.action),
        Err(_) if id == "unknown" => (
            "an unknown cause",
            "No effect of the library describes this gap.",
            "Make the next capture. Look at the residuals of the PSFs for rings, sides and directions.",
        ),
        Err(_) => (id, "", ""),
    };
    CauseWords {
        effect: id,
        title,
        meaning,
        action,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_and_the_unknown_cause_have_titles_of_their_own() {
        for effect in effects::ALL {
            let title = cause_words(effect.id()).title;
            assert_eq!(title, effect.description().title);
            assert_ne!(title, cause_words("unknown").title);
        }
        assert_eq!(cause_words("no_such_effect").title, "no_such_effect");
    }
}
