//! Signatures of functions that other modules call: tuples and bare `bool`s.

use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};
use syn::{FnArg, ImplItemFn, ItemFn, Signature, TraitItemFn, Type, TypeTuple, Visibility};

use super::Finding;

/// Smallest size of a tuple that should be a struct.
const LARGE_TUPLE: usize = 3;

/// Beginnings of names that say what a `bool` argument means: the new value of a property, or a condition to check.
const NAMES_OF_BOOLS: [&str; 3] = ["with_", "set_", "expect"];

/// Looks for breaches in the signatures of a Rust file.
pub(super) fn check(text: &str, found: &mut Vec<Finding>) {
    if let Ok(syntax) = syn::parse_file(text) {
        Functions { found }.visit_file(&syntax);
    }
}

struct Functions<'a> {
    found: &'a mut Vec<Finding>,
}

impl Functions<'_> {
    fn check(&mut self, signature: &Signature) {
        // Those of C are given by their standard.
        if signature.abi.is_some() {
            return;
        }
        let name = signature.ident.to_string();
        if !NAMES_OF_BOOLS.iter().any(|start| name.starts_with(start)) {
            for input in signature.inputs.iter().filter(is_bool) {
                self.found.push(Finding {
                    line: input.span().start().line,
                    message: format!("{name}: a bare bool; write an enum"),
                });
            }
        }
        LargeTuples { found: self.found }.visit_signature(signature);
    }
}

fn is_bool(input: &&FnArg) -> bool {
    let FnArg::Typed(typed) = input else {
        return false;
    };
    matches!(&*typed.ty, Type::Path(path) if path.path.is_ident("bool"))
}

impl<'ast> Visit<'ast> for Functions<'_> {
    fn visit_item_fn(&mut self, function: &'ast ItemFn) {
        if !matches!(function.vis, Visibility::Inherited) {
            self.check(&function.sig);
        }
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast ImplItemFn) {
        if !matches!(function.vis, Visibility::Inherited) {
            self.check(&function.sig);
        }
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_trait_item_fn(&mut self, function: &'ast TraitItemFn) {
        self.check(&function.sig);
        visit::visit_trait_item_fn(self, function);
    }
}

struct LargeTuples<'a> {
    found: &'a mut Vec<Finding>,
}

impl<'ast> Visit<'ast> for LargeTuples<'_> {
    fn visit_type_tuple(&mut self, tuple: &'ast TypeTuple) {
        if tuple.elems.len() >= LARGE_TUPLE {
            self.found.push(Finding {
                line: tuple.span().start().line,
                message: "a tuple of three or more in a signature; write a struct".to_owned(),
            });
        }
        visit::visit_type_tuple(self, tuple);
    }
}
