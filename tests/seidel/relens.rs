//! `seidel relens` with controls of one of its lenses.

use crate::support::{must_refuse, read_channel, seidel_in, succeeds, write_exr, write_pupil_lens};

const WIDTH: usize = 60;
const HEIGHT: usize = 44;

/// A sharp plate with edges and waves.
fn picture() -> Vec<f32> {
    let pixel = |k: usize| {
        let (x, y) = (k % WIDTH, k / WIDTH);
        let wave = (x as f32 * 0.7).sin() * (y as f32 * 0.4).cos();
        0.4 + 0.15 * wave + 0.3 * ((x / 15 + y / 11) % 2) as f32
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

fn rms(a: &[f32], b: &[f32]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn the_same_lens_is_opened_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_pupil_lens(folder, &["Y"]);
    write_exr(
        &folder.join("sharp.exr"),
        WIDTH,
        HEIGHT,
        &[("Y", picture())],
    );
    let y = |name: &str| read_channel(&folder.join(name), "Y");
    let common = "--lens-scale 0.4 --distance 2";
    for (name, stop) in [("narrow", 8), ("wide", 4)] {
        let line = format!(
            "apply --lens @lens.json @sharp.exr -o @{name}.exr --f-number {stop} --edges mirror {common}"
        );
        succeeds(folder, &line);
    }
    let relens = format!("relens --from @lens.json {common} --lens-check off");
    let line = format!("{relens} @narrow.exr -o @opened.exr --from-f-number f/8 --to-f-number 4");
    let opened = succeeds(folder, &line);
    let (missing, error) = (
        rms(&y("narrow.exr"), &y("wide.exr")),
        rms(&y("opened.exr"), &y("wide.exr")),
    );
    assert!(
        error < 0.2 * missing,
        "{error} of {missing}: {}",
        opened.stderr
    );
    let info = succeeds(folder, "info @opened.exr").stdout;
    assert!(
        info.contains("from-f-number: 8") && info.contains("to-f-number: 4"),
        "{info}"
    );
    // A control of both lenses is that of each side, and equal sides change nothing.
    let line = format!(
        "{relens} @narrow.exr -o @same.exr --f-number 5.6 --from-f-number 4 --to-f-number 4"
    );
    let same = succeeds(folder, &line).stderr;
    assert!(same.contains("both lenses are the same"), "{same}");
    // A table changes one side.
    std::fs::copy(folder.join("narrow.exr"), folder.join("narrow.1.exr")).expect("writable");
    std::fs::write(
        folder.join("stops.csv"),
        "frame,from-f-number,to-f-number\n1,8,4\n",
    )
    .expect("writable");
    let line = format!("{relens} @narrow.%d.exr -o @out.%d.exr --frames 1 --animate @stops.csv");
    succeeds(folder, &line);
    assert!(y("out.1.exr") == y("opened.exr"));
    let line = "apply --lens @lens.json @narrow.%d.exr -o @no.%d.exr --frames 1 --distance 2 --animate @stops.csv";
    must_refuse(folder, line, &["stops.csv", "from-f-number"]);
    let refused = seidel_in(
        folder,
        &format!("{relens} @narrow.exr -o @no.exr --to-f-number 0.1"),
    );
    assert!(
        refused.status == 2 && refused.stderr.contains("0.5"),
        "{}",
        refused.stderr
    );
}
