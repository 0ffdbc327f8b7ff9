//! `seidel apply`: energy and everything else in the file are preserved, and depth conventions agree.

use std::path::Path;

use crate::support::{
    listing, read_channel, real_data, seidel_in, succeeds, write_exr, write_moments_lens,
    write_plate,
};

fn total(path: &Path, channel: &str) -> f64 {
    read_channel(path, channel)
        .iter()
        .map(|&v| f64::from(v))
        .sum()
}

/// Largest difference of two channels, relative to the larger peak.
fn difference(a: &[f32], b: &[f32]) -> f32 {
    let peak = a.iter().chain(b).copied().fold(0.0, f32::max);
    a.iter()
        .zip(b)
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f32::max)
        / peak
}

#[test]
fn energy_and_depth_are_preserved() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    let plate = folder.path().join("plate.exr");
    write_plate(&plate, 90, 60);
    let outcome = succeeds(
        folder.path(),
        "apply --lens @lens.json @plate.exr -o @out.exr --quality exact --occlusion off --edges mirror",
    );
    assert!(
        outcome.stderr.contains("spans 1.0000 m"),
        "{}",
        outcome.stderr
    );
    let out = folder.path().join("out.exr");
    for channel in ["R", "G", "B", "A"] {
        let (before, after) = (total(&plate, channel), total(&out, channel));
        // Small lights beside the edge lose what leaves the plate.
        let lost = if channel == "A" { 0.0 } else { 0.01 };
        assert!(
            (-1e-5..=lost + 1e-5).contains(&(1.0 - after / before)),
            "{channel}: {before} {after}"
        );
        assert_ne!(read_channel(&plate, channel), read_channel(&out, channel));
    }
    assert_eq!(read_channel(&plate, "Z"), read_channel(&out, "Z"));
    // Black edges lose some light.
    succeeds(
        folder.path(),
        "apply --lens @lens.json @plate.exr -o @black.exr --edges black --geometry none --occlusion off",
    );
    assert!(total(&folder.path().join("black.exr"), "R") < 0.999 * total(&plate, "R"));
}

/// Compares a pixel at the upper edge of a uniform plate for each kind of edge.
#[test]
fn black_edges_lose_light_and_others_keep_it() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    let even = |name| (name, vec![0.5; 80 * 60]);
    let channels = ["R", "G", "B"].map(even);
    write_exr(&folder.path().join("plate.exr"), 80, 60, &channels);
    let upper = |edges: &str, quality: &str| {
        let line = format!(
            "apply --lens @lens.json @plate.exr -o @out.exr --distance 1.2 --geometry none --edges {edges} \
             --quality {quality}"
        );
        succeeds(folder.path(), &line);
        read_channel(&folder.path().join("out.exr"), "G")[40]
    };
    for quality in ["final", "exact"] {
        for edges in ["mirror", "extend"] {
            let light = upper(edges, quality);
            assert!((light - 0.5).abs() < 0.02, "{edges} {quality}: {light}");
        }
        assert!(upper("black", quality) < 0.35);
    }
}

/// The fast renderer approximates the exact one. Without occlusion the command uses the exact one and reports it.
#[test]
fn qualities_differ_by_little() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    write_plate(&folder.path().join("plate.exr"), 90, 60);
    let blurred = |quality: &str, depth: &str| {
        let line =
            format!("apply --lens @lens.json @plate.exr -o @out.exr --quality {quality}{depth}");
        let outcome = succeeds(folder.path(), &line);
        let out = folder.path().join("out.exr");
        (read_channel(&out, "G"), outcome.stderr)
    };
    for (depth, bounds) in [(" --distance 1.5", [0.02, 0.01]), ("", [0.03, 0.02])] {
        let (exact, _) = blurred("exact", depth);
        for (quality, bound) in ["draft", "final"].into_iter().zip(bounds) {
            let (fast, _) = blurred(quality, depth);
            assert_ne!(fast, exact);
            let apart = difference(&fast, &exact);
            assert!(apart < bound, "{quality}{depth}: {apart}");
        }
    }
    let (same, message) = blurred("final", " --occlusion off");
    assert!(message.contains("rendered exactly"), "{message}");
    assert_eq!(same, blurred("exact", " --occlusion off").0);
}

#[test]
fn equivalent_depth_options_give_the_same_plate() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    let (width, height) = (60, 40);
    write_plate(&folder.path().join("plate.exr"), width, height);
    let metres = read_channel(&folder.path().join("plate.exr"), "Z");
    let map = |f: &dyn Fn(f32) -> f32| -> Vec<f32> { metres.iter().map(|&z| f(z)).collect() };
    write_exr(
        &folder.path().join("z.exr"),
        width,
        height,
        &[
            ("metres", metres.clone()),
            ("cm", map(&|z| 100.0 * z)),
            ("backwards", map(&|z| -z)),
            ("inverse", map(&|z| 1.0 / z)),
            ("unit", map(&|z| (z - 0.5) / 5.5)),
            ("flipped", map(&|z| (6.0 - z) / 5.5)),
        ],
    );
    succeeds(
        folder.path(),
        "apply --lens @lens.json @plate.exr -o @own.exr",
    );
    let want = read_channel(&folder.path().join("own.exr"), "G");
    for options in [
        "--depth @z.exr:metres",
        "--depth @z.exr:cm --depth-unit cm",
        "--depth @z.exr:backwards --depth-unit -1",
        "--depth @z.exr:inverse --depth-kind inverse",
        "--depth @z.exr:unit --depth-kind far-one --near 0.5 --far 6",
        "--depth @z.exr:flipped --depth-kind far-zero --near 0.5 --far 6",
    ] {
        // `@` is not at the beginning of a word here.
        let options = options.replace("@z.exr", &folder.path().join("z.exr").to_string_lossy());
        succeeds(
            folder.path(),
            &format!("apply --lens @lens.json @plate.exr -o @other.exr {options}"),
        );
        let got = read_channel(&folder.path().join("other.exr"), "G");
        assert!(difference(&got, &want) < 1e-5, "{options}");
    }
    succeeds(
        folder.path(),
        "apply --lens @lens.json @plate.exr -o @constant.exr --distance 2",
    );
    let constant = read_channel(&folder.path().join("constant.exr"), "G");
    assert!(difference(&constant, &want) > 1e-3);
}

#[test]
fn blur_scales_with_the_size_of_the_plate() {
    // On a plate twice as wide, PSFs are twice as wide in pixels.
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    for (name, width, height) in [("small.exr", 150, 100), ("large.exr", 300, 200)] {
        let mut light = vec![0.0; width * height];
        light[(height / 4) * width + width / 4] = 1.0;
        write_exr(&folder.path().join(name), width, height, &[("Y", light)]);
        succeeds(
            folder.path(),
            &format!("apply --lens @lens.json @{name} -o @out-{name} --distance 0.9"),
        );
    }
    let variance = |name: &str, width: usize| {
        let light = read_channel(&folder.path().join(name), "Y");
        let mean = |f: &dyn Fn(f64) -> f64| -> f64 {
            light
                .iter()
                .enumerate()
                .map(|(i, &v)| f64::from(v) * f((i % width) as f64))
                .sum()
        };
        mean(&|x| x * x) - mean(&|x| x).powi(2)
    };
    let ratio = variance("out-large.exr", 300) / variance("out-small.exr", 150);
    assert!((ratio / 4.0 - 1.0).abs() < 0.03, "{ratio}");
}

#[test]
fn sequences_render_frame_by_frame() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    for frame in [7, 8] {
        write_plate(&folder.path().join(format!("plate.{frame:04}.exr")), 40, 30);
    }
    let outcome = succeeds(
        folder.path(),
        "apply --lens @lens.json @plate.%04d.exr -o @out.####.exr --frames 7-8",
    );
    assert_eq!(outcome.stdout.matches("wrote").count(), 2);
    assert!(folder.path().join("out.0008.exr").exists());
    let refused = seidel_in(
        folder.path(),
        "apply --lens @lens.json @plate.%04d.exr -o @out.exr",
    );
    assert_eq!(refused.status, 1);
    assert!(refused.stderr.contains("--frames"), "{}", refused.stderr);
}

#[test]
fn png_and_tiff_plates_keep_their_format() {
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["R", "G", "B"]);
    let picture = image::RgbImage::from_fn(48, 32, |x, y| {
        image::Rgb([(x * 5) as u8, (y * 7) as u8, if x > 20 { 200 } else { 30 }])
    });
    for name in ["plate.png", "plate.tif"] {
        picture.save(folder.path().join(name)).expect("writable");
        succeeds(
            folder.path(),
            &format!("apply --lens @lens.json @{name} -o @out-{name} --distance 1.2"),
        );
        let out = image::open(folder.path().join(format!("out-{name}"))).expect("readable");
        assert_eq!(out.color(), image::ColorType::Rgb8, "{name}");
        assert_ne!(out.to_rgb8(), picture);
        // The mean light is preserved.
        let mean = |i: &image::RgbImage| {
            i.pixels().map(|p| f64::from(p.0[2])).sum::<f64>() / f64::from(i.width() * i.height())
        };
        assert!((mean(&out.to_rgb8()) - mean(&picture)).abs() < 8.0);
    }
}

#[test]
fn colour_is_premultiplied_before_it_is_blurred() {
    // A uniform colour under an alpha edge: only alpha changes, premultiplied or not.
    let folder = tempfile::tempdir().expect("a folder");
    write_moments_lens(folder.path(), &["Y"]);
    let covered = |x: u32| if x < 24 { 255 } else { 0 };
    let straight = image::RgbaImage::from_fn(48, 32, |x, _| image::Rgba([200, 90, 40, covered(x)]));
    straight
        .save(folder.path().join("plate.png"))
        .expect("writable");
    succeeds(
        folder.path(),
        "apply --lens @lens.json @plate.png -o @out.png --distance 1.2",
    );
    let out = image::open(folder.path().join("out.png"))
        .expect("readable")
        .to_rgba8();
    let (mut partly, mut away) = (0, 0);
    for pixel in out.pixels() {
        let [r, g, b, a] = pixel.0;
        partly += usize::from(a > 10 && a < 245);
        let near = |got: u8, want: u8| got.abs_diff(want) <= 2;
        away += usize::from(a > 10 && !(near(r, 200) && near(g, 90) && near(b, 40)));
    }
    assert!(partly >= 60, "the edge of alpha is blurred: {partly}");
    assert_eq!(away, 0, "the colour under it stays");
    // The same as premultiplied EXR: colour stays proportional to alpha.
    let half = |value: f32| {
        (0..48 * 32)
            .map(|i| if i % 48 < 24 { value } else { 0.0 })
            .collect()
    };
    write_exr(
        &folder.path().join("plate.exr"),
        48,
        32,
        &[
            ("R", half(0.8)),
            ("G", half(0.4)),
            ("B", half(0.2)),
            ("A", half(1.0)),
        ],
    );
    succeeds(
        folder.path(),
        "apply --lens @lens.json @plate.exr -o @out.exr --distance 1.2",
    );
    let (red, alpha) = (
        read_channel(&folder.path().join("out.exr"), "R"),
        read_channel(&folder.path().join("out.exr"), "A"),
    );
    for (r, a) in red.iter().zip(&alpha) {
        assert!((r - 0.8 * a).abs() < 1e-5, "{r} {a}");
    }
}

#[test]
fn measured_plates_keep_their_energy_and_their_other_channels() {
    let (Some(set), Some(plates)) = (real_data("psf/zemax-dgauss28"), real_data("plates")) else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let lens = folder.path().join("lens.json");
    let fit = crate::support::seidel(&[
        "fit".as_ref(),
        "--model".as_ref(),
        "moments".as_ref(),
        set.as_os_str(),
        "-o".as_ref(),
        lens.as_os_str(),
    ]);
    assert_eq!(fit.status, 0, "{}", fit.stderr);
    for (name, unit, kept) in [
        // Ten scene units per metre: CG cones at 7 m to 95 m, mostly far from focus.
        ("cones-flat.exr", "0.1", vec!["Z"]),
        ("motorcycle.exr", "1", vec!["Z", "Zvalid"]),
    ] {
        let (input, output) = (plates.join(name), folder.path().join(name));
        let outcome = crate::support::seidel(&[
            "apply".as_ref(),
            "--lens".as_ref(),
            lens.as_os_str(),
            input.as_os_str(),
            "-o".as_ref(),
            output.as_os_str(),
            "--depth-unit".as_ref(),
            unit.as_ref(),
            // Occlusion hides light, and the fast renderer preserves energy within its own bound only.
            "--quality".as_ref(),
            "exact".as_ref(),
            "--occlusion".as_ref(),
            "off".as_ref(),
            "--edges".as_ref(),
            "mirror".as_ref(),
            "--no-provenance".as_ref(),
        ]);
        assert_eq!(outcome.status, 0, "{}", outcome.stderr);
        for channel in ["R", "G", "B"] {
            let (before, after) = (total(&input, channel), total(&output, channel));
            assert!((after / before - 1.0).abs() < 1e-4, "{name} {channel}");
        }
        for channel in kept {
            assert_eq!(
                read_channel(&input, channel),
                read_channel(&output, channel)
            );
        }
        let attributes = |path: &Path| {
            let meta = exr::meta::MetaData::read_from_file(path, false).expect("readable");
            let header = &meta.headers[0];
            (
                header.shared_attributes.clone(),
                header.own_attributes.clone(),
            )
        };
        assert_eq!(attributes(&input), attributes(&output), "{name}");
    }
    assert_eq!(listing(folder.path()).len(), 3);
}
