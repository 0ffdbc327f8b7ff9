//! The options and commands behind the terms of messages that come from the libraries.

/// Terms of the libraries, each with what a user of the command gives or runs for it.
const TERMS: [(&str, &str); 21] = [
    ("reduced model", "--model reduced"),
    ("extended model", "--model extended"),
    ("as a fit writes it", "seidel fit"),
    ("JSON schema of lens profiles", "seidel lens schema"),
    ("another lens of the library", "seidel lens list"),
    ("picture that was printed", "--chart"),
    ("turn only chroma off", "--only-chroma"),
    ("four corners", "--at"),
    ("larger sheet", "--paper"),
    ("one value for all colours", "--noise"),
    ("whole plate one distance", "--distance"),
    ("path of the config", "--ocio"),
    ("as the working space", "--working-space"),
    ("give the focus distance", "--focus-distance"),
    ("value a frame", "--animate"),
    ("channel that holds depth", "--depth FILE:CHANNEL"),
    ("depth kind", "--depth-kind"),
    ("depth unit", "--depth-unit"),
    ("near and far distances", "--near, --far"),
    ("distances are along the ray", "--along-ray"),
    ("encoding of the pictures", "--encoding"),
];

/// Returns `message` with the option or command behind each of its [`TERMS`].
pub(crate) fn with_options(message: &str) -> String {
    let missing = TERMS.iter().filter(|(_, option)| !message.contains(option));
    missing.fold(message.to_owned(), |message, (term, option)| {
        message.replacen(term, &format!("{term} ({option})"), 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_term_gets_its_option_once() {
        let message = "lens controls: need rays; fit the lens with the reduced model";
        let shown = with_options(message);
        assert_eq!(shown, format!("{message} (--model reduced)"));
        assert_eq!(with_options(&shown), shown);
    }
}
