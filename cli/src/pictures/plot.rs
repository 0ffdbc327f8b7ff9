//! Line plots with confidence bands, as SVG.

use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use seidel_core::{Error, Result};

use super::short_number;

/// A point of a line, with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlotPoint {
    /// Position along x.
    pub x: f64,
    /// Value.
    pub y: f64,
    /// Lower end of the interval.
    pub lower: f64,
    /// Upper end of the interval.
    pub upper: f64,
}

/// A named line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points in order of x.
    pub points: Vec<PlotPoint>,
}

/// The x axis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct XAxis {
    /// Label with its unit.
    pub label: String,
    /// Whether the axis is logarithmic, which requires positive values.
    pub logarithmic: bool,
}

const SIZE_PX: (u32, u32) = (1080, 600);
/// Width of the legend at the right, px.
const LEGEND_PX: u32 = 190;
/// Colours distinguishable by colour-blind readers (Okabe and Ito 2008), then darker shades of them.
const COLOURS: [RGBColor; 12] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(70, 70, 70),
    RGBColor(0, 58, 92),
    RGBColor(120, 52, 0),
    RGBColor(0, 84, 62),
    RGBColor(120, 62, 96),
    RGBColor(128, 88, 0),
    RGBColor(150, 150, 150),
];
const INK: RGBColor = RGBColor(40, 44, 52);

/// Returns the plot of `series` as an SVG document: lines over bands of their intervals, with a legend.
///
/// # Errors
/// No point, points that are not finite, and x not positive on a logarithmic axis.
pub fn line_plot_svg(title: &str, x: &XAxis, y_label: &str, series: &[Series]) -> Result<String> {
    let points: Vec<PlotPoint> = series.iter().flat_map(|s| s.points.clone()).collect();
    check(&points, x.logarithmic)?;
    let extent = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(v), b.max(v))
        })
    };
    let (left, right) = extent(&mut points.iter().map(|p| p.x));
    let (bottom, top) = extent(&mut points.iter().flat_map(|p| [p.y, p.lower, p.upper]));
    let margin = 0.06 * (top - bottom).max(1e-3 * top.abs()).max(1e-9);
    let y_range = bottom - margin..top + margin;
    let mut svg = String::new();
    let drawn = if x.logarithmic {
        let x_range = if right > left {
            left..right
        } else {
            left / 2.0..right * 2.0
        };
        // Powers of ten are too far apart to label fewer than three decades.
        let base = if x_range.end / x_range.start > 1e3 {
            10.0
        } else {
            2.0
        };
        draw(
            &mut svg,
            title,
            x_range.log_scale().base(base),
            &x.label,
            y_range,
            y_label,
            series,
        )
    } else {
        let x_range = if right > left {
            left..right
        } else {
            left - 0.5..right + 0.5
        };
        draw(&mut svg, title, x_range, &x.label, y_range, y_label, series)
    };
    drawn.map_err(|problem| Error::new("plot", problem.to_string(), "report this as a fault"))?;
    Ok(svg)
}

fn check(points: &[PlotPoint], logarithmic: bool) -> Result<()> {
    if points.is_empty() {
        return Err(Error::new(
            "plot",
            "has no point",
            "give at least one point",
        ));
    }
    for p in points {
        let finite = [p.x, p.y, p.lower, p.upper].iter().all(|v| v.is_finite());
        if !finite || (logarithmic && p.x <= 0.0) {
            return Err(Error::new(
                "plot",
                format!("cannot show the point {p:?}"),
                "leave it out",
            ));
        }
    }
    Ok(())
}

fn draw<X>(
    svg: &mut String,
    title: &str,
    x_range: X,
    x_label: &str,
    y_range: std::ops::Range<f64>,
    y_label: &str,
    series: &[Series],
) -> std::result::Result<(), Box<dyn std::error::Error>>
where
    X: plotters::coord::ranged1d::AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let font = |size: u32| ("sans-serif", size).into_font().color(&INK);
    let root = SVGBackend::with_string(svg, SIZE_PX).into_drawing_area();
    root.fill(&WHITE)?;
    let (plot, names) = root.split_horizontally(SIZE_PX.0 - LEGEND_PX);
    legend(&names, series)?;
    let mut chart = ChartBuilder::on(&plot)
        .caption(title, font(24))
        .margin(18)
        .x_label_area_size(56)
        .y_label_area_size(72)
        .build_cartesian_2d(x_range, y_range)?;
    chart
        .configure_mesh()
        .x_desc(x_label)
        .y_desc(y_label)
        .axis_desc_style(font(18))
        .label_style(font(15))
        .axis_style(INK)
        .bold_line_style(RGBColor(222, 226, 232))
        .light_line_style(WHITE)
        .x_label_formatter(&|v| short_number(*v))
        .y_label_formatter(&|v| short_number(*v))
        .x_labels(9)
        .y_labels(9)
        .draw()?;
    for (index, line) in series.iter().enumerate() {
        let colour = colour(index);
        let band: Vec<(f64, f64)> = line
            .points
            .iter()
            .map(|p| (p.x, p.upper))
            .chain(line.points.iter().rev().map(|p| (p.x, p.lower)))
            .collect();
        if line.points.len() > 1 {
            chart.draw_series([Polygon::new(band, colour.mix(0.16).filled())])?;
        }
    }
    // All lines are drawn on top of all bands.
    for (index, line) in series.iter().enumerate() {
        let colour = colour(index);
        let style = colour.stroke_width(3);
        chart.draw_series(LineSeries::new(
            line.points.iter().map(|p| (p.x, p.y)),
            style,
        ))?;
        if line.points.len() <= 40 {
            let dots = line
                .points
                .iter()
                .map(|p| Circle::new((p.x, p.y), 4, colour.filled()));
            chart.draw_series(dots)?;
        }
    }
    root.present()?;
    Ok(())
}

/// Draws the legend beside the plot.
fn legend<DB: DrawingBackend>(
    area: &DrawingArea<DB, plotters::coord::Shift>,
    series: &[Series],
) -> std::result::Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
    let font = ("sans-serif", 15).into_font().color(&INK);
    for (row, line) in (0..).zip(series) {
        let y = 70 + 24 * row;
        let style = colour(row as usize).stroke_width(3);
        area.draw(&PathElement::new([(8, y), (34, y)], style))?;
        area.draw(&Text::new(line.name.as_str(), (42, y - 8), font.clone()))?;
    }
    Ok(())
}

fn colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(name: &str, count: u32) -> Series {
        let points = (1..=count)
            .map(|k| {
                let x = f64::from(k);
                PlotPoint {
                    x,
                    y: 20.0 - 8.0 / x,
                    lower: 18.0 - 8.0 / x,
                    upper: 22.0 - 8.0 / x,
                }
            })
            .collect();
        Series {
            name: name.to_owned(),
            points,
        }
    }

    #[test]
    fn plots_contain_all_labels() {
        let all = [
            series("gaussian", 12),
            series("skew-normal", 12),
            series("one point", 1),
        ];
        for logarithmic in [false, true] {
            let x = XAxis {
                label: "tiles".to_owned(),
                logarithmic,
            };
            let svg = line_plot_svg("Figure 13", &x, "SNR (dB)", &all).expect("drawable");
            for text in [
                "Figure 13",
                "SNR (dB)",
                "tiles",
                "gaussian",
                "skew-normal",
                "sans-serif",
            ] {
                assert!(svg.contains(text), "{text}");
            }
            assert!(svg.trim_end().ends_with("</svg>"));
        }
    }

    #[test]
    fn invalid_points_are_rejected() {
        let x = XAxis {
            label: String::new(),
            logarithmic: true,
        };
        assert!(line_plot_svg("", &x, "", &[]).is_err());
        let mut bad = series("bad", 3);
        bad.points[0].x = 0.0;
        assert!(line_plot_svg("", &x, "", &[bad]).is_err());
    }
}
