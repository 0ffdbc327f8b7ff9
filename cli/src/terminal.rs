//! The streams of a command: what files say cannot control the terminal, and failed writes are remembered.

use std::io::{self, ErrorKind, Write};

/// A stream that writes control characters as `\u001b` and the like, and remembers its first error.
///
/// Texts of files reach the terminal through notes, errors and `seidel info`. Escape sequences in them could move the
/// cursor, rename the window or hide what follows. The notation is that of JSON, so that escaped JSON stays valid.
pub(crate) struct TerminalStream<'a> {
    inner: &'a mut dyn Write,
    keeps_tabs: bool,
    error: Option<io::Error>,
}

impl<'a> TerminalStream<'a> {
    /// Returns a stream of results, such as scripts of shells, which may contain tabs.
    pub(crate) fn of_results(inner: &'a mut dyn Write) -> Self {
        Self {
            inner,
            keeps_tabs: true,
            error: None,
        }
    }

    /// Returns a stream of messages. A tab in one comes from a file, and is shown by its number.
    pub(crate) fn of_messages(inner: &'a mut dyn Write) -> Self {
        Self {
            inner,
            keeps_tabs: false,
            error: None,
        }
    }

    /// Flushes the stream. Returns the first error of all writes; a closed pipe (`seidel ... | head`) is none.
    ///
    /// # Errors
    /// A stream that could not be written.
    pub(crate) fn finish(mut self) -> io::Result<()> {
        let flushed = self.inner.flush();
        match self.error.take().map_or(flushed, Err) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            result => result,
        }
    }
}

impl Write for TerminalStream<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(bytes);
        let written = self
            .inner
            .write_all(escaped(&text, self.keeps_tabs).as_bytes());
        if let Err(error) = written {
            let kind = error.kind();
            self.error.get_or_insert(error);
            return Err(kind.into());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Returns `text` with control characters by their numbers, except line breaks and, if `keeps_tabs`, tabs.
fn escaped(text: &str, keeps_tabs: bool) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        if is_control(c) && !(keeps_tabs && c == '\t') {
            escaped.push_str(&format!("\\u{:04x}", u32::from(c)));
        } else {
            escaped.push(c);
        }
    }
    escaped
}

/// Returns whether a terminal acts on `c` instead of showing it: control characters, and those that reverse the direction
/// of writing.
fn is_control(c: char) -> bool {
    (c.is_control() && c != '\n') || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_are_shown_and_text_is_unchanged() {
        assert_eq!(escaped("plain, ß 影\t\n", true), "plain, ß 影\t\n");
        assert_eq!(escaped("na\tme\n", false), "na\\u0009me\n");
        assert_eq!(
            escaped("\u{1b}]0;x\u{7}\r\u{9b}2J\u{7f}\u{202e}", true),
            r"\u001b]0;x\u0007\u000d\u009b2J\u007f\u202e"
        );
        let json = format!("\"{}\"", escaped("\u{9b}\u{7f}", true));
        let value: String = serde_json::from_str(&json).expect("valid JSON");
        assert_eq!(value, "\u{9b}\u{7f}");
    }

    /// A stream that fails with this error.
    struct Failing(ErrorKind);

    impl Write for Failing {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(self.0.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn the_first_error_is_kept_and_a_closed_pipe_is_none() {
        for (kind, expected) in [
            (ErrorKind::StorageFull, Err(ErrorKind::StorageFull)),
            (ErrorKind::BrokenPipe, Ok(())),
        ] {
            let mut failing = Failing(kind);
            let mut stream = TerminalStream::of_results(&mut failing);
            assert!(stream.write_all(b"x").is_err());
            assert_eq!(stream.finish().map_err(|e| e.kind()), expected);
        }
    }
}
