//! Signatures: tuples, destructured parameters and bare `bool`s.

use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};
use syn::{FnArg, Pat, Signature, Type};

use super::{Finding, Rule};

/// Smallest size of a tuple that should be a struct.
const LARGE_TUPLE: usize = 3;

/// Beginnings of names that say what a `bool` argument means: the new value of a property, or a condition to check.
const NAMES_OF_BOOLS: [&str; 3] = ["with_", "set_", "expect"];

/// A function of any kind.
#[derive(Clone, Copy)]
pub(super) struct Call<'a> {
    pub(super) signature: &'a Signature,
    /// Whether other modules can call it.
    pub(super) is_public: bool,
}

/// Looks for breaches in the signature of a function. Those of C are given by their standard.
pub(super) fn check(call: Call<'_>, found: &mut Vec<Finding>) {
    let Call {
        signature,
        is_public,
    } = call;
    if signature.abi.is_some() {
        return;
    }
    let name = signature.ident.to_string();
    let names_bool = NAMES_OF_BOOLS.iter().any(|start| name.starts_with(start));
    let mut add = |rule, line, message| {
        found.push(Finding {
            rule,
            line,
            message,
        })
    };
    for input in &signature.inputs {
        let FnArg::Typed(parameter) = input else {
            continue;
        };
        let line = parameter.span().start().line;
        if is_tuple_pattern(&parameter.pat) {
            add(
                Rule::Pattern,
                line,
                format!("{name}: a parameter destructures a tuple"),
            );
        }
        if is_public && !names_bool && is_bool(&parameter.ty) {
            add(
                Rule::Bool,
                line,
                format!("{name}: a bare bool; write an enum"),
            );
        }
    }
    if is_public {
        let mut tuples = LargeTuples { lines: Vec::new() };
        tuples.visit_signature(signature);
        for line in tuples.lines {
            add(
                Rule::Tuple,
                line,
                format!("{name}: a tuple of three or more; write a struct"),
            );
        }
    }
}

fn is_tuple_pattern(pattern: &Pat) -> bool {
    match pattern {
        Pat::Tuple(_) => true,
        Pat::Reference(reference) => is_tuple_pattern(&reference.pat),
        _ => false,
    }
}

fn is_bool(of: &Type) -> bool {
    matches!(of, Type::Path(path) if path.path.is_ident("bool"))
}

struct LargeTuples {
    lines: Vec<usize>,
}

impl<'ast> Visit<'ast> for LargeTuples {
    fn visit_type_tuple(&mut self, tuple: &'ast syn::TypeTuple) {
        if tuple.elems.len() >= LARGE_TUPLE {
            self.lines.push(tuple.span().start().line);
        }
        visit::visit_type_tuple(self, tuple);
    }
}
