//! The page of `seidel view`: one HTML file with the PSFs of a lens or a set as an atlas of small pictures, or the zones of
//! a report, and a script that draws them.
//!
//! The PSFs are precomputed, so that the page needs no program and no network.

mod atlas;
mod lens;
mod report;
mod set;

pub use lens::{LensSubject, lens_page};
pub use report::report_page;
pub use set::{SetSubject, set_page};

use serde::Serialize;

use crate::report::escape;

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

/// The texts of a page besides its drawing.
struct PageText {
    /// Heading and title of the page.
    title: String,
    /// Facts below the heading.
    facts: Vec<String>,
    /// Caption of the drawing.
    caption: String,
    /// Sections below the drawing, as HTML.
    sections: String,
    /// The origin of the pictures, in the footer.
    made: String,
}

/// Returns the page with `data` for its script.
fn page(text: &PageText, data: &impl Serialize) -> String {
    let facts = text.facts.iter();
    let facts: String = facts
        .map(|fact| format!("<span>{}</span>", escape(fact)))
        .collect();
    let json = serde_json::to_string(data).expect("numbers and texts have a JSON form");
    // An end tag in a name would end the script element.
    let json = json.replace('<', "\\u003c");
    let made = format!(
        "{} Written by seidel {}.",
        text.made,
        env!("CARGO_PKG_VERSION")
    );
    let parts = [
        ("{title}", escape(&text.title)),
        ("{facts}", facts),
        ("{caption}", escape(&text.caption)),
        ("{sections}", text.sections.clone()),
        ("{made}", escape(&made)),
        ("{data}", json),
        ("{script}", SCRIPT.to_owned()),
        ("{style}", STYLE.to_owned()),
    ];
    fill(TEMPLATE, &parts)
}

/// Returns `template` with each name in braces replaced by its part. Names within parts stay as they are.
fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let mut page = String::new();
    let mut rest = template;
    while let Some(at) = rest.find('{') {
        page.push_str(&rest[..at]);
        rest = &rest[at..];
        match parts.iter().find(|(name, _)| rest.starts_with(name)) {
            Some((name, part)) => {
                page.push_str(part);
                rest = &rest[name.len()..];
            }
            None => {
                page.push('{');
                rest = &rest[1..];
            }
        }
    }
    page + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cannot_leave_their_places() {
        let text = PageText {
            title: "</title><script>{data}".to_owned(),
            facts: vec!["a < b".to_owned()],
            caption: String::new(),
            sections: String::new(),
            made: "By a test.".to_owned(),
        };
        let page = page(&text, &serde_json::json!({ "name": "</script>" }));
        assert_eq!(page.matches("</title>").count(), 1);
        assert_eq!(page.matches("</script>").count(), 2);
        assert!(page.contains("&lt;script&gt;{data}") && page.contains("a &lt; b"));
        assert!(page.contains(r#"{"name":"\u003c/script>"}"#));
    }
}
