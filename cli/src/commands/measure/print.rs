//! `seidel measure print`: charts to print or to show on a screen.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use seidel_image_io::FileError;
use seidel_image_io::atomic::{Output, check_target, write_atomically};
use seidel_image_io::formats::png::write_rgb8;
use seidel_measure::capture_plan::CapturedLens;
use seidel_measure::printed::{self, Medium, PageCoverage, Sheet, Viewing};
use serde_json::json;

use super::by_option;
use crate::Console;
use crate::commands::CommandError;
use crate::pictures::printed::{PrintFormat, pdf, picture, svg};

/// Options of `seidel measure print`.
#[derive(Debug, Args)]
pub struct PrintArgs {
    /// Chart to draw
    #[arg(value_enum)]
    kind: Kind,
    /// File to write: .pdf or .svg to print, .png for a screen and for `measure chart --chart`; may be repeated
    #[arg(short, long, required = true, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Paper: A0 to A5, Letter, Legal, Tabloid, or WxH in millimetres; landscape
    #[arg(long, value_name = "A3|WxH", default_value = "A3", value_parser = parse_paper, conflicts_with = "screen")]
    paper: [f64; 2],
    /// Pixels of a screen that shows the chart full size, instead of paper
    #[arg(long, value_name = "WxH", value_parser = parse_screen)]
    screen: Option<[u32; 2]>,
    /// Width of the screen's picture in millimetres
    #[arg(long, value_name = "MM", default_value_t = 600.0)]
    screen_width_mm: f64,
    /// Distance from the lens to the chart in metres
    #[arg(
        long = "distance",
        alias = "distance-m",
        value_name = "METRES",
        default_value_t = 2.0
    )]
    distance_m: f64,
    /// Focal length in millimetres
    #[arg(
        long = "focal-length-mm",
        alias = "focal-mm",
        value_name = "MM",
        default_value_t = 50.0
    )]
    focal_mm: f64,
    /// Pixel pitch of the sensor in micrometres
    #[arg(long, value_name = "P", default_value_t = 4.0)]
    pitch_um: f64,
    /// Width and height of the sensor in millimetres
    #[arg(long, value_name = "WxH", default_value = "36x24", value_parser = parse_sensor)]
    sensor_mm: [f64; 2],
    /// Diameter of the expected blur in pixels of the photograph
    #[arg(long, value_name = "D", default_value_t = 8.0, conflicts_with_all = ["f_number", "focus_m"])]
    blur_px: f64,
    /// f-number of the shot, from which the blur follows instead
    #[arg(long, value_name = "N", requires = "focus_m")]
    f_number: Option<f64>,
    /// Focus distance of the shot in metres, or `inf`, from which the blur follows instead
    #[arg(
        long = "focus-distance",
        alias = "focus-m",
        value_name = "METRES",
        requires = "f_number"
    )]
    focus_m: Option<f64>,
    /// Seed of the random pattern: the same seed and options give the same chart
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Print the choices as JSON
    #[arg(long)]
    json: bool,
}

/// A kind of chart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Black and white cells at random, for `measure chart`
    Noise,
    /// Slanted squares, for `measure edges`
    Edges,
    /// White dots on black, for `measure lights`
    Lights,
    /// A slanted checkerboard, for `measure edges`
    Board,
}

/// Least blur of a lens in focus, px.
const LEAST_BLUR_PX: f64 = 2.0;

/// Blank margin of paper, mm: most printers cannot print there.
pub(super) const MARGIN_MM: f64 = 8.0;

/// Papers by name: width and height, landscape, mm.
const PAPERS: [(&str, [f64; 2]); 9] = [
    ("A0", [1189.0, 841.0]),
    ("A1", [841.0, 594.0]),
    ("A2", [594.0, 420.0]),
    ("A3", [420.0, 297.0]),
    ("A4", [297.0, 210.0]),
    ("A5", [210.0, 148.0]),
    ("LETTER", [279.4, 215.9]),
    ("LEGAL", [355.6, 215.9]),
    ("TABLOID", [431.8, 279.4]),
];

pub(super) fn parse_paper(text: &str) -> Result<[f64; 2], String> {
    let upper = text.to_ascii_uppercase();
    if let Some((_, size)) = PAPERS.iter().find(|(name, _)| *name == upper) {
        return Ok(*size);
    }
    let size = two(text, |v: &f64| (30.0..=5000.0).contains(v));
    size.ok_or_else(|| "give A0 to A5, Letter, Legal, Tabloid, or WxH in millimetres".to_owned())
}

pub(super) fn parse_sensor(text: &str) -> Result<[f64; 2], String> {
    let size = two(text, |v: &f64| *v > 0.0 && v.is_finite());
    size.ok_or_else(|| "give width and height in millimetres, such as 36x24".to_owned())
}

fn parse_screen(text: &str) -> Result<[u32; 2], String> {
    let size = two(text, |v: &u32| (64..=16_384).contains(v));
    size.ok_or_else(|| "give the screen's pixels, such as 3840x2160".to_owned())
}

fn two<T: std::str::FromStr>(text: &str, is_valid: impl Fn(&T) -> bool) -> Option<[T; 2]> {
    let (width, height) = text.split_once(['x', 'X'])?;
    let width = width.trim().parse().ok().filter(&is_valid)?;
    let height = height.trim().parse().ok().filter(&is_valid)?;
    Some([width, height])
}

pub(super) fn run(args: &PrintArgs, console: &mut Console) -> Result<(), CommandError> {
    let mut formats = Vec::new();
    for path in &args.output {
        let format = PrintFormat::of(path).ok_or_else(|| {
            CommandError::Usage(format!(
                "-o {}: give a name that ends in .pdf, .svg or .png",
                path.display()
            ))
        })?;
        check_target(path)?;
        formats.push(format);
    }
    let sheet = args.sheet()?;
    for (path, format) in args.output.iter().zip(formats) {
        write(path, format, &sheet)?;
    }
    if args.json {
        let report = json!({
            "files": args.output,
            "caption": sheet.caption,
            "choices": sheet.choices,
            "warnings": sheet.warnings,
        });
        console.print(format!("{report:#}"));
    } else {
        for choice in &sheet.choices {
            console.print(choice);
        }
        for path in &args.output {
            console.print(format!("wrote {}", path.display()));
        }
        console.print(args.advice());
    }
    for warning in &sheet.warnings {
        console.note(warning);
    }
    Ok(())
}

fn write(path: &Path, format: PrintFormat, sheet: &Sheet) -> Result<(), FileError> {
    let bytes = match format {
        PrintFormat::Png => return write_rgb8(path, &picture(sheet)),
        PrintFormat::Pdf => pdf(sheet),
        PrintFormat::Svg => svg(sheet).into_bytes(),
    };
    write_atomically(path, |out: &mut Output<'_>| out.write_all(&bytes))
}

impl PrintArgs {
    fn sheet(&self) -> Result<Sheet, CommandError> {
        let medium = self.medium()?;
        let viewing = Viewing {
            distance_m: self.distance_m,
            focal_mm: self.focal_mm,
            pitch_um: self.pitch_um,
            blur_px: self.blur_px()?,
        };
        let sheet = match self.kind {
            Kind::Noise => printed::noise(medium, &viewing, self.seed),
            Kind::Edges => printed::edges(medium, &viewing),
            Kind::Lights => printed::lights(medium, &viewing, self.seed),
            Kind::Board => printed::board(medium, &viewing),
        };
        let mut sheet = sheet.map_err(by_option)?;
        let coverage = PageCoverage::of(&medium, &viewing, self.sensor_mm);
        let blur_px = viewing.blur_px;
        sheet
            .choices
            .push(format!("for a blur of {blur_px:.1} px in diameter"));
        sheet
            .choices
            .push(coverage.describe(&self.distance_m.to_string()));
        Ok(sheet)
    }

    /// Returns the expected blur: that of a thin lens, or as stated.
    fn blur_px(&self) -> Result<f64, CommandError> {
        let (Some(f_number), Some(focus_m)) = (self.f_number, self.focus_m) else {
            return Ok(self.blur_px);
        };
        let lens = CapturedLens {
            focal_mm: self.focal_mm,
            f_number,
            focus_m,
            pitch_um: self.pitch_um,
            sensor_mm: self.sensor_mm,
            near_m: Some(self.distance_m),
            far_m: self.distance_m,
            count: 1,
        };
        let plan = lens.plan().map_err(by_option)?;
        Ok(lens
            .blur_px(1.0 / self.distance_m)
            .max(plan.airy_px)
            .max(LEAST_BLUR_PX))
    }

    fn medium(&self) -> Result<Medium, CommandError> {
        let Some([columns, rows]) = self.screen else {
            let [width_mm, height_mm] = self.paper;
            return Ok(Medium {
                width_mm,
                height_mm,
                margin_mm: MARGIN_MM,
                pixel_mm: None,
            });
        };
        if !(self.screen_width_mm.is_finite() && self.screen_width_mm > 0.0) {
            return Err(CommandError::Usage(
                "--screen-width-mm must be positive".to_owned(),
            ));
        }
        let pixel_mm = self.screen_width_mm / f64::from(columns);
        Ok(Medium {
            width_mm: self.screen_width_mm,
            height_mm: pixel_mm * f64::from(rows),
            margin_mm: 0.0,
            pixel_mm: Some(pixel_mm),
        })
    }

    /// Returns the next step.
    fn advice(&self) -> &'static str {
        match (self.kind, self.screen.is_some()) {
            (Kind::Noise, false) => {
                "print at 100 % without scaling, and keep a PNG of the same options and seed for `measure chart --chart`"
            }
            (Kind::Noise, true) => {
                "show the PNG pixel for pixel, full screen, and give the same file to `measure chart --chart`"
            }
            (Kind::Lights, _) => "photograph in a dark room, and measure with `measure lights`",
            (Kind::Edges | Kind::Board, _) => {
                "fix it flat and lit evenly, and measure with `measure edges`"
            }
        }
    }
}
