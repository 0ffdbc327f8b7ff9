//! Measurements as Markdown: a table of all cases and one of the goals.

use crate::cases::{Case, Lens};
use crate::rival::Tuned;

/// The measurements of one case; times are medians, s.
pub(crate) struct Measurement {
    pub(crate) case: Case,
    pub(crate) psnr_db: Option<f64>,
    pub(crate) seconds: f64,
    pub(crate) rival: Option<RivalMeasurement>,
    /// The fast renderer through the skew-normal lens, in the same rounds.
    pub(crate) skew_normal_seconds: Option<f64>,
    pub(crate) exact_seconds: Option<f64>,
    pub(crate) peak_bytes: Option<u64>,
}

pub(crate) struct RivalMeasurement {
    pub(crate) tuned: Tuned,
    pub(crate) seconds: f64,
    /// Part of them spent on kernels.
    pub(crate) kernel_seconds: f64,
}

impl Measurement {
    /// Returns the time per pixel and plane, ns.
    fn cost_ns(&self) -> f64 {
        let (width, height) = self.case.size;
        self.seconds * 1e9 / (3 * width * height) as f64
    }

    fn rival_ratio(&self) -> Option<f64> {
        Some(self.rival.as_ref()?.seconds / self.seconds)
    }

    fn row(&self) -> String {
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        let (width, height) = self.case.size;
        let rival = self.rival.as_ref();
        let cells = [
            format!(
                "{}, {} px",
                self.case.lens.name(),
                self.case.corner_sigma_px
            ),
            format!("{width} x {height}"),
            or_dash(self.psnr_db.map(|db| format!("{db:.1}"))),
            format!("{:.3}", self.seconds),
            format!("{:.1}", self.cost_ns()),
            or_dash(rival.map(|r| {
                let short = if r.tuned.reached { "" } else { ", short" };
                let OverlapAddText { spacing, left_out } = OverlapAddText::of(&r.tuned);
                format!("{spacing} px, {left_out}, {:.1} dB{short}", r.tuned.psnr_db)
            })),
            or_dash(
                rival.map(|r| format!("{:.2} ({:.2})", r.seconds, r.seconds - r.kernel_seconds)),
            ),
            or_dash(self.rival_ratio().map(|ratio| format!("{ratio:.1}"))),
            or_dash(self.exact_seconds.map(|s| format!("{s:.1}"))),
            or_dash(
                self.exact_seconds
                    .map(|s| format!("{:.0}", s / self.seconds)),
            ),
            match (self.case.memory, self.peak_bytes) {
                (false, _) => "-".to_owned(),
                (true, None) => "not measured".to_owned(),
                (true, Some(bytes)) => format!("{:.2} GiB", gib(bytes)),
            },
        ];
        format!("| {} |", cells.join(" | "))
    }
}

struct OverlapAddText {
    spacing: usize,
    left_out: String,
}

impl OverlapAddText {
    fn of(tuned: &Tuned) -> Self {
        Self {
            spacing: tuned.renderer.spacing,
            left_out: format!("{:.0e}", tuned.renderer.left_out),
        }
    }
}

fn gib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 30)
}

/// Returns the table of all measurements.
pub(crate) fn table(measurements: &[Measurement]) -> String {
    let head = [
        "lens, corner sigma",
        "plate",
        "PSNR, dB",
        "fast, s",
        "ns per pixel and plane",
        "overlap-add: spacing, left out, PSNR",
        "overlap-add, s (without kernels)",
        "ratio",
        "exact, s",
        "ratio",
        "peak memory above the images",
    ];
    let mut lines = vec![
        format!("| {} |", head.join(" | ")),
        format!("|{}", " --- |".repeat(head.len())),
    ];
    lines.extend(measurements.iter().map(Measurement::row));
    lines.join("\n")
}

/// Returns the table of goals and results, as far as they were measured.
pub(crate) fn aims(measurements: &[Measurement]) -> String {
    let mut lines = vec![
        "| aim | wanted | found | |".to_owned(),
        "| --- | --- | --- | --- |".to_owned(),
    ];
    let mut aim = |what: String, wanted: String, found: f64, met: bool| {
        let verdict = if met { "met" } else { "not met" };
        lines.push(format!("| {what} | {wanted} | {found:.2} | {verdict} |"));
    };
    let at_least = |found: f64, wanted: f64| (format!("at least {wanted}"), found, found >= wanted);
    let at_most = |found: f64, wanted: f64| (format!("at most {wanted}"), found, found <= wanted);
    let mut add = |what: String, (wanted, found, met)| aim(what, wanted, found, met);
    for measurement in measurements {
        let name = measurement.case.name();
        let large = measurement.case.corner_sigma_px > 6.0;
        if let Some(ratio) = measurement.rival_ratio() {
            let wanted = if large { 15.0 } else { 12.0 };
            add(
                format!("{name}: overlap-add / fast"),
                at_least(ratio, wanted),
            );
        }
        if let (Some(db), Lens::SkewNormal) = (measurement.psnr_db, measurement.case.lens) {
            let wanted = if large { 60.0 } else { 75.0 };
            add(format!("{name}: PSNR, dB"), at_least(db, wanted));
        }
        if let Some(seconds) = measurement.skew_normal_seconds {
            add(
                format!("{name}: pupil / skew-normal"),
                at_most(measurement.seconds / seconds, 1.5),
            );
        }
        if let Some(bytes) = measurement.peak_bytes {
            add(
                format!("{name}: memory above the images, GiB"),
                at_most(gib(bytes), 3.0),
            );
        }
    }
    let moments: Vec<&Measurement> = measurements
        .iter()
        .filter(|f| f.case.lens == Lens::SkewNormal)
        .collect();
    for (index, one) in moments.iter().enumerate() {
        for other in &moments[index + 1..] {
            let ratio = other.cost_ns() / one.cost_ns();
            let what = format!("{} / {}: cost a pixel", other.case.name(), one.case.name());
            if one.case.size == other.case.size {
                add(what, at_most(ratio, 2.0));
            } else if one.case.corner_sigma_px == other.case.corner_sigma_px {
                add(what, at_most(ratio.max(1.0 / ratio), 1.15));
            }
        }
    }
    lines.join("\n")
}
