//! The object distance at a pixel, and findings in a depth image.

use seidel_c::*;

use crate::support::{
    LensHandle, TestImage, assert_ok, assert_refused, exports, plate, rect, settings,
};

#[test]
fn the_distance_is_that_of_the_pixel_without_fine_gaps() {
    let area = rect(-3, 5, 40, 30);
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(area, 3);
    let depth = TestImage::from_fn(area, 1, |x, y, _| match x {
        _ if (x, y) == (8, 15) => 90.0,
        ..20 => 1.5,
        _ => 6.0,
    });
    let (image, depth_image) = (source.input(), depth.input());
    let mut plate = plate(&image, area);
    let pick = |plate: &SeidelPlate, x, y| {
        let mut distance = 0.0;
        // SAFETY: all pointers are valid.
        let status =
            unsafe { (exports().distance_at)(lens.0, &settings(), plate, x, y, &mut distance) };
        (status, distance)
    };
    assert_eq!(pick(&plate, 8, 15), (SeidelStatus::Ok, 2.0));
    plate.depth = &depth_image;
    for (x, metres) in [(8, 1.5), (30, 6.0)] {
        let (status, distance) = pick(&plate, x, 15);
        assert_ok(status);
        assert!((distance - metres).abs() < 1e-5, "{distance}");
    }
    let (status, _) = pick(&plate, -4, 15);
    assert_refused(status, SeidelStatus::Argument, "pixel (-4, 15)");
}

#[test]
fn a_normalised_depth_is_found_in_the_words_of_the_command() {
    let area = rect(0, 0, 160, 90);
    let lens = LensHandle::new(2.0);
    let source = TestImage::pattern(area, 3);
    let findings = |depth: &TestImage| {
        let (image, depth_image) = (source.input(), depth.input());
        let mut plate = plate(&image, area);
        plate.depth = &depth_image;
        let (mut text, mut needed) = ([0_u8; 1024], 0);
        // SAFETY: all pointers are valid, and the text has its length.
        assert_ok(unsafe {
            (exports().depth_findings)(
                lens.0,
                &settings(),
                &plate,
                text.as_mut_ptr().cast(),
                text.len(),
                &mut needed,
            )
        });
        String::from_utf8(text[..needed - 1].to_vec()).expect("UTF-8")
    };
    let post_and_wall = |wall: f32| {
        TestImage::from_fn(area, 1, move |x, _, _| match x {
            60..80 => 0.4 * wall,
            _ => wall,
        })
    };
    assert_eq!(findings(&post_and_wall(4.0)), "");
    let found = findings(&post_and_wall(1.0));
    assert!(
        found.starts_with("is doubtful: numbers fill 0 to 1"),
        "{found}"
    );
}
