//! Small lights between two depth layers.

use super::*;

/// Returns the layered and the exact render of lights on a dark wall whose vergence goes from 1 to 1.6 across the plate. The exact
/// one blurs each pixel at its own vergence.
fn rendered_lights(lights: &[(usize, usize)]) -> [Vec<f32>; 2] {
    let pass: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| 1.0 + 0.6 * (k % WIDTH) as f32 / WIDTH as f32)
        .collect();
    let mut wall = vec![0.0; WIDTH * HEIGHT];
    for (column, row) in lights {
        wall[row * WIDTH + column] = 1e4;
    }
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let planes = [plane(&wall, GREEN)];
    // Lights are not mirrored at the edges.
    let black = Scene {
        edges: Edges::Black,
        ..scene
    };
    let exact = Scatter.render(&black, &planes, &|_| true);
    let exact = exact.expect("a valid scene").planes.swap_remove(0);
    [
        render(Occlusion::default(), &scene, &planes).swap_remove(0),
        exact,
    ]
}

#[test]
fn small_lights_are_blurred_at_their_own_depth() {
    for column in (4..WIDTH).step_by(9) {
        let [layered, exact] = rendered_lights(&[(column, 20)]);
        let peak = exact.iter().copied().fold(0.0, f32::max);
        let apart = largest_difference(&layered, &exact) / peak;
        assert!(apart < 1e-5, "light in column {column}: {apart}");
    }
}

/// A lamp of 2 x 2 px whose rim has the depth of the wall behind it, as where a depth pass samples the middle of pixels.
#[test]
fn the_rim_of_a_light_is_blurred_at_its_depth() {
    let in_square = |index: usize, first: usize, side: usize| {
        (first..first + side).contains(&(index % WIDTH))
            && (first..first + side).contains(&(index / WIDTH))
    };
    let pass: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| if in_square(k, 21, 2) { 1.1 } else { 0.8 })
        .collect();
    let light: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|k| match (in_square(k, 21, 2), in_square(k, 20, 4)) {
            (true, _) => 900.0,
            (_, true) => 300.0,
            _ => 0.0,
        })
        .collect();
    let planes = [plane(&light, GREEN)];
    let by_pixel = scene(&EVEN, VergencePass::PerPixel(&pass));
    let drawn = render(Occlusion::default(), &by_pixel, &planes).swap_remove(0);
    let at_lamp = scene(&EVEN, VergencePass::Constant(1.1));
    let exact = Scatter.render(&at_lamp, &planes, &|_| true);
    let exact = exact.expect("a valid scene").planes.swap_remove(0);
    let peak = exact.iter().copied().fold(0.0, f32::max);
    let apart = largest_difference(&drawn, &exact) / peak;
    assert!(apart < 1e-3, "{apart}");
}

#[test]
fn brighter_plates_give_results_as_many_times_as_bright() {
    let pass: Vec<f32> = halves(1.1, 0.7);
    let mut plate = textured();
    // Lamps beside the edge in depth, and mixed pixels on it.
    for (index, light) in [(20 * WIDTH + 30, 40.0), (24 * WIDTH + 32, 9.0)] {
        plate[index] = light;
    }
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let settings = Occlusion {
        light_planes: Some(1),
        ..Occlusion::default()
    };
    let own = render(settings, &scene, &[plane(&plate, GREEN)]).swap_remove(0);
    for factor in [0.125, 8.0, 1024.0] {
        let scaled: Vec<f32> = plate.iter().map(|light| factor * light).collect();
        let result = render(settings, &scene, &[plane(&scaled, GREEN)]).swap_remove(0);
        let back: Vec<f32> = result.iter().map(|light| light / factor).collect();
        let apart = largest_difference(&back, &own);
        assert!(apart < 1e-6, "{factor}: {apart}");
    }
}

#[test]
fn neighbouring_lights_share_a_kernel_within_their_cell() {
    let lights: Vec<_> = (0..24).map(|k| (20 + k % 6, 18 + k / 6)).collect();
    let [layered, exact] = rendered_lights(&lights);
    let peak = exact.iter().copied().fold(0.0, f32::max);
    let apart = largest_difference(&layered, &exact) / peak;
    assert!(apart < 2e-3, "{apart}");
}

#[test]
fn a_light_in_focus_is_dimmed_by_the_share_of_the_aperture_that_a_near_edge_hides() {
    // Standard deviation of the near card's blur, px; the light lies in focus.
    let sigma = 4.8;
    let pass = halves(1.1, 0.5);
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    for (column, row) in [(33, 24), (38, 24), (60, 24)] {
        let mut light = vec![0.0; WIDTH * HEIGHT];
        light[row * WIDTH + column] = 1e4;
        let seen = render(Occlusion::default(), &scene, &[plane(&light, RED)]).swap_remove(0);
        let share = seen[row * WIDTH + column] / 1e4;
        // The card's edge lies at 32. An even disc has a radius of two standard deviations.
        let across = ((column as f32 + 0.5 - 32.0) / (2.0 * sigma)).min(1.0);
        let hidden =
            (across.acos() - across * (1.0 - across * across).sqrt()) / std::f32::consts::PI;
        let apart = (share - (1.0 - hidden)).abs();
        assert!(
            apart < 0.03,
            "light in column {column}: {share} for {}",
            1.0 - hidden
        );
    }
}

#[test]
fn a_light_behind_the_edge_of_a_sharp_card_is_blurred() {
    // A dark card in focus right of column 32. The first pixel at its edge shows a light of the background behind it.
    let pass = halves(0.0, 0.5);
    let scene = scene(&EVEN, VergencePass::PerPixel(&pass));
    let mut light = halves(0.3, 0.01);
    let at = 24 * WIDTH + 32;
    light[at] = 50.0;
    let seen = render(Occlusion::default(), &scene, &[plane(&light, RED)]).swap_remove(0);
    assert!(seen[at] < 1.0, "{} of 50 left at the edge", seen[at]);
}
