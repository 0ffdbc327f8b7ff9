//! Lists that must name every file of their folder.

use super::Tree;

pub(super) fn check(tree: &Tree, problems: &mut Vec<String>) {
    modules_listed(tree, "cli/src/commands", problems);
    models_listed(tree, problems);
    effects_listed(tree, problems);
    tests_listed(tree, problems);
    checks_listed(tree, problems);
}

/// Every command file is a module.
fn modules_listed(tree: &Tree, folder: &str, problems: &mut Vec<String>) {
    let list = tree.text(&format!("{folder}/mod.rs"));
    let prefix = format!("{folder}/");
    for (path, _) in tree.each(|p| p.starts_with(&prefix) && p.ends_with(".rs")) {
        let name = path[prefix.len()..].trim_end_matches(".rs");
        let own = !name.contains('/') && name != "mod";
        if own && !list.contains(&format!("mod {name};")) {
            problems.push(format!("{path}: not a module of {folder}/mod.rs"));
        }
    }
}

/// Every PSF model is in the list of all.
fn models_listed(tree: &Tree, problems: &mut Vec<String>) {
    let list = tree.text("core/src/psf/mod.rs");
    let all = list
        .split_once("static ALL")
        .map_or("", |(_, after)| after.split("];").next().unwrap_or(""));
    for (path, text) in tree.each(|p| p.starts_with("core/src/psf/") && p.ends_with(".rs")) {
        for line in text.lines() {
            let model = ["impl MomentPsf for ", "impl PsfModel for "]
                .iter()
                .find_map(|start| line.strip_prefix(start))
                .and_then(|rest| rest.split([' ', '{']).next());
            if let Some(model) = model
                && !all.contains(&format!("&{model},"))
            {
                problems.push(format!("{path}: the PSF model {model} is not in psf::ALL"));
            }
        }
    }
}

/// Every effect is in the list of all, and has its rows in the page about them.
fn effects_listed(tree: &Tree, problems: &mut Vec<String>) {
    let list = tree.text("core/src/effects/mod.rs");
    let all = list
        .split_once("static ALL")
        .map_or("", |(_, after)| after.split("];").next().unwrap_or(""));
    let page = tree.text("docs/background/effects.md");
    for (path, text) in tree.each(|p| p.starts_with("core/src/effects/") && p.ends_with(".rs")) {
        let starts = text
            .lines()
            .find_map(|line| line.strip_prefix("impl Effect for "));
        let Some(effect) = starts.and_then(|rest| rest.split([' ', '{']).next()) else {
            continue;
        };
        if !all.contains(&format!("&{effect},")) {
            problems.push(format!(
                "{path}: the effect {effect} is not in effects::ALL"
            ));
        }
        let id = path["core/src/effects/".len()..].trim_end_matches(".rs");
        if page.matches(&format!("\n| `{id}` |")).count() != 2 {
            problems.push(format!(
                "{path}: `{id}` lacks a row in docs/background/effects.md"
            ));
        }
    }
}

/// Every file of the tests is a module of the one binary.
fn tests_listed(tree: &Tree, problems: &mut Vec<String>) {
    let list = tree.text("tests/seidel/main.rs");
    for (path, _) in tree.each(|p| p.starts_with("tests/seidel/") && p.ends_with(".rs")) {
        let name = path["tests/seidel/".len()..].trim_end_matches(".rs");
        if name != "main" && !name.contains('/') && !list.contains(&format!("mod {name};")) {
            problems.push(format!("{path}: not a module of tests/seidel/main.rs"));
        }
    }
}

/// Every check of the OpenFX test host is on the list of all.
fn checks_listed(tree: &Tree, problems: &mut Vec<String>) {
    let folder = "tests/host/src/checks/";
    let list = tree.text(&format!("{folder}mod.rs"));
    for (path, text) in tree.each(|p| p.starts_with(folder) && p.ends_with(".rs")) {
        let name = path[folder.len()..].trim_end_matches(".rs");
        if text.contains("static CHECK: Check") && !list.contains(&format!("&{name}::CHECK,")) {
            problems.push(format!("{path}: the check {name} is not in checks::ALL"));
        }
    }
}
