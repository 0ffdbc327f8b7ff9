//! Compares renders of the plugin with those of the C ABI on the same samples, bit for bit.
//!
//! The host is a small one, because these tests are about images, not about the plugin's behaviour.

// Variadic arguments are passed on the stack on Apple's 64-bit Arm, where the host's getters would not find them.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]

mod abi;
mod depth;
mod host;
mod kept_results;
mod lenses;
mod picture;
mod plate;
mod psf_grid;
mod removal;
mod rig;

use picture::Picture;
use rig::Rig;
use seidel_c::SEIDEL_ALPHA_UNPREMULTIPLIED;

/// Size of the frame, and all of it.
const WIDTH: i32 = 56;
const HEIGHT: i32 = 40;
const WHOLE: [i32; 4] = [0, 0, WIDTH, HEIGHT];

#[test]
fn one_distance() {
    let mut rig = Rig::new();
    rig.host.set("distance", 6.0);
    rig.abi.settings.distance = 6.0;
    let rendered = rig.assert_same("one distance");
    assert_ne!(rendered.samples, plate::plate().samples, "it blurs");
}

#[test]
fn a_part_of_the_frame_in_rows_from_the_top_down() {
    let mut rig = Rig::new();
    rig.host.set("distance", 6.0);
    rig.abi.settings.distance = 6.0;
    let part = [5, 3, 31, 22];
    let from_the_top = plate::plate().with_reversed_rows();
    let rendered = rig.host.render(&from_the_top, part);
    rendered.assert_same(&rig.abi.apply(&plate::plate(), part), "a part");
}

#[test]
fn lengths_are_at_full_resolution_in_proxies() {
    let mut rig = Rig::new();
    rig.host.set("maxSize", 3.0);
    rig.host.set("lensScale", 0.2);
    rig.host.set_pair("axisOffset", 8.0, 4.0);
    let settings = &mut rig.abi.settings;
    settings.distance = 10.0;
    settings.maximum_size = 1.5;
    settings.lens_scale = 0.1;
    (settings.axis_offset_x, settings.axis_offset_y) = (4.0, -2.0);
    let rendered = rig.host.render_at(&plate::plate(), WHOLE, 0.5);
    rendered.assert_same(&rig.expected(), "half resolution");
}

#[test]
fn unpremultiplied_alpha() {
    let mut rig = Rig::new();
    rig.host.choose("sourceAlpha", "Unpremultiplied");
    rig.abi.settings.distance = 10.0;
    rig.abi.settings.alpha = SEIDEL_ALPHA_UNPREMULTIPLIED;
    rig.assert_same("unpremultiplied");
}

#[test]
fn a_missing_lens_is_reported_and_the_next_render_works() {
    let host = host::Host::new();
    host.set_text("profile", "there is/no 100%s lens.json");
    assert!(host.try_render(&plate::plate(), WHOLE).is_err());
    let messages = host.messages();
    let is_reported = (messages.iter()).any(|text| text.contains("no 100%s lens.json"));
    assert!(is_reported, "{messages:?}");
    host.choose("lens", "Library: modern-50");
    assert!(host.try_render(&plate::plate(), WHOLE).is_ok());
}
