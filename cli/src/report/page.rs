//! `report.html`: the whole gap report on one self-contained page.

use seidel_core::calibrate::diagnose::Diagnosis;

use super::Subject;
use super::headline::headline;
use super::maps::maps;
use super::markup::{data_uri, document, escape};
use super::tables::{causes, pairs, places_and_shape};
use super::tiles::tiles;
use super::words::{effect_name, percent};

/// Returns the report as an HTML page with its styles, drawings and pictures embedded.
pub fn html(d: &Diagnosis, subject: &Subject) -> String {
    let title = format!("Gap report: {} and {}", subject.lens, subject.observations);
    let body = [
        about(subject),
        headline(d),
        maps(d, subject),
        plate_gap(subject),
        tiles(d),
        causes(d),
        places_and_shape(d),
        method_and_pairs(d),
        footer(d),
    ];
    document(&title, &body.concat())
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

/// Returns the maps of the gap in the plate, where it was rendered.
fn plate_gap(subject: &Subject) -> String {
    let Some(picture) = &subject.plate_gap else {
        return String::new();
    };
    format!(
        "<section><h2>Where the plate differs from a rendering</h2>\n\
         <figure><figcaption>The sharp picture through the given lens (left) and the corrected one (right) against the \
         plate, in blocks of {} px: mean squared difference over the variance of the plate in the blocks around. 0 is \
         equal, 1 as different as an even picture. Noise is included. Black frames of a crop are unknown.</figcaption>\
         <img class=\"plate-gap\" src=\"{}\" alt=\"gap of the plate by channel\"></figure></section>\n",
        seidel_core::PLATE_GAP_BLOCK_PX,
        data_uri(picture)
    )
}

/// Returns the method of measurement, with the pairs of causes beside it where any were tried.
fn method_and_pairs(d: &Diagnosis) -> String {
    let (method, pairs) = (method(d), pairs(d));
    if pairs.is_empty() {
        return format!("<section>{method}</section>\n");
    }
    format!(
        "<section><div class=\"columns\"><div>{method}</div><div>{pairs}</div></div></section>\n"
    )
}

fn method(d: &Diagnosis) -> String {
    let best_other = d
        .causes
        .iter()
        .filter(|c| c.effect != "unknown" && !d.added.contains(&c.effect))
        .max_by(|a, b| a.gap_closed.total_cmp(&b.gap_closed));
    let other = match best_other {
        Some(cause) if !d.added.is_empty() => format!(
            "<li>The best effect that was not added, {}, closes {}.</li>\n",
            escape(&effect_name(cause.effect)),
            percent(cause.gap_closed)
        ),
        _ => String::new(),
    };
    format!(
        "<h2>How the gap is measured</h2>\n<ul>\n\
         <li>The gap of a PSF is |o − p|² / |o|², with o the observed and p the predicted light, both of unit \
         sum, less the contribution of noise.</li>\n\
         <li>All gaps are of held-out PSFs. The field is divided into zones; for each zone the effects are \
         fitted to the PSFs of the other zones and scored on this one, with all its channels and \
         distances.</li>\n\
         <li>A free-form model of the residual, held out in the same way, closes {} of the gap: a lower bound of \
         the share that any model could explain.</li>\n{other}\
         <li>Ranges in per cent are 95&nbsp;% confidence intervals.</li>\n</ul>\n",
        percent(d.explainable)
    )
}

fn footer(d: &Diagnosis) -> String {
    let remarks: String = d
        .remarks
        .iter()
        .map(|r| format!("<li>{}</li>\n", escape(r)))
        .collect();
    let remarks = if remarks.is_empty() {
        remarks
    } else {
        format!("<section><h2>Remarks</h2>\n<ul>\n{remarks}</ul></section>\n")
    };
    format!(
        "{remarks}<footer>Written by seidel {}. The numbers are in report.json; corrected.json is the lens with the \
         added effects.</footer>\n",
        env!("CARGO_PKG_VERSION")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::samples::{diagnosis, subject};
    use seidel_core::calibrate::diagnose::Verdict;
    use seidel_image_io::atomic::{Output, write_atomically};

    const ALL: [Verdict; 5] = [
        Verdict::NoGap,
        Verdict::Explained,
        Verdict::Ambiguous,
        Verdict::Unexplained,
        Verdict::ModelTooSimple,
    ];

    /// Also writes the pages to the folder in `SEIDEL_PAGES`, for visual inspection.
    #[test]
    fn pages_are_self_contained_and_complete() {
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
                "Observed and predicted PSFs",
                "Causes tried",
                "Pairs of effects",
                "How the gap is measured",
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
                write_atomically(&path, write).expect("the folder is writable");
            }
        }
    }

    #[test]
    fn the_verdict_is_a_sentence() {
        let page = |verdict| html(&diagnosis(verdict), &subject());
        let percent = "94\u{a0}% (92–96\u{a0}%) of the gap";
        assert!(page(Verdict::Explained).contains(&format!(
            "<h1>The lens lacks vignetting: adding it closes {percent}.</h1>"
        )));
        assert!(page(Verdict::Ambiguous).contains("vignetting or higher order; these"));
        assert!(page(Verdict::Unexplained).contains("no known cause"));
        assert!(page(Verdict::NoGap).contains("no effect is missing.</h1>"));
        let simple = page(Verdict::ModelTooSimple);
        assert!(
            simple.contains("The model of the lens is too simple"),
            "{simple}"
        );
        assert!(simple.contains("decentre"));
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
    fn names_from_files_are_escaped() {
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
    fn a_diagnosis_with_empty_lists_has_a_page() {
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
        assert!(page.contains("Not needed") && !page.contains("NaN\u{a0}"));
    }
}
