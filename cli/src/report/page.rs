//! `report.html`: the whole gap report on one self-contained page.

use seidel_core::Diagnosis;

use super::Subject;
use super::advice::advice_section;
use super::headline::headline;
use super::maps::maps;
use super::markup::{data_uri, document, escape};
use super::tables::{causes, pairs, places_and_shape};
use super::tiles::tiles;
use super::words::{percent, title};

/// Returns the report as an HTML page with its styles, drawings and pictures embedded.
pub fn html(d: &Diagnosis, subject: &Subject) -> String {
    let heading = format!("Gap report: {} and {}", subject.lens, subject.observations);
    let body = [
        about(d, subject),
        headline(d),
        advice_section(d),
        maps(d, subject),
        plate_gap(subject),
        tiles(d),
        causes(d),
        places_and_shape(d),
        method_and_pairs(d),
        footer(d),
    ];
    document(&heading, &body.concat())
}

fn about(d: &Diagnosis, subject: &Subject) -> String {
    let facts = [
        "<b>Gap report</b>".to_owned(),
        format!("lens <b>{}</b>", escape(&subject.lens)),
        format!("observations <b>{}</b>", escape(&subject.observations)),
        format!(
            "{} ({})",
            subject.counts(d),
            escape(&subject.channels.join(", "))
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
            escape(title(cause.effect)),
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
         <li>A tile is a PSF in one channel. Probabilities of causes are those given a gap.</li>\n</ul>\n",
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
    use crate::report::samples::{ALL, diagnosis, subject};
    use crate::report::words::{closed, gap};
    use seidel_core::Verdict;
    use seidel_image_io::atomic::{Output, write_atomically};

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

    /// Returns the text of the part of `page` from `start` to the next `end`, with plain spaces.
    fn part(page: &str, start: &str, end: &str) -> String {
        let from = page.find(start).unwrap_or_else(|| panic!("no {start}"));
        let rest = &page[from..];
        let to = rest.find(end).unwrap_or(rest.len());
        rest[..to].replace('\u{a0}', " ")
    }

    fn headline(page: &str) -> String {
        part(page, "<h1>", "</h1>")
    }

    #[test]
    fn the_verdict_is_a_sentence() {
        let title = |d: &Diagnosis| headline(&html(d, &subject()));
        let of = |verdict| title(&diagnosis(verdict));
        assert_eq!(
            of(Verdict::Explained),
            "<h1>Explained in part by vignetting: with the correction, 94 % of the gap closes; 0.47 % remains, mostly in \
             channel B at 1.2 m, the edge of the field, lower right of the axis."
        );
        assert!(
            of(Verdict::Ambiguous)
                .contains("Vignetting or fifth-order aberrations: these observations")
        );
        assert!(of(Verdict::Unexplained).contains("has no known cause"));
        assert!(of(Verdict::NoGap).contains("No effect is missing: the gap of 0.11 % is below"));
        let simple = of(Verdict::ModelTooSimple);
        assert!(simple.contains("too simple: it leaves 6.1 %"), "{simple}");
        assert!(simple.contains("a decentred element"), "{simple}");
        let mut whole = diagnosis(Verdict::Explained);
        whole.residual.clear();
        whole.places_left.clear();
        whole.added.push("decentre");
        let text = title(&whole);
        assert!(
            text.contains("Explained by vignetting and a decentred element:"),
            "{text}"
        );
        assert!(html(&whole, &subject()).contains("with its best partner"));
        let mut none = diagnosis(Verdict::Unexplained);
        none.added.clear();
        assert!(title(&none).contains("a gap of 8.1 % that no known effect closes"));
    }

    #[test]
    fn headline_cards_pictures_and_tables_agree() {
        for verdict in ALL {
            let d = diagnosis(verdict);
            let page = html(&d, &subject());
            let card = part(&page, "Gap, % of the energy", "Next capture");
            let plain = |text: String| text.replace('\u{a0}', " ");
            // Every number of the headline stands in the card of the gap.
            let title = headline(&page);
            let numbers = title.split(' ').zip(title.split(' ').skip(1));
            for (number, _) in numbers.filter(|(_, unit)| unit.starts_with('%')) {
                let stated = format!("{number} %");
                let of_model = plain(crate::report::words::percent(d.model.freedom_closes));
                assert!(
                    card.contains(&stated) || stated == of_model,
                    "{stated}: {card}"
                );
            }
            // The card gives the gaps that the tiles of the maps have in the mean.
            let mean = d.tiles.iter().map(|t| t.before).sum::<f64>() / d.tiles.len() as f64;
            assert!((mean / d.gap.before - 1.0).abs() < 1e-9, "{verdict:?}");
            assert!(card.contains(&plain(gap(d.gap.before))), "{card}");
            let corrected = !d.added.is_empty();
            assert_eq!(card.contains("corrected lens"), corrected, "{verdict:?}");
            assert_eq!(
                card.contains(&plain(format!("Closed: {}", closed(d.gap.closed)))),
                corrected,
                "{card}"
            );
            assert_eq!(
                page.contains("residual, corrected"),
                corrected,
                "{verdict:?}"
            );
            // A remainder is shown where it exceeds the limit of detection, and only there.
            let remains = d.gap.after > d.detection_limit;
            assert_eq!(page.contains("Remaining gap: "), remains, "{verdict:?}");
            assert_eq!(verdict == Verdict::NoGap, d.gap.before <= d.detection_limit);
            // What was added is marked in the table, and nothing else.
            assert_eq!(page.matches("<tr class=\"added\">").count(), d.added.len());
            let advice = page.contains("What it means, and what to do");
            assert_eq!(advice, verdict != Verdict::NoGap);
        }
    }

    #[test]
    fn no_identifier_stands_in_sentences() {
        for verdict in ALL {
            let page = html(&diagnosis(verdict), &subject());
            let start = part(&page, "<h1>", "<section>");
            for id in ["higher_order", "defocus_offset", "pixel_footprint"] {
                assert!(!start.contains(id), "{verdict:?}: {id}");
            }
        }
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
