//! Blurs a test image with a lens profile: `cargo run --release -p seidel-core --example blur_image -- seidel-demo/lens.json`.

use seidel_core::{Depth, Image, Lens, ObjectDistance, Plate, Settings, apply, no_progress};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("give a lens profile, such as seidel-demo/lens.json")?;
    let lens = Lens::from_json(&std::fs::read_to_string(path)?)?;

    // A grid of points of light on black, 480 x 270 pixels.
    let (width, height) = (480, 270);
    let light = |x: usize, y: usize| {
        if x % 48 == 24 && y % 45 == 22 {
            100.0
        } else {
            0.0
        }
    };
    let samples: Vec<f32> = (0..height)
        .flat_map(|y| (0..width).flat_map(move |x| [light(x, y); 3]))
        .collect();
    let image = Image::from_interleaved(width, height, 3, &samples)?;
    let plate = Plate::new(image).with_depth(Depth::Distance(ObjectDistance::metres(3.0)?));
    let blurred = apply(&lens, &plate, &Settings::default(), &no_progress)?;

    for (name, plane) in blurred.names.iter().zip(&blurred.colours) {
        let peak = plane.iter().fold(0.0_f32, |peak, sample| peak.max(*sample));
        let sum: f32 = plane.iter().sum();
        println!("{name}: brightest pixel {peak:.2}, all light {sum:.0}");
    }
    Ok(())
}
