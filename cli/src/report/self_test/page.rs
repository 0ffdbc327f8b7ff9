//! `self-test.html`: a self-test on one page that needs nothing else.

use super::super::markup::{document, escape};
use super::super::page::STYLE;
use super::super::words::percent_range;
use super::cases::cases;
use super::confusion::confusion;
use super::drawings::drawings;
use super::{Aim, SelfTest};

const OWN_STYLE: &str = include_str!("page.css");

/// The self-test as a page: styles and drawings inside, no scripts and no links.
pub fn html(test: &SelfTest) -> String {
    let scores = test.scores();
    let aims = test.aims();
    let body = [
        about(test),
        headline(test, &aims),
        confusion(&scores.confusion),
        drawings(test, &scores),
        cases(test),
        footer(),
    ];
    let title = format!("Self-test: {} cases, seed {}", test.cases.len(), test.seed);
    document(&title, &[STYLE, OWN_STYLE], &body.concat())
}

fn about(test: &SelfTest) -> String {
    let size = &test.size;
    format!(
        "<div class=\"subject\"><span><b>Self-test of the diagnosis</b></span><span>{} sealed cases</span>\
         <span>seed <b>{}</b></span><span>places a case: {} simulated, {} real, {} held out, each at two \
         distances</span><span>tiles of {} px</span></div>\n",
        test.cases.len(),
        test.seed,
        size.design,
        size.real,
        size.holdout,
        size.tile
    )
}

fn headline(test: &SelfTest, aims: &[Aim]) -> String {
    let met = |wanted: bool| aims.iter().filter(|a| a.met() == Some(wanted)).count();
    let tried = met(true) + met(false);
    let failed = match test.failed() {
        0 => String::new(),
        1 => " One case could not be diagnosed and counts as wrong.".to_owned(),
        n => format!(" {n} cases could not be diagnosed and count as wrong."),
    };
    let rows: String = aims.iter().map(row).collect();
    format!(
        "<h1>{} of {} cases are answered rightly; {} of {tried} aims are met.</h1>\n\
         <p class=\"lead\">Each case is a lens of its own that separates from its design by one effect, two, an \
         unknown cause or nothing. It was diagnosed before the answer was opened.{failed}</p>\n\
         <div class=\"card\"><table class=\"aims\"><thead><tr><th>What</th><th>Found</th><th>95&nbsp;% \
         interval</th><th>Aim</th><th></th></tr></thead><tbody>\n{rows}</tbody></table></div>\n",
        test.right(),
        test.cases.len(),
        met(true)
    )
}

fn row(aim: &Aim) -> String {
    let (class, word) = match (aim.met(), aim.bound) {
        (Some(true), _) => ("met", "met"),
        (Some(false), _) => ("missed", "missed"),
        (None, Some(_)) => ("", "no case"),
        (None, None) => ("", "told only"),
    };
    format!(
        "<tr><td>{}</td><td class=\"name\">{}</td><td>{}</td><td>{}</td><td><span class=\"state {class}\">{word}\
         </span></td></tr>\n",
        escape(aim.name),
        escape(&aim.found()),
        aim.interval().map_or_else(|| "–".to_owned(), percent_range),
        escape(&aim.wanted())
    )
}

fn footer() -> String {
    format!(
        "<section><h2>How this is done</h2>\n<ul>\n\
         <li>Cases are drawn by a program of their own that shares no optics with what is tested.</li>\n\
         <li>A lens is fitted to the simulated set; the real set is held against it. What the diagnosis adds \
         is then judged on other places of the real lens, which nothing has seen: the share truly closed.</li>\n\
         <li>A cause counts as named by itself, or by a class of at most two that the diagnosis says it cannot \
         tell apart. The odds' calibration counts the cause itself only.</li>\n\
         <li>Intervals hold the rate behind so many cases with 95&nbsp;%.</li>\n</ul></section>\n\
         <footer>Made by seidel {}. The same numbers stand in self-test.json.</footer>\n",
        env!("CARGO_PKG_VERSION")
    )
}

#[cfg(test)]
mod tests {
    use super::super::made::self_test;
    use super::*;
    use seidel_image_io::atomic::{Output, write_whole};

    /// Also writes the page to the folder that `SEIDEL_PAGES` names, for a person to look at.
    #[test]
    fn the_page_needs_nothing_else_and_holds_every_part() {
        let page = html(&self_test());
        for part in [
            "http:",
            "https:",
            "<script",
            "@import",
            "<link",
            "NaN",
            "<no light>",
        ] {
            assert!(!page.contains(part), "{part}");
        }
        for part in [
            "<h1>4 of 9 cases are answered rightly; 2 of 8 aims are met.</h1>",
            "1 of 3 (33 %)",
            "at least 90 %",
            "One case could not be diagnosed",
            "withheld effects called unexplained",
            "What was true and what was named",
            "Whether the odds can be believed",
            "Share of the gap closed",
            "Every case, wrong ones first",
        ] {
            assert!(page.contains(part), "{part}");
        }
        for tag in ["section", "div", "svg", "table", "tr", "span"] {
            let opened = page.matches(&format!("<{tag}>")).count()
                + page.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, page.matches(&format!("</{tag}>")).count(), "{tag}");
        }
        if let Some(folder) = std::env::var_os("SEIDEL_PAGES") {
            let path = std::path::Path::new(&folder).join("self-test.html");
            let write = |out: &mut Output<'_>| std::io::Write::write_all(out, page.as_bytes());
            write_whole(&path, write).expect("the folder is writable");
        }
    }

    #[test]
    fn no_cases_have_a_page_too() {
        let mut none = self_test();
        none.cases.clear();
        let page = html(&none);
        assert!(page.contains("0 of 0 aims") && !page.contains("NaN"));
    }
}
