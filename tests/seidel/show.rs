//! `seidel apply --show`: pictures of the blur by depth.

use std::path::Path;

use seidel_core::{BlurField, LensProfile, Predictor};

use crate::support::{
    must_refuse, read_channel, seidel_in, succeeds, write_exr, write_plate, write_pupil_lens,
};

const WIDTH: usize = 300;
const HEIGHT: usize = 200;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    write_pupil_lens(folder.path(), &["R", "G", "B"]);
    write_plate(&folder.path().join("plate.exr"), WIDTH, HEIGHT);
    folder
}

/// The colours of a picture, pixel by pixel.
fn colours(path: &Path) -> Vec<[f32; 3]> {
    let planes = ["R", "G", "B"].map(|name| read_channel(path, name));
    let [r, g, b] = &planes;
    (0..r.len()).map(|k| [r[k], g[k], b[k]]).collect()
}

/// Returns the two numbers after `before` in a line like `... 1.4 to 14.9 px`.
fn range_after(text: &str, before: &str) -> [f64; 2] {
    let rest = &text[text.find(before).expect("the line is printed") + before.len()..];
    let mut numbers = rest.split_whitespace().filter_map(|word| word.parse().ok());
    [(); 2].map(|()| numbers.next().expect("a number"))
}

#[test]
fn circles_of_confusion_are_those_of_the_lens() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let line = "apply --lens @lens.json @plate.exr -o @coc.exr --show coc";
    let outcome = succeeds(folder.path(), line);
    let [least, largest] = range_after(&outcome.stderr, "in this plate it is ");
    let text = std::fs::read_to_string(at("lens.json")).expect("written");
    let lens = LensProfile::from_json(&text).expect("valid");
    let predictor = Predictor::new(&lens).expect("valid");
    // The frame of 300 x 200 px is that of the plate.
    let scale = WIDTH as f64 / 300.0;
    let depth = read_channel(&at("plate.exr"), "Z");
    let diameter = |index: usize| {
        let centre = |k: usize| (k as f64 + 0.5) / scale;
        let point = seidel_core::ImagePoint::new(centre(index % WIDTH), centre(index / WIDTH));
        let field = lens.frame.field_point(point);
        let vergence = 1.0 / f64::from(depth[index]);
        let variance = (0..3).map(|channel| {
            let moments = predictor.blur_at(channel, field, vergence).blur.moments;
            (moments.mu20 + moments.mu02) / 6.0
        });
        4.0 * variance.sum::<f64>().sqrt() * scale
    };
    let all: Vec<f64> = (0..depth.len()).map(diameter).collect();
    let want = [
        all.iter().copied().fold(f64::INFINITY, f64::min),
        all.iter().copied().fold(0.0, f64::max),
    ];
    for (got, want) in [least, largest].into_iter().zip(want) {
        assert!(
            (got - want).abs() < 0.1 + 0.02 * want,
            "{got} px, but {want} px"
        );
    }
    // Wider circles are other colours; alpha stays that of the plate.
    let drawn = colours(&at("coc.exr"));
    let right = WIDTH - 1;
    assert_ne!(drawn[right], drawn[(HEIGHT - 1) * WIDTH + right]);
    let alpha = |file: &str| read_channel(&at(file), "A");
    assert!(alpha("coc.exr") == alpha("plate.exr"));
    let info = succeeds(folder.path(), "info @coc.exr").stdout;
    assert!(
        info.contains("show: coc") && info.contains("seidelLens"),
        "{info}"
    );
}

#[test]
fn focus_is_grey_orange_in_front_and_blue_behind() {
    let folder = folder();
    let line = "apply --lens @lens.json @plate.exr -o @focus.exr --show focus --focus-distance 2 --amount 4";
    let outcome = succeeds(folder.path(), line);
    assert!(
        outcome.stderr.contains("% of the pixels are in focus"),
        "{}",
        outcome.stderr
    );
    let drawn = colours(&folder.path().join("focus.exr"));
    let depth = read_channel(&folder.path().join("plate.exr"), "Z");
    let [mut orange, mut grey, mut blue] = [const { Vec::new() }; 3];
    for ([red, green, blueness], metres) in drawn.iter().zip(&depth) {
        let (least, most) = (
            red.min(*green).min(*blueness),
            red.max(*green).max(*blueness),
        );
        let tint = if least > 0.6 * most {
            &mut grey
        } else if most == *red {
            &mut orange
        } else {
            assert_eq!(most, *blueness, "{red} {green} {blueness}");
            &mut blue
        };
        tint.push(*metres);
    }
    assert!(!orange.is_empty() && !blue.is_empty());
    assert!(orange.iter().all(|metres| *metres < 2.0), "{orange:?}");
    assert!(blue.iter().all(|metres| *metres > 2.0), "{blue:?}");
    assert!(grey.iter().any(|metres| *metres < 2.2) && grey.iter().any(|metres| *metres > 1.8));
}

#[test]
fn slices_have_one_colour_each_that_the_legend_names() {
    let folder = folder();
    let line = "apply --lens @lens.json @plate.exr -o @slices.exr --show slices";
    let outcome = succeeds(folder.path(), line);
    let count = outcome.stderr.matches(": #").count();
    assert!(
        outcome.stderr.contains(&format!("{count} depth slices")),
        "{}",
        outcome.stderr
    );
    // Where the plate is opaque.
    let drawn = colours(&folder.path().join("slices.exr"));
    let alpha = read_channel(&folder.path().join("plate.exr"), "A");
    let mut distinct: Vec<[u32; 3]> = (drawn.iter().zip(&alpha))
        .filter(|(_, alpha)| **alpha == 1.0)
        .map(|(colour, _)| colour.map(f32::to_bits))
        .collect();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(distinct.len(), count);
    assert!(count > 2);
}

#[test]
fn pictures_follow_the_rules_of_outputs() {
    let folder = folder();
    let folder = folder.path();
    for frame in 1..=2 {
        write_plate(&folder.join(format!("in.{frame}.exr")), WIDTH, HEIGHT);
    }
    let run = "apply --lens @lens.json @in.%d.exr -o @out.%d.exr --frames 1-2 --show coc";
    let outcome = succeeds(folder, run);
    // The legend is printed once.
    assert_eq!(outcome.stderr.matches("circle of confusion").count(), 1);
    let again = succeeds(folder, &format!("{run} --skip-existing"));
    assert!(
        again.stderr.contains("2 of 2 frames are finished"),
        "{}",
        again.stderr
    );
    let other = run.replace("coc", "slices");
    let again = succeeds(folder, &format!("{other} --skip-existing"));
    assert!(
        again.stderr.contains("made with other options"),
        "{}",
        again.stderr
    );
    // Another format.
    succeeds(
        folder,
        "apply --lens @lens.json @plate.exr -o @coc.png --show coc",
    );
}

#[test]
fn what_cannot_be_shown_is_refused_by_name() {
    let folder = folder();
    let folder = folder.path();
    let light = vec![0.5; WIDTH * HEIGHT];
    let rgb = ["R", "G", "B"].map(|name| (name, light.clone()));
    write_exr(&folder.join("flat.exr"), WIDTH, HEIGHT, &rgb);
    let line = "apply --lens @lens.json @flat.exr -o @out.exr";
    must_refuse(
        folder,
        &format!("{line} --show coc"),
        &["flat.exr", "depth", "--depth FILE"],
    );
    let parts = ["flat.exr", "--show slices", "--depth FILE"];
    must_refuse(
        folder,
        &format!("{line} --distance 2 --show slices"),
        &parts,
    );
    succeeds(folder, &format!("{line} --distance 2 --show coc"));
    let both = seidel_in(folder, &format!("{line} --show coc --verbose"));
    assert_eq!(both.status, 2, "{}", both.stderr);
}

#[test]
fn a_plate_without_colours_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    let planes = [
        ("Y", vec![0.5; WIDTH * HEIGHT]),
        ("Z", vec![2.0; WIDTH * HEIGHT]),
    ];
    write_exr(&folder.join("grey.exr"), WIDTH, HEIGHT, &planes);
    let line = "apply --lens @lens.json @grey.exr -o @out.exr --show coc";
    must_refuse(folder, line, &["grey.exr", "has no R, G and B", "Y"]);
}
