//! Small lights beside mirrored edges, at one distance and with a depth pass.

use super::*;
use crate::MirroringRenderer;

/// An even plate with a lamp of 3 x 3 px four pixels from the left edge.
fn with_lamp(grey: f32, lamp: f32) -> Vec<f32> {
    let is_lamp =
        |index: usize| (3..6).contains(&(index % WIDTH)) && (20..23).contains(&(index / WIDTH));
    let value = |index| if is_lamp(index) { lamp } else { grey };
    (0..WIDTH * HEIGHT).map(value).collect()
}

/// Returns the grey plate under the lamp's light that stays on the plate.
fn drawn_once(vergence: VergencePass) -> Vec<f32> {
    let black = Scene {
        edges: Edges::Black,
        ..scene(&EVEN, vergence)
    };
    let lamp = with_lamp(0.0, 19.8);
    let rendered = Scatter.render(&black, &[plane(&lamp, RED)], &|_| true);
    let light = rendered.expect("a sound scene").planes.remove(0);
    light.iter().map(|light| 0.2 + light).collect()
}

#[test]
fn lamps_beside_an_edge_are_drawn_once() {
    let samples = with_lamp(0.2, 20.0);
    let planes = [plane(&samples, RED)];
    // Out of focus by 1.25 / m: a standard deviation of 10 px.
    let pass = vec![1.75_f32; WIDTH * HEIGHT];
    let (constant, by_pixel) = (VergencePass::Constant(1.75), VergencePass::PerPixel(&pass));
    let want = drawn_once(constant);
    let mirroring = MirroringRenderer { inner: &Scatter };
    for vergence in [constant, by_pixel] {
        let drawn = mirroring.render(&scene(&EVEN, vergence), &planes, &|_| true);
        let drawn = drawn.expect("a sound scene").planes.remove(0);
        assert!(largest_difference(&drawn, &want) < 1e-5);
    }
    let layered = render(Occlusion::default(), &scene(&EVEN, by_pixel), &planes).remove(0);
    let difference = largest_difference(&layered, &want);
    assert!(difference < 0.02, "{difference}");
}

#[test]
fn plates_without_lamps_are_those_of_the_inner_renderer() {
    let samples = textured();
    let planes = [plane(&samples, GREEN)];
    let scene = scene(&EVEN, VergencePass::Constant(1.0));
    let own = Scatter
        .render(&scene, &planes, &|_| true)
        .expect("a sound scene");
    let mirroring = MirroringRenderer { inner: &Scatter };
    let drawn = mirroring
        .render(&scene, &planes, &|_| true)
        .expect("a sound scene");
    assert_eq!(drawn.planes, own.planes);
}
