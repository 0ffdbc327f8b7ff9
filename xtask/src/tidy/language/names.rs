//! Names: whole ones, and parts between underscores or capitals.

use syn::{Attribute, Ident, Item};

use super::words::Words;
use super::{Finding, Rule};

/// The attributes and the name of an item, if it has a name of its own.
pub(super) fn attributes_and_name(item: &Item) -> Option<(&[Attribute], &Ident)> {
    match item {
        Item::Const(item) => Some((&item.attrs, &item.ident)),
        Item::Enum(item) => Some((&item.attrs, &item.ident)),
        Item::Fn(item) => Some((&item.attrs, &item.sig.ident)),
        Item::Mod(item) => Some((&item.attrs, &item.ident)),
        Item::Static(item) => Some((&item.attrs, &item.ident)),
        Item::Struct(item) => Some((&item.attrs, &item.ident)),
        Item::Trait(item) => Some((&item.attrs, &item.ident)),
        Item::Type(item) => Some((&item.attrs, &item.ident)),
        Item::Union(item) => Some((&item.attrs, &item.ident)),
        _ => None,
    }
}

/// Looks for a whole name; returns whether it is in the list.
pub(super) fn check_whole(name: &Ident, words: &Words, found: &mut Vec<Finding>) -> bool {
    let entry = words.names.iter().find(|entry| name == &entry.words[0]);
    if let Some(entry) = entry {
        found.push(finding(name, entry.message(&name.to_string())));
    }
    entry.is_some()
}

/// Looks for a part of a name.
pub(super) fn check_parts(name: &Ident, words: &Words, found: &mut Vec<Finding>) {
    let parts = parts(&name.to_string());
    let entry = words
        .parts
        .iter()
        .find(|entry| parts.contains(&entry.words[0]));
    if let Some(entry) = entry {
        found.push(finding(name, entry.message(&name.to_string())));
    }
}

fn finding(name: &Ident, message: String) -> Finding {
    Finding {
        rule: Rule::Name,
        line: name.span().start().line,
        message,
    }
}

/// Parts of a name in small letters: `tile_data`, `TileData` and `TILE_DATA` have the same two.
pub(super) fn parts(name: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut previous_is_upper = true;
    for c in name.chars() {
        let starts_part = c == '_' || (c.is_uppercase() && !previous_is_upper);
        if starts_part {
            parts.push(String::new());
        }
        if c != '_'
            && let Some(last) = parts.last_mut()
        {
            last.extend(c.to_lowercase());
        }
        previous_is_upper = c.is_uppercase() || c == '_';
    }
    parts
}
