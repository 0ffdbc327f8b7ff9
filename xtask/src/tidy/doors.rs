//! The C ABI: its header is what its sources say, and every export goes through the guard.

use std::path::Path;

use super::Tree;
use crate::header::{HEADER, made};

pub(super) fn header(root: &Path, tree: &Tree, problems: &mut Vec<String>) {
    match made(root) {
        Ok(text) if text == tree.text(HEADER) => {}
        Ok(_) => problems.push(format!(
            "{HEADER}: is out of date; run `cargo xtask header`"
        )),
        Err(why) => problems.push(format!("{HEADER}: cannot be made: {why}")),
    }
}

/// No panic may leave an export: the first thing each does is to call the guard.
pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    for (path, text) in tree.each(|p| p.starts_with("plugin/src/") && p.ends_with(".rs")) {
        for (_, after) in text
            .match_indices("#[unsafe(no_mangle)]")
            .map(|(at, mark)| text[at..].split_at(mark.len()))
        {
            let name = after
                .split("fn ")
                .nth(1)
                .and_then(|rest| rest.split('(').next())
                .unwrap_or("");
            let body = after.split_once("{\n").map_or("", |(_, body)| body);
            let first = (body.lines().map(str::trim)).find(|line| !line.starts_with("//"));
            let guarded = ["guard(", "crate::guard::guard_or("];
            if !first.is_some_and(|line| guarded.iter().any(|call| line.starts_with(call))) {
                problems.push(format!("{path}: {name} does not begin with the guard"));
            }
        }
    }
}
