//! `report.html`: the whole gap report on one page that needs nothing else.

use seidel_core::calibrate::diagnose::Diagnosis;

use super::Subject;
use super::headline::headline;
use super::maps::maps;
use super::markup::{document, escape};
use super::tables::{causes, pairs, places_and_shape};
use super::tiles::tiles;
use super::words::percent;

/// The styles of every page.
pub(super) const STYLE: &str = include_str!("page.css");

/// The report as a page: styles, drawings and pictures inside, no scripts and no links.
pub fn html(d: &Diagnosis, subject: &Subject) -> String {
    let title = format!("Gap report: {} and {}", subject.lens, subject.observations);
    let body = [
        about(subject),
        headline(d),
        maps(d, subject),
        tiles(d),
        causes(d),
        places_and_shape(d),
        proof_and_pairs(d),
        footer(d),
    ];
    document(&title, &[STYLE], &body.concat())
}

fn about(subject: &Subject) -> String {
    let count =
        |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
    let facts = [
        "<b>Gap report</b>".to_owned(),
        format!("lens <b>{}</b>", escape(&subject.lens)),
        format!("observations <b>{}</b>", escape(&subject.observations)),
        format!(
            "{} in {} at {}",
            count(subject.count, "PSF", "PSFs"),
            escape(&subject.channels.join(", ")),
            count(subject.distances, "distance", "distances")
        ),
        format!(
            "frame {} × {} px",
            subject.frame.width_px(),
            subject.frame.height_px()
        ),
    ];
    let spans: String = facts.iter().map(|f| format!("<span>{f}</span>")).collect();
    format!("<div class=\"subject\">{spans}</div>\n")
}

/// How the numbers were made, and pairs beside it where there are any.
fn proof_and_pairs(d: &Diagnosis) -> String {
    let pairs = pairs(d);
    let proof = proof(d);
    if pairs.is_empty() {
        return format!("<section>{proof}</section>\n");
    }
    format!(
        "<section><div class=\"columns\"><div>{proof}</div><div>{pairs}</div></div></section>\n"
    )
}

fn proof(d: &Diagnosis) -> String {
    let best_other = d
        .causes
        .iter()
        .filter(|c| c.effect != "unknown" && !d.added.contains(&c.effect))
        .map(|c| (c.gap_closed, c.effect))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let other = match best_other {
        Some((closed, id)) if !d.added.is_empty() => format!(
            "<li>The best cause that was not added, {}, closes {}.</li>\n",
            escape(&super::words::effect_name(id)),
            percent(closed)
        ),
        _ => String::new(),
    };
    format!(
        "<h2>How this is proved</h2>\n<ul>\n\
         <li>Every gap here is of PSFs that took no part. The field is cut into zones; for each zone the effects \
         are fitted to the PSFs of all others and scored on its own, all channels and distances of it \
         together.</li>\n\
         <li>The gap of a PSF is the squared difference between observed and predicted light, both of unit sum, \
         over the squared observed light. What noise alone gives is taken off.</li>\n\
         <li>A free-form model of the residual, held out in the same way, closes {}: what any cause can \
         explain, at least.</li>\n{other}\
         <li>Intervals hold their number with 95&nbsp;%.</li>\n</ul>\n",
        percent(d.gap.explainable)
    )
}

fn footer(d: &Diagnosis) -> String {
    let remarks: String = d
        .remarks
        .iter()
        .map(|r| format!("<li>{}</li>\n", escape(r)))
        .collect();
    let remarks = if remarks.is_empty() {
        String::new()
    } else {
        format!("<section><h2>Remarks</h2>\n<ul>\n{remarks}</ul></section>\n")
    };
    format!(
        "{remarks}<footer>Made by seidel {}. The same numbers stand in report.json; corrected.json is the lens \
         with what was added.</footer>\n",
        env!("CARGO_PKG_VERSION")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::made::{diagnosis, subject};
    use seidel_core::calibrate::diagnose::Verdict;
    use seidel_image_io::atomic::{Output, write_whole};

    const ALL: [Verdict; 4] = [
        Verdict::NoGap,
        Verdict::Explained,
        Verdict::Ambiguous,
        Verdict::Unexplained,
    ];

    /// Also writes the pages to the folder that `SEIDEL_PAGES` names, for a person to look at.
    #[test]
    fn pages_need_nothing_else_and_hold_every_part() {
        for verdict in ALL {
            let page = html(&diagnosis(verdict), &subject());
            for part in [
                "http:",
                "https:",
                "<script",
                "src=\"/",
                "@import",
                "<link",
                "NaN\u{a0}",
                " NaN",
            ] {
                assert!(!page.contains(part), "{part}");
            }
            for part in [
                "Where the gap lies",
                "What the PSFs look like",
                "Every cause that was tried",
                "Two causes together",
                "How this is proved",
                "Remarks",
                "data:image/png;base64,",
                "1.043 ± 0.012",
            ] {
                assert!(page.contains(part), "{part}");
            }
            assert_eq!(
                page.matches("<section>").count(),
                page.matches("</section>").count()
            );
            assert_eq!(page.matches("<div").count(), page.matches("</div>").count());
            if let Some(folder) = std::env::var_os("SEIDEL_PAGES") {
                let path = std::path::Path::new(&folder).join(format!("{}.html", verdict.id()));
                let write = |out: &mut Output<'_>| std::io::Write::write_all(out, page.as_bytes());
                write_whole(&path, write).expect("the folder is writable");
            }
        }
    }

    #[test]
    fn the_answer_is_a_sentence() {
        let said = |verdict| html(&diagnosis(verdict), &subject());
        let percent = "94\u{a0}% (92–96\u{a0}%) of the gap";
        assert!(said(Verdict::Explained).contains(&format!(
            "<h1>The lens lacks vignetting: adding it closes {percent}.</h1>"
        )));
        assert!(said(Verdict::Ambiguous).contains("vignetting or higher order; these"));
        assert!(said(Verdict::Unexplained).contains("no known cause"));
        assert!(said(Verdict::NoGap).contains("nothing is missing.</h1>"));
        let mut two = diagnosis(Verdict::Explained);
        two.added.push("decentre");
        assert!(
            html(&two, &subject()).contains("lacks vignetting and decentre: adding both closes")
        );
        assert!(html(&two, &subject()).contains("with its best partner"));
        let mut none = diagnosis(Verdict::Unexplained);
        none.added.clear();
        assert!(html(&none, &subject()).contains("a gap that no known effect closes"));
    }

    #[test]
    fn names_from_files_are_text_and_nothing_more() {
        let mut named = diagnosis(Verdict::Explained);
        named.tiles[0].channel = "<img src=x>".to_owned();
        named.next_capture = "a <b>bold</b> try".to_owned();
        let mut about = subject();
        about.channels[0] = "<img src=x>".to_owned();
        let page = html(&named, &about);
        assert!(!page.contains("<img src=x>") && !page.contains("<b>bold"));
        assert!(
            page.contains("fifty &lt;mm&gt; &amp; co.json") && page.contains("set-&quot;b&quot;")
        );
        assert!(page.contains("&lt;saturated&gt;"));
    }

    #[test]
    fn bare_diagnoses_have_a_page_too() {
        let mut bare = diagnosis(Verdict::NoGap);
        bare.causes.clear();
        bare.pairs.clear();
        bare.places.clear();
        bare.tiles.clear();
        bare.examples.clear();
        bare.remarks.clear();
        bare.residual.clear();
        bare.next_capture.clear();
        bare.shape.orders.clear();
        let page = html(&bare, &subject());
        assert!(page.contains("Nothing more is needed") && !page.contains("NaN\u{a0}"));
    }
}
