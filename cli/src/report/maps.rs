//! Maps of the gap over the frame: a pair, given and corrected lens, per channel and distance.

use std::fmt::Write as _;

use seidel_core::diagnosis::TileGap;
use seidel_core::{Diagnosis, ObjectDistance};

use super::Subject;
use super::markup::escape;
use super::words::{distance, gap, round_gap};

/// Width of a map in SVG units.
const WIDTH: f64 = 300.0;
/// Largest number of distances drawn; of more, evenly chosen ones are drawn.
const MOST_DISTANCES: usize = 6;
/// Largest number of channels drawn; of more, evenly chosen ones are drawn.
const MOST_CHANNELS: usize = 4;
/// Ratio of the largest gap to the smallest that the colour scale resolves.
const SPAN: f64 = 300.0;
/// Least ratio of the end of the colour scale to the limit of detection: gaps below the limit are never dark.
const TOP_OVER_LIMIT: f64 = 10.0;
/// Largest number of dots with a tooltip each; more would make the page too large.
const MOST_TITLES: usize = 4000;

/// Returns the section with the maps and their colour scale.
pub(super) fn maps(d: &Diagnosis, subject: &Subject) -> String {
    let scale = Scale::of(&d.tiles, d.detection_limit);
    let all_distances = distances(&d.tiles);
    let channels = evenly_chosen(&subject.channels, MOST_CHANNELS);
    let distances = evenly_chosen(&all_distances, MOST_DISTANCES);
    let map = Map {
        subject,
        scale: &scale,
        titles: d.tiles.len() <= MOST_TITLES,
        corrected: !d.added.is_empty(),
    };
    let mut figures = String::new();
    for &at in &distances {
        for channel in &channels {
            let tiles = d.tiles.iter();
            let tiles = tiles.filter(|t| t.channel == *channel && t.distance == at);
            let tiles: Vec<&TileGap> = tiles.collect();
            if !tiles.is_empty() {
                figures += &map.figure(channel, at, &tiles);
            }
        }
    }
    let columns = if channels.len() > 1 {
        channels.len()
    } else {
        distances.len().clamp(1, 3)
    };
    let all_drawn =
        channels.len() == subject.channels.len() && distances.len() == all_distances.len();
    let left_out = if all_drawn {
        String::new()
    } else {
        format!(
            "<p class=\"quiet small\">{} of {} channels and {} of {} distances are drawn.</p>\n",
            channels.len(),
            subject.channels.len(),
            distances.len(),
            all_distances.len()
        )
    };
    format!(
        "<section><h2>Where the gap lies</h2>\n<p class=\"quiet\">Each dot is a PSF at its position in the \
         frame, coloured by its gap on a scale common to all maps. Numbers are means over a map. The cross marks \
         the optical axis.</p>\n{left_out}{}\
         <div class=\"maps\" style=\"grid-template-columns:repeat({columns},1fr)\">\n{figures}</div>\n\
         </section>\n",
        scale.legend()
    )
}

/// Returns the distances of `tiles`, nearest first, then infinity, then unknown.
fn distances(tiles: &[TileGap]) -> Vec<ObjectDistance> {
    let mut all: Vec<ObjectDistance> = Vec::new();
    for tile in tiles {
        if !all.contains(&tile.distance) {
            all.push(tile.distance);
        }
    }
    let rank = |d: &ObjectDistance| match d {
        ObjectDistance::Metres(m) => *m,
        ObjectDistance::Infinity => f64::MAX,
        ObjectDistance::Unknown => f64::INFINITY,
    };
    all.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
    all
}

/// Returns at most `most` items of `all`, evenly chosen and with both ends.
fn evenly_chosen<T: Clone>(all: &[T], most: usize) -> Vec<T> {
    if all.len() <= most {
        return all.to_vec();
    }
    let chosen = (0..most).map(|k| all[k * (all.len() - 1) / (most - 1)].clone());
    chosen.collect()
}

/// The parts that all maps share.
struct Map<'a> {
    subject: &'a Subject,
    scale: &'a Scale,
    /// Whether dots have tooltips with their numbers.
    titles: bool,
    /// Whether effects were added, so that the corrected lens is another one.
    corrected: bool,
}

impl Map<'_> {
    /// Returns the pair of maps of a channel at a distance; only that of the given lens where no effect was added.
    fn figure(&self, channel: &str, at: ObjectDistance, tiles: &[&TileGap]) -> String {
        let map = |of: &dyn Fn(&TileGap) -> f64| {
            let mean = tiles.iter().map(|t| of(t)).sum::<f64>() / tiles.len() as f64;
            (self.svg(tiles, of), gap(mean))
        };
        let (given, given_mean) = map(&|t| t.before);
        let (corrected, corrected_mean) = map(&|t| t.after);
        let of_corrected = if self.corrected {
            format!("<div>{corrected}<span>corrected lens: {corrected_mean}</span></div>")
        } else {
            String::new()
        };
        let class = if self.corrected { "twins" } else { "single" };
        format!(
            "<figure><figcaption><b>{}</b> at {}</figcaption><div class=\"{class}\">\
             <div>{given}<span>given lens: {given_mean}</span></div>{of_corrected}</div></figure>\n",
            escape(channel),
            distance(at)
        )
    }

    /// Returns the frame with a dot per tile.
    fn svg(&self, tiles: &[&TileGap], of: &dyn Fn(&TileGap) -> f64) -> String {
        let frame = &self.subject.frame;
        let unit = WIDTH / f64::from(frame.width_px());
        let height = f64::from(frame.height_px()) * unit;
        let axis = frame.axis();
        let (ax, ay) = (axis.x_px * unit, axis.y_px * unit);
        let mut svg = format!(
            "<svg viewBox=\"0 0 {WIDTH} {height:.1}\" role=\"img\" aria-label=\"gap over the frame\">\
             <rect x=\"1\" y=\"1\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#fbfcfd\" stroke=\"#c9d0d7\" stroke-width=\"1.5\"/>\
             <path d=\"M{:.1} {ay:.1}h12M{ax:.1} {:.1}v12\" stroke=\"#9aa5b0\"/>",
            WIDTH - 2.0,
            height - 2.0,
            ax - 6.0,
            ay - 6.0
        );
        let spacing = (WIDTH * height / tiles.len() as f64).sqrt();
        let radius = (0.3 * spacing).clamp(2.5, 13.0);
        // The largest gaps are drawn last, on top.
        let mut order: Vec<&&TileGap> = tiles.iter().collect();
        order.sort_by(|a, b| of(a).total_cmp(&of(b)));
        for tile in order {
            let (x, y) = (tile.at.x_px * unit, tile.at.y_px * unit);
            let paint = self.scale.paint(of(tile));
            // Writing to a string cannot fail.
            let _ = write!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" {paint}"
            );
            if self.titles {
                let _ = write!(
                    svg,
                    "><title>({:.0}, {:.0}) px: given {}, corrected {}</title></circle>",
                    tile.at.x_px,
                    tile.at.y_px,
                    gap(tile.before),
                    gap(tile.after)
                );
            } else {
                svg += "/>";
            }
        }
        svg + "</svg>"
    }
}

/// A logarithmic colour scale of gaps.
struct Scale {
    least: f64,
    most: f64,
    /// Limit of detection of the mean gap.
    limit: f64,
}

/// Colours from pale to dark, readable on white and in greyscale print.
const STOPS: [[f64; 3]; 5] = [
    [253.0, 240.0, 196.0],
    [250.0, 190.0, 99.0],
    [230.0, 107.0, 64.0],
    [161.0, 36.0, 86.0],
    [51.0, 10.0, 74.0],
];

impl Scale {
    fn of(tiles: &[TileGap], limit: f64) -> Self {
        let most = tiles
            .iter()
            .flat_map(|t| [t.before, t.after])
            .filter(|v| v.is_finite())
            .fold(TOP_OVER_LIMIT * limit, f64::max);
        let most = if most > 0.0 { most } else { 1e-3 };
        Self {
            least: most / SPAN,
            most,
            limit,
        }
    }

    /// Returns the position of a gap on the scale, 0 to 1.
    fn share(&self, value: f64) -> f64 {
        let share = (value / self.least).ln() / (self.most / self.least).ln();
        share.clamp(0.0, 1.0)
    }

    fn colour(share: f64) -> String {
        let along = share * (STOPS.len() - 1) as f64;
        let k = (along as usize).min(STOPS.len() - 2);
        let mix = |c: usize| {
            let value = STOPS[k][c] + (STOPS[k + 1][c] - STOPS[k][c]) * (along - k as f64);
            value.round() as u8
        };
        format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
    }

    /// Returns the attributes of a dot; one whose gap is within the noise is hollow.
    fn paint(&self, value: f64) -> String {
        if value > 0.0 {
            let fill = Self::colour(self.share(value));
            format!("fill=\"{fill}\" stroke=\"#00000030\"")
        } else {
            "fill=\"#fff\" stroke=\"#b3bcc5\"".to_owned()
        }
    }

    /// Returns the scale as a labelled bar.
    fn legend(&self) -> String {
        const LONG: f64 = 320.0;
        const STEPS: u32 = 64;
        let mut svg = format!(
            "<svg width=\"{}\" height=\"34\" font-size=\"12\" fill=\"#5b6570\">",
            LONG + 40.0
        );
        let step = LONG / f64::from(STEPS);
        for k in 0..STEPS {
            let share = (f64::from(k) + 0.5) / f64::from(STEPS);
            let _ = write!(
                svg,
                "<rect x=\"{:.1}\" y=\"0\" width=\"{:.1}\" height=\"12\" fill=\"{}\"/>",
                20.0 + f64::from(k) * step,
                step + 0.5,
                Self::colour(share)
            );
        }
        for tick in self.ticks() {
            let x = 20.0 + LONG * self.share(tick);
            let _ = write!(
                svg,
                "<path d=\"M{x:.1} 12v4\" stroke=\"#5b6570\"/><text x=\"{x:.1}\" y=\"29\" \
                 text-anchor=\"middle\">{}</text>",
                round_gap(tick)
            );
        }
        let limit = 20.0 + LONG * self.share(self.limit);
        let _ = write!(
            svg,
            "<path d=\"M{limit:.1} 0v12\" stroke=\"#1b1f24\" stroke-width=\"2\"/>"
        );
        svg += "</svg>";
        format!(
            "<div class=\"legend\"><span>Gap of a PSF</span>{svg}<span><svg width=\"150\" height=\"16\" \
             font-size=\"12\" fill=\"#5b6570\"><circle cx=\"8\" cy=\"8\" r=\"5.5\" {}/>\
             <text x=\"20\" y=\"12\">within noise</text></svg></span>\
             <span><b>|</b> limit of detection of the mean</span></div>\n",
            self.paint(0.0)
        )
    }

    /// Returns 1 and 3 times powers of ten within the scale.
    fn ticks(&self) -> Vec<f64> {
        let first = self.least.log10().floor() as i32;
        let last = self.most.log10().ceil() as i32;
        (first..=last)
            .flat_map(|power| [1.0, 3.0].map(|m| m * 10_f64.powi(power)))
            .filter(|tick| (self.least..=self.most).contains(tick))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_logarithmic_and_holds_its_ends() {
        let scale = Scale {
            least: 1e-3,
            most: 0.1,
            limit: 0.002,
        };
        assert_eq!(scale.share(1e-9), 0.0);
        assert!((scale.share(0.01) - 0.5).abs() < 1e-12);
        assert_eq!(scale.share(7.0), 1.0);
        assert_eq!(scale.ticks().len(), 5);
        assert_eq!(Scale::colour(1.0), "#330a4a");
        assert_eq!(Scale::of(&[], 0.0).most, 1e-3);
        assert_eq!(Scale::of(&[], 0.005).most, 0.05);
        assert!(scale.legend().contains("limit of detection of the mean"));
    }

    #[test]
    fn long_lists_are_thinned_evenly() {
        assert_eq!(evenly_chosen(&[1, 2, 3], 4), [1, 2, 3]);
        let all: Vec<i32> = (0..31).collect();
        assert_eq!(evenly_chosen(&all, 6), [0, 6, 12, 18, 24, 30]);
    }
}
