//! The C ABI: its header is up to date, and every export begins with the panic guard.

use std::path::Path;

use syn::{Expr, Item, ItemFn, Stmt};

use crate::header;
use crate::workspace::{Package, Tree};

/// The package that exports the C ABI.
const PACKAGE: &str = "seidel-plugin";

/// Functions that catch a panic and return a status.
const GUARDS: [&str; 2] = ["guard", "guard_or"];

pub(super) fn check_header(root: &Path, tree: &Tree, problems: &mut Vec<String>) {
    let path = header::PATH;
    match header::generate(root) {
        Ok(text) if text == tree.text(path) => {}
        Ok(_) => problems.push(format!("{path}: is out of date; run `cargo xtask header`")),
        Err(problem) => problems.push(format!("{path}: cannot be generated: {problem}")),
    }
}

/// A panic that leaves an exported function aborts the host, so each calls the guard first.
pub(super) fn check_guards(tree: &Tree, packages: &[Package], problems: &mut Vec<String>) {
    let Some(package) = packages.iter().find(|package| package.name == PACKAGE) else {
        problems.push(format!("Cargo.toml: the package {PACKAGE} is missing"));
        return;
    };
    for file in tree.rust_files(&package.path("src/")) {
        let Ok(syntax) = syn::parse_file(&file.text) else {
            problems.push(format!("{}: is not valid Rust", file.path));
            continue;
        };
        for item in &syntax.items {
            if let Item::Fn(function) = item
                && is_exported(function)
                && !begins_with_guard(function)
            {
                let name = &function.sig.ident;
                problems.push(format!(
                    "{}: {name} does not begin with the guard",
                    file.path
                ));
            }
        }
    }
}

fn is_exported(function: &ItemFn) -> bool {
    let is_no_mangle = |attribute: &syn::Attribute| {
        let inner = attribute.parse_args::<syn::Path>();
        attribute.path().is_ident("no_mangle") || inner.is_ok_and(|path| path.is_ident("no_mangle"))
    };
    function.attrs.iter().any(is_no_mangle)
}

fn begins_with_guard(function: &ItemFn) -> bool {
    let Some(Stmt::Expr(Expr::Call(call), _)) = function.block.stmts.first() else {
        return false;
    };
    let Expr::Path(callee) = &*call.func else {
        return false;
    };
    let name = callee.path.segments.last();
    name.is_some_and(|segment| GUARDS.iter().any(|guard| segment.ident == guard))
}
