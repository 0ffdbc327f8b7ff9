//! The walk over the syntax of a Rust file.

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};

use super::text::Described;
use super::words::Words;
use super::{Finding, Rule, names, signatures, text};

/// Looks for breaches in a Rust file.
pub(super) fn check(source: &str, words: &Words, found: &mut Vec<Finding>) {
    text::check_comments(source, words, found);
    let (Ok(tokens), Ok(syntax)) = (source.parse::<TokenStream>(), syn::parse_file(source)) else {
        return;
    };
    check_strings(tokens, words, found);
    let mut walk = Walk { words, found };
    walk.check_docs(&syntax.attrs, Described::Other);
    walk.visit_file(&syntax);
}

/// Looks for phrases in string literals, those in macro calls included. Doc comments are strings of attributes here and
/// left out, because they are checked with the comments.
fn check_strings(tokens: TokenStream, words: &Words, found: &mut Vec<Finding>) {
    let mut after_doc = 0;
    for token in tokens {
        match token {
            TokenTree::Group(group) => check_strings(group.stream(), words, found),
            TokenTree::Ident(name) if name == "doc" => after_doc = 2,
            TokenTree::Literal(literal) if after_doc == 0 => {
                if let Ok(string) = syn::parse_str::<syn::LitStr>(&literal.to_string()) {
                    let line = literal.span().start().line;
                    let prose = text::without_placeholders(&string.value());
                    text::check_phrases(&prose, line, words, found);
                }
            }
            _ => after_doc = usize::saturating_sub(after_doc, 1),
        }
    }
}

impl Described {
    fn value(of: &syn::Type) -> Self {
        let syn::Type::Path(path) = of else {
            return Self::Other;
        };
        match path.path.segments.last().map(|last| &last.arguments) {
            _ if path.path.is_ident("bool") => Self::Bool,
            // The items of `Vec<bool>` and the like.
            Some(syn::PathArguments::AngleBracketed(list)) => match list.args.first() {
                Some(syn::GenericArgument::Type(item)) => Self::value(item),
                _ => Self::Other,
            },
            _ => Self::Other,
        }
    }

    fn result(of: &syn::Signature) -> Self {
        match &of.output {
            syn::ReturnType::Type(_, returned) => Self::value(returned),
            syn::ReturnType::Default => Self::Other,
        }
    }

    fn item(item: &syn::Item) -> Self {
        match item {
            syn::Item::Const(item) => Self::value(&item.ty),
            syn::Item::Fn(item) => Self::result(&item.sig),
            syn::Item::Static(item) => Self::value(&item.ty),
            _ => Self::Other,
        }
    }
}

struct Walk<'a> {
    words: &'a Words,
    found: &'a mut Vec<Finding>,
}

impl Walk<'_> {
    fn check_docs(&mut self, attributes: &[syn::Attribute], described: Described) {
        let docs = attributes
            .iter()
            .filter(|attribute| attribute.path().is_ident("doc"));
        let mut line = 0;
        let mut doc = String::new();
        for attribute in docs {
            if let syn::Meta::NameValue(meta) = &attribute.meta
                && let syn::Expr::Lit(literal) = &meta.value
                && let syn::Lit::Str(string) = &literal.lit
            {
                if doc.is_empty() {
                    line = attribute.span().start().line;
                }
                doc.push_str(&string.value());
            }
        }
        if let Some(opening) = text::bad_opening(&doc, described) {
            self.found.push(Finding {
                rule: Rule::Opening,
                line,
                message: format!("opens with `{opening}`; open with a noun phrase or a verb"),
            });
        }
    }

    fn check_name(&mut self, name: &syn::Ident) {
        if !names::check_whole(name, self.words, self.found) {
            names::check_parts(name, self.words, self.found);
        }
    }
}

fn is_public(visibility: &syn::Visibility) -> bool {
    !matches!(visibility, syn::Visibility::Inherited)
}

impl<'ast> Visit<'ast> for Walk<'_> {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if let Some((attributes, name)) = names::attributes_and_name(item) {
            self.check_docs(attributes, Described::item(item));
            self.check_name(name);
        }
        visit::visit_item(self, item);
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        let call = signatures::Call {
            signature: &function.sig,
            is_public: is_public(&function.vis),
        };
        signatures::check(call, self.found);
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.check_docs(&function.attrs, Described::result(&function.sig));
        self.check_name(&function.sig.ident);
        let call = signatures::Call {
            signature: &function.sig,
            is_public: is_public(&function.vis),
        };
        signatures::check(call, self.found);
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        self.check_docs(&function.attrs, Described::result(&function.sig));
        self.check_name(&function.sig.ident);
        let call = signatures::Call {
            signature: &function.sig,
            is_public: true,
        };
        signatures::check(call, self.found);
        visit::visit_trait_item_fn(self, function);
    }

    fn visit_field(&mut self, field: &'ast syn::Field) {
        self.check_docs(&field.attrs, Described::value(&field.ty));
        if let Some(name) = &field.ident {
            self.check_name(name);
        }
        visit::visit_field(self, field);
    }

    fn visit_variant(&mut self, variant: &'ast syn::Variant) {
        self.check_docs(&variant.attrs, Described::Other);
        self.check_name(&variant.ident);
        visit::visit_variant(self, variant);
    }

    fn visit_pat_ident(&mut self, pattern: &'ast syn::PatIdent) {
        names::check_parts(&pattern.ident, self.words, self.found);
        visit::visit_pat_ident(self, pattern);
    }

    fn visit_expr_match(&mut self, expression: &'ast syn::ExprMatch) {
        let is_bool = |arm: &syn::Arm| matches!(&arm.pat, syn::Pat::Lit(literal) if matches!(literal.lit, syn::Lit::Bool(_)));
        if expression.arms.iter().any(is_bool) {
            self.found.push(Finding {
                rule: Rule::Match,
                line: expression.span().start().line,
                message: "a match on a bool; write an if".to_owned(),
            });
        }
        visit::visit_expr_match(self, expression);
    }
}
