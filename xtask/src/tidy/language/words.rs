//! The list of words, `words.txt`.

/// Words and phrases with their replacements.
#[derive(Default)]
pub(super) struct Words {
    /// Whole names.
    pub(super) names: Vec<Entry>,
    /// Parts of names.
    pub(super) parts: Vec<Entry>,
    /// Phrases of text.
    pub(super) phrases: Vec<Entry>,
}

/// A word or phrase of the list.
pub(super) struct Entry {
    /// Its words. A `*` stands for any one word.
    pub(super) words: Vec<String>,
    /// Suggested replacement, empty if there is none.
    pub(super) instead: String,
}

impl Words {
    /// Reads the list.
    pub(super) fn read() -> Self {
        let mut words = Self::default();
        let mut section = &mut Vec::new();
        for line in include_str!("words.txt").lines() {
            match line.trim() {
                "[names]" => section = &mut words.names,
                "[parts]" => section = &mut words.parts,
                "[phrases]" => section = &mut words.phrases,
                line if line.is_empty() || line.starts_with('#') => {}
                line => section.push(Entry::parse(line)),
            }
        }
        words
    }
}

impl Entry {
    fn parse(line: &str) -> Self {
        let (find, instead) = line.split_once(" / ").unwrap_or((line, ""));
        Self {
            words: find.split_whitespace().map(str::to_owned).collect(),
            instead: instead.to_owned(),
        }
    }

    /// A message about the entry.
    pub(super) fn message(&self, found: &str) -> String {
        if self.instead.is_empty() {
            format!("`{found}`")
        } else {
            format!("`{found}`; write for example: {}", self.instead)
        }
    }

    /// Whether the entry matches the beginning of `words`, which are in small letters.
    pub(super) fn matches_start(&self, words: &[&str]) -> bool {
        self.words.len() <= words.len()
            && self
                .words
                .iter()
                .zip(words)
                .all(|(own, word)| own == "*" || own == word)
    }
}
