//! Views of the OpenFX plugin in the test host: circles of confusion, and the gap to a photograph.

// Variadic calls to this host are untested there: see `tests/host/src/host/suites/variadic.rs`.
#![cfg(not(all(target_vendor = "apple", target_arch = "aarch64")))]

use seidel_ofx_host::render_job::ClipFile;

use crate::host_render::{
    DepthInput, HEIGHT, NAMES, WIDTH, assert_equals_command, in_host, lens_and_plate, try_in_host,
    try_in_host_with,
};
use crate::support::{read_channel, succeeds, write_exr};

#[test]
fn the_coc_map_equals_the_command() {
    let folder = lens_and_plate();
    let folder = folder.path();
    let knobs = [
        ("math", "depth"),
        ("worldScale", "metres"),
        ("output", "CoC Map"),
        ("amount", "2"),
    ];
    let host = in_host(folder, DepthInput::OfPlate, &knobs);
    let line = "apply --lens @lens.json --no-depth-check --amount 2 --show coc";
    assert_equals_command(&host, folder, line);
}

/// The gap to the command's own result is nothing. Where the photograph is flat instead, it is large.
#[test]
fn the_gap_is_where_result_and_reference_differ() {
    let folder = lens_and_plate();
    let folder = folder.path();
    let knobs = [("distance", "2"), ("output", "Gap")];
    let error = try_in_host(folder, DepthInput::None, &knobs).expect_err("no reference");
    assert!(error.contains("input Reference; connect"), "{error}");
    let line = "apply --lens @lens.json --distance 2 @plate.exr -o @out.exr";
    succeeds(folder, line);
    let plane = |name: &str| {
        let mut plane = read_channel(&folder.join("out.exr"), name);
        for (k, value) in plane.iter_mut().enumerate() {
            // Half the exposure, and a flat block of R.
            *value *= 0.5;
            if name == "R" && (32..48).contains(&(k % WIDTH)) && (16..32).contains(&(k / WIDTH)) {
                *value = 0.1;
            }
        }
        plane
    };
    let photograph = folder.join("photograph.exr");
    let channels = NAMES.map(|name| (name, plane(name)));
    write_exr(&photograph, WIDTH, HEIGHT, &channels);
    let reference = ClipFile {
        clip: "Reference".to_owned(),
        file: photograph,
        channel: None,
    };
    let gap = try_in_host_with(folder, vec![reference], &knobs).expect("rendered");
    assert!(gap.pixel(4, 60)[..3].iter().all(|gap| *gap < 1e-6));
    let [red, green, _, alpha] = gap.pixel(40, 43) else {
        panic!("four channels");
    };
    assert!(
        *red > 0.3 && *green < 1e-6 && *alpha == 1.0,
        "{red} {green} {alpha}"
    );
}
