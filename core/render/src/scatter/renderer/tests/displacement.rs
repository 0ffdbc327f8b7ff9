//! Kernels in focus that displacement moves.

use super::*;

#[test]
fn kernels_displaced_by_whole_pixels_are_not_widened() {
    for displacement_px in [(0.0, 0.0), (2.0, -1.0)] {
        let sharp = move |_: usize, _: FieldPoint, _: f64| DisplacedBlur {
            displacement_px,
            ..constant(0.004, 0.004, 0.0)
        };
        let lens = Lens {
            channel_count: 1,
            blur: sharp,
        };
        let scene = Scene {
            displacement: Displacement::Full,
            ..scene(&lens, 20, 12)
        };
        let mut lit = vec![0.0; 20 * 12];
        lit[6 * 20 + 9] = 1.0;
        let plane = Plane {
            samples: &lit,
            weights: &[1.0],
        };
        let out = render(&scene, &[plane]).remove(0);
        let (x, y) = displacement_px;
        let index = (6.0 + y) * 20.0 + 9.0 + x;
        assert!(out[index as usize] > 0.999, "{}", out[index as usize]);
    }
}
