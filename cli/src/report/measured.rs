//! The page of a measurement: what was kept and left out over the photograph, noise, the lens, and what to shoot next.

use image::RgbImage;
use seidel_core::{LensProfile, ObjectDistance};
use seidel_measure::{LeftOut, Photograph, Reason};

use super::markup::{bar, data_uri, document, escape, with_code};

/// A place that was kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index of the photograph.
    pub photograph: usize,
    /// Frame position, px.
    pub at: [f64; 2],
}

/// The kind of a page of edges.
pub const EDGES: &str = "edges";

/// The content of the page.
#[derive(Debug)]
pub struct MeasuredPage<'a> {
    /// Name of the places: "lights", "blocks" or [`EDGES`].
    pub kind: &'static str,
    /// The photographs.
    pub photographs: &'a [Photograph],
    /// Distances of all that the lens was fitted to, earlier photographs included.
    pub distances: Vec<ObjectDistance>,
    /// Places that were kept.
    pub kept: Vec<Place>,
    /// Places that were left out.
    pub left_out: &'a [LeftOut],
    /// The picture of all places.
    pub sheet: &'a RgbImage,
    /// Figures of noise and registration, a phrase each.
    pub noise: Vec<String>,
    /// The fitted lens.
    pub lens: Option<&'a LensProfile>,
    /// Limits of the result.
    pub warnings: &'a [String],
}

/// Columns and rows of the zones that should all hold a place.
const ZONES: [usize; 2] = [3, 3];
const ZONE_NAMES: [&str; 9] = [
    "top left",
    "top",
    "top right",
    "left",
    "centre",
    "right",
    "bottom left",
    "bottom",
    "bottom right",
];
/// Places that a lens needs at every distance, and that bring its errors down to those of the model.
const LEAST_PLACES: usize = 24;
const GOOD_PLACES: usize = 54;
/// Share of places left out for one reason from which on the reason is worth advice.
const NOTABLE_SHARE: f64 = 0.1;

/// Returns the page, with its picture and styles embedded.
pub fn measured_page(page: &MeasuredPage<'_>) -> String {
    let names: Vec<&str> = page.photographs.iter().map(|p| p.name.as_str()).collect();
    let title = format!("Measured {}: {}", page.kind, names.join(", "));
    let body = [
        page.about(),
        page.headline(),
        page.cards(),
        page.picture(),
        page.reasons(),
        page.remarks(),
        format!(
            "<footer>Written by seidel {}. The numbers are in manifest.json and left_out.json.</footer>\n",
            env!("CARGO_PKG_VERSION")
        ),
    ];
    document(&title, &body.concat())
}

impl MeasuredPage<'_> {
    fn about(&self) -> String {
        let mut facts = vec![format!("<b>Measured {}</b>", escape(self.kind))];
        for photo in self.photographs {
            let mosaic = photo
                .mosaic
                .map_or("no mosaic".to_owned(), |m| m.to_string());
            facts.push(format!(
                "<b>{}</b> {} × {} px, {}, {}",
                escape(&photo.name),
                photo.width,
                photo.height,
                escape(&mosaic),
                escape(&photo.distance.to_string())
            ));
        }
        let spans: String = facts.iter().map(|f| format!("<span>{f}</span>")).collect();
        format!("<div class=\"subject\">{spans}</div>\n")
    }

    fn headline(&self) -> String {
        let (kept, all) = (self.kept.len(), self.kept.len() + self.left_out.len());
        let adequacy = self
            .lens
            .and_then(|l| l.held_out.as_ref()?.adequacy.as_ref());
        let of_lens = match (self.lens, adequacy) {
            (_, Some(adequacy)) => sentence(&adequacy.to_string()),
            (Some(_), None) => "A lens was fitted.".to_owned(),
            (None, None) => "No lens was fitted.".to_owned(),
        };
        format!(
            "<h1>{kept} of {all} {} measured. {}</h1>\n",
            escape(self.kind),
            escape(&of_lens)
        )
    }

    fn cards(&self) -> String {
        let noise: String = self
            .noise
            .iter()
            .map(|n| format!("<p>{}</p>", escape(n)))
            .collect();
        let next: String = (self.next().iter())
            .map(|n| format!("<p class=\"next\">{}</p>", with_code(n)))
            .collect();
        format!(
            "<div class=\"cards\"><div class=\"card\"><h3>The lens</h3>{}</div>\
             <div class=\"card\"><h3>Noise and registration</h3>{noise}</div>\
             <div class=\"card\"><h3>What to shoot next</h3>{next}</div></div>\n",
            self.lens_card()
        )
    }

    fn lens_card(&self) -> String {
        let Some(lens) = self.lens else {
            return "<p>Not fitted. Add <code>--fit LENS</code>.</p>".to_owned();
        };
        let axis = lens.frame.axis();
        let mut card = format!(
            "<p>Optical axis ({:.1}, {:.1}) px.</p>",
            axis.x_px, axis.y_px
        );
        if let Some(held_out) = &lens.held_out {
            card += &format!(
                "<p>Forward-blur signal-to-noise ratio on {} held-out tiles:</p>",
                held_out.tiles
            );
            for group in &held_out.groups {
                let label = format!(
                    "{} at {}",
                    escape(&group.channel),
                    escape(&group.distance.to_string())
                );
                // 50 dB fills the bar.
                card += &bar(
                    &label,
                    &format!("{:.1} dB", group.snr_db),
                    group.snr_db / 50.0,
                    "",
                );
            }
        }
        card
    }

    fn picture(&self) -> String {
        let mark = if self.kind == EDGES {
            "a green line, and a bar of two standard deviations of the blur to each side of it"
        } else {
            "a green ellipse, three standard deviations of their blur wide"
        };
        format!(
            "<section><h2>Where it was measured</h2>\n<figure><figcaption>Kept {} have {mark}. Those left out have a frame \
             in the colour of the reason above the picture.</figcaption><img style=\"width:100%\" src=\"{}\" alt=\"measured places over the photograph\">\
             </figure></section>\n",
            escape(self.kind),
            data_uri(self.sheet)
        )
    }

    fn count(&self, why: Reason) -> usize {
        self.left_out.iter().filter(|l| l.why == why).count()
    }

    fn reasons(&self) -> String {
        let rows: String = (Reason::ALL.into_iter())
            .filter(|why| self.count(*why) > 0)
            .map(|why| {
                let of_reason = || self.left_out.iter().filter(move |l| l.why == why);
                let limit = of_reason().next().map_or(0.0, |l| l.limit);
                let mut values: Vec<f64> = of_reason().map(|l| l.value).collect();
                values.sort_by(f64::total_cmp);
                format!(
                    "<tr><td><span class=\"name\">{why}</span></td><td class=\"n\">{}</td><td>{}</td>\
                     <td class=\"n\">{:.3}</td><td class=\"n\">{limit:.3}</td></tr>\n",
                    values.len(),
                    why.quantity(),
                    values[values.len() / 2]
                )
            })
            .collect();
        if rows.is_empty() {
            return "<section><h2>Left out</h2>\n<p>Nothing.</p></section>\n".to_owned();
        }
        format!(
            "<section><h2>Left out</h2>\n<table><tr><th>Reason</th><th class=\"n\">Number</th><th>Quantity</th>\
             <th class=\"n\">Median</th><th class=\"n\">Limit</th></tr>\n{rows}</table></section>\n"
        )
    }

    fn remarks(&self) -> String {
        if self.warnings.is_empty() {
            return String::new();
        }
        let items: String = self
            .warnings
            .iter()
            .map(|w| format!("<li>{}</li>\n", escape(w)))
            .collect();
        format!("<section><h2>Remarks</h2>\n<ul>\n{items}</ul></section>\n")
    }

    /// Returns what would improve the lens most, one sentence for each.
    fn next(&self) -> Vec<String> {
        let mut next = Vec::new();
        let empty = self.empty_zones();
        if !empty.is_empty() {
            next.push(format!(
                "Nothing was measured at the {} of the frame: fill it, or add a photograph with `--also`.",
                empty.join(", ")
            ));
        }
        let all = (self.kept.len() + self.left_out.len()).max(1) as f64;
        let notable = |why| self.count(why) as f64 >= NOTABLE_SHARE * all;
        for (why, advice) in [
            (Reason::Clipped, "Many places clip: expose less."),
            (
                Reason::Faint,
                "Many lights are faint: expose longer, or use brighter ones.",
            ),
            (
                Reason::Double,
                if self.kind == EDGES {
                    "Many edges have another one close beside them: print larger squares, farther apart."
                } else {
                    "Many lights overlap: put them farther apart."
                },
            ),
            (
                Reason::Moved,
                "Lights moved between photographs: use a tripod and a self-timer.",
            ),
            (
                Reason::LowContrast,
                "Places have little contrast, or little fine detail, as beside corner marks: light the chart evenly, avoid reflections, and fill the frame with it.",
            ),
        ] {
            if notable(why) {
                next.push(advice.to_owned());
            }
        }
        let mut distances: Vec<ObjectDistance> = Vec::new();
        for distance in &self.distances {
            if !distances.contains(distance) {
                distances.push(*distance);
            }
        }
        if distances.len() < 3 {
            next.push(format!(
                "{} distance{} so far: the change of the blur with depth needs three or more, even in 1 / distance. `seidel measure plan` lists them.",
                distances.len(),
                if distances.len() == 1 { "" } else { "s" }
            ));
        }
        let places = self.kept.len() / distances.len().max(1);
        if places < LEAST_PLACES {
            next.push(format!("{places} places a distance are few: {LEAST_PLACES} or more are needed, {GOOD_PLACES} are good."));
        }
        if next.is_empty() {
            next.push("Nothing is missing: apply the lens.".to_owned());
        }
        next
    }

    /// Returns the names of the zones of the frame without any place.
    fn empty_zones(&self) -> Vec<&'static str> {
        let first = &self.photographs[0];
        let zone = |at: f64, length: usize, count: usize| {
            ((at / length as f64 * count as f64) as usize).min(count - 1)
        };
        let filled: Vec<usize> = (self.kept.iter())
            .map(|place| {
                let column = zone(place.at[0], first.width, ZONES[0]);
                zone(place.at[1], first.height, ZONES[1]) * ZONES[0] + column
            })
            .collect();
        let names = ZONE_NAMES.into_iter().enumerate();
        names
            .filter(|(k, _)| !filled.contains(k))
            .map(|(_, name)| name)
            .collect()
    }
}

/// Returns `text` with a capital letter and a full stop.
fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(char::to_uppercase);
    let rest = letters.as_str().trim_end_matches('.');
    first.map_or(String::new(), |f| {
        format!("{}{rest}.", f.collect::<String>())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use seidel_core::ObjectDistance;
    use seidel_measure::SampleErrors;

    #[test]
    fn the_page_is_self_contained_and_says_what_is_missing() {
        let photo = Photograph {
            name: "a<b>.dng".to_owned(),
            width: 300,
            height: 200,
            planes: vec![vec![0.0; 60_000]],
            channels: vec!["Y".to_owned()],
            mosaic: None,
            white: 1000.0,
            distance: ObjectDistance::Metres(2.0),
            gain: None,
            errors: SampleErrors::default(),
            bad: Vec::new(),
        };
        let places = [
            [20.0, 20.0],
            [150.0, 20.0],
            [280.0, 20.0],
            [20.0, 100.0],
            [150.0, 100.0],
        ];
        let omitted = |why| LeftOut {
            number: None,
            photograph: 0,
            x: 5.0,
            y: 5.0,
            why,
            value: 2.0,
            limit: 1.0,
        };
        let left_out = [omitted(Reason::Clipped), omitted(Reason::Clipped)];
        let page = measured_page(&MeasuredPage {
            kind: "lights",
            distances: vec![photo.distance],
            photographs: &[photo],
            kept: places.map(|at| Place { photograph: 0, at }).to_vec(),
            left_out: &left_out,
            sheet: &RgbImage::new(30, 20),
            noise: vec!["0.5 counts per electron".to_owned()],
            lens: None,
            warnings: &[],
        });
        for part in [
            "5 of 7 lights measured",
            "at the right, bottom left, bottom, bottom right of the frame",
            "Many places clip",
            "1 distance so far",
            "a&lt;b&gt;.dng",
            "data:image/png;base64,",
            "0.5 counts per electron",
        ] {
            assert!(page.contains(part), "{part}");
        }
        for part in ["http:", "https:", "<script", "<link"] {
            assert!(!page.contains(part), "{part}");
        }
    }
}
