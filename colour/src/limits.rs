//! Limits on the text of a config, checked before an engine reads it.
//!
//! Engines copy the value of an anchor wherever an alias names it. A few lines of aliases of aliases so take all memory, and
//! values nested in one another take all of the stack.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use yaml_rust2::parser::{Event, Parser};

use crate::{ColourError, Result, Source};

/// Limit of the values of a config, aliases replaced. The largest config that comes with OpenColorIO has 20 000.
const MAX_VALUES: u64 = 1_000_000;

/// Limit of lists and mappings within one another. Configs have about ten.
const MAX_DEPTH: usize = 100;

/// Limit of the text of a config, bytes. The largest config that comes with OpenColorIO has 400 000.
const MAX_BYTES: u64 = 64 << 20;

/// The name of the config in an archive.
const ARCHIVED_CONFIG: &str = "config.ocio";

/// The first bytes of an archive.
const ARCHIVE_MAGIC: &[u8] = b"PK\x03\x04";

/// Checks the text of a config. Text that is no YAML, and files that cannot be read, are left to the engine.
///
/// # Errors
/// A text that is too long, or that has too many or too deeply nested values once aliases are replaced; a pipe or device, for
/// which an engine could wait for ever.
pub(crate) fn check(source: &Source) -> Result<()> {
    if let Source::File(path) = source
        && std::fs::metadata(path).is_ok_and(|m| !(m.is_file() || m.is_dir()))
    {
        return Err(ColourError::new(
            source.to_string(),
            String::new(),
            "is a pipe or a device, not a file".to_owned(),
            "save its content in a file and give that",
        ));
    }
    let text = match source {
        Source::Embedded | Source::BuiltIn(_) => return Ok(()),
        Source::Text { yaml, .. } => Some(yaml.clone().into_bytes()),
        Source::File(path) => read(path),
    };
    let Some(text) = text else {
        return Ok(());
    };
    let refuse = |field: String, problem: String| {
        let remedy = "write out the values, or check that this is the right file";
        Err(ColourError::new(source.to_string(), field, problem, remedy))
    };
    if text.len() as u64 > MAX_BYTES {
        return refuse(
            String::new(),
            format!("the config is longer than {MAX_BYTES} bytes"),
        );
    }
    match find_excess(&String::from_utf8_lossy(&text)) {
        Some(Excess { line, problem }) => refuse(format!("line {line}"), problem),
        None => Ok(()),
    }
}

/// Returns the text of a config file or archive, up to one byte more than allowed; `None` if it cannot be read.
fn read(path: &Path) -> Option<Vec<u8>> {
    let read_all = |from: &mut dyn Read| {
        let mut bytes = Vec::new();
        let read = from.take(MAX_BYTES + 1).read_to_end(&mut bytes);
        read.ok().map(|_| bytes)
    };
    let bytes = read_all(&mut File::open(path).ok()?)?;
    if !bytes.starts_with(ARCHIVE_MAGIC) {
        return Some(bytes);
    }
    let mut archive = zip::ZipArchive::new(File::open(path).ok()?).ok()?;
    read_all(&mut archive.by_name(ARCHIVED_CONFIG).ok()?)
}

/// The place where a config exceeds a limit.
struct Excess {
    /// Counted from 1.
    line: usize,
    problem: String,
}

/// A list or mapping that is not closed yet.
struct Open {
    anchor: usize,
    /// Values in it so far, aliases replaced, and itself.
    values: u64,
}

/// Returns the first place where the `text` exceeds a limit.
fn find_excess(text: &str) -> Option<Excess> {
    let mut parser = Parser::new_from_str(text);
    // Values of each anchor; an anchor that is not closed yet has none.
    let mut anchors: HashMap<usize, u64> = HashMap::new();
    let mut open = vec![Open {
        anchor: 0,
        values: 0,
    }];
    loop {
        // An engine names what is wrong with the text.
        let (event, place) = parser.next_token().ok()?;
        let added = match event {
            Event::StreamEnd => return None,
            Event::SequenceStart(anchor, _) | Event::MappingStart(anchor, _) => {
                open.push(Open { anchor, values: 1 });
                0
            }
            Event::SequenceEnd | Event::MappingEnd => {
                let closed = open.pop()?;
                anchors.insert(closed.anchor, closed.values);
                closed.values
            }
            Event::Scalar(_, _, anchor, _) => {
                anchors.insert(anchor, 1);
                1
            }
            Event::Alias(anchor) => anchors.get(&anchor).copied().unwrap_or(1),
            _ => 0,
        };
        let within = open.last_mut()?;
        within.values = within.values.saturating_add(added);
        let problem = if within.values > MAX_VALUES {
            format!("its aliases make the config larger than {MAX_VALUES} values")
        } else if open.len() > MAX_DEPTH {
            format!("has more than {MAX_DEPTH} lists and mappings within one another")
        } else {
            continue;
        };
        return Some(Excess {
            line: place.line(),
            problem,
        });
    }
}
