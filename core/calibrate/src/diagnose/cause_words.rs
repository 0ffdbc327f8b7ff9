//! Plain words for causes: title, meaning and action of each effect, and of the unknown cause.

use seidel_optics::effects;

/// Plain words for a cause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CauseWords {
    /// Name in plain words: a noun phrase that starts in lower case.
    pub title: &'static str,
    /// Meaning for the lens or the camera, in one sentence.
    pub meaning: &'static str,
    /// Advice on what to do about it.
    pub action: &'static str,
}

/// Returns the words for the effect `id` or for `unknown`; `None` for other identifiers.
pub fn cause_words(id: &str) -> Option<CauseWords> {
    if id == "unknown" {
        return Some(UNKNOWN);
    }
    let effect = effects::by_id(id).ok()?.description();
    Some(CauseWords {
        title: effect.title,
        meaning: effect.meaning,
        action: effect.action,
    })
}

/// Returns the title of the effect `id`; the identifier itself where no words are known.
pub(super) fn title(id: &str) -> &str {
    cause_words(id).map_or(id, |words| words.title)
}

const UNKNOWN: CauseWords = CauseWords {
    title: "an unknown cause",
    meaning: "No effect of the library describes this gap.",
    action: "Make the next capture. Look at the residuals of the PSFs for rings, sides and directions.",
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_and_the_unknown_cause_have_titles_of_their_own() {
        for effect in effects::ALL {
            assert_eq!(title(effect.id()), effect.description().title);
            assert_ne!(title(effect.id()), title("unknown"));
        }
        assert_eq!(title("no_such_effect"), "no_such_effect");
    }
}
