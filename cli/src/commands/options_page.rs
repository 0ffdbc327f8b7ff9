//! The page of all options in the guide, made from the options themselves.

use std::path::Path;

use clap::Arg;
use seidel_image_io::json::{TEXT_LIMIT_BYTES, read_text};

use super::{command, write_text};

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/guide/options.md");

const INTRODUCTION: &str = "# Options

Every option of every command, as `seidel COMMAND --help` prints them. [Knobs](knobs.md) has the settings of the blur by their names in
nodes, Python and C.

This page is written by `UPDATE_EXPECT=1 cargo test -p seidel --lib options_page` from the options of the program.
";

/// Adds the table of `command` and those of its subcommands to `page`.
fn add_tables(command: &clap::Command, before: &str, page: &mut String) {
    let name = format!("{before}{}", command.get_name());
    let is_shown =
        |arg: &&Arg| !arg.is_hide_set() && !["help", "version"].contains(&arg.get_id().as_str());
    let args: Vec<&Arg> = command.get_arguments().filter(is_shown).collect();
    if !args.is_empty() {
        let about = command.get_about().map(ToString::to_string);
        page.push_str(&format!(
            "\n## {name}\n\n{}.\n\n",
            about.unwrap_or_default()
        ));
        page.push_str("| option | values | default | meaning |\n| --- | --- | --- | --- |\n");
        args.into_iter().for_each(|arg| page.push_str(&row(arg)));
    }
    for subcommand in command.get_subcommands() {
        add_tables(subcommand, &format!("{name} "), page);
    }
}

fn row(arg: &Arg) -> String {
    let long = arg.get_long().map(|name| format!("`--{name}`"));
    let aliases = arg.get_visible_aliases().unwrap_or_default().into_iter();
    let names = (long.into_iter())
        .chain(aliases.map(|name| format!("`--{name}`")))
        .chain(arg.get_short().map(|name| format!("`-{name}`")));
    let mut names: Vec<String> = names.collect();
    if names.is_empty() {
        names.push(arg.get_id().to_string());
    }
    let words = arg.get_possible_values();
    let values = if !arg.get_action().takes_values() {
        String::new()
    } else if words.is_empty() {
        let names = arg.get_value_names().unwrap_or_default();
        let names: Vec<&str> = names.iter().map(|name| name.as_str()).collect();
        names.join(" ")
    } else {
        let words: Vec<String> =
            (words.iter().map(|word| format!("`{}`", word.get_name()))).collect();
        words.join(", ")
    };
    let defaults = arg.get_default_values().iter();
    let defaults: Vec<String> = defaults.map(|v| v.to_string_lossy().into_owned()).collect();
    let help = arg.get_long_help().or(arg.get_help());
    let help = help.map(ToString::to_string).unwrap_or_default();
    let help = help
        .split("\n\n")
        .map(str::trim)
        .collect::<Vec<_>>()
        .join(". ");
    let cells = [names.join(", "), values, defaults.join(", "), help];
    let cells = cells.map(|cell| {
        let cell = cell.split_whitespace().collect::<Vec<_>>().join(" ");
        cell.replace('|', "\\|").replace('<', "&lt;")
    });
    format!("| {} |\n", cells.join(" | "))
}

#[test]
fn the_page_of_options_is_up_to_date() {
    let mut page = INTRODUCTION.to_owned();
    add_tables(&command(), "", &mut page);
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        write_text(Path::new(PATH), &page).expect("written");
    }
    let found = read_text(Path::new(PATH), TEXT_LIMIT_BYTES).unwrap_or_default();
    let remedy = "run `UPDATE_EXPECT=1 cargo test -p seidel --lib options_page`";
    assert!(
        found == page,
        "docs/guide/options.md is out of date; {remedy}"
    );
}
