//! Masks that scale the blur of each pixel.

use seidel_core::{
    Depth, DepthPass, Image, Lens, LensScale, MaskScales, ObjectDistance, Plate, Settings, apply,
    no_progress,
};

const WIDTH: usize = 80;
const HEIGHT: usize = 60;
/// Distance of the wall, metres: far behind the focus of the lens.
const WALL_M: f64 = 6.0;

fn lens() -> Lens {
    Lens::from_json(include_str!("data/lens.json")).expect("a lens profile")
}

/// Bars on a wall, with a bright logo in the middle.
fn plate(depth: Depth, mask: impl Fn(bool) -> f32) -> Plate {
    let pixel = |index: usize| {
        let bar = 0.1 + 0.4 * ((index % WIDTH / 6) % 2) as f32;
        if is_logo(index) { 3.0 } else { bar }
    };
    let samples: Vec<f32> = (0..WIDTH * HEIGHT).flat_map(|k| [pixel(k); 3]).collect();
    let image = Image::from_interleaved(WIDTH, HEIGHT, 3, &samples).expect("an image");
    let mut plate = Plate::new(image).with_depth(depth);
    // A part of the frame of the lens, so that its blur is wide.
    plate.geometry.lens_scale = LensScale::PixelRatio(1.0);
    plate.mask = Some((0..WIDTH * HEIGHT).map(|k| mask(is_logo(k))).collect());
    plate
}

fn is_logo(index: usize) -> bool {
    (30..50).contains(&(index % WIDTH)) && (22..38).contains(&(index / WIDTH))
}

fn wall() -> Depth {
    Depth::Distance(ObjectDistance::metres(WALL_M).expect("a distance"))
}

fn wall_pass() -> Depth {
    Depth::Pass(DepthPass::metres(vec![WALL_M as f32; WIDTH * HEIGHT]))
}

fn render(plate: &Plate, mask_scales: MaskScales) -> Image {
    let mut settings = Settings::default();
    settings.mask_scales = mask_scales;
    apply(&lens(), plate, &settings, &no_progress).expect("a render")
}

/// Root mean square of a difference over the pixels that `counts` names.
fn difference(a: &Image, b: &Image, counts: impl Fn(usize) -> bool) -> f64 {
    let pixels: Vec<usize> = (0..WIDTH * HEIGHT).filter(|k| counts(*k)).collect();
    let square = |k: &usize| f64::from(a.colours[1][*k] - b.colours[1][*k]).powi(2);
    (pixels.iter().map(square).sum::<f64>() / pixels.len() as f64).sqrt()
}

#[test]
fn a_mask_of_ones_changes_no_bit() {
    let masked = plate(wall_pass(), |_| 1.0);
    let blurred = render(&masked, MaskScales::Blur);
    assert_eq!(blurred, render(&masked, MaskScales::Mix));
}

#[test]
fn a_logo_is_sharp_without_its_own_halo() {
    let masked = plate(wall(), |is_logo| f32::from(u8::from(!is_logo)));
    let (mixed, scaled) = (
        render(&masked, MaskScales::Mix),
        render(&masked, MaskScales::Blur),
    );
    let around = |k: usize| !is_logo(k) && is_logo_within(k, 4);
    let halo = |image: &Image| {
        let light = (0..WIDTH * HEIGHT).filter(|k| around(*k));
        light.map(|k| f64::from(image.colours[1][k])).sum::<f64>()
            / (0..WIDTH * HEIGHT).filter(|k| around(*k)).count() as f64
    };
    // The wall has 0.3 on average; the logo, ten times brighter, spreads into it where only the mix is masked.
    assert!(halo(&mixed) > 0.6, "{}", halo(&mixed));
    assert!(halo(&scaled) < 0.45, "{}", halo(&scaled));
    let inside = |k: usize| is_logo(k) && !is_logo_edge(k);
    assert!(difference(&scaled, &masked.image, inside) < 0.05);
    let far = |k: usize| !is_logo_within(k, 12);
    assert!(
        difference(&scaled, &mixed, far) < 0.01,
        "{}",
        difference(&scaled, &mixed, far)
    );
}

fn is_logo_within(index: usize, reach: i64) -> bool {
    let (x, y) = ((index % WIDTH) as i64, (index / WIDTH) as i64);
    (30 - reach..50 + reach).contains(&x) && (22 - reach..38 + reach).contains(&y)
}

fn is_logo_edge(index: usize) -> bool {
    let (x, y) = (index % WIDTH, index / WIDTH);
    !((32..48).contains(&x) && (24..36).contains(&y))
}

#[test]
fn half_a_mask_is_half_the_distance_from_focus() {
    let half = plate(wall_pass(), |_| 0.5);
    let mut settings = Settings::default();
    settings.focus.back = 0.5;
    let expected = apply(
        &lens(),
        &plate(wall_pass(), |_| 1.0),
        &settings,
        &no_progress,
    );
    let scaled = render(&half, MaskScales::Blur);
    assert!(difference(&scaled, &expected.expect("a render"), |_| true) < 1e-4);
}
