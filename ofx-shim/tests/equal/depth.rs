//! Depth passes, holdouts and focus.

use seidel_c::{SEIDEL_DEPTH_DISTANCE, SEIDEL_DEPTH_INVERSE};

use crate::host::Host;
use crate::plate::{centimetres, inverse_depth, plate};
use crate::rig::Rig;
use crate::{Picture, WHOLE};

/// Returns a rig with a pass of 1 / distance, `far=0` in Nuke.
fn with_inverse_depth() -> Rig {
    let mut rig = Rig::new();
    rig.host.choose("math", "far=0");
    rig.host.connect("Depth", Some(inverse_depth(1)));
    rig.abi.settings.depth_kind = SEIDEL_DEPTH_INVERSE;
    rig.abi.depth = Some(inverse_depth(1));
    rig
}

/// Returns a rig with a pass of negated distances in centimetres, which the C ABI gets without the sign.
fn with_negated_centimetres() -> Rig {
    let mut rig = Rig::new();
    rig.host.choose("math", "-depth");
    rig.host.choose("worldScale", "centimetres");
    rig.host.connect("Depth", Some(centimetres(-1.0)));
    rig.abi.settings.depth_kind = SEIDEL_DEPTH_DISTANCE;
    rig.abi.settings.depth_unit = 0.01;
    rig.abi.depth = Some(centimetres(1.0));
    rig
}

#[test]
fn depth_in_one_channel_and_in_four() {
    let rig = with_inverse_depth();
    let of_one = rig.assert_same("one channel");
    rig.host.connect("Depth", Some(inverse_depth(4)));
    rig.assert_same("R of four channels");
    rig.host.choose("depthChannel", "Luminance");
    let difference = rig.rendered().max_difference(&of_one);
    assert!(difference < 1e-3, "luminance of grey is grey: {difference}");
}

#[test]
fn a_holdout_without_and_with_a_depth_of_its_own() {
    let mut rig = with_inverse_depth();
    let whole = rig.expected();
    let matte = |x: i32| f32::from(u8::from(x < 18));
    // The depth of the holdout is in G.
    let four = Picture::new(WHOLE, 4, |x, _, c| if c == 1 { 0.5 } else { matte(x) });
    rig.host.connect("Holdout", Some(four));
    rig.abi.matte = Some(Picture::new(WHOLE, 1, |x, _, _| matte(x)));
    let held = rig.assert_same("a holdout");
    assert_ne!(held.samples, whole.samples);
    rig.host.choose("holdoutDepth", "G");
    rig.abi.matte_depth = Some(Picture::new(WHOLE, 1, |_, _, _| 0.5));
    rig.assert_same("a holdout at a depth");
}

#[test]
fn a_mask_that_scales_the_blur() {
    let mut rig = with_inverse_depth();
    let whole = rig.expected();
    let weight = |x: i32| if x < 18 { 0.0 } else { 0.75 };
    let mask = || Picture::new(WHOLE, 1, |x, _, _| weight(x));
    rig.host.choose("maskScales", "Blur");
    rig.host.connect("Mask", Some(mask()));
    rig.abi.settings.mask_scales = 1;
    rig.abi.mask = Some(mask());
    let scaled = rig.assert_same("a mask of the blur");
    assert_ne!(scaled.samples, whole.samples);
}

#[test]
fn negated_distances_in_centimetres() {
    with_negated_centimetres().assert_same("-depth in cm");
}

#[test]
fn focus_at_a_value_of_the_pass() {
    let mut rig = with_negated_centimetres();
    rig.host.choose("focus", "Focus Plane (C)");
    rig.host.set("focusPlane", -150.0);
    rig.abi.settings.focus_distance = 1.5;
    rig.assert_same("focus plane");
}

#[test]
fn doubts_about_depth_and_focus_name_knobs() {
    let host = Host::new();
    let last_message = || host.messages().last().cloned().expect("a warning");
    let metres = Picture::new(WHOLE, 1, |x, y, _| 0.02 + (x + y) as f32 / 100.0);
    host.connect("Depth", Some(metres));
    host.render(&plate(), WHOLE);
    let doubt = last_message();
    assert!(doubt.starts_with("Depth: "), "{doubt}");
    assert!(doubt.contains("set Depth Math to"), "{doubt}");
    host.connect("Depth", None);
    host.set("maxSize", 0.01);
    host.render(&plate(), WHOLE);
    let doubt = last_message();
    assert!(doubt.contains("drawn as in focus"), "{doubt}");
}

/// Natron gives the colour of a file where its menu *Depth Layer* is left alone.
#[test]
fn the_colour_of_the_plate_is_no_depth() {
    let host = Host::new();
    host.connect("Depth", Some(plate()));
    host.render(&plate(), WHOLE);
    let messages = host.messages();
    let warning = messages.last().expect("a warning");
    assert!(
        warning.contains("equals a colour of the plate"),
        "{warning}"
    );
    assert!(warning.contains("Depth Layer"), "{warning}");
}

/// The command says it as a note, too: the lens was measured up to infinity, and everything is a kilometre away.
#[test]
fn millimetres_read_as_metres_are_noted() {
    let host = Host::new();
    let millimetres = Picture::new(WHOLE, 1, |x, y, _| 1e3 / (0.3 + (x + y) as f32 / 200.0));
    host.connect("Depth", Some(millimetres));
    host.render(&plate(), WHOLE);
    let messages = host.messages();
    let note = messages.last().expect("a note");
    assert!(note.contains("is the unit right?"), "{note}");
    assert!(note.contains("set World Scale"), "{note}");
}
