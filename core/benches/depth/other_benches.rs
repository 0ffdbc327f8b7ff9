//! Rows of other benches: flat plates, depth against a flat plate, and the node in a host.

use super::aim::{Aim, Wanted};
use std::process::Command;

/// Runs the benches and returns their aims.
pub(crate) fn aims() -> Vec<Aim> {
    let mut aims = Vec::new();
    for (case, least) in [
        ("skew-normal-6-1920x1080", 3.0),
        ("skew-normal-60-1920x1080", 8.0),
    ] {
        let name = format!("{case}: overlap-add / fast");
        let rows = rows("seidel-render", "render", &["--only", case]);
        let found = value(&rows, &name, 3);
        aims.push(Aim::new(
            format!("flat plate, {name}"),
            Wanted::AtLeast(least),
            "",
            found,
        ));
    }
    let name = "depth / flat";
    let only = ["--only", "depth-1920x1080"];
    let found = value(&rows("seidel-render", "render", &only), name, 3);
    aims.push(Aim::new(
        "lens of moments: depth / flat",
        Wanted::AtMost(5.0),
        "",
        found,
    ));
    let rows = rows("seidel-ofx", "interactive", &[]);
    for (name, most) in [
        ("another mix", 5.0),
        ("another mask", 5.0),
        ("another focus", 60.0),
        ("proxy at half size, first render", 25.0),
    ] {
        aims.push(Aim::new(
            format!("node: {name}"),
            Wanted::AtMost(most),
            "%",
            value(&rows, name, 4),
        ));
    }
    aims
}

/// Runs a bench and returns the rows of its tables, cell by cell.
fn rows(package: &str, bench: &str, arguments: &[&str]) -> Vec<Vec<String>> {
    eprintln!("{package}, bench {bench} {}", arguments.join(" "));
    let output = Command::new(env!("CARGO"))
        .args(["bench", "--locked", "-p", package, "--bench", bench, "--"])
        .args(arguments)
        .output();
    let text = output.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    let text = text.unwrap_or_default();
    let rows = text.lines().filter(|line| line.starts_with('|'));
    rows.map(|row| row.split('|').map(|cell| cell.trim().to_owned()).collect())
        .collect()
}

/// Returns the number that begins cell `column` of the row whose first cell is `name`.
fn value(rows: &[Vec<String>], name: &str, column: usize) -> Option<f64> {
    let row = rows
        .iter()
        .find(|row| row.get(1).is_some_and(|cell| cell == name))?;
    row.get(column)?.split_whitespace().next()?.parse().ok()
}
