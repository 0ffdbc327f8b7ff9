//! The fast renderer beside the exact one through a tilted lens, whose blur grows from nothing within a few pixels.

use seidel_core::{
    Depth, Image, Lens, ObjectDistance, Plate, Quality, Settings, apply, no_progress,
};

const WIDTH: usize = 320;
const HEIGHT: usize = 180;

/// A plate of bright squares, whose discs are cut off at white.
fn plate() -> Image {
    let grey = |index: usize| {
        let (x, y) = (index % WIDTH % 13, index / WIDTH % 11);
        if x < 4 && y < 4 { 6.0 } else { 0.02 }
    };
    let samples: Vec<f32> = (0..3 * WIDTH * HEIGHT).map(|at| grey(at / 3)).collect();
    Image::from_interleaved(WIDTH, HEIGHT, 3, &samples).expect("samples of its size")
}

#[test]
fn a_tilted_lens_is_drawn_as_pixel_by_pixel() {
    let lens = Lens::from_json(include_str!("data/lens.json")).expect("a profile");
    let distance = ObjectDistance::metres(2.5).expect("a distance");
    let plate = Plate::new(plate()).with_depth(Depth::Distance(distance));
    let [fast, exact] = [Quality::Final, Quality::Exact].map(|quality| {
        let mut settings = Settings::default();
        settings.quality = quality;
        settings.look.tilt_deg = 8.0;
        apply(&lens, &plate, &settings, &no_progress).expect("a sound plate")
    });
    for (fast, exact) in fast.colours.iter().zip(&exact.colours) {
        let pairs = fast.iter().zip(exact);
        let squares = pairs.map(|(a, b)| f64::from(a.min(1.0) - b.min(1.0)).powi(2));
        let psnr = -10.0 * (squares.sum::<f64>() / fast.len() as f64).log10();
        assert!(psnr > 34.0, "{psnr:.1} dB");
    }
}
