//! Mixed pixels at the outline of a foreground whose clean plate is given.

use super::*;

/// A card left of column 32 covers so much of the mixed pixels there.
const MIXED: [f32; 2] = [0.3, 0.7];
const CARD: f32 = 0.9;

#[test]
fn the_outline_of_a_foreground_leaves_no_trace_on_its_clean_plate() {
    let clean = textured();
    let coverage: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| match k % WIDTH {
            column if column < 32 => 1.0,
            32 => MIXED[k / WIDTH % 2],
            _ => 0.0,
        })
        .collect();
    let mix = |(coverage, clean): (&f32, &f32)| coverage * CARD + (1.0 - coverage) * clean;
    let plate: Vec<f32> = coverage.iter().zip(&clean).map(mix).collect();
    // The background is in focus; the depth pass is sampled in the middle of pixels.
    let pass: Vec<f32> = coverage
        .iter()
        .map(|c| if *c > 0.5 { 0.9 } else { 0.5 })
        .collect();
    let by_pixel = scene(&EVEN, VergencePass::PerPixel(&pass));
    let settings = Occlusion {
        background: Some(Background {
            planes: &[&clean],
            vergence: VergencePass::Constant(0.5),
        }),
        ..Occlusion::default()
    };
    let drawn = render(settings, &by_pixel, &[plane(&plate, RED)]).swap_remove(0);
    let at_card = scene(&EVEN, VergencePass::Constant(f64::from(0.9_f32)));
    let blurred = Scatter.render(&at_card, &[plane(&coverage, RED)], &|_| true);
    let blurred = blurred.expect("a sound scene").planes.swap_remove(0);
    let want: Vec<f32> = blurred.iter().zip(&clean).map(mix).collect();
    let apart = largest_difference(&drawn, &want);
    assert!(apart < 0.01, "{apart}");
}
