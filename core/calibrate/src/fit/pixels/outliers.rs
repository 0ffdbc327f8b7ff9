//! Tiles that are not of the lens: garbage, or PSFs of another lens, among many that the model describes.

use crate::measure::{MeasuredTile, Rejection};
use seidel_optics::numeric::median;

/// Share of its energy by which an outlying tile differs at least from the lens, beyond noise, and the same in medians of all
/// tiles.
const MIN_GAP: f64 = 0.3;
const MIN_MEDIANS: f64 = 30.0;
/// Share of the tiles up to which they are outliers. Where there are more, the model fails.
const MAX_SHARE: f64 = 0.1;

/// A tile with the share of its energy by which it differs from the lens beyond noise.
pub(super) struct Scored<'a> {
    pub(super) measured: &'a MeasuredTile,
    pub(super) excess_gap: f64,
}

/// An outlying tile.
pub(super) struct Outlier<'a> {
    pub(super) measured: &'a MeasuredTile,
    excess_gap: f64,
    median: f64,
}

/// Returns the outlying tiles among `tiles`.
pub(super) fn of<'a>(tiles: impl Iterator<Item = Scored<'a>>) -> Vec<Outlier<'a>> {
    let tiles: Vec<Scored> = tiles.collect();
    let mut gaps: Vec<f64> = tiles.iter().map(|tile| tile.excess_gap).collect();
    let median = median(&mut gaps).max(0.0);
    let least = MIN_GAP.max(MIN_MEDIANS * median);
    let strange = tiles.iter().filter(|tile| tile.excess_gap > least);
    let found: Vec<Outlier> = strange
        .map(|tile| Outlier {
            measured: tile.measured,
            excess_gap: tile.excess_gap,
            median,
        })
        .collect();
    if found.len() as f64 > MAX_SHARE * tiles.len() as f64 {
        return Vec::new();
    }
    found
}

impl Outlier<'_> {
    /// Returns the entry of the report; `names` are those of the channels.
    pub(super) fn rejection(self, names: &[String]) -> Rejection {
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        Rejection {
            set: self.measured.set,
            observation: self.measured.observation,
            file: self.measured.file.clone(),
            channel: names[self.measured.channel].clone(),
            reason: format!(
                "differs from the fitted lens by {} of its energy, half of all tiles by less than {}: it hardly counted in the fit, and not in its score",
                percent(self.excess_gap),
                percent(self.median)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{measure, tests::discs};
    use seidel_optics::moments::support::Support;

    #[test]
    fn a_few_tiles_of_another_lens_are_named_and_many_are_not() {
        let places: Vec<[f64; 2]> = (0..30).map(|k| [30.5 * f64::from(k + 1), 300.5]).collect();
        let measured = measure(&[discs(4.0, &places)], Support::AllPixels, &mut Vec::new());
        let named = |strange: usize| -> Vec<String> {
            let scored = measured.iter().enumerate().map(|(k, measured)| Scored {
                measured,
                excess_gap: if k < strange { 0.8 } else { 1e-3 },
            });
            of(scored)
                .into_iter()
                .map(|o| o.rejection(&["Y".to_owned()]).file)
                .collect()
        };
        assert_eq!(named(0), Vec::<String>::new());
        assert_eq!(named(2), ["0", "1"]);
        // The model fails.
        assert_eq!(named(4), Vec::<String>::new());
    }
}
