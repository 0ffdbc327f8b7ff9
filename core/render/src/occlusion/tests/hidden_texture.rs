//! The texture behind a thin foreground.

use super::*;

/// Columns of a card, before squares of 3 px that are in focus.
const CARD: std::ops::Range<usize> = 28..36;

/// Returns the root mean square difference over the columns of the card.
fn rms_behind_card(a: &[f32], b: &[f32]) -> f64 {
    let pixels = (0..WIDTH * HEIGHT).filter(|k| CARD.contains(&(k % WIDTH)));
    let squares: Vec<f64> = pixels.map(|k| f64::from(a[k] - b[k]).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn squares_go_on_behind_a_card_and_noise_is_no_worse_than_without() {
    let squares: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| {
            if (k % WIDTH / 3 + k / WIDTH / 3).is_multiple_of(2) {
                0.2
            } else {
                0.8
            }
        })
        .collect();
    let even = vec![0.5; WIDTH * HEIGHT];
    for (clean, most) in [(squares, 0.05), (textured(), 0.13)] {
        let is_card = |k: usize| CARD.contains(&(k % WIDTH));
        let at_card = |light: &[f32], card: f32| -> Vec<f32> {
            (0..WIDTH * HEIGHT)
                .map(|k| if is_card(k) { card } else { light[k] })
                .collect()
        };
        let (plate, pass) = (at_card(&clean, 0.5), at_card(&even, 0.9));
        let by_pixel = scene(&EVEN, VergencePass::PerPixel(&pass));
        let with_clean = Occlusion {
            background: Some(Background {
                planes: &[&clean],
                vergence: VergencePass::Constant(0.5),
            }),
            ..Occlusion::default()
        };
        let [guess, want] = [Occlusion::default(), with_clean]
            .map(|settings| render(settings, &by_pixel, &[plane(&plate, RED)]).swap_remove(0));
        let apart = rms_behind_card(&guess, &want);
        assert!(apart < most, "{apart}");
    }
}
