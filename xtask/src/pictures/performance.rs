//! Processor time of `seidel apply` with depth: a pixel over the size of the frame, and a frame over the size of the blur.

use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use plotters::prelude::*;

use super::programs::Programs;

/// Factors by which the demo's plate, 960 x 540, is enlarged along each side.
const FRAMES: [usize; 4] = [1, 2, 4, 8];
/// The frame of full HD among them.
const HD: usize = 2;
/// The demo's plate, pixels.
const PLATE_PIXELS: f64 = 960.0 * 540.0;
/// Values of `--amount` at the lens's largest aperture.
const AMOUNTS: [f64; 6] = [0.15, 0.3, 0.6, 1.2, 2.4, 5.8];
const SIZE_PX: (u32, u32) = (720, 400);
const INK: RGBColor = RGBColor(40, 44, 52);
const LINE: RGBColor = RGBColor(0, 114, 178);

/// A curve and its axes. The x axis is logarithmic, the y axis begins at zero.
struct Curve<'a> {
    file: &'a str,
    title: &'a str,
    x_label: &'a str,
    y_label: &'a str,
    points: &'a [(f64, f64)],
}

/// Measures and draws both curves. Takes some minutes; other programs should rest.
pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    programs.demo()?;
    let plate = |factor: usize| format!("performance-{factor}.exr");
    let mut sizes = Vec::new();
    for factor in FRAMES {
        repeat_pixels(programs, &plate(factor), factor)?;
        let seconds = seconds_of(programs, &format!("{} --f-number 2.8", plate(factor)))?;
        let pixels = PLATE_PIXELS * (factor * factor) as f64;
        sizes.push((pixels / 1e6, seconds / pixels * 1e6));
    }
    let mut radii = Vec::new();
    for amount in AMOUNTS {
        let options = format!("{} --amount {amount}", plate(HD));
        let radius = largest_radius(programs, &options)?;
        radii.push((radius, seconds_of(programs, &options)?));
    }
    println!("{sizes:?}\n{radii:?}");
    let curves = [
        Curve {
            file: "cost-of-frame.svg",
            title: "seidel apply, depth pass, f/2.8",
            x_label: "megapixels of the frame",
            y_label: "CPU microseconds a pixel",
            points: &sizes,
        },
        Curve {
            file: "cost-of-blur.svg",
            title: "seidel apply, depth pass, 1920 x 1080",
            x_label: "largest radius of the blur, px",
            y_label: "CPU seconds",
            points: &radii,
        },
    ];
    for curve in curves {
        let path = programs.work().join(curve.file);
        let svg = svg_of(&curve).map_err(|why| format!("{}: {why}", path.display()))?;
        std::fs::write(&path, svg).map_err(|why| format!("{}: {why}", path.display()))?;
        programs.install_in("figures", &path, curve.file)?;
    }
    Ok(())
}

/// The processor seconds of the program and the system for one frame, files included.
fn seconds_of(programs: &Programs, options: &str) -> Result<f64, String> {
    let before = children_seconds()?;
    programs.seidel(&format!(
        "apply --lens demo/lens.json {options} -o performance-out.exr --progress none"
    ))?;
    Ok(children_seconds()? - before)
}

/// The processor seconds of all finished child processes, from Linux's `/proc`, in steps of 10 ms.
fn children_seconds() -> Result<f64, String> {
    const PATH: &str = "/proc/self/stat";
    /// Clock ticks a second, the same on every Linux (`USER_HZ`).
    const TICKS: f64 = 100.0;
    let stat = std::fs::read_to_string(PATH).map_err(|why| format!("{PATH}: {why}"))?;
    // The name of the program, in brackets, may hold spaces; cutime and cstime are fields 16 and 17 (proc(5)).
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks = after_name.split_whitespace().skip(13).take(2);
    let ticks: Option<f64> = ticks.map(|field| field.parse::<f64>().ok()).sum();
    Ok(ticks.ok_or_else(|| format!("{PATH}: has no times of children"))? / TICKS)
}

/// The largest radius of a circle of confusion, px.
fn largest_radius(programs: &Programs, options: &str) -> Result<f64, String> {
    let file = "performance-coc.exr";
    programs.seidel(&format!(
        "apply --lens demo/lens.json {options} --show coc-px -o {file} --progress none"
    ))?;
    let image = read_first_flat_layer_from_file(programs.work().join(file))
        .map_err(|why| format!("{file}: {why}"))?;
    let diameters = &image.layer_data.channel_data.list[0].sample_data;
    Ok(diameters
        .values_as_f32()
        .fold(0.0, |largest, diameter| diameter.abs().max(largest)) as f64
        / 2.0)
}

/// Writes the demo's plate with each pixel repeated `factor` times along both sides.
fn repeat_pixels(programs: &Programs, file: &str, factor: usize) -> Result<(), String> {
    let plate = programs.work().join("demo").join("plate.exr");
    let mut image = read_first_flat_layer_from_file(&plate)
        .map_err(|why| format!("{}: {why}", plate.display()))?;
    let layer = &mut image.layer_data;
    let (width, height) = (layer.size.width() * factor, layer.size.height() * factor);
    for channel in &mut layer.channel_data.list {
        let samples: Vec<f32> = channel.sample_data.values_as_f32().collect();
        let from =
            |place: usize| place / width / factor * (width / factor) + place % width / factor;
        let repeated = (0..width * height).map(|place| samples[from(place)]);
        channel.sample_data = FlatSamples::F32(repeated.collect());
    }
    layer.size = exr::math::Vec2(width, height);
    image.attributes.display_window.size = layer.size;
    let to = programs.work().join(file);
    exr::prelude::WritableImage::write(&image)
        .to_file(&to)
        .map_err(|why| format!("{}: {why}", to.display()))
}

fn svg_of(curve: &Curve) -> Result<String, Box<dyn std::error::Error>> {
    let mut svg = String::new();
    let (first, last) = (curve.points[0].0, curve.points[curve.points.len() - 1].0);
    let top = curve.points.iter().fold(0.0, |top, point| point.1.max(top));
    let font = |size: u32| ("sans-serif", size).into_font().color(&INK);
    {
        let root = SVGBackend::with_string(&mut svg, SIZE_PX).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(curve.title, font(20))
            .margin(16)
            .x_label_area_size(48)
            .y_label_area_size(64)
            .build_cartesian_2d(
                (first * 0.9..last * 1.1).log_scale().base(2.0),
                0.0..top * 1.1,
            )?;
        chart
            .configure_mesh()
            .x_desc(curve.x_label)
            .y_desc(curve.y_label)
            .axis_desc_style(font(16))
            .label_style(font(14))
            .axis_style(INK)
            .bold_line_style(RGBColor(222, 226, 232))
            .light_line_style(WHITE)
            .draw()?;
        let points = curve.points.iter().copied();
        chart.draw_series(LineSeries::new(points.clone(), LINE.stroke_width(3)))?;
        chart.draw_series(points.map(|point| Circle::new(point, 4, LINE.filled())))?;
        root.present()?;
    }
    Ok(svg)
}
