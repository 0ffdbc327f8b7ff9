//! Circles of confusion and slices of a lens whose blur is known.

use super::*;

/// The variance of the lens is the square of 8 (v - 0.5) px in the first channel; a disc of that variance has four times the
/// standard deviation as its diameter.
fn expected_px(vergence: f64) -> f64 {
    4.0 * 8.0 * (vergence - 0.5).abs()
}

#[test]
fn diameters_are_those_of_even_discs_of_the_same_variance() {
    for (left, right) in [(0.5, 1.0), (0.1, 2.0), (0.45, 0.55)] {
        let pass = halves(left, right);
        let map = BlurMap::new(&scene(&EVEN, VergencePass::PerPixel(&pass)), RED);
        for (index, vergence) in pass.iter().enumerate() {
            let (got, want) = (map.diameter_px[index], expected_px(f64::from(*vergence)));
            // Sizes are linear between layers, which are less than half a pixel of blur apart near focus.
            let tolerance = 1.0 + 0.02 * want;
            assert!(
                (f64::from(got) - want).abs() < tolerance,
                "{vergence}: {got} {want}"
            );
            assert!(map.focused_px[index] < 1.0, "{}", map.focused_px[index]);
        }
        let focus = map.focus_per_m.expect("the lens has one");
        assert!((focus - 0.5).abs() < 0.01, "{focus}");
        assert_eq!(map.side(WIDTH - 1), Some(FocusSide::Front));
        if left < 0.49 {
            assert_eq!(map.side(0), Some(FocusSide::Behind));
        }
    }
}

#[test]
fn blur_that_grows_with_the_field_is_followed() {
    let lens = Lens { field: 1.0, ..EVEN };
    let map = BlurMap::new(&scene(&lens, VergencePass::Constant(1.5)), RED);
    let scene = scene(&lens, VergencePass::Constant(1.5));
    for (column, row) in [(0, 0), (32, 24), (63, 47), (10, 40)] {
        let field = lens.frame().field_point(scene.map.frame_point(column, row));
        let want = expected_px(1.5) * (1.0 + field.radius());
        let got = f64::from(map.diameter_px[row * WIDTH + column]);
        assert!(
            (got - want).abs() < 0.03 * want,
            "({column}, {row}): {got} {want}"
        );
    }
    // One distance is not cut into slices.
    assert!(map.slices.is_empty() && map.slice_of.is_empty());
}

#[test]
fn slices_hold_all_pixels_and_lie_at_their_vergences() {
    let pass = halves(0.3, 1.4);
    let map = BlurMap::new(&scene(&EVEN, VergencePass::PerPixel(&pass)), RED);
    let pixels: usize = map.slices.iter().map(|slice| slice.pixels).sum();
    assert_eq!(pixels, WIDTH * HEIGHT);
    let steps = map
        .slices
        .windows(2)
        .map(|s| s[1].vergence_per_m - s[0].vergence_per_m);
    let longest = steps.fold(0.0, f64::max);
    for (index, vergence) in pass.iter().enumerate() {
        let slice = map.slices[usize::from(map.slice_of[index])];
        assert!((slice.vergence_per_m - f64::from(*vergence)).abs() <= longest / 2.0 + 1e-6);
    }
    assert_ne!(map.slice_of[0], map.slice_of[WIDTH - 1]);
}

#[test]
fn the_plane_of_focus_of_a_tilted_lens_is_followed() {
    let lens = Lens { tilt: 0.4, ..EVEN };
    let map = BlurMap::new(&scene(&lens, VergencePass::Constant(0.5)), RED);
    for (row, side) in [(4, FocusSide::Front), (43, FocusSide::Behind)] {
        for index in [row * WIDTH, row * WIDTH + WIDTH / 2] {
            assert_eq!(map.side(index), Some(side), "{index}");
            assert!(map.diameter_px[index] > 5.0, "{}", map.diameter_px[index]);
            assert!(map.focused_px[index] < 1.0, "{}", map.focused_px[index]);
        }
    }
}
